"""The plots draw what they are given."""

from __future__ import annotations

import facerecon as fr
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from facerecon import viz  # noqa: E402


def test_plots(result: fr.Result) -> None:
    ax = viz.dots(result.capture.left, fr.detect(result.capture.left))
    assert len(ax.lines[0].get_xdata()) > 500
    left, right = viz.matches(result)
    for side, places in ((left, result.matches.left), (right, result.matches.right)):
        assert np.array_equal(side.collections[0].get_offsets(), places)
    assert viz.disparity(result).get_title() == f"{len(result.matches)} matches"
    assert np.array_equal(viz.convergence(result).lines[0].get_ydata(), result.icp_history)
    assert viz.heat(result.mesh, np.zeros(len(result.mesh.vertices))).images


def test_the_3d_view(result: fr.Result) -> None:
    pytest.importorskip("k3d")
    plot = viz.show3d(result)
    assert len(plot.objects) == 1
    assert np.allclose(plot.objects[0].vertices, result.mesh.vertices, atol=1e-3)


def test_progress_bar(result: fr.Result, capsys: pytest.CaptureFixture[str]) -> None:
    fr.match(result.capture, progress=True)
    assert "stage" in capsys.readouterr().err

"""The plots show the given data."""

from __future__ import annotations

import sys

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
    assert len(viz.matches(result.matches, result.capture)) == 2
    assert viz.disparity(result).get_title() == f"{len(result.matches)} matches"
    assert np.array_equal(viz.convergence(result).lines[0].get_ydata(), result.registration_history)
    assert viz.heat(result.mesh, np.zeros(len(result.mesh.vertices))).images


def test_the_3d_view(result: fr.Result) -> None:
    pytest.importorskip("k3d")
    plot = viz.show3d(result, result.cloud)
    face, points = plot.objects
    drawn = face.vertices[face.indices.reshape(-1, 3)]
    assert np.allclose(drawn, result.mesh.vertices[result.mesh.faces], atol=1e-3)
    assert len(face.texture) > 1000 and len(points.positions) == len(result.cloud)
    bare = result.mesh.transformed(np.eye(4))
    bare.texture = None
    assert len(bare.show().objects) == 1
    with pytest.raises(ValueError, match="no faces"):
        viz.show3d(fr.Mesh(bare.vertices, np.zeros((0, 3), np.uint32)))


def test_progress_bar(result: fr.Result, capsys: pytest.CaptureFixture[str]) -> None:
    fr.correspond(result.capture, progress=True)
    shown = capsys.readouterr().err
    assert "correspond" in shown and "3/3 stages" in shown
    fr.simulate(subject=1, width_px=200, height_px=150, focal_px=720.0, progress=True)
    assert "simulate" in capsys.readouterr().err


def test_without_an_extra_it_says_what_to_install(
    result: fr.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("matplotlib.pyplot", "k3d", "tqdm.auto", "trimesh", "open3d", "distributed"):
        monkeypatch.setitem(sys.modules, module, None)
    for extra, use in (
        ("viz", lambda: viz.disparity(result)),
        ("viz", result.mesh.show),
        ("viz", lambda: fr.correspond(result.capture, progress=True)),
        ("mesh", result.mesh.to_trimesh),
        ("dask", lambda: fr.batch(["x"], "nowhere", client=object())),
    ):
        with pytest.raises(ImportError, match=rf"facerecon\[{extra}\]"):
            use()
    with pytest.raises(ImportError, match="open3d"):
        result.mesh.to_open3d()

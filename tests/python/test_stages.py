"""Every stage on arrays, and the stages in sequence."""

from __future__ import annotations

import warnings
from pathlib import Path

import facerecon as fr
import numpy as np
import pytest


def test_the_thesis_preprocessing_step_by_step(shot: fr.Simulation) -> None:
    photo = shot.capture.left
    level = fr.equalize(photo)
    assert level.shape == photo.shape[:2] and level.std() > 0
    # Eq. 2.1 on a flat image changes nothing; any odd kernel is taken
    flat = np.full((20, 30), 77.0)
    assert np.allclose(fr.sharpen(flat), 77.0)
    shifted = fr.sharpen(np.arange(100.0).reshape(10, 10), kernel=np.eye(3) / 3)
    assert shifted.shape == (10, 10)
    binary = fr.threshold(fr.sharpen(photo), "otsu")
    assert set(np.unique(binary)) <= {0.0, 255.0}
    dots = fr.thin(binary)
    assert len(dots) > 500 and dots.thinned is not None
    assert np.count_nonzero(dots.thinned) <= len(dots) and dots.spacing_px > 3
    found = fr.detect(photo)
    assert len(found) > 500 and found.positions.shape == (len(found), 2)
    for bad in ("much", "none"):
        with pytest.raises(ValueError, match="filter.threshold is .*fixed, otsu, local"):
            fr.threshold(photo, bad)


def test_layouts_of_images_do_not_matter(shot: fr.Simulation) -> None:
    gray = shot.capture.left[:, :, 1]
    wanted = fr.sharpen(np.ascontiguousarray(gray))
    assert np.array_equal(fr.sharpen(gray), wanted)
    assert np.array_equal(fr.sharpen(np.asfortranarray(gray)), wanted)
    assert np.array_equal(fr.sharpen(gray.astype(np.float64)), wanted)
    assert np.allclose(fr.sharpen(gray.astype(np.uint16) * 257), wanted, atol=1e-3)


def test_from_matches_to_a_deformed_and_textured_head(shot: fr.Simulation) -> None:
    rows = fr.rectify(shot.capture)
    assert rows.left.shape == shot.capture.left.shape[:2] and rows.plain is not None
    found = fr.correspond(shot.capture)
    cloud = fr.triangulate(shot.capture, found)
    assert len(cloud) == len(found) and 900 < np.median(cloud.points[:, 2]) < 1700
    pose = fr.register(cloud)
    assert pose.model_from_data.shape == (4, 4) and pose.rms_after <= pose.rms_before
    assert pose.termination == "converged" and pose.history
    # one step is too few to converge
    early = fr.register(cloud, profile="facebuilder", max_iterations=1, coarse_first=False)
    assert early.termination == "max_iterations" and len(early.history) == 2
    points = pose.apply(cloud.points)
    head = fr.head()
    deformed = fr.deform(head, points, method="gaussian-rbf")
    assert deformed.mesh.vertices.shape == head.vertices.shape and deformed.rms_after <= deformed.rms_before
    fitted = fr.fit(head, points)
    assert fitted.rms_after < fitted.rms_before
    smoothed = fr.smooth(deformed.mesh, steps=3)
    assert smoothed.landmarks == head.landmarks
    camera = fitted.mesh.transformed(np.linalg.inv(pose.model_from_data))
    coloured, coverage = fr.texture(camera, shot.capture, size=256)
    assert coloured.texture is not None and coloured.texture.shape == (256, 256, 3)
    assert coverage.shape == (256, 256) and (coverage & 1).any()


def test_wrong_points_are_refused() -> None:
    head = fr.head("head-coarse")
    with pytest.raises(ValueError, match=r"data has shape \(5, 2\)"):
        fr.register(np.zeros((5, 2)), head)
    with pytest.raises(ValueError, match="data .*finite"):
        fr.deform(head, np.full((50, 3), np.nan))
    with pytest.raises(ValueError, match="assignments names vertices"):
        fr.deform(head, np.zeros((5, 3)), assignments={10**6: (0, 0, 0)})
    with pytest.raises(ValueError, match="no .*third_eye"):
        fr.deform(head, np.zeros((5, 3)), landmarks={"third_eye": (0, 0, 0)})
    with pytest.raises(ValueError, match="right has shape"):
        black = fr.Capture(np.zeros((50, 60, 3), np.uint8), np.zeros((50, 60, 3), np.uint8))
        fr.triangulate(black, (np.zeros((4, 2)), np.zeros((5, 2))))
    with pytest.raises(fr.FaceReconError):
        fr.register(np.zeros((0, 3)), head)


def test_functions_around_the_pipeline(tmp_path: Path) -> None:
    image = fr.pattern(columns=20, rows=10, width_px=320, height_px=160)
    assert image.shape == (160, 320, 3) and set(np.unique(image)) >= {0, 255}
    with pytest.raises(ValueError, match="dot_fraction"):
        fr.pattern(dot_fraction=3.0)
    head = fr.head("head-coarse")
    grown = fr.Mesh(head.vertices * 1.05, head.faces)
    apart = fr.compare(head, grown, alignment="none", samples=2000)
    assert 1.0 < apart.median_mm < 8.0 and len(apart.vertex_distances) == len(head.vertices)
    assert fr.compare(head, grown, alignment="similarity", samples=2000).median_mm < 0.2
    sheet = fr.render(head, ["front", "profile"], heat=apart.vertex_distances, size=(100, 120))
    assert sheet.shape == (120, 200, 3)
    with pytest.raises(ValueError, match="view"):
        fr.render(head, "from-mars")
    shot = fr.simulate(head, width_px=200, height_px=150, focal_px=700.0)
    again = fr.Capture.load(shot.save(tmp_path / "shot"))
    assert again.left.shape == (150, 200, 3) and again.rig is not None
    assert np.array_equal(again.left, shot.capture.left)
    assert np.allclose(again.rig.K1, shot.capture.rig.K1)  # type: ignore[union-attr]


def test_rigs(tmp_path: Path) -> None:
    rig = fr.Rig.parallel(150.0, 2766.0, (383.5, 287.5), (383.5, 287.5))
    rig.save(tmp_path / "rig.yml")
    again = fr.Rig.load(tmp_path / "rig.yml")
    assert np.allclose(again.T, [-150, 0, 0]) and again.baseline_mm == pytest.approx(150.0)
    with pytest.raises(ValueError, match=r"rig.K1 has shape \(2, 2\)"):
        fr.Rig(np.eye(2), [0] * 5, np.eye(3), [0] * 5, np.eye(3), [1, 2, 3])
    swapped = fr.Rig.parallel(-150.0, 2766.0, (383.5, 287.5), (383.5, 287.5))
    black = np.zeros((576, 768, 3), np.uint8)
    with pytest.raises(ValueError, match="LEFT"):
        fr.Capture(black, black, rig=swapped)
    with pytest.raises(OSError, match="missing.yml"):
        fr.Rig.load(tmp_path / "missing.yml")


def test_earlier_names_still_work(shot: fr.Simulation) -> None:
    assert fr.match is fr.correspond and fr.icp is fr.register
    head = fr.head("head-coarse")
    target = {"nose_tip": head.vertices[head.landmarks["nose_tip"]] + 3.0}
    points = head.vertices + 1.0
    by_landmarks = fr.deform(head, points, landmarks=target, method="linear-rbf")
    by_features = fr.deform(head, points, features=target, method="linear-rbf")
    assert np.array_equal(by_landmarks.mesh.vertices, by_features.mesh.vertices)


def test_warnings_of_single_stages_are_python_warnings(shot: fr.Simulation) -> None:
    photo = shot.capture.left
    with pytest.warns(fr.FaceReconWarning, match="kernel"):
        fr.equalize(photo, kernel=[0, 0, 0, 0, 2, 0, 0, 0, 0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fr.equalize(photo)

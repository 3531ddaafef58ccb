"""Photographs to a face; the same bytes as the command line; watching and stopping."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import facerecon as fr
import numpy as np
import pytest

#: Everything but the files that hold the times the stages took.
SAME = (
    "face.obj face.mtl texture.png face.glb cloud.ply matches.csv depth_left.png "
    "depth_right.png coverage.png"
).split()


def facerecon(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The ``facerecon`` command of the wheel."""
    command = Path(sys.executable).parent / "facerecon"
    return subprocess.run(
        [command, *map(str, arguments)], capture_output=True, text=True, check=False
    )


def test_the_face_is_where_the_truth_is(shot: fr.Simulation, result: fr.Result) -> None:
    assert result.metric and len(result.matches) > 800
    truth = shot.mesh.transformed(np.linalg.inv(shot.camera_from_model))
    # the true face is what the left camera saw of it, in the camera frame
    mesh = result.mesh_in("camera")
    rows, cols = np.nonzero(shot.face & np.isfinite(shot.depth_mm))
    rig = shot.capture.rig
    assert rig is not None
    z = shot.depth_mm[rows, cols].astype(np.float64)
    rays = np.linalg.inv(rig.K1) @ np.stack([cols, rows, np.ones_like(rows)])
    points = (rays * z).T[::97]
    nearest = np.array([np.linalg.norm(mesh.vertices - p, axis=1).min() for p in points])
    # vertices lie some millimetres apart: near one of them is near the surface
    assert np.median(nearest) < 2.5
    assert len(truth.vertices) == len(shot.mesh.vertices)


def test_module_and_command_give_the_same_bytes(
    folder: Path, result: fr.Result, tmp_path: Path
) -> None:
    done = facerecon("reconstruct", folder, "-o", tmp_path / "cli", "--quiet")
    assert done.returncode == 0, done.stderr
    result.save(tmp_path / "module")
    for name in SAME:
        ours, theirs = (tmp_path / side / name for side in ("module", "cli"))
        assert ours.read_bytes() == theirs.read_bytes(), name
    assert (tmp_path / "module" / "result.json").exists()
    assert "<html" in result.report_html() and (tmp_path / "module" / "report.html").exists()


def test_arrays_give_what_files_give(shot: fr.Simulation, result: fr.Result) -> None:
    seen = shot.capture
    rebuilt = fr.Capture(
        np.asfortranarray(seen.left),
        seen.right,
        seen.left_plain,
        seen.right_plain,
        rig=seen.rig,
        **{k: v for k, v in seen.pattern.items()},  # type: ignore[arg-type]
    )
    again = fr.match(rebuilt)
    assert np.array_equal(again.left, fr.match(seen).left)
    assert np.allclose(again.left, fr.match(result.capture).left, atol=1e-6)


def test_a_result_shows_itself(result: fr.Result) -> None:
    face = result.mesh
    assert face.vertices.shape[1] == 3 and face.faces.dtype == np.uint32
    assert face.texture is not None and set(fr.FEATURES) <= set(face.landmarks)
    assert result.depth_left.shape == result.depth_right.shape == result.capture.left.shape[:2]
    assert result.matches.to_numpy().shape == (len(result.matches), 11)
    table = result.matches.to_pandas()
    assert list(table.columns) == list(fr.Matches.COLUMNS)
    assert np.array_equal(result.cloud.to_pandas()[["x", "y", "z"]], result.cloud.points)
    moved = result.cloud_in("camera").points @ result.model_from_camera[:3, :3].T
    assert np.allclose(moved + result.model_from_camera[:3, 3], result.cloud.points, atol=1e-9)
    assert "data:image/png;base64," in result._repr_html_()
    assert "data:image/png" in result.capture._repr_html_()
    assert result.timings["total"] > 0 and "correspond" in result.timings
    assert len(result.artifacts()) > 0 and result.summary()


def test_callbacks_see_the_stages_and_may_stop_the_run(folder: Path) -> None:
    seen: list[str] = []

    def watch(event: fr.Event) -> None:
        seen.append(f"{event.stage} {event.kind}")
        if event.stage == "correspond":
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fr.reconstruct(folder, progress=watch)
    assert "rectify started" in seen and "detect finished" in seen
    assert not any(s.startswith("texture") for s in seen)


def test_ctrl_c_stops_within_a_second(folder: Path) -> None:
    pressed = [0.0]

    def press() -> None:
        pressed[0] = time.process_time()
        os.kill(os.getpid(), signal.SIGINT)

    capture = fr.Capture.load(folder)
    # once before the long stages, once among them
    for wait_s in (0.1, 1.0):
        timer = threading.Timer(wait_s, press)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            for _ in range(200):
                fr.reconstruct(capture)
        # counted in the work of two cores, so that a busy machine does not matter
        assert time.process_time() - pressed[0] < 2.0
        timer.join()


def test_the_gil_is_released() -> None:
    ticks: list[float] = []
    stop = threading.Event()

    def tick() -> None:
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    fr.simulate(subject=3)
    end = time.monotonic()
    stop.set()
    thread.join()
    inside = sum(begin < t < end for t in ticks)
    assert inside > 20, f"{inside} ticks in {end - begin:.2f} s"


def test_parameters_are_those_of_the_command_line(tmp_path: Path) -> None:
    params = fr.Params("facebuilder", smooth={"steps": 3, "lambda": 0.25})
    values = params.to_dict()
    assert values["profile"] == "facebuilder" and values["smooth"]["steps"] == 3
    assert values["smooth"]["lambda"] == 0.25 and values["detect"]["method"] == "thin"
    path = tmp_path / "params.toml"
    params.save(path)
    assert fr.Params(config=path) == params != fr.Params()
    printed = facerecon("params", "--config", path)
    assert printed.returncode == 0 and printed.stdout.strip() == params.to_toml().strip()
    with pytest.raises(ValueError, match=r"smooth.lambda is 3"):
        fr.Params(smooth={"lambda": 3.0})
    with pytest.raises(ValueError, match="smoth"):
        fr.reconstruct("nowhere", smoth={"steps": 3})
    with pytest.raises(ValueError, match="precise"):
        fr.Params("best")


def test_faults_have_their_class_and_say_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        fr.reconstruct(tmp_path / "nowhere")
    black = np.zeros((576, 768, 3), dtype=np.uint8)
    with pytest.raises(fr.FaceReconError) as caught:
        fr.reconstruct(fr.Capture(black, black))
    assert caught.value.stage and str(caught.value)
    assert isinstance(caught.value, fr.errors.DetectError | fr.errors.RectifyError)
    with pytest.raises(ValueError, match="frame"):
        fr.render(fr.head(), frame="sideways")

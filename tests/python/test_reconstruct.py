"""From photographs to a face; the same bytes as the command line; progress and cancellation."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import facerecon as fr
import numpy as np
import pytest

FIXTURES = Path(__file__).parents[2] / "fixtures"
#: The files of a result beside those that hold the times the stages took.
SAME = (
    "face.obj face.mtl texture.png face.glb face.landmarks.toml cloud.ply matches.csv "
    "landmarks.csv distances.csv depth_left.png depth_right.png coverage.png"
).split()


def facerecon(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The ``facerecon`` command of the wheel."""
    command = Path(sys.executable).parent / "facerecon"
    return subprocess.run(
        [command, *map(str, arguments)], capture_output=True, text=True, check=False
    )


def test_the_face_is_where_the_truth_is(shot: fr.Simulation, result: fr.Result) -> None:
    assert result.metric and len(result.matches) > 800
    # the vertices of the true face that the left camera sees, camera frame
    rig = shot.capture.rig
    assert rig is not None
    pixels = np.rint((shot.mesh.vertices / shot.mesh.vertices[:, 2:]) @ rig.K1.T).astype(int)
    cols, rows = pixels[:, 0], pixels[:, 1]
    height, width = shot.depth_mm.shape
    inside = (cols >= 0) & (cols < width) & (rows >= 0) & (rows < height)
    cols, rows = np.where(inside, cols, 0), np.where(inside, rows, 0)
    visible = shot.mesh.vertices[:, 2] < shot.depth_mm[rows, cols] + 3.0
    region = inside & shot.face[rows, cols] & visible
    assert region.sum() > 300
    apart = fr.compare(shot.mesh, result.mesh_in("camera"), region=region, alignment="none")
    # the bounds of tests/golden.rs for profile precise
    figures = apart.facts["before"]["first_to_second"]
    assert figures["median_mm"] < 0.12 and figures["p90_mm"] < 0.4, figures
    # back in its own frame the simulated person is the mesh in the model frame
    back = shot.mesh.transformed(np.linalg.inv(shot.camera_from_model))
    assert np.abs(back.vertices).max() < 300.0 < shot.mesh.vertices[:, 2].min()


@pytest.mark.parametrize("profile", ["precise", "facebuilder"])
@pytest.mark.parametrize("fixture", ["parallel", "toed_in"])
def test_module_and_command_give_the_same_bytes(fixture: str, profile: str, tmp_path: Path) -> None:
    capture = FIXTURES / fixture
    frame = "camera" if fixture == "toed_in" else "model"
    done = facerecon(
        "reconstruct", capture, "-o", tmp_path / "cli", "--profile", profile, "--frame", frame,
        "--keep-stages", "--quiet",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    fr.reconstruct(capture, profile).save(tmp_path / "module", frame=frame, keep_stages=True)
    ours, theirs = (files(tmp_path / side) for side in ("module", "cli"))
    assert set(ours) == set(theirs) >= {*SAME, "result.json", "report.html"}
    assert any(name.startswith("stages/") for name in ours)
    for name in ours:
        assert untimed(name, ours[name]) == untimed(name, theirs[name]), name


def files(folder: Path) -> dict[str, bytes]:
    """All files of a folder by their path in it."""
    found = (p for p in folder.rglob("*") if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in found}


def untimed(name: str, content: bytes) -> bytes:
    """A file without the times that stages took."""
    if name == "result.json":
        facts = json.loads(content)
        assert facts.pop("timings_ms")["total"] > 0
        return json.dumps(facts).encode()
    if name == "report.html":
        timed = re.compile(rb" ms</td>|The run took|for all stages")
        return b"\n".join(line for line in content.split(b"\n") if not timed.search(line))
    return content


def test_arrays_give_what_files_give(shot: fr.Simulation, result: fr.Result) -> None:
    seen = shot.capture
    rebuilt = fr.Capture(
        np.asfortranarray(seen.left),
        seen.right,
        seen.left_plain,
        seen.right_plain,
        rig=seen.rig,
        seeds=seen.seeds,
        **{k: v for k, v in seen.pattern.items()},  # type: ignore[arg-type]
    )
    assert rebuilt.seeds == seen.seeds and set(seen.seeds or ()) == {
        "head",
        "left_ear",
        "right_ear",
    }
    again = fr.correspond(rebuilt)
    assert np.array_equal(again.left, fr.correspond(seen).left)
    assert np.allclose(again.left, fr.correspond(result.capture).left, atol=1e-6)


def test_a_result_has_its_parts_and_notebook_images(result: fr.Result) -> None:
    face = result.mesh
    assert face.vertices.shape[1] == 3 and face.faces.dtype == np.uint32
    assert face.texture is not None and set(fr.LANDMARK_NAMES) <= set(face.landmarks)
    assert result.depth_left.shape == result.depth_right.shape == result.capture.left.shape[:2]
    assert result.matches.to_numpy().shape == (len(result.matches), 11)
    table = result.matches.to_pandas()
    assert list(table.columns) == list(fr.Matches.COLUMNS)
    assert np.array_equal(result.cloud.to_pandas()[["x", "y", "z"]], result.cloud.points)
    moved = result.cloud_in("camera").points @ result.model_from_camera[:3, :3].T
    assert np.allclose(moved + result.model_from_camera[:3, 3], result.cloud.points, atol=1e-9)
    assert "data:image/png;base64," in result._repr_html_()
    for shown in (result.capture, result.mesh, result.cloud, result.cloud_in("camera")):
        assert "data:image/png" in shown._repr_html_(), shown
    assert "data:image/png" in result.matches._repr_html_()
    assert result.termination == "converged"
    assert result.timings["total"] > 0 and "correspond" in result.timings
    assert len(result.artifacts()) > 0 and result.summary()


def test_the_surface_itself_without_a_head(shot: fr.Simulation, tmp_path: Path) -> None:
    face = fr.reconstruct(shot.capture, surface={"method": "auto"})
    assert face.mesh.landmarks == {} and face.mesh.texture is not None
    assert face.facts["face_width_mm"] is None and face.metric
    face.save(tmp_path / "surface")
    assert (tmp_path / "surface" / "face.glb").exists() and "measured surface" in face.summary()
    alone = fr.surface(shot.capture)
    assert alone.uv is not None and 900 < np.median(alone.vertices[:, 2]) < 1700
    apart = fr.compare(alone, face.mesh_in("camera"), alignment="none", samples=2000)
    assert apart.median_mm < 0.01
    with pytest.raises(ValueError, match="surface.spacing"):
        fr.reconstruct(shot.capture, surface={"spacing": 0.0})


def test_callbacks_see_the_stages_and_may_stop_the_run(folder: Path) -> None:
    seen: list[str] = []

    def watch(event: fr.Event) -> None:
        seen.append(f"{event.stage} {event.kind}")
        if event.stage == "correspond":
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        fr.reconstruct(folder, progress=watch)
    assert "rectify started" in seen and "detect finished" in seen
    assert not any(s.startswith("texture") for s in seen)


#: Prints a line, works until it is stopped, prints how.
LONG = """
import signal, sys, time
import facerecon as fr
import numpy as np
head = fr.head()
capture = fr.Capture.load(sys.argv[1]) if len(sys.argv) > 1 else None
pressed = []
def press(number, frame):
    raise KeyboardInterrupt
signal.signal(signal.SIGINT, press)
print("ready", flush=True)
try:
    while True:
        {work}
except KeyboardInterrupt:
    print("KeyboardInterrupt", flush=True)
"""
WORKS = {
    "reconstruct": "fr.reconstruct(capture)",
    "facebuilder": 'fr.reconstruct(capture, "facebuilder")',
    "simulate": "fr.simulate(width_px=1536, height_px=1152, focal_px=5532.0)",
    "fit": "fr.fit(head, head.vertices * 1.05)",
    "deform": 'fr.deform(head, head.vertices * 1.05, method="gaussian-rbf")',
    "compare": "fr.compare(head, fr.Mesh(head.vertices * 1.05, head.faces), samples=2_000_000)",
    "batch": "fr.batch([sys.argv[1]], sys.argv[2], workers=1, smooth={'lambda': time.time() % 1})",
}


@pytest.mark.parametrize("work", WORKS)
def test_ctrl_c_stops_within_a_second(work: str, folder: Path, tmp_path: Path) -> None:
    script = tmp_path / "work.py"
    script.write_text(LONG.replace("{work}", WORKS[work]))
    command = [sys.executable, str(script), str(folder), str(tmp_path / "out")]
    for wait_s in (0.3, 1.7):
        # a group of its own, as a terminal makes it
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        time.sleep(wait_s)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        said = process.stdout.readline()
        took = time.monotonic() - begin
        assert process.wait() == 0 and said == "KeyboardInterrupt\n"
        # on a quiet machine; one that does other things as well gets more time
        assert took < max(1.0, os.getloadavg()[0]), f"{took:.2f} s"


def test_ctrl_c_stops_the_command_too(folder: Path, tmp_path: Path) -> None:
    command = Path(sys.executable).parent / "facerecon"
    process = subprocess.Popen(
        [command, "batch", folder, "-o", tmp_path / "out", "--set", "smooth.steps=77"],
        stderr=subprocess.PIPE,
    )
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    assert process.wait() == -signal.SIGINT
    assert time.monotonic() - begin < max(1.0, os.getloadavg()[0])


def test_two_threads_overlap(folder: Path, result: fr.Result) -> None:
    """While two threads reconstruct, a third one ticks: none of them keeps the GIL."""
    capture = fr.Capture.load(folder)
    spans: list[tuple[float, float]] = []
    made: list[fr.Mesh] = []

    def work() -> None:
        begin = time.monotonic()
        made.append(fr.reconstruct(capture).mesh)
        spans.append((begin, time.monotonic()))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    ticks: list[float] = []
    while any(thread.is_alive() for thread in threads):
        ticks.append(time.monotonic())
        time.sleep(0.002)
    begin, end = max(s[0] for s in spans), min(s[1] for s in spans)
    inside = sum(begin < t < end for t in ticks)
    assert inside > 20, f"{inside} ticks while both worked, {end - begin:.2f} s"
    for mesh in made:
        assert np.array_equal(mesh.vertices, result.mesh.vertices)


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


def test_errors_have_their_class_and_say_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        fr.reconstruct(tmp_path / "nowhere")
    black = np.zeros((576, 768, 3), dtype=np.uint8)
    with pytest.raises(fr.FaceReconError) as caught:
        fr.reconstruct(fr.Capture(black, black))
    assert caught.value.stage and str(caught.value)
    assert isinstance(caught.value, fr.errors.DetectError | fr.errors.RectifyError)
    with pytest.raises(ValueError, match="frame"):
        fr.render(fr.head(), frame="sideways")

"""Batches: a failure does not stop the others, and finished work is kept."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import facerecon as fr
import pytest
from facerecon._pool import run_one


FIXTURE = Path(__file__).parents[2] / "fixtures" / "parallel"
#: Small pictures are enough here.
SMALL: dict[str, Any] = {"texture": {"size": 128}}


@pytest.fixture(scope="module")
def captures(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two good ones and a broken one between them."""
    home = tmp_path_factory.mktemp("many")
    for name in ("anna", "berta", "clara"):
        shutil.copytree(FIXTURE, home / name)
    (home / "berta" / "left_dots.png").unlink(missing_ok=True)
    (home / "berta" / "capture.toml").write_text("[images]\nleft = 'gone.png'\n")
    return [home / name for name in ("anna", "berta", "clara")]


def test_a_batch_is_resumed(captures: list[Path], tmp_path: Path) -> None:
    first = fr.batch(captures, tmp_path / "out", workers=2, smooth={"steps": 1}, **SMALL)
    assert [row["status"] for row in first.rows] == ["done", "failed", "done"]
    assert "right" in first.failed[0]["error"] or "gone" in first.failed[0]["error"]
    made = tmp_path / "out" / "anna" / "face.glb"
    before = made.stat().st_mtime_ns
    again = fr.batch(captures, tmp_path / "out", workers=1, smooth={"steps": 1}, **SMALL)
    assert [row["status"] for row in again.rows] == ["kept", "failed", "kept"]
    assert made.stat().st_mtime_ns == before
    other = fr.batch(captures[:1], tmp_path / "out", workers=1, smooth={"steps": 2}, **SMALL)
    assert other.rows[0]["status"] == "done" and made.stat().st_mtime_ns != before
    assert "anna" in first.csv.read_text() and "report.html" in first.html.read_text()
    assert len(first.to_pandas()) == 3 and "<table" in first._repr_html_()


def test_two_captures_of_one_name_are_refused(captures: list[Path], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="anna"):
        fr.batch([captures[0], captures[0]], tmp_path)


def test_a_folder_of_captures_is_all_of_them(captures: list[Path], tmp_path: Path) -> None:
    home = captures[0].parent
    table = fr.batch(
        home, tmp_path / "out", workers=1, profile="facebuilder", detect={"min_area_px": 10_000}
    )
    assert [row["name"] for row in table.rows] == ["anna", "berta", "clara"]
    assert len(table.failed) == 3 and "dots" in table.failed[0]["error"]
    nothing = fr.batch([], tmp_path / "none")
    assert nothing.rows == [] and nothing.csv.read_text().count("\n") == 1
    lost = fr.batch(tmp_path / "nowhere", tmp_path / "lost")
    assert lost.rows[0]["status"] == "failed" and "nowhere" in lost.rows[0]["error"]


def test_a_process_that_dies_takes_no_other_with_it(
    captures: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first process is killed as soon as it works; its capture is done by the next."""
    begun: list[subprocess.Popen[str]] = []
    start = subprocess.Popen

    def watched(*arguments: Any, **options: Any) -> Any:
        process = start(*arguments, **options)
        begun.append(process)
        if len(begun) == 1:
            threading.Timer(1.0, process.kill).start()
        return process

    monkeypatch.setattr(subprocess, "Popen", watched)
    good = [captures[0], captures[2]]
    table = fr.batch(good, tmp_path / "out", workers=1, **SMALL)
    assert [row["status"] for row in table.rows] == ["done", "done"]
    assert len(begun) == 2 and begun[0].returncode == -signal.SIGKILL
    assert all(p.returncode is not None for p in begun), "a process is left"


def test_a_capture_given_again_by_its_own_batch_is_done(
    captures: list[Path], tmp_path: Path
) -> None:
    """Its worker died between the work and the answer: the result is used and counts as done."""
    toml = fr.Params(texture={"size": 128}).to_toml()
    first, again, later = (
        run_one((str(captures[0]), "anna", str(tmp_path), toml, "head", "model", name))
        for name in ("monday", "monday", "tuesday")
    )
    assert [row["status"] for row in (first, again, later)] == ["done", "done", "kept"]
    assert first == again and first["total_ms"] == later["total_ms"]


def test_the_command_resumes_the_same_batch(captures: list[Path], tmp_path: Path) -> None:
    ours = fr.batch(captures, tmp_path / "out", workers=2, **SMALL)
    command = Path(sys.executable).parent / "facerecon"
    done = subprocess.run(
        [
            command,
            "batch",
            captures[0].parent,
            "-o",
            tmp_path / "out",
            "--json",
            "-q",
            "--set",
            "texture.size=128",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    rows = json.loads(done.stdout)
    assert [r["status"] for r in rows] == ["kept", "failed", "kept"]
    for theirs, mine in zip(rows, ours.rows, strict=True):
        assert {**theirs, "status": ""} == {**mine, "status": ""}


def finished(out: Path) -> dict[str, int]:
    """Captures that are finished, and when."""
    return {p.parent.name: p.stat().st_mtime_ns for p in out.glob("*/fingerprint.txt")}


def test_a_dask_worker_that_dies_loses_nothing(captures: list[Path], tmp_path: Path) -> None:
    """One of two is killed in the middle: nothing is lost, nothing finished is done again."""
    distributed = pytest.importorskip("distributed")
    home, out = tmp_path / "many", tmp_path / "out"
    many = [shutil.copytree(captures[0], home / f"person{i}") for i in range(5)]
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    )
    before: dict[str, int] = {}
    with cluster, distributed.Client(cluster) as client:
        victim = next(iter(client.scheduler_info()["workers"]))
        pid = client.run(os.getpid, workers=[victim])[victim]

        def kill() -> None:
            # in the middle: some are finished, and it works on another
            while not (len(finished(out)) >= 2 and client.processing()[victim]):
                time.sleep(0.01)
            os.kill(pid, signal.SIGKILL)
            before.update(finished(out))

        killer = threading.Thread(target=kill)
        killer.start()
        table = fr.batch(many, out, client=client, **SMALL)
        killer.join()
    assert 2 <= len(before) < 5, "it was not in the middle"
    assert [row["status"] for row in table.rows] == ["done"] * 5
    assert [row["name"] for row in table.rows] == [p.name for p in many]
    after = finished(out)
    assert len(after) == 5 and {n: after[n] for n in before} == before
    assert len({(out / p.name / "face.obj").read_bytes() for p in many}) == 1


def test_a_failure_on_dask_stops_nothing(captures: list[Path], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.Client(
        processes=False, n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as client:
        table = fr.batch(captures[:2], tmp_path, client=client, **SMALL)
        assert [row["status"] for row in table.rows] == ["done", "failed"]
        with pytest.raises(ValueError, match="workers and client"):
            fr.batch(captures, tmp_path, client=client, workers=2)

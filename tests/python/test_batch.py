"""Many captures: one failure stops nothing, nothing is done twice, a dead worker loses nothing."""

from __future__ import annotations

import os
import shutil
import signal
import threading
import time
from pathlib import Path

import facerecon as fr
import pytest


@pytest.fixture(scope="module")
def captures(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two good ones and a broken one between them."""
    home = tmp_path_factory.mktemp("many")
    for name in ("anna", "berta", "clara"):
        shutil.copytree(folder, home / name)
    (home / "berta" / "left_dots.png").unlink(missing_ok=True)
    (home / "berta" / "capture.toml").write_text("[images]\nleft = 'gone.png'\n")
    return [home / name for name in ("anna", "berta", "clara")]


def test_a_batch_is_resumed(captures: list[Path], tmp_path: Path) -> None:
    first = fr.batch(captures, tmp_path / "out", workers=2, smooth={"steps": 1})
    assert [row["status"] for row in first.rows] == ["done", "failed", "done"]
    assert "right" in first.failed[0]["error"] or "gone" in first.failed[0]["error"]
    made = tmp_path / "out" / "anna" / "face.glb"
    before = made.stat().st_mtime_ns
    again = fr.batch(captures, tmp_path / "out", workers=1, smooth={"steps": 1})
    assert [row["status"] for row in again.rows] == ["kept", "failed", "kept"]
    assert made.stat().st_mtime_ns == before
    other = fr.batch(captures[:1], tmp_path / "out", workers=1, smooth={"steps": 2})
    assert other.rows[0]["status"] == "done" and made.stat().st_mtime_ns != before
    assert "anna" in first.csv.read_text() and "report.html" in first.html.read_text()
    assert len(first.to_pandas()) == 3 and "<table" in first._repr_html_()


def test_two_captures_of_one_name_are_refused(captures: list[Path], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="anna"):
        fr.batch([captures[0], captures[0]], tmp_path)


def test_a_dask_worker_that_dies_loses_nothing(captures: list[Path], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        victim = next(iter(client.scheduler_info()["workers"]))
        pid = client.run(os.getpid, workers=[victim])[victim]
        died = threading.Event()

        def kill() -> None:
            while not client.processing()[victim]:
                time.sleep(0.01)
            os.kill(pid, signal.SIGKILL)
            died.set()

        killer = threading.Thread(target=kill)
        killer.start()
        table = fr.batch([captures[0], captures[2]], tmp_path / "out", client=client)
        killer.join()
    assert died.is_set()
    assert [row["status"] for row in table.rows] == ["done", "done"]
    assert sorted(p.name for p in (tmp_path / "out").iterdir() if p.is_dir()) == ["anna", "clara"]

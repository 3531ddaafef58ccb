"""A batch on processes of this machine.

Each process is a new interpreter (:mod:`facerecon._worker`) that reads jobs from stdin and writes
rows to stdout, one JSON text per line. Unlike a process of :mod:`multiprocessing` it does not
import the caller's script, can be stopped at any time, and affects only its own capture when it
dies (out of memory, for example).
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Generator
from pathlib import Path
from typing import Any

from . import _core

#: Capture, name, output folder, parameters as TOML, template, frame, name of the batch.
Job = tuple[str, str, str, str, str, str, str]
Row = dict[str, Any]
#: Number of attempts for a capture whose process dies.
TRIES = 2


def run_one(job: Job) -> Row:
    """Reconstruct one capture in a worker; errors become a row too."""
    capture, _name, out, toml, template, frame, batch = job
    try:
        params = _core.Params(None, toml, [])
        row: Row = json.loads(_core.batch_run(capture, out, template, params, frame, batch))
    except Exception as error:  # one failure does not stop the others
        row = failed(job, str(error))
    return row


def failed(job: Job, why: str) -> Row:
    """The row of a capture that failed."""
    row: Row = {"name": job[1], "status": "failed"}
    row |= dict.fromkeys(("matches", "face_width_mm", "face_height_mm", "total_ms"))
    return {**row, "warnings": 0, "error": why}


def run_all(jobs: list[Job], workers: int) -> Generator[tuple[int, Row], None, None]:
    """Indices and rows of all jobs, in order of completion."""
    todo: queue.SimpleQueue[int] = queue.SimpleQueue()
    done: queue.SimpleQueue[tuple[int, Row]] = queue.SimpleQueue()
    for number in range(len(jobs)):
        todo.put(number)
    pool = [_Worker(workers) for _ in range(min(workers, len(jobs)))]

    def drive(worker: _Worker) -> None:
        while not worker.stopped:
            try:
                number = todo.get_nowait()
            except queue.Empty:
                break
            done.put((number, worker.run(jobs[number])))
        worker.stop()

    for worker in pool:
        threading.Thread(target=drive, args=(worker,), daemon=True).start()
    try:
        for _ in jobs:
            yield done.get()
    finally:
        for worker in pool:
            worker.stop()


class _Worker:
    """A process that handles one capture after another; when it dies, a new one is started."""

    def __init__(self, workers: int) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._lock = threading.Lock()
        self.stopped = False
        package = str(Path(__file__).resolve().parent.parent)
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        cores = os.cpu_count() or 1
        self._environment = {
            # all processes together use each core once
            "RAYON_NUM_THREADS": str(max(1, cores // workers)),
            **os.environ,
            "PYTHONPATH": os.pathsep.join(paths),
        }

    def run(self, job: Job) -> Row:
        """The row of a job; a failed row when its processes die or cannot start."""
        code: int | None = None
        for _ in range(TRIES):
            try:
                process = self._running()
                assert process.stdin is not None and process.stdout is not None
                process.stdin.write(json.dumps(job) + "\n")
                process.stdin.flush()
                answer = process.stdout.readline()
                if answer.endswith("\n"):
                    row: Row = json.loads(answer)
                    return row
                code = process.wait()
            except BrokenPipeError:
                code = process.wait()
            except Exception as error:
                return failed(job, f"the worker process could not be used: {error}")
            with self._lock:
                self._process = None
        return failed(
            job,
            f"its worker process died {TRIES} times (exit code {code}); "
            "if memory is short, use fewer workers",
        )

    def _running(self) -> subprocess.Popen[str]:
        with self._lock:
            if self.stopped:
                raise RuntimeError("the batch was stopped")
            if self._process is None:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "facerecon._worker"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    text=True,
                    encoding="utf-8",
                    env=self._environment,
                    # Ctrl-C goes to the batch only, which then stops its processes
                    start_new_session=True,
                )
            return self._process

    def stop(self) -> None:
        """Kill the process; files are written completely or not at all."""
        with self._lock:
            self.stopped = True
            process, self._process = self._process, None
            if process is None:
                return
            process.kill()
            process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                try:
                    stream.close()
                except BrokenPipeError:
                    pass

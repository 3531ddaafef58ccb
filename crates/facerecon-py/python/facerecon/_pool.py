"""Captures of a batch on processes of this machine.

Each process is a new interpreter (:mod:`facerecon._worker`) that reads jobs from its input and
writes rows to its output, one JSON text a line. Unlike those of :mod:`multiprocessing` it does not
import the caller's script again, can be stopped at any time, and when it dies (out of memory, say)
only its own capture is concerned.
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

#: Capture, output folder, parameters as TOML, template, frame, name of the batch.
Job = tuple[str, str, str, str, str, str]
Row = dict[str, Any]
#: A capture whose process dies is tried so many times.
TRIES = 2


def run_one(job: Job) -> Row:
    """One capture, in a worker: its row, whatever happens."""
    capture, out, toml, template, frame, batch = job
    try:
        params = _core.Params(None, toml, [])
        row: Row = json.loads(_core.batch_run(capture, out, template, params, frame, batch))
    except Exception as error:  # one failure does not stop the rest
        row = failed(job, str(error))
    return row


def failed(job: Job, why: str) -> Row:
    """The row of a capture whose worker could not even begin or died."""
    row: Row = {"name": Path(job[0]).name, "status": "failed"}
    row |= dict.fromkeys(("matches", "face_width_mm", "face_height_mm", "total_ms"))
    return {**row, "warnings": 0, "error": why}


def run_all(jobs: list[Job], workers: int) -> Generator[tuple[int, Row], None, None]:
    """Numbers and rows of all jobs as they end."""
    todo: queue.SimpleQueue[int] = queue.SimpleQueue()
    done: queue.SimpleQueue[tuple[int, Row]] = queue.SimpleQueue()
    for number in range(len(jobs)):
        todo.put(number)
    crew = [_Worker(workers) for _ in range(min(workers, len(jobs)))]

    def drive(worker: _Worker) -> None:
        while not worker.stopped:
            try:
                number = todo.get_nowait()
            except queue.Empty:
                break
            done.put((number, worker.run(jobs[number])))
        worker.stop()

    for worker in crew:
        threading.Thread(target=drive, args=(worker,), daemon=True).start()
    try:
        for _ in jobs:
            yield done.get()
    finally:
        for worker in crew:
            worker.stop()


class _Worker:
    """A process that does one capture after another; a new one takes over when it dies."""

    def __init__(self, crew: int) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._lock = threading.Lock()
        self.stopped = False
        package = str(Path(__file__).resolve().parent.parent)
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        cores = os.cpu_count() or 1
        self._environment = {
            # all together use the machine once
            "RAYON_NUM_THREADS": str(max(1, cores // crew)),
            **os.environ,
            "PYTHONPATH": os.pathsep.join(paths),
        }

    def run(self, job: Job) -> Row:
        """The row of a job; that of a failure when its processes die or cannot start."""
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
                return failed(job, f"no process could work on it: {error}")
            with self._lock:
                self._process = None
        return failed(
            job,
            f"the process that worked on it died {TRIES} times (exit code {code}); "
            "is there enough memory for so many workers?",
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
                    # Ctrl-C in a terminal is for the batch, which then stops its processes
                    start_new_session=True,
                )
            return self._process

    def stop(self) -> None:
        """Ends the process at once; files are written whole or not at all."""
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

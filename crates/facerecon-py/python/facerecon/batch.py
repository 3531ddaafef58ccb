"""Many captures: a process pool on one machine, or a Dask cluster; resumable."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _core
from .errors import ParameterError
from .params import Params, to_sets

Job = tuple[str, str, str, str, str]


@dataclass(frozen=True, eq=False)
class BatchResult:
    """What came of a batch.

    Attributes:
        rows: one dictionary a capture, in the order given: ``name``, ``status`` (``"done"``,
            ``"kept"`` from an earlier run, ``"failed"``), ``matches``, ``face_width_mm``,
            ``face_height_mm``, ``total_ms``, ``warnings`` (their number), ``error``.
        csv, html: paths of the tables.
    """

    rows: list[dict[str, Any]]
    csv: Path
    html: Path

    @property
    def failed(self) -> list[dict[str, Any]]:
        """The rows of captures that could not be reconstructed."""
        return [row for row in self.rows if row["status"] == "failed"]

    def to_pandas(self) -> Any:
        """The rows as a ``pandas.DataFrame``."""
        import pandas as pd

        return pd.DataFrame(self.rows)

    def __repr__(self) -> str:
        counts = {s: sum(r["status"] == s for r in self.rows) for s in ("done", "kept", "failed")}
        words = ", ".join(f"{n} {s}" for s, n in counts.items())
        return f"<facerecon.BatchResult: {words}>"

    def _repr_html_(self) -> str:
        return _core.batch_tables(json.dumps(self.rows))[1]


def batch(
    captures: Iterable[str | PathLike[str]],
    out: str | PathLike[str],
    *,
    workers: int | None = None,
    client: Any = None,
    profile: str | None = None,
    params: Params | None = None,
    template: str | PathLike[str] = "head",
    frame: str = "model",
    progress: bool = False,
    **settings: Any,
) -> BatchResult:
    """Reconstructs many captures, each into ``out/NAME``.

    A capture that is finished is not done again unless its photos, the parameters, the template
    or the version changed. One failure does not stop the rest.

    Args:
        captures: folders or ``capture.toml`` files; their folders' names must differ.
        out: folder for the results, and for ``batch.csv`` and ``batch.html``.
        workers: processes on this machine; by default one for each core.
        client: a ``dask.distributed.Client`` instead (extra ``[dask]``); its workers must see the
            same paths. Captures of a worker that dies are given to another.
        progress: draw a bar (extra ``[viz]``).

    Raises:
        ParameterError: (a ``ValueError``) for parameters, or two captures of one name.
    """
    if params is not None and (profile is not None or settings):
        raise ParameterError(
            "params is given together with a profile or settings; put them into the Params",
            "parameters",
        )
    if workers is not None and workers < 1:
        raise ParameterError(f"workers is {workers}, but 1 or more is wanted", "parameters")
    core = params._core if params is not None else _core.Params(profile, None, to_sets(settings))
    folder = Path(out).absolute()
    paths = [Path(c).absolute() for c in captures]
    names = [(p.parent if p.is_file() else p).name for p in paths]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ParameterError(
            f"captures: more than one is named {', '.join(twice)}; their results would overwrite "
            "each other",
            "parameters",
        )
    common = (str(folder), core.to_toml(), fspath(template), frame)
    jobs: list[Job] = [(str(p), *common) for p in paths]
    found = _on_dask(jobs, client, progress) if client is not None else _on_pool(
        jobs, workers or os.cpu_count() or 1, progress
    )
    rows = [found[i] for i in range(len(jobs))]
    csv_text, html_text = _core.batch_tables(json.dumps(rows))
    folder.mkdir(parents=True, exist_ok=True)
    csv, page = folder / "batch.csv", folder / "batch.html"
    csv.write_text(csv_text, encoding="utf-8")
    page.write_text(html_text, encoding="utf-8")
    return BatchResult(rows, csv, page)


def run_one(job: Job) -> dict[str, Any]:
    """One capture, in a worker."""
    capture, out, toml, template, frame = job
    try:
        params = _core.Params(None, toml, [])
        row: dict[str, Any] = json.loads(_core.batch_run(capture, out, template, params, frame))
    except Exception as error:  # one failure does not stop the rest
        row = failed(job, str(error))
    return row


def failed(job: Job, why: str) -> dict[str, Any]:
    """The row of a capture whose worker could not even begin."""
    path = Path(job[0])
    row: dict[str, Any] = dict.fromkeys(
        ("matches", "face_width_mm", "face_height_mm", "total_ms")
    )
    name = (path.parent if path.is_file() else path).name
    return {"name": name, "status": "failed", **row, "warnings": 0, "error": why}


def _on_pool(jobs: list[Job], workers: int, progress: bool) -> dict[int, dict[str, Any]]:
    found: dict[int, dict[str, Any]] = {}
    bar = _bar(len(jobs), progress)
    # a new interpreter for each worker: threads of the core do not survive a fork
    spawn = get_context("spawn")
    with ProcessPoolExecutor(min(workers, max(1, len(jobs))), mp_context=spawn) as pool:
        futures = {pool.submit(run_one, job): i for i, job in enumerate(jobs)}
        try:
            for future in as_completed(futures):
                number = futures[future]
                error = future.exception()
                found[number] = (
                    future.result() if error is None else failed(jobs[number], str(error))
                )
                bar.update()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        finally:
            bar.close()
    return found


def _on_dask(jobs: list[Job], client: Any, progress: bool) -> dict[int, dict[str, Any]]:
    from distributed import as_completed as as_they_end

    found: dict[int, dict[str, Any]] = {}
    bar = _bar(len(jobs), progress)
    futures = client.map(run_one, jobs, pure=False, retries=3)
    numbers = {future.key: i for i, future in enumerate(futures)}
    try:
        for future in as_they_end(futures):
            number = numbers[future.key]
            if future.status == "finished":
                found[number] = future.result()
            else:
                found[number] = failed(jobs[number], str(future.exception()))
            bar.update()
    except BaseException:
        client.cancel(futures)
        raise
    finally:
        bar.close()
    return found


class _NoBar:
    def update(self) -> None:
        pass

    def close(self) -> None:
        pass


def _bar(total: int, progress: bool) -> Any:
    if not progress:
        return _NoBar()
    from tqdm.auto import tqdm

    return tqdm(total=total, unit="capture")

"""Batches: many captures on processes of one machine or on a Dask cluster; resumable."""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Generator, Iterable
from contextlib import closing
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _core
from ._pool import Job, failed, run_all, run_one
from .errors import ParameterError
from .params import Params, given_params
from .progress import bar


@dataclass(frozen=True, eq=False)
class BatchResult:
    """The outcome of a batch.

    Attributes:
        rows: one dictionary per capture, in the order given: ``name``, ``status`` (``"done"``,
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
        shown = ", ".join(f"{n} {s}" for s, n in counts.items())
        return f"<facerecon.BatchResult: {shown}>"

    def _repr_html_(self) -> str:
        page = _core.batch_tables(json.dumps(self.rows))[1]
        # the table only: the style of the page would affect the notebook
        return page[page.index("<table>") :]


def batch(
    captures: str | PathLike[str] | Iterable[str | PathLike[str]],
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
    """Reconstruct many captures, each into ``out/NAME``, like ``facerecon batch``.

    A finished capture is skipped unless its photos, the parameters, the template, the frame or
    the version changed. A failure (an error or a process that dies) does not stop the others.
    Ctrl-C stops the batch within a second; finished results are kept.

    Args:
        captures: capture folders or ``capture.toml`` files, or folders of such folders; the
            names of the captures must differ.
        out: folder for the results, and for ``batch.csv`` and ``batch.html``.
        workers: number of processes on this machine; by default one per core.
        client: a ``dask.distributed.Client`` instead (extra ``[dask]``); its workers must have
            access to the same paths and should have one thread each. When a worker dies, another
            one takes its captures.
        profile: ``"precise"`` (the default) or ``"facebuilder"`` (the thesis).
        params: all parameters; not together with ``profile`` or ``settings``.
        template: name or file of the template.
        frame: ``"model"`` or ``"camera"``: the frame of the files written.
        progress: draw a progress bar (extra ``[viz]``).
        settings: single parameters in groups, e.g. ``smooth={"steps": 3}``.

    Returns:
        The table of results, also written to ``out`` as CSV and HTML.

    Raises:
        ParameterError: (a ``ValueError``) for invalid parameters, or captures with the same name.
        FileError: (an ``OSError``) for a template that cannot be read.
        OSError: when the tables cannot be written.
        ImportError: for a client or a progress bar without its extra.
    """
    core = given_params(profile, params, settings)
    if workers is not None and (isinstance(workers, bool) or workers < 1):
        raise ParameterError(f"workers is {workers}; expected 1 or more", "parameters")
    if workers is not None and client is not None:
        raise ParameterError("workers and client are both given; give only one", "parameters")
    if frame not in ("model", "camera"):
        raise ParameterError(f'frame is {frame!r}; expected "model" or "camera"', "parameters")
    _core.Template.load(fspath(template))
    several = [captures] if isinstance(captures, str | PathLike) else captures
    found = _core.batch_captures([Path(path).absolute() for path in several])
    folder = Path(out).absolute()
    # the name of the batch marks its own results as done when a dead worker's capture is repeated
    common = (str(folder), core.to_toml(), fspath(template), frame, uuid.uuid4().hex)
    jobs: list[Job] = [(str(path), name, *common) for path, name in found]
    if client is not None:
        finished = _on_dask(jobs, client)
    else:
        finished = run_all(jobs, workers or os.cpu_count() or 1)
    rows: list[dict[str, Any]] = [{}] * len(jobs)
    with bar(len(jobs), "capture", progress) as advance, closing(finished):
        for number, row in finished:
            rows[number] = {**row, "name": jobs[number][1]}
            advance()
    csv_text, html_text = _core.batch_tables(json.dumps(rows))
    folder.mkdir(parents=True, exist_ok=True)
    csv, page = folder / "batch.csv", folder / "batch.html"
    csv.write_text(csv_text, encoding="utf-8")
    page.write_text(html_text, encoding="utf-8")
    return BatchResult(rows, csv, page)


def _on_dask(jobs: list[Job], client: Any) -> Generator[tuple[int, dict[str, Any]], None, None]:
    """Indices and rows in order of completion. Dask repeats the work of a dead worker itself."""
    try:
        from distributed import as_completed
    except ImportError as error:
        raise ImportError("a client needs Dask: pip install 'facerecon[dask]'") from error

    futures = client.map(run_one, jobs, pure=False)
    numbers = {future.key: i for i, future in enumerate(futures)}
    try:
        for future in as_completed(list(futures)):
            number = numbers[future.key]
            if future.status == "finished":
                row = future.result()
            else:
                row = failed(jobs[number], str(future.exception()))
            # an unreleased result would be computed again if its worker dies
            futures.remove(future)
            future.release()
            yield number, row
    finally:
        client.cancel(futures)

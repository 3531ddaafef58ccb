"""Many captures: a pool of processes on one machine, or a Dask cluster; resumable."""

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
        page = _core.batch_tables(json.dumps(self.rows))[1]
        # the table alone: the page's style would change the notebook's
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
    """Reconstructs many captures, each into ``out/NAME``, like ``facerecon batch``.

    A capture that is finished is not done again unless its photos, the parameters, the template,
    the frame or the version changed. One failure does not stop the rest, be it an error or a
    process that dies. Ctrl-C stops it within a second; what is finished by then is kept.

    Args:
        captures: capture folders or ``capture.toml`` files, or folders that hold such folders;
            the captures' names must differ.
        out: folder for the results, and for ``batch.csv`` and ``batch.html``.
        workers: processes on this machine; by default one for each core.
        client: a ``dask.distributed.Client`` instead (extra ``[dask]``); its workers must see the
            same paths and should have one thread each. Captures of a worker that dies are given
            to another.
        profile: ``"precise"`` (the default) or ``"facebuilder"``, the thesis.
        params: all parameters; not together with ``profile`` or ``settings``.
        template: name or file of the generic head.
        frame: ``"model"`` or ``"camera"``: the frame of the files written.
        progress: draw a bar (extra ``[viz]``).
        settings: single parameters in groups, e.g. ``smooth={"steps": 3}``.

    Returns:
        The table of results, also written to ``out`` as CSV and HTML.

    Raises:
        ParameterError: (a ``ValueError``) for parameters, or two captures of one name.
        FileError: (an ``OSError``) for a template that cannot be read.
        OSError: when the tables cannot be written.
        ImportError: for a client or a bar without their extra.
    """
    core = given_params(profile, params, settings)
    if workers is not None and (isinstance(workers, bool) or workers < 1):
        raise ParameterError(f"workers is {workers}, but 1 or more is wanted", "parameters")
    if workers is not None and client is not None:
        raise ParameterError("workers and client are given together; give one", "parameters")
    if frame not in ("model", "camera"):
        raise ParameterError(f'frame is {frame!r}, but must be "model" or "camera"', "parameters")
    _core.Template.load(fspath(template))
    paths = _captures(captures)
    names = [_name(p) for p in paths]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ParameterError(
            f"captures: more than one is named {', '.join(twice)}; their results would overwrite "
            "each other",
            "parameters",
        )
    folder = Path(out).absolute()
    # a capture given again because its worker died after the work still counts as done
    common = (str(folder), core.to_toml(), fspath(template), frame, uuid.uuid4().hex)
    jobs: list[Job] = [(str(p), *common) for p in paths]
    if client is not None:
        finished = _on_dask(jobs, client)
    else:
        finished = run_all(jobs, workers or os.cpu_count() or 1)
    rows: list[dict[str, Any]] = [{}] * len(jobs)
    with bar(len(jobs), "capture", progress) as advance, closing(finished):
        for number, row in finished:
            rows[number] = {**row, "name": names[number]}
            advance()
    csv_text, html_text = _core.batch_tables(json.dumps(rows))
    folder.mkdir(parents=True, exist_ok=True)
    csv, page = folder / "batch.csv", folder / "batch.html"
    csv.write_text(csv_text, encoding="utf-8")
    page.write_text(html_text, encoding="utf-8")
    return BatchResult(rows, csv, page)


def _name(capture: Path) -> str:
    return (capture.parent if capture.is_file() else capture).name


def _captures(given: str | PathLike[str] | Iterable[str | PathLike[str]]) -> list[Path]:
    """The captures named, and those in the folders named, in the order of their names."""
    several = [given] if isinstance(given, str | PathLike) else given
    found: list[Path] = []
    for path in (Path(g).absolute() for g in several):
        inside: list[Path] = []
        if path.is_dir() and not (path / "capture.toml").is_file():
            inside = sorted(p.parent for p in path.glob("*/capture.toml"))
        found += inside or [path]
    return found


def _on_dask(jobs: list[Job], client: Any) -> Generator[tuple[int, dict[str, Any]], None, None]:
    """Numbers and rows as they end. Dask gives the work of a dead worker to another by itself."""
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
            # else it would be worked out again should the worker that remembers it die
            futures.remove(future)
            future.release()
            yield number, row
    finally:
        client.cancel(futures)

"""Makers and judges around the pipeline: simulate, pattern, check, render, compare."""

from __future__ import annotations

import json
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import F32, F64, U8, column
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh, as_mesh
from .params import to_sets
from .progress import Callback, watcher


class Simulation:
    """A simulated capture and its truth; made by :func:`simulate`.

    No features are marked in the capture; a made-up person's has the thesis's three pairs.
    """

    def __init__(self, core: _core.Simulation) -> None:
        self._core = core

    @property
    def capture(self) -> Capture:
        """The photographs and what is told to the reconstruction."""
        return Capture._wrap(self._core.capture())

    @property
    def mesh(self) -> Mesh:
        """The subject, left camera's frame, mm."""
        return Mesh._from_parts(self._core.mesh())

    @property
    def depth_mm(self) -> F32:
        """(height, width) depth of the subject in the left photo, mm; NaN beside it."""
        return self._core.depth()

    @property
    def face(self) -> npt.NDArray[np.bool_]:
        """(height, width) whether a pixel of the left photo shows the face."""
        return self._core.face()

    @property
    def camera_from_model(self) -> F64:
        """(4, 4) left camera's frame from the subject's model frame."""
        return self._core.camera_from_model()

    def save(self, folder: str | PathLike[str]) -> str:
        """Write the capture folder with the truth beside it.

        Returns:
            The path of ``capture.toml``.

        Raises:
            FileError: (an ``OSError``) naming the file that could not be written.
        """
        return fspath(self._core.save(fspath(folder)))

    def __repr__(self) -> str:
        return f"<facerecon.Simulation of {self.mesh!r}: {self.capture!r}>"

    def _repr_html_(self) -> str:
        return self.capture._repr_html_()


def simulate(
    mesh: Mesh | None = None,
    *,
    subject: int = 1,
    progress: bool | Callback = False,
    **settings: Any,
) -> Simulation:
    """Photographs a mesh in a virtual stereo rig, with and without the projected pattern.

    Args:
        mesh: model frame (x right, y up, z toward the viewer), mm, with texture or vertex
            colours; by default the made-up person number ``subject``.
        subject: number of the made-up person, 0 or more; the same number is the same person.
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: of the rig, e.g. ``distance_mm=1300``, ``toe_in_deg=4``, ``yaw_deg=10``,
            ``pattern={"columns": 60}``; an unknown name is answered with all of them.

    Returns:
        The capture and its truth.

    Raises:
        ParameterError: (a ``ValueError``) for arguments and settings.
        SimulateError: for a subject outside the photos or an impossible rig.
    """
    if not isinstance(subject, int | np.integer) or not 0 <= subject < 2**64:
        raise ParameterError(
            f"subject is {subject!r}, but a whole number from 0 is wanted", "parameters"
        )
    parts = skin = None
    if mesh is not None:
        parts, skin = as_mesh("mesh", mesh)._parts(), mesh._texture()
    watch = watcher(progress, ("simulate",))
    try:
        return Simulation(
            _core.simulate(int(subject), parts, skin, to_sets(settings), watch.callback)
        )
    finally:
        watch.close()


def pattern(**settings: Any) -> U8:
    """The image to project, (height, width, 3) uint8: a lattice of dots, or stripes.

    Args:
        settings: ``kind`` (``"dots"`` or ``"stripes"``), ``columns``, ``rows``, ``width_px``,
            ``height_px``, ``dot_fraction``, ``margin_fraction``, ``rotation_deg``.

    Raises:
        ParameterError: (a ``ValueError``) for unknown settings and values out of range.
        PatternError: for a pattern that cannot be made.
    """
    return _core.pattern(to_sets(settings))


@dataclass(frozen=True)
class Finding:
    """A rule for a good capture, and how it was kept.

    Attributes:
        rule: its name.
        verdict: ``"good"``, ``"warning"``, or ``"unknown"`` when it could not be measured.
        message: what was found and what is wanted, with figures.
        advice: what to do about it; empty when nothing.
    """

    rule: str
    verdict: str
    message: str
    advice: str


def check(capture: Capture | str | PathLike[str], **settings: Any) -> list[Finding]:
    """Whether the photographs will do, by the rules of thesis section 6.5.1; ``facerecon check``.

    Args:
        capture: a :class:`Capture`, or its path.
        settings: limits of the rules, e.g. ``min_width=640``; an unknown name is answered with all
            of them.

    Returns:
        One finding a rule. A capture that breaks one may still be reconstructed.

    Raises:
        ParameterError: (a ``ValueError``) for settings.
        FileError: (an ``OSError``) for a capture that cannot be read.
    """
    found = json.loads(_core.check(as_capture(capture)._core, to_sets(settings)))
    return [Finding(**finding) for finding in found]


def render(
    mesh: Mesh,
    view: str | Sequence[str] = "front",
    *,
    mode: str | None = None,
    heat: Any = None,
    limit_mm: float | None = None,
    frame: str = "model",
    size: tuple[int, int] = (512, 512),
) -> U8:
    """A picture (height, width, 3) uint8 of a mesh from named views, side by side; no display.

    Args:
        mesh: the mesh, with faces.
        view: ``front``, ``three-quarter``, ``profile`` ..., or several.
        mode: ``shaded``, ``textured``, ``lit``, ``wireframe`` or ``heat``; by default what the
            mesh has.
        heat: (n,) a value for each vertex, at least 0, for ``heat``; NaN is grey.
        limit_mm: value at the end of the scale.
        frame: ``"model"`` or ``"camera"``: the mesh's axes.
        size: (width, height) of each picture, pixels.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        RenderError: for a mesh that cannot be drawn, or a picture too large.
    """
    as_mesh("mesh", mesh)
    values = None if heat is None else column("heat", heat, len(mesh.vertices))
    if values is not None and not (np.isnan(values) | ((values >= 0) & (values < np.inf))).all():
        raise ParameterError(
            f"heat has shape {values.shape} and values from {np.nanmin(values)} to "
            f"{np.nanmax(values)}, but finite values of at least 0 are wanted, NaN where unknown",
            "parameters",
        )
    if mode is None:
        coloured = mesh.texture is not None or mesh.colors is not None
        mode = "heat" if values is not None else "lit" if coloured else "shaded"
    views = [view] if isinstance(view, str) else list(view)
    try:
        width, height = (operator.index(n) for n in size)
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"size is {size!r}, but (width, height) is wanted", "parameters"
        ) from error
    if min(width, height) < 1:
        raise ParameterError(f"size is {size}, but at least (1, 1) is wanted", "parameters")
    return _core.render(
        mesh._parts(), mesh._texture(), values, limit_mm, views, mode, frame, (width, height)
    )


@dataclass(frozen=True, eq=False)
class Comparison:
    """Distances between two meshes.

    Attributes:
        facts: statistics ``before`` and ``after`` the alignment, in both directions, mm;
            ``second_from_first`` (4x4), ``scale``, ``rotation_deg``, ``iterations``.
        vertex_distances: (n,) of each vertex of the first mesh, mm; NaN beyond the reach.
    """

    facts: dict[str, Any]
    vertex_distances: F64

    @property
    def median_mm(self) -> float:
        """Median distance of the first surface from the second, after the alignment if any."""
        both = self.facts["after"] or self.facts["before"]
        return float(both["first_to_second"]["median_mm"])

    def __repr__(self) -> str:
        return f"<facerecon.Comparison: median {self.median_mm:.3f} mm>"

    def _repr_html_(self) -> str:
        cells = ["<th></th><th>median</th><th>90 %</th><th>99 %</th><th>greatest</th>"]
        for when, both in self.facts.items():
            if when not in ("before", "after") or both is None:
                continue
            for side in ("first_to_second", "second_to_first"):
                numbers = [both[side][k] for k in ("median_mm", "p90_mm", "p99_mm", "max_mm")]
                words = f"{side.replace('_', ' ')}, {when} alignment"
                cells.append(f"<td>{words}</td>" + "".join(f"<td>{n:.3f}</td>" for n in numbers))
        return "<table>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table><p>mm</p>"


def compare(first: Mesh, second: Mesh, *, region: Any = None, **settings: Any) -> Comparison:
    """Distances between two meshes, as they lie and after the best alignment.

    Args:
        first, second: the meshes; lengths are theirs, millimetres by custom.
        region: (n,) bool, the vertices of ``first`` that count.
        settings: ``alignment`` (``"none"``, ``"rigid"``, ``"similarity"``), ``samples``, ``keep``,
            ``iterations``, ``reach_mm``.

    Raises:
        ParameterError: (a ``ValueError``) for arguments and settings.
        CompareError: for meshes that cannot be compared.
    """
    as_mesh("first", first)
    as_mesh("second", second)
    mask = None
    if region is not None:
        array = np.asarray(region)
        if array.shape != (len(first.vertices),) or array.dtype != np.bool_:
            raise ParameterError(
                f"region has shape {array.shape} and type {array.dtype}, "
                f"but ({len(first.vertices)},) of bool is wanted",
                "parameters",
            )
        mask = array.tolist()
    text, distances = _core.compare(first._parts(), second._parts(), mask, to_sets(settings))
    return Comparison(json.loads(text), distances)

"""Functions around the pipeline: simulate, pattern, check, render, compare."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import F32, F64, U8, column
from ._render import draw
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh, as_mesh
from .params import to_sets
from .progress import Callback, watcher


class Simulation:
    """A simulated capture with its ground truth; the result of :func:`simulate`.

    No landmarks are marked in the capture. For a simulated person it has the three seeds of the
    thesis.
    """

    def __init__(self, core: _core.Simulation) -> None:
        self._core = core

    @property
    def capture(self) -> Capture:
        """The photographs, pattern, rig and seeds."""
        return Capture._wrap(self._core.capture())

    @property
    def mesh(self) -> Mesh:
        """The subject, camera frame, mm."""
        return Mesh._from_parts(self._core.mesh())

    @property
    def depth_mm(self) -> F32:
        """(height, width) depth of the subject in the left photo, mm; NaN in the background."""
        return self._core.depth()

    @property
    def face(self) -> npt.NDArray[np.bool_]:
        """(height, width) whether a pixel of the left photo shows the face."""
        return self._core.face()

    @property
    def camera_from_model(self) -> F64:
        """(4, 4) camera frame from the model frame of the subject."""
        return self._core.camera_from_model()

    def save(self, folder: str | PathLike[str]) -> str:
        """Write the capture folder, with the ground truth beside it.

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
    """Render a mesh in a virtual stereo rig, with and without the projected pattern.

    Args:
        mesh: model frame (x right, y up, z toward the viewer), mm, with texture or vertex
            colours; by default the simulated person number ``subject``.
        subject: number of the simulated person, 0 or more; the same number gives the same person.
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: of the rig, e.g. ``distance_mm=1300``, ``toe_in_deg=4``, ``yaw_deg=10``,
            ``pattern={"columns": 60}``; the error for an unknown name lists all.

    Returns:
        The capture and its ground truth.

    Raises:
        ParameterError: (a ``ValueError``) for arguments and settings.
        SimulateError: for a subject outside the photos or an impossible rig.
    """
    if not isinstance(subject, int | np.integer) or not 0 <= subject < 2**64:
        raise ParameterError(
            f"subject is {subject!r}; expected a whole number, 0 or more", "parameters"
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
    """A rule for a good capture, and its result.

    Attributes:
        rule: name of the rule.
        verdict: ``"good"``, ``"warning"``, ``"fault"`` when a result could not be
            trusted, or ``"unknown"`` when it could not be measured.
        message: what was found and what is expected, with figures.
        advice: what to do; empty if nothing.
    """

    rule: str
    verdict: str
    message: str
    advice: str


def check(capture: Capture | str | PathLike[str], **settings: Any) -> list[Finding]:
    """Check the photographs by the rules of thesis section 6.5.1, like ``facerecon check``.

    Args:
        capture: a :class:`Capture`, or its path.
        settings: limits of the rules, e.g. ``min_width=640``; the error for an unknown name lists
            all.

    Returns:
        One finding per rule; the last one, ``reconstruction``, is that of a trial reconstruction
        without texture. A capture with warnings can still be reconstructed.

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
    """Render a mesh to an image (height, width, 3) uint8; several views side by side.

    Args:
        mesh: the mesh, with faces.
        view: ``front``, ``three-quarter``, ``profile`` ..., or several.
        mode: ``shaded``, ``textured``, ``lit``, ``wireframe`` or ``heat``; by default
            ``heat`` with values, ``lit`` for a mesh with colours, else ``shaded``.
        heat: (n,) one value per vertex, at least 0, for mode ``heat``; NaN is grey.
        limit_mm: value at the upper end of the scale.
        frame: ``"model"`` or ``"camera"``: the mesh's axes.
        size: (width, height) of each view, pixels.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        RenderError: for a mesh that cannot be rendered, or an image that is too large.
    """
    as_mesh("mesh", mesh)
    values = None if heat is None else column("heat", heat, len(mesh.vertices))
    if values is not None and not (np.isnan(values) | ((values >= 0) & (values < np.inf))).all():
        raise ParameterError(
            f"heat has shape {values.shape} and values from {np.nanmin(values)} to "
            f"{np.nanmax(values)}; expected finite values of at least 0, NaN where unknown",
            "parameters",
        )
    return draw(
        mesh._parts(),
        mesh._texture(),
        view,
        mode=mode,
        heat=values,
        limit_mm=limit_mm,
        frame=frame,
        size=size,
    )


@dataclass(frozen=True, eq=False)
class Comparison:
    """Distances between two meshes.

    Attributes:
        facts: statistics ``before`` and ``after`` the alignment, in both directions, mm;
            ``second_from_first`` (4x4), ``scale``, ``rotation_deg``, ``iterations``.
        vertex_distances: (n,) of each vertex of the first mesh, mm; NaN beyond ``reach_mm``.
    """

    facts: dict[str, Any]
    vertex_distances: F64

    @property
    def median_mm(self) -> float:
        """Median distance of the first surface from the second, after the alignment if any, mm."""
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
                label = f"{side.replace('_', ' ')}, {when} alignment"
                cells.append(f"<td>{label}</td>" + "".join(f"<td>{n:.3f}</td>" for n in numbers))
        return "<table>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table><p>mm</p>"


def compare(first: Mesh, second: Mesh, *, region: Any = None, **settings: Any) -> Comparison:
    """Measure distances between two meshes, before and after alignment.

    Args:
        first, second: the meshes, in the same unit; figures named ``_mm`` assume millimetres.
        region: (n,) bool, the vertices of ``first`` to use.
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
                f"region has shape {array.shape} and type {array.dtype}; "
                f"expected ({len(first.vertices)},) of bool",
                "parameters",
            )
        mask = array.tolist()
    text, distances = _core.compare(first._parts(), second._parts(), mask, to_sets(settings))
    return Comparison(json.loads(text), distances)

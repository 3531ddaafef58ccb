"""Makers and judges around the pipeline: simulate, pattern, render, compare."""

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
from .capture import Capture
from .errors import ParameterError
from .mesh import Mesh
from .params import to_sets
from .progress import Callback, watcher


class Simulation:
    """A simulated capture and its truth; made by :func:`simulate`."""

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
        """Write the capture folder with the truth beside it; gives the path of ``capture.toml``."""
        return fspath(self._core.save(fspath(folder)))

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
        settings: of the rig, e.g. ``distance_mm=1300``, ``toe_in_deg=4``, ``yaw_deg=10``,
            ``pattern={"columns": 60}``; ``facerecon simulate --set help`` lists all.

    Raises:
        SimulateError: for a subject outside the photos or an impossible rig.
    """
    if subject < 0:
        raise ParameterError(f"subject is {subject}, but 0 or more is wanted", "parameters")
    parts = None if mesh is None else mesh._parts()
    skin = None if mesh is None else mesh._texture()
    watch = watcher(progress)
    try:
        return Simulation(_core.simulate(subject, parts, skin, to_sets(settings), watch.callback))
    finally:
        watch.close()


def pattern(**settings: Any) -> U8:
    """The image to project, (height, width, 3) uint8: a lattice of dots, or stripes.

    Settings: ``kind``, ``columns``, ``rows``, ``width_px``, ``height_px``, ``dot_fraction``,
    ``margin_fraction``, ``rotation_deg``.
    """
    return _core.pattern(to_sets(settings))


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
        view: ``front``, ``three-quarter``, ``profile`` ..., or several.
        mode: ``shaded``, ``textured``, ``lit``, ``wireframe`` or ``heat``; by default what the
            mesh has.
        heat: (n,) a value for each vertex, at least 0, for ``heat``; NaN is grey.
        limit_mm: value at the end of the scale.
        frame: ``"model"`` or ``"camera"``: the mesh's axes.
        size: (width, height) of each picture, pixels.
    """
    values = None if heat is None else column("heat", heat, len(mesh.vertices))
    if mode is None:
        coloured = mesh.texture is not None or mesh.colors is not None
        mode = "heat" if values is not None else "lit" if coloured else "shaded"
    views = [view] if isinstance(view, str) else list(view)
    if len(size) != 2 or min(size) < 1:
        raise ParameterError(f"size is {size}, but (width, height) is wanted", "parameters")
    picture_size = int(size[0]), int(size[1])
    return _core.render(
        mesh._parts(), mesh._texture(), values, limit_mm, views, mode, frame, picture_size
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


def compare(first: Mesh, second: Mesh, *, region: Any = None, **settings: Any) -> Comparison:
    """Distances between two meshes, as they lie and after the best alignment.

    Args:
        region: (n,) bool, the vertices of ``first`` that count.
        settings: ``alignment`` (``none``, ``rigid``, ``similarity``), ``samples``, ``keep``,
            ``iterations``, ``reach_mm``.
    """
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

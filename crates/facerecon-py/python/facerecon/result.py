"""reconstruct(), its result, and templates."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import F64, U8
from ._html import figure, points_picture, ramp
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh
from .params import Params, given_params
from .progress import Callback, watcher


@dataclass(frozen=True, eq=False)
class Cloud:
    """Measured points.

    Attributes:
        points: (n, 3), millimetres when the result is metric, else model units.
        normals: (n, 3) unit normals toward the cameras, or ``None``.
        colors: (n, 3) uint8 sRGB, or ``None``.
        sigmas: (n,) standard deviation along the line of sight, unit of the points, or ``None``.
    """

    points: F64
    normals: F64 | None = None
    colors: U8 | None = None
    sigmas: F64 | None = None

    def __len__(self) -> int:
        return len(self.points)

    def to_numpy(self) -> F64:
        """The points, (n, 3)."""
        return self.points

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with ``x y z`` and, where known, normals, colours, sigma."""
        import pandas as pd

        table: dict[str, Any] = dict(zip("xyz", self.points.T, strict=True))
        if self.normals is not None:
            table |= dict(zip(("nx", "ny", "nz"), self.normals.T, strict=True))
        if self.colors is not None:
            table |= dict(zip(("red", "green", "blue"), self.colors.T, strict=True))
        if self.sigmas is not None:
            table["sigma"] = self.sigmas
        return pd.DataFrame(table)

    def to_open3d(self) -> Any:
        """Convert to an ``open3d.geometry.PointCloud``."""
        import open3d as o3d

        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(self.points))
        if self.normals is not None:
            cloud.normals = o3d.utility.Vector3dVector(self.normals)
        if self.colors is not None:
            cloud.colors = o3d.utility.Vector3dVector(self.colors / 255.0)
        return cloud

    def __repr__(self) -> str:
        return f"<facerecon.Cloud: {len(self)} points>"

    def _repr_html_(self) -> str:
        x, y, z = self.points.T
        # camera frame: the subject far along +z, y down; model frame: y up
        camera = bool(len(z)) and float(np.median(z)) > 3.0 * float(np.std(z)) + 1.0
        down, near = (y, -z) if camera else (-y, z)
        order = np.argsort(near)
        colors = ramp(near) if self.colors is None else self.colors
        picture = points_picture(np.stack([x, down], axis=1)[order], colors[order])
        return figure(picture, repr(self))


@dataclass(frozen=True, eq=False)
class Matches:
    """Points seen in both photos (matches).

    Attributes:
        left, right: (n, 2) positions ``x, y`` in the original photos, pixels.
        disparity: (n,) ``xl - xr`` of the rectified pair, pixels.
        points: (n, 3) positions in space; NaN where unknown.
        lattice: (n, 2) ``column, row`` in the projected pattern; NaN where unknown.
        score: (n,) confidence, 0 to 1.
    """

    left: F64
    right: F64
    disparity: F64
    points: F64
    lattice: F64
    score: F64

    COLUMNS = ("xl", "yl", "xr", "yr", "disparity", "x", "y", "z", "column", "row", "score")

    def __len__(self) -> int:
        return len(self.left)

    def to_numpy(self) -> F64:
        """(n, 11) with the columns :attr:`COLUMNS`."""
        return np.column_stack(
            [self.left, self.right, self.disparity, self.points, self.lattice, self.score]
        )

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with the columns :attr:`COLUMNS`."""
        import pandas as pd

        return pd.DataFrame(self.to_numpy(), columns=list(self.COLUMNS))

    def __repr__(self) -> str:
        return f"<facerecon.Matches: {len(self)}>"

    def _repr_html_(self) -> str:
        colors = ramp(self.disparity)
        pair = [points_picture(side, colors) for side in (self.left, self.right)]
        picture = np.concatenate(
            [pair[0], np.full((300, 6, 3), 255, dtype=np.uint8), pair[1]], axis=1
        )
        return figure(picture, f"{self!r}, left and right, coloured by disparity (red is nearest)")


class Result:
    """The result of :func:`reconstruct`."""

    def __init__(self, core: _core.Reconstruction, capture: Capture) -> None:
        self._core = core
        self.capture = capture
        #: The facts of ``result.json``: counts, registration, rows, parameters, version.
        self.facts: dict[str, Any] = json.loads(core.json())

    @property
    def mesh(self) -> Mesh:
        """The textured face, model frame (x right, y up, z toward the viewer).

        ``mesh.sigma`` is the standard deviation of each vertex along its normal, ``mesh.measured``
        says which vertices are supported by measured points.
        """
        return self.mesh_in("model")

    def mesh_in(self, frame: str) -> Mesh:
        """The textured face in the ``"model"`` or ``"camera"`` frame (left camera, OpenCV axes).

        Raises:
            ParameterError: (a ``ValueError``) for another frame.
        """
        return Mesh._from_parts(self._core.mesh(frame), self._core.texture, self._core.landmarks)

    @property
    def cloud(self) -> Cloud:
        """The measured points, model frame."""
        return self.cloud_in("model")

    def cloud_in(self, frame: str) -> Cloud:
        """The measured points in the ``"model"`` or ``"camera"`` frame.

        Raises:
            ParameterError: (a ``ValueError``) for another frame.
        """
        return Cloud(*self._core.cloud(frame))

    @property
    def matches(self) -> Matches:
        """The matches in the original photos; their points in the model frame."""
        return Matches(*self._core.matches("model"))

    @property
    def texture(self) -> U8 | None:
        """(size, size, 3) uint8 sRGB; ``None`` without a plain pair."""
        return self._core.texture

    @property
    def coverage(self) -> U8 | None:
        """(size, size) uint8: photos that show a texel, 1 left + 2 right + 4 extra; 128 filled."""
        return self._core.coverage

    @property
    def depth_left(self) -> U8:
        """(height, width) grey depth map of the left photo, lighter is nearer (Fig. 2.5)."""
        return self._core.depth()[0]

    @property
    def depth_right(self) -> U8:
        """(height, width) grey depth map of the right photo, lighter is nearer (Fig. 2.5)."""
        return self._core.depth()[1]

    @property
    def metric(self) -> bool:
        """Whether lengths are millimetres."""
        return bool(self.facts["metric"])

    @property
    def model_from_camera(self) -> F64:
        """(4, 4) model frame from the camera frame."""
        return self._core.model_from_camera

    @property
    def timings(self) -> dict[str, float]:
        """Duration of each stage and in ``total``, milliseconds."""
        return dict(self.facts["timings_ms"])

    @property
    def warnings(self) -> list[str]:
        """What needs attention, as sentences."""
        return list(self.facts["warnings"])

    @property
    def verdict(self) -> dict[str, Any]:
        """Whether the result can be trusted.

        ``level`` (``"good"``, ``"usable"`` or ``"doubtful"``), ``reasons`` (each with ``level``
        and ``text``) and ``figures``.
        """
        return dict(self.facts["verdict"])

    @property
    def landmarks(self) -> list[dict[str, Any]]:
        """The 18 landmarks as in ``result.json``: position, ``sigma_mm``, ``status`` ..."""
        return list(self.facts["landmarks"])

    @property
    def distances(self) -> list[dict[str, Any]]:
        """The distances between landmarks as in ``result.json``; empty without calibration."""
        return list(self.facts["distances"])

    @property
    def params(self) -> dict[str, Any]:
        """The parameters it was made with."""
        return dict(self.facts["params"])

    @property
    def registration_history(self) -> list[float]:
        """Error of the registration before the first and after each step (Eq. 3.8 in ``besl``).

        Empty for a measured surface that could not be registered.
        """
        pose = self.facts["registration"]
        return list(pose["error_history"]) if pose else []

    @property
    def icp_history(self) -> list[float]:
        """Alias of :attr:`registration_history`."""
        return self.registration_history

    def artifacts(self) -> dict[str, npt.NDArray[Any] | Mesh]:
        """Intermediate results by ``NN_stage_name``, in order: images, points, meshes."""
        shown: dict[str, npt.NDArray[Any] | Mesh] = {}
        for number, (stage, name, value) in enumerate(self._core.artifacts(), start=1):
            key = f"{number:02}_{stage}_{name}"
            shown[key] = Mesh._from_parts(value) if isinstance(value, tuple) else value
        return shown

    def summary(self) -> str:
        """The main figures as sentences."""
        return "\n".join(self._core.summary())

    def report_html(self) -> str:
        """The contents of ``report.html``: one HTML page that needs no network."""
        return self._core.report_html()

    def save(
        self, folder: str | PathLike[str], frame: str = "model", keep_stages: bool = False
    ) -> None:
        """Write the files of ``facerecon reconstruct -o``, byte for byte the same.

        Args:
            folder: created if missing; each file is written completely or not at all.
            frame: ``"model"`` or ``"camera"``.
            keep_stages: also write the intermediate results to ``stages/``.

        Raises:
            FileError: (an ``OSError``) naming the file that could not be written.
        """
        self._core.save(fspath(folder), frame, keep_stages)

    @property
    def termination(self) -> str:
        """Why the registration stopped: ``"converged"`` or ``"max_iterations"``.

        ``"none"`` for a measured surface that could not be registered.
        """
        pose = self.facts["registration"]
        return str(pose["termination"]) if pose else "none"

    def __repr__(self) -> str:
        matches, vertices = self.facts["matches"], self.facts["vertices"]
        level = self.facts["verdict"]["level"]
        return (
            f"<facerecon.Result: {level}, {matches} matches, {vertices} vertices, "
            f"{self.facts['unit']}>"
        )

    def _repr_html_(self) -> str:
        summary = "<br>".join(html.escape(line) for line in self._core.summary())
        warned = "".join(f"<li>{html.escape(w)}</li>" for w in self.warnings)
        listed = f"<ul>{warned}</ul>" if warned else ""
        verdict = html.escape(self._core.verdict())
        return f"{self.mesh._repr_html_()}<p><b>{verdict}</b></p><p>{summary}</p>{listed}"


def load_template(
    template: str | PathLike[str] | Mesh, argument: str = "template"
) -> _core.Template:
    """A template by name, file or mesh."""
    if isinstance(template, Mesh):
        return _core.Template("mesh", template._parts(), template.landmarks)
    if isinstance(template, str | PathLike):
        return _core.Template.load(fspath(template))
    raise ParameterError(
        f"{argument} is a {type(template).__name__}; expected a name, a path or a facerecon.Mesh",
        "parameters",
    )


def head(name: str | PathLike[str] = "head") -> Mesh:
    """Load a template (generic head) with its 18 landmarks, model frame, mm.

    Args:
        name: ``"head"`` (about 6,000 vertices), ``"head-coarse"`` (about 830), ``"PRESET=FILE"``
            of a preset, or a mesh file with its ``NAME.landmarks.toml`` beside it.

    Raises:
        TemplateError: for a name or a file that is not a template.
        FileError: (an ``OSError``) for a file that cannot be read.
    """
    template = load_template(name)
    return Mesh._from_parts(template.mesh(), None, template.landmarks)


def reconstruct(
    capture: Capture | str | PathLike[str],
    profile: str | None = None,
    *,
    params: Params | None = None,
    template: str | PathLike[str] | Mesh | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Result:
    """Reconstruct a textured face mesh from photographs.

    Ctrl-C stops it within a second. It releases the GIL.

    Args:
        capture: a capture folder, its ``capture.toml``, or a :class:`Capture`.
        profile: ``"precise"`` (the default) or ``"facebuilder"`` (the thesis).
        params: all parameters; not together with ``profile`` or ``settings``.
        template: instead of the built-in head: a name, a file, or a :class:`Mesh` with landmarks
            (model frame, mm).
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: single parameters in groups, e.g. ``smooth={"steps": 3}``;
            ``surface={"method": "auto"}`` meshes the measured surface instead of deforming a
            template.

    Returns:
        The mesh, the points, the texture and the figures of the run.

    Raises:
        FaceReconError: naming the stage that failed, with the figures found and required;
            ``ParameterError`` (a ``ValueError``) for arguments, ``FileError`` (an ``OSError``) for
            files.
    """
    core_params = given_params(profile, params, settings)
    photos = as_capture(capture)
    head_core = None if template is None else load_template(template)
    watch = watcher(progress)
    try:
        found = _core.reconstruct(photos._core, head_core, core_params, watch.callback)
    finally:
        watch.close()
    return Result(found, photos)

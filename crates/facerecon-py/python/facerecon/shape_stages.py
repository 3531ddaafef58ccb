"""The stages that work on points and meshes: from matches to a face (thesis chapters 2.4 to 5)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8, rows, vertex_numbers
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh, as_mesh
from .params import Params, given_params, params_for
from .progress import Callback, watcher
from .result import Cloud, Matches, load_template


@dataclass(frozen=True, eq=False)
class Registration:
    """How points came to a model.

    Attributes:
        model_from_data: (4, 4) similarity; the points' own frame on its right.
        history: error after each step, the first before any (thesis Eq. 3.8 with ``besl``).
        termination: why it stopped: ``"converged"`` (the error fell by less than the tolerance)
            or ``"max_iterations"``.
        iterations: steps taken, those of a search for the start included.
        rms_before, rms_after: of the closest 80 %, model units.
        scale: of ``model_from_data``.
        inliers: numbers of the points that were used.
    """

    model_from_data: F64
    history: list[float]
    termination: str
    iterations: int
    rms_before: float
    rms_after: float
    scale: float
    inliers: list[int]

    def apply(self, points: Any) -> F64:
        """Points (n, 3) brought into the model frame (Eq. 3.7).

        Raises:
            ParameterError: (a ``ValueError``) for another shape or values that are not finite.
        """
        given = rows("points", points, 3)
        moved: F64 = given @ self.model_from_data[:3, :3].T + self.model_from_data[:3, 3]
        return moved

    def __repr__(self) -> str:
        return (
            f"<facerecon.Registration: {self.termination} after {self.iterations} steps, "
            f"rms {self.rms_before:.2f} -> {self.rms_after:.2f}>"
        )


@dataclass(frozen=True, eq=False)
class Deformed:
    """A bent head.

    Attributes:
        mesh: the template with new vertex positions; vertices that ``nicp`` adds come last.
        rms_before, rms_after: distance of the used vertices (or points) from their goals, units of
            the mesh.
        centres: points the fit rests on.
    """

    mesh: Mesh
    rms_before: float
    rms_after: float
    centres: int

    def __repr__(self) -> str:
        return (
            f"<facerecon.Deformed: {self.centres} centres, "
            f"rms {self.rms_before:.2f} -> {self.rms_after:.2f}>"
        )

    def _repr_html_(self) -> str:
        return self.mesh._repr_html_()


def triangulate(
    capture: Capture | str | PathLike[str],
    matches: Matches | tuple[Any, Any],
    **settings: Any,
) -> Cloud:
    """Points from matches.

    Args:
        capture: a :class:`Capture`, or its path.
        matches: :class:`Matches`, or ``(left, right)`` positions (n, 2) in the photos, pixels.
        settings: those of ``triangulate``.

    Returns:
        (n, 3) points in the order of the matches: camera frame, millimetres, with a calibrated
        capture (Eq. 2.2); else model units (Eq. 2.3 to 2.6).

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        TriangulateError: for pairs that give no points.
    """
    if isinstance(matches, Matches):
        matches = matches.left, matches.right
    left, right = _two("matches", matches, "(left, right), both (n, 2) pixels,")
    left, right = rows("left", left, 2), rows("right", right, 2)
    if len(left) != len(right):
        raise ParameterError(
            f"right has shape {right.shape}, but that of left, {left.shape}, is wanted",
            "parameters",
        )
    params = params_for("triangulate", None, settings)
    columns, _metric = _core.triangulate(as_capture(capture)._core, left, right, params)
    return Cloud(*columns)


def icp(
    data: Cloud | Any,
    model: Mesh | str | PathLike[str] = "head",
    *,
    metric: bool = True,
    features: tuple[Any, Any] | None = None,
    profile: str | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Registration:
    """Brings measured points to a model (thesis chapter 3: Eq. 3.1 to 3.8 with ``method="besl"``).

    Args:
        data: (n, 3) points: camera frame, mm, when ``metric``; else near the model's frame.
        model: a generic head: its name, its file, or a :class:`Mesh` (model frame, mm).
        metric: whether the points are millimetres in the camera frame (y down, z forward).
        features: marked features as ``(measured, on the model)``, both (k, 3) (section 6.5.2).
        profile: ``"precise"`` (trimmed point-to-plane, the default) or ``"facebuilder"``.
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: those of ``register``.

    Returns:
        ``model_from_data``, the error after each step, and why it stopped.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        RegisterError: for too few points, or when they do not come to fit the model.
    """
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    marks = None
    if features is not None:
        measured, on_model = _two("features", features, "(measured, on the model)")
        marks = rows("features[0]", measured, 3), rows("features[1]", on_model, 3)
        if len(marks[0]) != len(marks[1]):
            raise ParameterError(
                f"features[1] has shape {marks[1].shape}, but {marks[0].shape} is wanted",
                "parameters",
            )
    params = params_for("register", profile, settings)
    head = load_template(model, "model")
    watch = watcher(progress, ("register",))
    try:
        matrix, text, history, inliers = _core.icp(
            points, head, metric, marks, params, watch.callback
        )
    finally:
        watch.close()
    facts = json.loads(text)
    names = ("termination", "iterations", "rms_before", "rms_after", "scale")
    return Registration(matrix, history, inliers=inliers, **{name: facts[name] for name in names})


def deform(
    template: Mesh,
    data: Cloud | Any,
    *,
    assignments: Mapping[int, Any] | None = None,
    features: Mapping[int | str, Any] | None = None,
    profile: str | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Deformed:
    """Bends a head to registered points (thesis chapter 4: Eq. 4.1 to 4.8 with the RBF methods).

    Args:
        template: the generic head, model frame.
        data: (n, 3) points of the model frame.
        assignments: the place (3,) each vertex must reach, by vertex number; by default the mean of
            the points whose closest vertex it is (thesis section 3.2).
        features: places (3,) of marked features, by vertex number or landmark name.
        profile: ``"precise"`` (``nicp``, the default) or ``"facebuilder"`` (``gaussian-rbf``).
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: those of ``deform``, e.g. ``method="gaussian-rbf"``, ``"linear-rbf"``,
            ``"biharmonic-rbf"``, ``"nicp"``.

    Returns:
        The bent head and how far it was and is from its goals.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DeformError: for too few points, or equations without a stable solution.
    """
    as_mesh("template", template)
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    named = None
    if features is not None:
        unknown = [k for k in features if isinstance(k, str) and k not in template.landmarks]
        if unknown:
            raise ParameterError(f"features: the template has no {unknown}", "parameters")
        named = {template.landmarks[k] if isinstance(k, str) else k: v for k, v in features.items()}
    count = len(template.vertices)
    params = params_for("deform", profile, settings)
    watch = watcher(progress, ("deform",))
    try:
        parts, before, after, centres = _core.deform(
            template._parts(),
            points,
            _goals("assignments", assignments, count),
            _goals("features", named, count),
            params,
            watch.callback,
        )
    finally:
        watch.close()
    mesh = Mesh._from_parts(parts, template.texture, template.landmarks)
    return Deformed(mesh, before, after, centres)


def fit(
    template: Mesh,
    data: Cloud | Any,
    *,
    features: Mapping[int | str, Any] | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Deformed:
    """Robust non-rigid ICP: :func:`deform` with ``method="nicp"``, to all points, no spikes.

    Args:
        template: the generic head, model frame.
        data: (n, 3) points of the model frame; those of the surface between the dots help.
        features: places (3,) of marked features, by vertex number or landmark name.
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: those of ``deform``, e.g. ``nicp={"rounds": 2}``.

    Returns:
        The fitted head and how far the points were and are from it.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DeformError: for too few points, or equations without a stable solution.
    """
    return deform(
        template, data, features=features, progress=progress, **{**settings, "method": "nicp"}
    )


def surface(
    capture: Capture | str | PathLike[str],
    profile: str | None = None,
    *,
    params: Params | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Mesh:
    """The measured surface of a capture as a mesh, without a generic head; holes stay open.

    Args:
        capture: a :class:`Capture`, or its path.
        profile: ``"precise"`` (the dense disparity, the default) or ``"facebuilder"`` (the dots).
        params: all parameters; not together with ``profile`` or ``settings``.
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: groups, as for :func:`facerecon.reconstruct`, which gives the same textured and
            in the model frame with ``surface={"method": "auto"}``.

    Returns:
        The mesh, camera frame, mm, with a calibrated capture, with texture coordinates for
        :func:`texture`.

    Raises:
        ParameterError: (a ``ValueError``) for parameters.
        FileError: (an ``OSError``) for a capture that cannot be read.
        SurfaceError: when the measured points enclose no surface.
    """
    core = given_params(profile, params, settings)
    photos = as_capture(capture)
    watch = watcher(progress)
    try:
        parts, _metric = _core.surface(photos._core, core, watch.callback)
    finally:
        watch.close()
    return Mesh._from_parts(parts)


def smooth(
    mesh: Mesh, method: str = "laplacian", *, reference: Any = None, **settings: Any
) -> Mesh:
    """Smooths a mesh (Eq. 4.9 and 4.10).

    Args:
        mesh: the mesh, mm; vertices on an open edge stay.
        method: ``"laplacian"``, ``"taubin"`` (the second step of thesis section 4.3), ``"none"``.
        reference: (k, 3) points whose bounds the mesh is enlarged back to (section 6.5.2).
        settings: those of ``smooth``, e.g. ``steps=5``, ``lambda_=0.5`` (Eq. 4.10), ``mu``.

    Returns:
        A mesh of the same faces, texture and landmarks.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        SmoothError: for a mesh or a ``mu`` that cannot be smoothed with.
    """
    as_mesh("mesh", mesh)
    bounds = None if reference is None else rows("reference", reference, 3)
    params = params_for("smooth", None, {"method": method, **settings})
    parts, _steps, _movement, _enlarged = _core.smooth(mesh._parts(), bounds, params)
    return Mesh._from_parts(parts, mesh.texture, mesh.landmarks)


def texture(
    mesh: Mesh,
    capture: Capture | str | PathLike[str],
    *,
    profile: str | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> tuple[Mesh, U8]:
    """Colours a mesh from a calibrated capture's pair without the pattern (thesis chapter 5).

    Args:
        mesh: camera frame, mm, with texture coordinates.
        capture: a :class:`Capture`, or its path.
        profile: ``"precise"`` (projected and blended, the default) or ``"facebuilder"`` (scan
            lines: thesis section 5.2).
        progress: ``True`` for a bar, or a function that is given every :class:`Event`.
        settings: those of ``texture``, e.g. ``size=1024``.

    Returns:
        The textured mesh and the (size, size) uint8 coverage map (see
        :attr:`facerecon.Result.coverage`).

    Raises:
        ParameterError: (a ``ValueError``) for parameters.
        InputError: without a plain pair or calibration.
        TextureError: for a mesh that cannot be coloured.
    """
    as_mesh("mesh", mesh)
    params = params_for("texture", profile, settings)
    photos = as_capture(capture)
    watch = watcher(progress, ("texture",))
    try:
        image, coverage = _core.texture(photos._core, mesh._parts(), params, watch.callback)
    finally:
        watch.close()
    return Mesh._from_parts(mesh._parts(), image, mesh.landmarks), coverage


def _two(name: str, given: Any, wanted: str) -> tuple[Any, Any]:
    try:
        first, second = given
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"{name} is not a pair, but {wanted} is wanted", "parameters"
        ) from error
    return first, second


def _goals(name: str, given: Mapping[int, Any] | None, count: int) -> tuple[list[int], F64] | None:
    if given is None:
        return None
    return (
        vertex_numbers(name, list(given), count),
        rows(name, list(given.values()) if given else np.zeros((0, 3)), 3),
    )

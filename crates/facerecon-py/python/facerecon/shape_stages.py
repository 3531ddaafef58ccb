"""The stages on points and meshes: from matches to a face (thesis section 2.4 to chapter 5)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8, rows, vertex_indices
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh, as_mesh
from .params import Params, given_params, params_for
from .progress import Callback, watcher
from .result import Cloud, Matches, load_template

#: Values by landmark name or vertex index.
ByLandmark = Mapping[str, Any] | Mapping[int, Any] | Mapping[int | str, Any]


@dataclass(frozen=True, eq=False)
class Registration:
    """The alignment of points with a model; the result of :func:`register`.

    Attributes:
        model_from_data: (4, 4) similarity, model frame from the frame of the points.
        history: error before the first and after each step (thesis Eq. 3.8 with ``besl``).
        termination: why it stopped: ``"converged"`` (the error decreased by less than the
            tolerance) or ``"max_iterations"``.
        iterations: number of steps; with ``besl`` those of the initial search included.
        rms_before, rms_after: root mean square distance of the closest 80 % of the points from
            the model, model units.
        scale: scale of ``model_from_data``.
        inliers: indices of the points that were used.
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
        """Transform points (n, 3) into the model frame (Eq. 3.7).

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
    """A deformed template; the result of :func:`deform` and :func:`fit`.

    Attributes:
        mesh: the template with new vertex positions; vertices that ``nicp`` adds come last.
        rms_before, rms_after: root mean square distance of the vertices (or points) from their
            targets, units of the mesh.
        centres: number of RBF centres, or of points used by ``nicp``.
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
    """Compute points in space from matches (thesis section 2.4).

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
    left, right = _two("matches", matches, "(left, right), both (n, 2) pixels")
    left, right = rows("left", left, 2), rows("right", right, 2)
    if len(left) != len(right):
        raise ParameterError(
            f"right has shape {right.shape}; expected {left.shape}, that of left",
            "parameters",
        )
    params = params_for("triangulate", None, settings)
    columns, _metric = _core.triangulate(as_capture(capture)._core, left, right, params)
    return Cloud(*columns)


def register(
    data: Cloud | Any,
    model: Mesh | str | PathLike[str] = "head",
    *,
    metric: bool = True,
    landmarks: tuple[Any, Any] | None = None,
    features: tuple[Any, Any] | None = None,
    profile: str | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Registration:
    """Align measured points with a model (thesis chapter 3: Eq. 3.1 to 3.8 with ``method="besl"``).

    ``icp`` is an alias.

    Args:
        data: (n, 3) points: camera frame, mm, when ``metric``; else model units, model frame.
        model: a template: name, file, or :class:`Mesh` (model frame, mm).
        metric: whether the points are millimetres in the camera frame (y down, z forward).
        landmarks: positions of landmarks as ``(measured, on the model)``, both (k, 3)
            (section 6.5.2).
        features: alias of ``landmarks``.
        profile: ``"precise"`` (trimmed point-to-plane, the default) or ``"facebuilder"``.
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: those of ``register``.

    Returns:
        The transform, the error after each step, and why it stopped.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        RegisterError: for too few points, or when the points do not fit the model.
    """
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    pairs = None
    landmarks = _with_alias(landmarks, features)
    if landmarks is not None:
        measured, on_model = _two("landmarks", landmarks, "(measured, on the model)")
        pairs = rows("landmarks[0]", measured, 3), rows("landmarks[1]", on_model, 3)
        if len(pairs[0]) != len(pairs[1]):
            raise ParameterError(
                f"landmarks[1] has shape {pairs[1].shape}; expected {pairs[0].shape}, that of "
                "landmarks[0]",
                "parameters",
            )
    params = params_for("register", profile, settings)
    head = load_template(model, "model")
    watch = watcher(progress, ("register",))
    try:
        matrix, text, inliers = _core.register(
            points, head, metric, pairs, params, watch.callback
        )
    finally:
        watch.close()
    facts = json.loads(text)
    names = ("termination", "iterations", "rms_before", "rms_after", "scale")
    return Registration(
        matrix, facts["error_history"], inliers=inliers, **{name: facts[name] for name in names}
    )


#: Alias of :func:`register`.
icp = register


def deform(
    template: Mesh,
    data: Cloud | Any,
    *,
    assignments: Mapping[int, Any] | None = None,
    landmarks: ByLandmark | None = None,
    features: ByLandmark | None = None,
    profile: str | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Deformed:
    """Deform a template to registered points (thesis chapter 4: Eq. 4.1 to 4.8 with RBF methods).

    Args:
        template: the generic head, model frame.
        data: (n, 3) points in the model frame.
        assignments: target position (3,) by vertex index; by default each vertex that is closest
            to some points gets their mean (thesis section 3.2).
        landmarks: positions (3,) of landmarks, by name or vertex index.
        features: alias of ``landmarks``.
        profile: ``"precise"`` (``nicp``, the default) or ``"facebuilder"`` (``gaussian-rbf``).
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: those of ``deform``, e.g. ``method="gaussian-rbf"``, ``"linear-rbf"``,
            ``"biharmonic-rbf"``, ``"nicp"``.

    Returns:
        The deformed template and its distance from the targets, before and after.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DeformError: for too few points, or a system of equations without a stable solution.
    """
    as_mesh("template", template)
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    by_vertex = None
    landmarks = _with_alias(landmarks, features)
    if landmarks is not None:
        known = template.landmarks
        unknown = [k for k in landmarks if isinstance(k, str) and k not in known]
        if unknown:
            raise ParameterError(
                f"landmarks: the template has no {unknown}; expected names of {sorted(known)}",
                "parameters",
            )
        by_vertex = {known[k] if isinstance(k, str) else k: v for k, v in landmarks.items()}
    count = len(template.vertices)
    params = params_for("deform", profile, settings)
    watch = watcher(progress, ("deform",))
    try:
        parts, before, after, centres = _core.deform(
            template._parts(),
            points,
            _targets("assignments", assignments, count),
            _targets("landmarks", by_vertex, count),
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
    landmarks: ByLandmark | None = None,
    features: ByLandmark | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Deformed:
    """Robust non-rigid ICP: :func:`deform` with ``method="nicp"``.

    Args:
        template: the generic head, model frame.
        data: (n, 3) points in the model frame, best with those between the dots
            (:attr:`facerecon.Result.cloud`).
        landmarks: positions (3,) of landmarks, by name or vertex index.
        features: alias of ``landmarks``.
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: those of ``deform``, e.g. ``nicp={"rounds": 2}``.

    Returns:
        The fitted template and the distance of the points from it, before and after.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DeformError: for too few points, or a system of equations without a stable solution.
    """
    return deform(
        template,
        data,
        landmarks=landmarks,
        features=features,
        progress=progress,
        **{**settings, "method": "nicp"},
    )


def surface(
    capture: Capture | str | PathLike[str],
    profile: str | None = None,
    *,
    params: Params | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Mesh:
    """Mesh the measured surface of a capture, without a template; holes stay open.

    Args:
        capture: a :class:`Capture`, or its path.
        profile: ``"precise"`` (the dense disparity, the default) or ``"facebuilder"`` (the dots).
        params: all parameters; not together with ``profile`` or ``settings``.
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: groups, as for :func:`facerecon.reconstruct`, which returns the same mesh
            textured and in the model frame with ``surface={"method": "auto"}``.

    Returns:
        The mesh, with texture coordinates for :func:`texture`: camera frame, mm, with a calibrated
        capture; else model units.

    Raises:
        ParameterError: (a ``ValueError``) for parameters.
        FileError: (an ``OSError``) for a capture that cannot be read.
        SurfaceError: when the measured points form no surface.
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
    """Smooth a mesh (Eq. 4.9 and 4.10).

    Args:
        mesh: the mesh, mm; vertices on its border do not move.
        method: ``"laplacian"``, ``"taubin"`` (the second step of thesis section 4.3), ``"none"``.
        reference: (k, 3) points; smoothing shrinks a mesh, so it is enlarged until the vertices at
            these points have their former bounds (section 6.5.2). By default all vertices count.
        settings: those of ``smooth``, e.g. ``steps=5``, ``lambda_=0.5`` (Eq. 4.10), ``mu``.

    Returns:
        The mesh with new vertex positions.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        SmoothError: for a mesh that cannot be smoothed, or an invalid ``mu``.
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
    """Texture a mesh from the plain pair of a calibrated capture (thesis chapter 5).

    Args:
        mesh: camera frame, mm, with texture coordinates.
        capture: a :class:`Capture`, or its path.
        profile: ``"precise"`` (projection and blending, the default) or ``"facebuilder"`` (scan
            lines: thesis section 5.2).
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: those of ``texture``, e.g. ``size=1024``.

    Returns:
        The textured mesh and the (size, size) uint8 coverage map (see
        :attr:`facerecon.Result.coverage`).

    Raises:
        ParameterError: (a ``ValueError``) for parameters.
        InputError: without a plain pair or calibration.
        TextureError: for a mesh that cannot be textured.
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


def _with_alias(landmarks: Any, features: Any) -> Any:
    """The value of ``landmarks``, or that of its alias ``features``."""
    if landmarks is not None and features is not None:
        raise ParameterError(
            "landmarks and its alias features are both given; give only landmarks", "parameters"
        )
    return features if landmarks is None else landmarks


def _two(name: str, given: Any, expected: str) -> tuple[Any, Any]:
    try:
        first, second = given
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"{name} is not a pair; expected {expected}", "parameters"
        ) from error
    return first, second


def _targets(
    name: str, given: Mapping[int, Any] | None, count: int
) -> tuple[list[int], F64] | None:
    if given is None:
        return None
    return (
        vertex_indices(name, list(given), count),
        rows(name, list(given.values()) if given else np.zeros((0, 3)), 3),
    )

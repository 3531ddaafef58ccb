"""Every stage as a function on arrays. Each takes the parameters of its group as keywords."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

from . import _core
from ._arrays import F32, F64, U8, gray, rows, vertex_numbers
from .capture import Capture, as_capture
from .errors import ParameterError
from .mesh import Mesh
from .params import Params, params_for, to_sets
from .progress import Callback, watcher
from .result import Cloud, Matches, load_template


@dataclass(frozen=True, eq=False)
class Dots:
    """Projected dots found in one photo.

    Attributes:
        positions: (n, 2) centres ``x, y``, pixels.
        sigmas: (n,) standard deviation of the profile, pixels; 0 where not measured.
        amplitudes: (n,) height above the surroundings, grey levels; 0 where not measured.
        scores: (n,) confidence, 0 to 1.
        spacing_px: usual distance to the next dot.
        thinned: (height, width) one white pixel a dot (thesis Fig. 2.4), where thinned.
    """

    positions: F64
    sigmas: F64
    amplitudes: F64
    scores: F64
    spacing_px: float
    thinned: F32 | None

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True, eq=False)
class Rectified:
    """A pair with level rows.

    Attributes:
        left, right: (height, width) grey photos with the pattern, 0 to 255.
        plain: the pair without the pattern, or ``None``.
        offset_px, roll_deg, scale: how the right photo's rows were found off.
        residual_px: row difference that is left, or ``None`` when not measured.
        corrected: whether the views were corrected by these figures.
        warnings: in words.
    """

    left: F32
    right: F32
    plain: tuple[F32, F32] | None
    offset_px: float
    roll_deg: float
    scale: float
    residual_px: float | None
    corrected: bool
    warnings: list[str]


@dataclass(frozen=True, eq=False)
class Registration:
    """How points came to a model.

    Attributes:
        model_from_data: (4, 4) similarity.
        history: error after each step, the first before any (thesis Eq. 3.8).
        termination: ``"converged"`` or ``"max_iterations"``.
        iterations: steps taken.
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
        """Points (n, 3) brought into the model frame."""
        given = rows("points", points, 3)
        moved: F64 = given @ self.model_from_data[:3, :3].T + self.model_from_data[:3, 3]
        return moved


@dataclass(frozen=True, eq=False)
class Deformed:
    """A bent head: its mesh, the points it rests on, and the distance from its goals (rms)."""

    mesh: Mesh
    rms_before: float
    rms_after: float
    centres: int


def equalize(image: Any, method: str = "global", **settings: Any) -> F32:
    """Histogram equalisation, ``"global"`` or ``"clahe"``; (height, width) grey 0 to 255."""
    params = params_for("filter", None, {"equalize": method, **settings})
    equalized, _, _ = _core.filter(gray("image", image), params)
    if equalized is None:
        raise ParameterError(
            f'method is {method!r}, but must be "global" or "clahe"', "parameters"
        )
    return equalized


def sharpen(image: Any, kernel: Any = None) -> F32:
    """Convolution with the thesis's 3x3 matrix (Eq. 2.1), or any odd square ``kernel``."""
    given = {} if kernel is None else {"kernel": kernel}
    return _core.sharpen(gray("image", image), params_for("filter", None, given))


def threshold(image: Any, method: str = "fixed", **settings: Any) -> F32:
    """Black and white, 0 or 255: ``"fixed"`` (``level=``), ``"otsu"`` or ``"local"``."""
    params = params_for("filter", None, {"threshold": method, **settings})
    return _core.threshold(gray("image", image), params)


def thin(binary: Any, **settings: Any) -> Dots:
    """One dot for each white spot of a black and white image (thesis section 2.2.3)."""
    params = params_for("detect", "facebuilder", settings)
    return Dots(*_core.detect(gray("binary", binary), True, params))


def detect(image: Any, profile: str | None = None, **settings: Any) -> Dots:
    """The projected dots of one photo; settings are those of ``detect``."""
    params = params_for("detect", profile, settings)
    return Dots(*_core.detect(gray("image", image), False, params))


def rectify(capture: Capture | str | PathLike[str], **settings: Any) -> Rectified:
    """Both pairs with level rows."""
    params = params_for("rectify", None, settings)
    return Rectified(**_core.rectify(as_capture(capture)._core, params))


def match(
    capture: Capture | str | PathLike[str],
    profile: str | None = None,
    *,
    params: Params | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Matches:
    """Which dot of the left photo is which of the right: rectify, detect, correspond.

    ``settings`` are groups, as for :func:`facerecon.reconstruct`. The matches have no points yet.
    """
    core = _core.Params(profile, None, to_sets(settings)) if params is None else params._core
    watch = watcher(progress)
    try:
        columns, _dots, _warnings = _core.find_matches(
            as_capture(capture)._core, core, watch.callback
        )
    finally:
        watch.close()
    return Matches(*columns)


def triangulate(
    capture: Capture | str | PathLike[str],
    matches: Matches | tuple[Any, Any],
    **settings: Any,
) -> Cloud:
    """Points from matches, or from ``(left, right)`` positions (n, 2) in the photos, pixels.

    Camera frame, millimetres, with a calibrated capture (Eq. 2.2); else model units (Eq. 2.3 to
    2.6).
    """
    left, right = matches if isinstance(matches, tuple) else (matches.left, matches.right)
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
    """Brings measured points to a model (Eq. 3.1-3.8 with ``method="besl"``).

    Args:
        data: (n, 3) points: camera frame, mm, when ``metric``; else near the model's frame.
        model: a generic head.
        features: marked features as ``(measured, on the model)``, both (k, 3).
        settings: those of ``register``.

    Raises:
        RegisterError: when the pose would be worse than the start.
    """
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    marks = None
    if features is not None:
        marks = rows("features[0]", features[0], 3), rows("features[1]", features[1], 3)
        if len(marks[0]) != len(marks[1]):
            raise ParameterError(
                f"features[1] has shape {marks[1].shape}, but {marks[0].shape} is wanted",
                "parameters",
            )
    params = params_for("register", profile, settings)
    watch = watcher(progress)
    try:
        matrix, text, history, inliers = _core.icp(
            points, load_template(model), metric, marks, params, watch.callback
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
    """Bends a head to registered points (Eq. 4.1-4.8 with the RBF methods).

    Args:
        template: the generic head, model frame.
        data: (n, 3) points of the model frame.
        assignments: the place each vertex must reach; by default the mean of the points whose
            closest vertex it is (thesis section 3.2).
        features: places of marked features, by vertex number or landmark name.
        settings: those of ``deform``, e.g. ``method="gaussian-rbf"``.
    """
    points = rows("data", data.points if isinstance(data, Cloud) else data, 3)
    named = None
    if features is not None:
        unknown = [k for k in features if isinstance(k, str) and k not in template.landmarks]
        if unknown:
            raise ParameterError(f"features: the template has no {unknown}", "parameters")
        named = {template.landmarks[k] if isinstance(k, str) else k: v for k, v in features.items()}
    count = len(template.vertices)
    params = params_for("deform", profile, settings)
    watch = watcher(progress)
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


def fit(template: Mesh, data: Cloud | Any, **settings: Any) -> Deformed:
    """Robust non-rigid ICP: :func:`deform` with ``method="nicp"``."""
    return deform(template, data, method="nicp", **settings)


def smooth(mesh: Mesh, method: str = "laplacian", *, reference: Any = None, **settings: Any) -> Mesh:
    """Laplacian smoothing (Eq. 4.9-4.10), or ``"taubin"``; settings are those of ``smooth``.

    ``reference``: (k, 3) points whose bounds the mesh is enlarged back to.
    """
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
    """Colours a mesh of the camera frame (mm) from a calibrated capture's plain pair.

    Gives the textured mesh and the coverage map (see :attr:`facerecon.Result.coverage`).
    """
    params = params_for("texture", profile, settings)
    watch = watcher(progress)
    try:
        image, coverage = _core.texture(
            as_capture(capture)._core, mesh._parts(), params, watch.callback
        )
    finally:
        watch.close()
    return Mesh._from_parts(mesh._parts(), image, mesh.landmarks), coverage


def _goals(
    name: str, given: Mapping[int, Any] | None, count: int
) -> tuple[list[int], F64] | None:
    if given is None:
        return None
    return (
        vertex_numbers(name, list(given), count),
        rows(name, list(given.values()) if given else _NOTHING, 3),
    )


_NOTHING = rows("nothing", [[0.0, 0.0, 0.0]], 3)[:0]

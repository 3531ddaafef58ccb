"""The stages on photos: from pixels to matches (thesis chapter 2)."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from . import _core
from ._arrays import F32, F64, gray, square
from ._html import figure, points_picture, ramp, thumbnail
from .capture import Capture, as_capture
from .errors import ParameterError
from .params import Params, given_params, params_for
from .progress import Callback, watcher
from .result import Matches


@dataclass(frozen=True, eq=False)
class Dots:
    """Projected dots found in one photo.

    Attributes:
        positions: (n, 2) centres ``x, y``, pixels.
        sigmas: (n,) standard deviation of the Gaussian profile, pixels; 0 where not measured.
        amplitudes: (n,) height above the surroundings, grey levels; 0 where not measured.
        scores: (n,) confidence, 0 to 1.
        spacing_px: spacing of the dots.
        thinned: (height, width) one white pixel per dot (thesis Fig. 2.4) with thinning, else
            ``None``.
    """

    positions: F64
    sigmas: F64
    amplitudes: F64
    scores: F64
    spacing_px: float
    thinned: F32 | None

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<facerecon.Dots: {len(self)}, {self.spacing_px:.1f} px apart>"

    def _repr_html_(self) -> str:
        return figure(points_picture(self.positions, ramp(self.scores)), repr(self))


@dataclass(frozen=True, eq=False)
class Rectified:
    """A rectified pair: corresponding points lie on the same row.

    Attributes:
        left, right: (height, width) grey photos with the pattern, 0 to 255.
        plain: the plain pair (without the pattern), or ``None``.
        offset_px, roll_deg, scale: measured misalignment of the rows of the right photo.
        residual_px: remaining row difference, or ``None`` when not measured.
        corrected: whether the misalignment was corrected.
        warnings: what needs attention.
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

    def __repr__(self) -> str:
        height, width = self.left.shape
        return f"<facerecon.Rectified: {width}x{height} px, rows off by {self.offset_px:.2f} px>"

    def _repr_html_(self) -> str:
        pair = np.concatenate([thumbnail(self.left), thumbnail(self.right)], axis=1)
        return figure(pair, repr(self))


def equalize(image: Any, method: str = "global", **settings: Any) -> F32:
    """Equalise the histogram of a photo (thesis section 2.2, there future work).

    Args:
        image: (height, width) grey, or (height, width, 3) uint8 sRGB.
        method: ``"global"``, or ``"clahe"`` (per tile, with limited contrast).
        settings: those of ``filter``, e.g. ``clip_limit=3``, ``tiles=8``.

    Returns:
        (height, width) float32 grey levels, 0 to 255.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        FilterError: for a photo that cannot be filtered.
    """
    if method not in ("global", "clahe"):
        raise ParameterError(f'method is {method!r}; expected "global" or "clahe"', "parameters")
    params = params_for("filter", None, {"equalize": method, **settings})
    equalized, _, _ = _core.filter(gray("image", image), params)
    assert equalized is not None
    return equalized


def sharpen(image: Any, kernel: Any = None) -> F32:
    """Convolve a photo with the 3x3 matrix of the thesis (Eq. 2.1), or another odd square.

    Args:
        image: (height, width) grey, or (height, width, 3) uint8 sRGB.
        kernel: (k, k) numbers, k odd; they should sum to 1. By default Eq. 2.1.

    Returns:
        (height, width) float32 grey levels, clipped to 0 to 255.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
    """
    given = {} if kernel is None else {"kernel": square("kernel", kernel)}
    return _core.sharpen(gray("image", image), params_for("filter", None, given))


def threshold(image: Any, method: str = "fixed", **settings: Any) -> F32:
    """Make a photo binary, black and white (thesis section 2.2.2).

    Args:
        image: (height, width) grey, or (height, width, 3) uint8 sRGB.
        method: ``"fixed"`` (the thesis, with ``level=``), ``"otsu"``, or ``"local"`` (relative to
            the neighbourhood).
        settings: those of ``filter``, e.g. ``level=180``.

    Returns:
        (height, width) float32, 0 or 255.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
    """
    params = params_for("filter", None, {"threshold": method, **settings})
    return _core.threshold(gray("image", image), params)


def thin(binary: Any, **settings: Any) -> Dots:
    """Reduce each white spot of a binary image to one dot (thesis section 2.2.3).

    Args:
        binary: (height, width), 0 or 255.
        settings: those of ``detect``, e.g. ``merge=False`` for the literal window of the thesis.

    Returns:
        The dots, pixels, with the thinned image of Fig. 2.4.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DetectError: when there are too few spots.
    """
    params = params_for("detect", "facebuilder", settings)
    return Dots(*_core.detect(gray("binary", binary), True, params))


def detect(image: Any, profile: str | None = None, **settings: Any) -> Dots:
    """Detect the projected dots of one photo.

    Args:
        image: (height, width) grey, or (height, width, 3) uint8 sRGB.
        profile: ``"precise"`` (sub-pixel, the default) or ``"facebuilder"`` (Eq. 2.1, threshold,
            thinning: thesis section 2.2).
        settings: those of ``detect``.

    Returns:
        The dots, pixels.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        DetectError: when there are too few dots.
    """
    params = params_for("detect", profile, settings)
    return Dots(*_core.detect(gray("image", image), False, params))


def rectify(capture: Capture | str | PathLike[str], **settings: Any) -> Rectified:
    """Rectify both pairs, so that corresponding points lie on the same row (thesis section 2.3).

    Args:
        capture: a :class:`Capture`, or its path.
        settings: those of ``rectify``.

    Returns:
        The grey pairs and the measured misalignment of the rows, pixels and degrees.

    Raises:
        ParameterError: (a ``ValueError``) for settings.
        FileError: (an ``OSError``) for a capture that cannot be read.
        RectifyError: for photos that cannot be rectified.
    """
    params = params_for("rectify", None, settings)
    return Rectified(**_core.rectify(as_capture(capture)._core, params))


def correspond(
    capture: Capture | str | PathLike[str],
    profile: str | None = None,
    *,
    params: Params | None = None,
    progress: bool | Callback = False,
    **settings: Any,
) -> Matches:
    """Match the dots of the left photo with those of the right: rectify, detect, correspond.

    ``match`` is an alias.

    Args:
        capture: a :class:`Capture`, or its path.
        profile: ``"precise"`` (by the lattice of the dots, the default) or ``"facebuilder"`` (the
            scan from three marked pairs: thesis section 2.3).
        params: all parameters; not together with ``profile`` or ``settings``.
        progress: ``True`` for a bar, or a function that receives every :class:`Event`.
        settings: groups, as for :func:`facerecon.reconstruct`.

    Returns:
        The matches, pixels of the photos. They have no points yet (see :func:`triangulate`).

    Raises:
        ParameterError: (a ``ValueError``) for parameters.
        FileError: (an ``OSError``) for a capture that cannot be read.
        RectifyError, DetectError, CorrespondError: for photos that cannot be matched.
    """
    core = given_params(profile, params, settings)
    photos = as_capture(capture)
    watch = watcher(progress, ("rectify", "detect", "correspond"))
    try:
        columns, _dots = _core.find_matches(photos._core, core, watch.callback)
    finally:
        watch.close()
    return Matches(*columns)


#: Alias of :func:`correspond`.
match = correspond

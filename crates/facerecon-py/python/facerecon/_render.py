"""Rendering of a mesh given as arrays; below :mod:`facerecon.mesh` and :mod:`facerecon.makers`."""

from __future__ import annotations

import operator
from collections.abc import Sequence

from . import _core
from ._arrays import F64, U8, MeshParts
from .errors import ParameterError


def draw(
    parts: MeshParts,
    texture: U8 | None,
    view: str | Sequence[str],
    *,
    mode: str | None = None,
    heat: F64 | None = None,
    limit_mm: float | None = None,
    frame: str = "model",
    size: tuple[int, int],
) -> U8:
    """An image (height, width, 3) uint8 of one view, or of several side by side.

    Without ``mode``: ``heat`` with values, else ``lit`` with a texture or vertex colours, else
    ``shaded``.
    """
    if mode is None:
        coloured = texture is not None or parts[4] is not None
        mode = "heat" if heat is not None else "lit" if coloured else "shaded"
    views = [view] if isinstance(view, str) else list(view)
    try:
        width, height = (operator.index(n) for n in size)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"size is {size!r}; expected (width, height)", "parameters") from error
    if min(width, height) < 1:
        raise ParameterError(f"size is {size}; expected at least (1, 1)", "parameters")
    return _core.render(parts, texture, heat, limit_mm, views, mode, frame, (width, height))

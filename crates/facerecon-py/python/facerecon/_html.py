"""Images for the HTML representations in notebooks."""

from __future__ import annotations

import base64
import html
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8

#: Background of images of points, sRGB.
BACKGROUND = (32, 34, 38)


def figure(image: U8, caption: str) -> str:
    """An HTML figure with an embedded image."""
    data = base64.b64encode(_core.encode_png(np.ascontiguousarray(image))).decode("ascii")
    return (
        '<figure style="margin:0"><img style="max-width:100%" '
        f'src="data:image/png;base64,{data}" alt=""/>'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def thumbnail(image: Any, width: int = 450) -> U8:
    """A photo, grey or in colour, reduced to about this width: (height, width, 3)."""
    shown = np.asarray(image)
    fine = max(1, round(shown.shape[1] / width))
    height, across = (n // fine * fine for n in shown.shape[:2])
    if fine > 1 and height and across:
        cells = shown[:height, :across].astype(np.float32)
        cells = cells.reshape(height // fine, fine, across // fine, fine, -1).mean(axis=(1, 3))
        shown = cells[..., 0] if shown.ndim == 2 else cells
    if shown.ndim == 2:
        shown = np.repeat(shown[:, :, None], 3, axis=2)
    picture: U8 = np.clip(np.rint(shown), 0, 255).astype(np.uint8)
    return picture


def ramp(values: F64) -> U8:
    """Colours (n, 3) from blue over green and yellow to red; the ends are the 2nd and 98th
    percentiles, values that are not finite are grey."""
    known = np.isfinite(values)
    colors = np.full((len(values), 3), 128, dtype=np.uint8)
    if known.any():
        low, high = np.percentile(values[known], (2, 98))
        at = np.clip((values[known] - low) / max(high - low, 1e-12), 0.0, 1.0) * 4.0
        stops = np.array(
            [[49, 54, 220], [69, 159, 220], [120, 220, 130], [253, 190, 70], [215, 48, 39]]
        )
        colors[known] = np.stack([np.interp(at, range(5), stops[:, k]) for k in range(3)], axis=1)
    return colors


def points_picture(places: F64, colors: U8, size: tuple[int, int] = (300, 300)) -> U8:
    """An image filled with points (n, 2): x right, y down, later points on top."""
    width, height = size
    canvas = np.full((height, width, 3), BACKGROUND, dtype=np.uint8)
    known = np.isfinite(places).all(axis=1)
    if not known.any():
        return canvas
    x, y, colors = places[known, 0], places[known, 1], colors[known]
    # percentiles: a few outliers must not shrink the rest
    (left, right), (top, bottom) = (np.percentile(v, (1, 99)) for v in (x, y))
    scale = 0.85 * min(width / max(right - left, 1e-9), height / max(bottom - top, 1e-9))
    across = np.clip((x - (left + right) / 2.0) * scale + width / 2.0, -9, width + 9).astype(int)
    down = np.clip((y - (top + bottom) / 2.0) * scale + height / 2.0, -9, height + 9).astype(int)
    # single pixels for dense clouds, larger squares for sparse ones
    side = 1 if len(x) > 20_000 else 2 if len(x) > 4_000 else 3
    for i in range(side):
        for j in range(side):
            col, row = across + i, down + j
            inside = (col >= 0) & (col < width) & (row >= 0) & (row < height)
            canvas[row[inside], col[inside]] = colors[inside]
    return canvas

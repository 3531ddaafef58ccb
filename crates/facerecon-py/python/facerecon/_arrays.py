"""Checks and converts arguments to arrays of the core: C order, type, shape, finite values.

Any memory layout is accepted (Fortran order, strides, read-only), and other number types where
values are preserved. An error names the argument, its shape and the expected shape.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import ParameterError

F64 = npt.NDArray[np.float64]
F32 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint8]
U32 = npt.NDArray[np.uint32]
Matrix = list[list[float]]
#: A photo for the core: colour, and grey where the array was grey.
PhotoParts = tuple[U8, F32 | None]
Bool = npt.NDArray[np.bool_]
#: Vertices, faces, texture coordinates, their faces, colours, sigmas, measured flags.
MeshParts = tuple[F64, U32, F64 | None, U32 | None, U8 | None, F64 | None, Bool | None]
#: K1, D1, K2, D2, R, T, image size.
RigParts = tuple[
    Matrix, list[float], Matrix, list[float], Matrix, list[float], tuple[int, int] | None
]
#: Photo, K, D, R, T.
ExtraParts = tuple[PhotoParts, Matrix, list[float], Matrix, list[float]]


def refuse(name: str, value: npt.NDArray[Any], expected: str) -> ParameterError:
    """The exception for an array of the wrong shape or type."""
    return ParameterError(
        f"{name} has shape {value.shape} and type {value.dtype}; expected {expected}",
        "parameters",
    )


def _array(name: str, value: object, expected: str) -> npt.NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ParameterError(f"{name} is ragged; expected {expected}", "parameters") from error


def _numbers(name: str, value: object, expected: str) -> npt.NDArray[Any]:
    array = _array(name, value, expected)
    if array.dtype.kind not in "fiu":
        raise refuse(name, array, expected)
    return array


def rows(name: str, value: object, columns: int, *, nan: bool = False) -> F64:
    """``(n, columns)`` numbers, finite unless ``nan``."""
    expected = f"an array (n, {columns}) of numbers"
    array = _numbers(name, value, expected)
    if array.ndim != 2 or array.shape[1] != columns:
        raise refuse(name, array, expected)
    array = np.ascontiguousarray(array, dtype=np.float64)
    if not nan and not np.isfinite(array).all():
        row = int(np.argwhere(~np.isfinite(array))[0][0])
        raise ParameterError(
            f"{name} has shape {array.shape}, but row {row} holds {array[row].tolist()}; "
            "expected finite numbers",
            "parameters",
        )
    return array


def indices(name: str, value: object, columns: int, count: int) -> U32:
    """``(n, columns)`` whole numbers from 0 to ``count - 1``."""
    expected = f"an array (n, {columns}) of whole numbers"
    array = _numbers(name, value, expected)
    if array.ndim != 2 or array.shape[1] != columns or array.dtype.kind == "f":
        raise refuse(name, array, expected)
    if array.size and (array.min() < 0 or array.max() >= count):
        raise ParameterError(
            f"{name} has shape {array.shape} and entries from {array.min()} to {array.max()}; "
            f"expected entries from 0 to {count - 1}",
            "parameters",
        )
    return np.ascontiguousarray(array, dtype=np.uint32)


def colors(name: str, value: object) -> U8:
    """``(n, 3)`` sRGB colours, uint8."""
    expected = "an array (n, 3) of uint8"
    array = _array(name, value, expected)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype != np.uint8:
        raise refuse(name, array, expected)
    return np.ascontiguousarray(array)


def column(name: str, value: object, count: int) -> F64:
    """``(count,)`` numbers, NaN where unknown."""
    expected = f"an array ({count},) of numbers"
    array = _numbers(name, value, expected)
    if array.shape != (count,):
        raise refuse(name, array, expected)
    return np.ascontiguousarray(array, dtype=np.float64)


def picture(name: str, value: object) -> U8:
    """``(height, width, 3)`` sRGB, uint8."""
    expected = "an image (height, width, 3) of uint8"
    array = _array(name, value, expected)
    if array.ndim != 3 or array.shape[2] != 3 or array.dtype != np.uint8 or 0 in array.shape:
        raise refuse(name, array, expected)
    return np.ascontiguousarray(array)


def gray(name: str, value: object) -> F32:
    """``(height, width)`` grey levels 0 to 255, float32.

    uint8 and float images have levels 0 to 255, uint16 images 0 to 65535; colour images are
    converted to luma (Rec. 601).
    """
    expected = "a grey image (height, width) or a colour image (height, width, 3) of uint8"
    array = _numbers(name, value, expected)
    if array.ndim == 3:
        colour = picture(name, array).astype(np.float32)
        luma = colour @ np.array([0.299, 0.587, 0.114], dtype=np.float32)
        return np.ascontiguousarray(luma, dtype=np.float32)
    if array.ndim != 2 or 0 in array.shape:
        raise refuse(name, array, expected)
    if array.dtype.kind == "u" and array.dtype.itemsize == 2:
        return np.ascontiguousarray(array / np.float32(257.0), dtype=np.float32)
    if array.dtype.kind in "iu" and array.dtype != np.uint8:
        raise refuse(name, array, expected + ", or float with levels 0 to 255")
    with np.errstate(over="ignore"):  # values beyond float32 become infinite and are refused below
        levels = np.ascontiguousarray(array, dtype=np.float32)
    if not np.isfinite(levels).all():
        row, col = np.argwhere(~np.isfinite(levels))[0]
        raise ParameterError(
            f"{name} has shape {array.shape}, but pixel ({col}, {row}) is {levels[row, col]}; "
            "expected finite grey levels",
            "parameters",
        )
    return levels


def photo(name: str, value: object) -> PhotoParts:
    """A photo: colour, and grey with its fractional levels where the array is grey."""
    array = _array(name, value, "a photo (height, width, 3) or (height, width)")
    if array.ndim == 3:
        return picture(name, array), None
    levels = gray(name, array)
    rounded = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return np.ascontiguousarray(np.repeat(rounded[:, :, None], 3, axis=2)), levels


def floats(name: str, value: object) -> list[float]:
    """Finite numbers of any shape, as a flat list."""
    array = _numbers(name, value, "finite numbers").astype(np.float64).reshape(-1)
    if not np.isfinite(array).all():
        raise ParameterError(
            f"{name} is {array.tolist()}; expected finite numbers", "parameters"
        )
    return [float(v) for v in array]


def whole(name: str, value: object, least: int, most: int) -> int:
    """A whole number within bounds."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise ParameterError(
            f"{name} is {value!r}; expected a whole number from {least} to {most}",
            "parameters",
        )
    return number


def matrix(name: str, value: object, shape: tuple[int, ...]) -> Any:
    """A finite array of a fixed shape, as nested lists; a vector may be a row or a column."""
    expected = f"an array {shape} of finite numbers"
    array = _numbers(name, value, expected).astype(np.float64)
    if len(shape) == 1 and array.ndim == 2 and array.size == shape[0]:
        array = array.reshape(shape)
    if array.shape != shape:
        raise refuse(name, array, expected)
    if not np.isfinite(array).all():
        raise ParameterError(
            f"{name} has shape {array.shape} and holds {array.tolist()}; expected {expected}",
            "parameters",
        )
    return array.tolist()


def square(name: str, value: object) -> list[list[float]]:
    """A finite (k, k) array, k odd, as nested lists."""
    expected = "an array (k, k) of finite numbers, k odd"
    array = _numbers(name, value, expected)
    if array.ndim != 2 or array.shape[0] != array.shape[1] or array.shape[0] % 2 == 0:
        raise refuse(name, array, expected)
    nested: list[list[float]] = matrix(name, array, array.shape)
    return nested


def vertex_indices(name: str, value: Sequence[int] | npt.NDArray[Any], count: int) -> list[int]:
    """Vertex indices from 0 to ``count - 1``."""
    array = _array(name, value, "a list of vertex indices")
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise refuse(name, array, "a list of vertex indices")
    if array.size and (array.min() < 0 or array.max() >= count):
        raise ParameterError(
            f"{name} names vertices {array.min()} to {array.max()}; "
            f"expected 0 to {count - 1}",
            "parameters",
        )
    return [int(i) for i in array]

"""Arguments as the core takes them: C order, the right type, the right shape, finite.

Any layout is taken (Fortran order, strides, read-only, other number types without loss of
meaning); what is wrong is refused with the argument's name, its shape and what was wanted.
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
#: What a photo is for the core: colour, and grey where it has fractions.
PhotoParts = tuple[U8, F32 | None]
#: Vertices, faces, texture coordinates, their faces, colours.
MeshParts = tuple[F64, U32, F64 | None, U32 | None, U8 | None]
#: K1, D1, K2, D2, R, T, image size.
RigParts = tuple[
    Matrix, list[float], Matrix, list[float], Matrix, list[float], tuple[int, int] | None
]
#: Photo, K, D, R, T.
ExtraParts = tuple[PhotoParts, Matrix, list[float], Matrix, list[float]]


def refuse(name: str, value: npt.NDArray[Any], wanted: str) -> ParameterError:
    """The exception for an array of the wrong shape or type."""
    return ParameterError(
        f"{name} has shape {value.shape} and type {value.dtype}, but {wanted} is wanted",
        "parameters",
    )


def _array(name: str, value: object, wanted: str) -> npt.NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ParameterError(f"{name} is ragged, but {wanted} is wanted", "parameters") from error


def _numbers(name: str, value: object, wanted: str) -> npt.NDArray[Any]:
    array = _array(name, value, wanted)
    if array.dtype.kind not in "fiu":
        raise refuse(name, array, wanted)
    return array


def rows(name: str, value: object, columns: int, *, nan: bool = False) -> F64:
    """``(n, columns)`` numbers, finite unless ``nan``."""
    wanted = f"an array (n, {columns}) of numbers"
    array = _numbers(name, value, wanted)
    if array.ndim != 2 or array.shape[1] != columns:
        raise refuse(name, array, wanted)
    array = np.ascontiguousarray(array, dtype=np.float64)
    if not nan and not np.isfinite(array).all():
        row = int(np.argwhere(~np.isfinite(array))[0][0])
        raise ParameterError(
            f"{name} has shape {array.shape}, but row {row} holds {array[row].tolist()}: "
            "finite numbers are wanted",
            "parameters",
        )
    return array


def indices(name: str, value: object, columns: int, count: int) -> U32:
    """``(n, columns)`` whole numbers from 0 to ``count - 1``."""
    wanted = f"an array (n, {columns}) of whole numbers"
    array = _numbers(name, value, wanted)
    if array.ndim != 2 or array.shape[1] != columns or array.dtype.kind == "f":
        raise refuse(name, array, wanted)
    if array.size and (array.min() < 0 or array.max() >= count):
        raise ParameterError(
            f"{name} has shape {array.shape} and entries from {array.min()} to {array.max()}, "
            f"but entries from 0 to {count - 1} are wanted",
            "parameters",
        )
    return np.ascontiguousarray(array, dtype=np.uint32)


def colors(name: str, value: object) -> U8:
    """``(n, 3)`` sRGB colours, uint8."""
    wanted = "an array (n, 3) of uint8"
    array = _array(name, value, wanted)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype != np.uint8:
        raise refuse(name, array, wanted)
    return np.ascontiguousarray(array)


def column(name: str, value: object, count: int) -> F64:
    """``(count,)`` numbers, NaN where unknown."""
    wanted = f"an array ({count},) of numbers"
    array = _numbers(name, value, wanted)
    if array.shape != (count,):
        raise refuse(name, array, wanted)
    return np.ascontiguousarray(array, dtype=np.float64)


def picture(name: str, value: object) -> U8:
    """``(height, width, 3)`` sRGB, uint8."""
    wanted = "a picture (height, width, 3) of uint8"
    array = _array(name, value, wanted)
    if array.ndim != 3 or array.shape[2] != 3 or array.dtype != np.uint8 or 0 in array.shape:
        raise refuse(name, array, wanted)
    return np.ascontiguousarray(array)


def gray(name: str, value: object) -> F32:
    """``(height, width)`` grey levels 0 to 255, float32.

    uint8 and float images count as 0 to 255, uint16 ones as 0 to 65535; of colour pictures the
    luma (Rec. 601) is taken.
    """
    wanted = "a grey image (height, width) or a colour picture (height, width, 3) of uint8"
    array = _numbers(name, value, wanted)
    if array.ndim == 3:
        colour = picture(name, array).astype(np.float32)
        luma = colour @ np.array([0.299, 0.587, 0.114], dtype=np.float32)
        return np.ascontiguousarray(luma, dtype=np.float32)
    if array.ndim != 2 or 0 in array.shape:
        raise refuse(name, array, wanted)
    if array.dtype.kind == "u" and array.dtype.itemsize == 2:
        return np.ascontiguousarray(array / np.float32(257.0), dtype=np.float32)
    if array.dtype.kind in "iu" and array.dtype != np.uint8:
        raise refuse(name, array, wanted + ", or float with levels 0 to 255")
    with np.errstate(over="ignore"):  # what does not fit is infinite, and refused
        levels = np.ascontiguousarray(array, dtype=np.float32)
    if not np.isfinite(levels).all():
        row, col = np.argwhere(~np.isfinite(levels))[0]
        raise ParameterError(
            f"{name} has shape {array.shape}, but pixel ({col}, {row}) is {levels[row, col]}: "
            "finite grey levels are wanted",
            "parameters",
        )
    return levels


def photo(name: str, value: object) -> PhotoParts:
    """A photo: colour, and grey with its fractions where the array is grey."""
    array = _array(name, value, "a photo (height, width, 3) or (height, width)")
    if array.ndim == 3:
        return picture(name, array), None
    levels = gray(name, array)
    rounded = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    return np.ascontiguousarray(np.repeat(rounded[:, :, None], 3, axis=2)), levels


def floats(name: str, value: object) -> list[float]:
    """Some finite numbers, in a row whatever their shape."""
    array = _numbers(name, value, "a row of finite numbers").astype(np.float64).reshape(-1)
    if not np.isfinite(array).all():
        raise ParameterError(
            f"{name} is {array.tolist()}, but finite numbers are wanted", "parameters"
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
            f"{name} is {value!r}, but a whole number from {least} to {most} is wanted",
            "parameters",
        )
    return number


def matrix(name: str, value: object, shape: tuple[int, ...]) -> Any:
    """A small finite array of a fixed shape, as nested lists; a vector may be a row or a column."""
    wanted = f"an array {shape} of finite numbers"
    array = _numbers(name, value, wanted).astype(np.float64)
    if len(shape) == 1 and array.ndim == 2 and array.size == shape[0]:
        array = array.reshape(shape)
    if array.shape != shape:
        raise refuse(name, array, wanted)
    if not np.isfinite(array).all():
        raise ParameterError(
            f"{name} has shape {array.shape} and holds {array.tolist()}, but {wanted} is wanted",
            "parameters",
        )
    return array.tolist()


def square(name: str, value: object) -> list[list[float]]:
    """A finite (k, k) array, k odd, as nested lists."""
    wanted = "an array (k, k) of finite numbers, k odd,"
    array = _numbers(name, value, wanted)
    if array.ndim != 2 or array.shape[0] != array.shape[1] or array.shape[0] % 2 == 0:
        raise refuse(name, array, wanted)
    nested: list[list[float]] = matrix(name, array, array.shape)
    return nested


def vertex_numbers(name: str, value: Sequence[int] | npt.NDArray[Any], count: int) -> list[int]:
    """Vertex numbers from 0 to ``count - 1``."""
    array = _array(name, value, "a list of vertex numbers")
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise refuse(name, array, "a list of vertex numbers")
    if array.size and (array.min() < 0 or array.max() >= count):
        raise ParameterError(
            f"{name} names vertices {array.min()} to {array.max()}, "
            f"but 0 to {count - 1} are wanted",
            "parameters",
        )
    return [int(i) for i in array]

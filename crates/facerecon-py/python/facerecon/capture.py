"""Captures and rigs: from files or from arrays."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8, ExtraParts, RigParts, floats, matrix, photo, whole
from ._html import figure, thumbnail
from .errors import FaceReconWarning, ParameterError

#: A position in both photos: ``((xl, yl), (xr, yr))``, pixels.
Pair = tuple[tuple[float, float], tuple[float, float]]
SEEDS = ("head", "left_ear", "right_ear")


@dataclass(frozen=True, eq=False)
class Rig:
    """Two calibrated cameras, as OpenCV's stereo calibration gives them.

    Attributes:
        K1, K2: (3, 3) camera matrices of the left and right camera, pixels.
        D1, D2: up to 8 distortion coefficients ``k1 k2 p1 p2 k3 k4 k5 k6``.
        R, T: (3, 3) rotation and (3,) translation, mm: ``X_right = R X_left + T``.
        image_size: (width, height) of the photos it was calibrated on, or ``None``.

    Raises:
        ParameterError: (a ``ValueError``) naming the argument, its shape and the expected shape.
    """

    K1: Any
    D1: Any
    K2: Any
    D2: Any
    R: Any
    T: Any
    image_size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name, shape in (("K1", (3, 3)), ("K2", (3, 3)), ("R", (3, 3)), ("T", (3,))):
            object.__setattr__(
                self, name, np.array(matrix(f"rig.{name}", getattr(self, name), shape))
            )
        for name in ("D1", "D2"):
            object.__setattr__(self, name, np.array(_lens(f"rig.{name}", getattr(self, name))))
        if self.image_size is not None:
            sides = matrix("rig.image_size", self.image_size, (2,))
            size = tuple(whole("rig.image_size", int(n), 1, 10**6) for n in sides)
            object.__setattr__(self, "image_size", size)
        for name in ("K1", "K2"):
            _camera(f"rig.{name}", getattr(self, name))

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Rig:
        """Read an OpenCV calibration (YAML, XML or JSON), mm.

        What is unusual in the file gives a :class:`FaceReconWarning`.

        Raises:
            FileError: (an ``OSError``) with the file and the reason.
        """
        parts, found = _core.read_rig(fspath(path))
        for text in found:
            warnings.warn(f"{fspath(path)}: {text}", FaceReconWarning, stacklevel=2)
        return cls(*parts)

    @classmethod
    def parallel(
        cls,
        baseline_mm: float,
        focal_px: float,
        principal_left: Sequence[float],
        principal_right: Sequence[float],
    ) -> Rig:
        """A parallel rig: equal focal lengths, no distortion, level rows (thesis Eq. 2.2).

        Args:
            baseline_mm: distance between the cameras.
            focal_px: focal length of both.
            principal_left, principal_right: ``(x, y)`` of the principal points, pixels.

        Raises:
            ParameterError: (a ``ValueError``) for values that are not those of a camera.
        """
        baseline_mm, focal_px = floats("baseline_mm, focal_px", [baseline_mm, focal_px])
        principal_left = matrix("principal_left", principal_left, (2,))
        principal_right = matrix("principal_right", principal_right, (2,))
        left = [[focal_px, 0, principal_left[0]], [0, focal_px, principal_left[1]], [0, 0, 1]]
        right = [[focal_px, 0, principal_right[0]], [0, focal_px, principal_right[1]], [0, 0, 1]]
        lens = [0.0] * 5
        return cls(left, lens, right, lens, np.eye(3), [-float(baseline_mm), 0.0, 0.0])

    def save(self, path: str | PathLike[str]) -> None:
        """Write an OpenCV calibration (YAML), mm.

        Raises:
            FileError: (an ``OSError``) when it cannot be written.
        """
        _core.write_rig(fspath(path), self._parts())

    @property
    def baseline_mm(self) -> float:
        """Distance between the cameras, mm."""
        return float(np.linalg.norm(self.T))

    def _parts(self) -> RigParts:
        return (
            self.K1.tolist(),
            self.D1.tolist(),
            self.K2.tolist(),
            self.D2.tolist(),
            self.R.tolist(),
            self.T.tolist(),
            self.image_size,
        )


def _lens(name: str, value: Any) -> list[float]:
    numbers = floats(name, value)
    if len(numbers) > 8:
        raise ParameterError(
            f"{name} has {len(numbers)} numbers; expected at most 8", "parameters"
        )
    return numbers


def _camera(name: str, k: F64) -> None:
    rest = k - np.array([[k[0, 0], 0, k[0, 2]], [0, k[1, 1], k[1, 2]], [0, 0, 1]])
    if np.abs(rest).max() > 1e-6 or k[0, 0] <= 0 or k[1, 1] <= 0:
        raise ParameterError(
            f"{name} is {k.tolist()}; expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
            "parameters",
        )


def _marks(name: str, marks: Mapping[str, Any]) -> dict[str, list[float]]:
    """Positions in both photos as ``xl, yl, xr, yr``."""
    found: dict[str, list[float]] = {}
    for key, value in marks.items():
        if isinstance(value, Mapping):
            value = [value.get("left"), value.get("right")]
        flat = floats(f"{name}[{key!r}]", value)
        if len(flat) != 4:
            raise ParameterError(
                f"{name}[{key!r}] has {len(flat)} numbers; expected ((xl, yl), (xr, yr))",
                "parameters",
            )
        found[key] = flat
    return found


def _pair(m: Sequence[float]) -> Pair:
    return (m[0], m[1]), (m[2], m[3])


def _landmarks(landmarks: Mapping[str, Any]) -> dict[str, list[float]]:
    marked = _marks("landmarks", landmarks)
    unknown = sorted(set(marked) - set(_core.LANDMARK_NAMES))
    if unknown:
        raise ParameterError(
            f"landmarks has {unknown}; expected names of {list(_core.LANDMARK_NAMES)}",
            "parameters",
        )
    return marked


class Capture:
    """The input of a reconstruction: photographs, pattern, rig, marked positions.

    Args:
        left, right: photos with the pattern, (height, width, 3) uint8 sRGB, or grey
            (height, width) uint8, uint16 or float with levels 0 to 255.
        left_plain, right_plain: the plain pair (photos without the pattern), for the texture.
        rig: the cameras; without it the result is not metric.
        columns, rows: dots of the projected pattern.
        kind: ``"dots"`` or ``"stripes"``.
        rotation_deg: rotation of the lattice, clockwise.
        seeds: the three marked pairs of the thesis, ``head``, ``left_ear``, ``right_ear``, each
            ``((xl, yl), (xr, yr))`` in pixels of the photos.
        landmarks: marked landmarks by name, in the same form.
        extra: further photos for the texture with their cameras, dictionaries with ``image``,
            ``K``, ``D``, ``R``, ``T``; ``X_camera = R X_left + T``, mm.

    Raises:
        ParameterError: (a ``ValueError``) naming the argument, its shape and the expected shape.
    """

    def __init__(
        self,
        left: Any,
        right: Any,
        left_plain: Any = None,
        right_plain: Any = None,
        *,
        rig: Rig | None = None,
        columns: int = 85,
        rows: int = 64,
        kind: str = "dots",
        rotation_deg: float = 0.0,
        seeds: Mapping[str, Any] | None = None,
        landmarks: Mapping[str, Any] | None = None,
        extra: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        if rig is not None and not isinstance(rig, Rig):
            raise ParameterError(
                f"rig is a {type(rig).__name__}; expected a facerecon.Rig", "parameters"
            )
        photos = {"left": photo("left", left), "right": photo("right", right)}
        if (left_plain is None) != (right_plain is None):
            raise ParameterError(
                "left_plain and right_plain belong together; give both or neither", "parameters"
            )
        plain = None
        if left_plain is not None:
            photos["left_plain"] = photo("left_plain", left_plain)
            photos["right_plain"] = photo("right_plain", right_plain)
            plain = photos["left_plain"], photos["right_plain"]
        size = photos["left"][0].shape[:2]
        for name, (colour, _) in photos.items():
            if colour.shape[:2] != size:
                raise ParameterError(
                    f"{name} has shape {colour.shape[:2]}; expected {size}, that of left",
                    "parameters",
                )
        if kind not in ("dots", "stripes"):
            raise ParameterError(f'kind is {kind!r}; expected "dots" or "stripes"', "parameters")
        shape = whole("columns", columns, 2, 10_000), whole("rows", rows, 1, 10_000)
        (turn,) = floats("rotation_deg", [rotation_deg])
        marks = None if seeds is None else _marks("seeds", seeds)
        if marks is not None and set(marks) != set(SEEDS):
            raise ParameterError(
                f"seeds has {sorted(marks)}; expected {list(SEEDS)}", "parameters"
            )
        marked = _landmarks(landmarks or {})
        self._core = _core.Capture(
            photos["left"],
            photos["right"],
            plain,
            [_extra(i, e) for i, e in enumerate(extra)],
            (kind, *shape, turn),
            None if rig is None else rig._parts(),
            marks,
            marked,
        )

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Capture:
        """Read a capture folder, or its ``capture.toml``; see also :attr:`warnings`.

        Raises:
            FileError: (an ``OSError``) with the file and the reason.
        """
        return cls._wrap(_core.Capture.read(fspath(path)))

    @classmethod
    def _wrap(cls, core: _core.Capture) -> Capture:
        capture = cls.__new__(cls)
        capture._core = core
        return capture

    def with_landmarks(self, landmarks: Mapping[str, Any]) -> Capture:
        """The same capture with these landmarks marked, in place of its own.

        Args:
            landmarks: ``((xl, yl), (xr, yr))`` by name, pixels of the photos.

        Raises:
            ParameterError: (a ``ValueError``) for unknown names and for marks that are not two
                positions in the photos.
        """
        return Capture._wrap(self._core.with_landmarks(_landmarks(landmarks)))

    def save(self, folder: str | PathLike[str]) -> str:
        """Write a capture folder: photos, calibration and ``capture.toml``.

        Returns:
            The path of its ``capture.toml``.

        Raises:
            FileError: (an ``OSError``) naming the file that could not be written.
        """
        return fspath(self._core.write(fspath(folder)))

    @property
    def left(self) -> U8:
        """The left photo with the pattern, (height, width, 3) uint8."""
        image = self._core.photo("left")
        assert image is not None
        return image

    @property
    def right(self) -> U8:
        """The right photo with the pattern, (height, width, 3) uint8."""
        image = self._core.photo("right")
        assert image is not None
        return image

    @property
    def left_plain(self) -> U8 | None:
        """The left photo without the pattern, or ``None``."""
        return self._core.photo("left_plain")

    @property
    def right_plain(self) -> U8 | None:
        """The right photo without the pattern, or ``None``."""
        return self._core.photo("right_plain")

    @property
    def rig(self) -> Rig | None:
        """The cameras, or ``None``."""
        parts = self._core.rig
        return None if parts is None else Rig(*parts)

    @property
    def pattern(self) -> dict[str, str | int | float]:
        """``kind``, ``columns``, ``rows`` and ``rotation_deg`` of the projected pattern."""
        kind, columns, rows, rotation = self._core.pattern
        return {"kind": kind, "columns": columns, "rows": rows, "rotation_deg": rotation}

    @property
    def seeds(self) -> dict[str, Pair] | None:
        """The three marked pairs of the thesis, ``((xl, yl), (xr, yr))``, pixels, or ``None``."""
        marked = self._core.seeds
        return None if marked is None else {name: _pair(m) for name, m in marked.items()}

    @property
    def landmarks(self) -> dict[str, Pair]:
        """The marked landmarks ``((xl, yl), (xr, yr))`` by name, pixels."""
        return {name: _pair(m) for name, m in self._core.landmarks.items()}

    @property
    def warnings(self) -> list[str]:
        """What the reader of the capture found unusual."""
        return self._core.warnings

    def __repr__(self) -> str:
        height, width, _ = self.left.shape
        plain = "with" if self.left_plain is not None else "without"
        rig = "calibrated" if self.rig is not None else "not calibrated"
        return f"<facerecon.Capture: {width}x{height} px, {plain} plain pair, {rig}>"

    def _repr_html_(self) -> str:
        pairs = [(self.left, self.right)]
        if self.left_plain is not None and self.right_plain is not None:
            pairs.append((self.left_plain, self.right_plain))
        lines = [np.concatenate([thumbnail(p, 380) for p in pair], axis=1) for pair in pairs]
        return figure(np.concatenate(lines, axis=0), repr(self))


def _extra(number: int, given: Mapping[str, Any]) -> ExtraParts:
    name = f"extra[{number}]"
    missing = sorted({"image", "K", "R", "T"} - set(given))
    if missing:
        raise ParameterError(f"{name} lacks {missing}", "parameters")
    k = matrix(f"{name}.K", given["K"], (3, 3))
    _camera(f"{name}.K", np.array(k))
    return (
        photo(f"{name}.image", given["image"]),
        k,
        _lens(f"{name}.D", given.get("D", [])),
        matrix(f"{name}.R", given["R"], (3, 3)),
        matrix(f"{name}.T", given["T"], (3,)),
    )


def as_capture(capture: Capture | str | PathLike[str]) -> Capture:
    """A capture, or the one at a path."""
    if isinstance(capture, Capture):
        return capture
    if isinstance(capture, str | PathLike):
        return Capture.load(capture)
    raise ParameterError(
        f"capture is a {type(capture).__name__}; expected a facerecon.Capture or its path",
        "parameters",
    )

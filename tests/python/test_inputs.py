"""Every function with every kind of array: a correct result, or an error with the name of the
argument, its shape and the expected shape."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import facerecon as fr
import numpy as np
import pytest
from facerecon import viz

HEAD = fr.head("head-coarse")
RIG = fr.Rig.parallel(150.0, 2766.0, (79.5, 59.5), (79.5, 59.5))


def lattice() -> Any:
    """A grey photo (120, 160) uint8 of soft dots."""
    y, x = np.mgrid[:120, :160]
    waves = np.cos(2 * np.pi * x / 8.0) + np.cos(2 * np.pi * y / 8.0)
    return np.rint(np.clip(40 + 100 * (waves - 0.6), 10, 250)).astype(np.uint8)


PHOTO = lattice()
#: Enough points of a face for a registration: vertices of the head, in the camera frame.
POINTS = HEAD.vertices[HEAD.vertices[:, 2] > 20.0] * [1.0, -1.0, -1.0] + [0.0, 0.0, 1300.0]
CAPTURE = fr.Capture(PHOTO, PHOTO, PHOTO, PHOTO, rig=RIG)
PAIRS = np.array([[80.0, 40.0], [90.0, 50.0], [70.0, 60.0], [60.0, 44.0], [85.0, 71.0]])


def kinds(array: Any) -> dict[str, Any]:
    """The same numbers in other memory layouts and types."""
    wide = np.zeros(tuple(3 * n for n in array.shape), dtype=array.dtype)
    strided = wide[tuple(slice(None, None, 3) for _ in array.shape)]
    strided[...] = array
    frozen = array.copy()
    frozen.flags.writeable = False
    return {
        "fortran": np.asfortranarray(array),
        "strided": strided,
        "backward": np.ascontiguousarray(array[::-1])[::-1],
        "read-only": frozen,
        "other byte order": array.astype(array.dtype.newbyteorder()),
        "list": array.tolist() if array.dtype == np.float64 else array[:],
        "float32": array.astype(np.float32).astype(array.dtype).astype(np.float32),
    }


def spoiled(array: Any, value: float) -> Any:
    """As float64 with one bad value."""
    bad = np.asarray(array, dtype=np.float64).copy()
    bad[3, 1] = value
    return bad


Take = Callable[[Any], Any]
#: Functions of grey images, by the name of the argument.
IMAGES: list[tuple[str, str, Take]] = [
    ("sharpen", "image", fr.sharpen),
    ("equalize", "image", fr.equalize),
    ("clahe", "image", lambda a: fr.equalize(a, "clahe")),
    ("threshold", "image", lambda a: fr.threshold(a, "otsu")),
    ("thin", "binary", lambda a: fr.thin(a).positions),
    ("detect", "image", lambda a: fr.detect(a).positions),
    ("capture", "left", lambda a: fr.detect(fr.Capture(a, PHOTO).left).positions),
    ("capture, plain", "right_plain", lambda a: fr.Capture(PHOTO, PHOTO, PHOTO, a).right_plain),
]
#: Functions of points, with the points they are given and their name.
ROWS: list[tuple[str, str, Any, Take]] = [
    ("mesh", "vertices", HEAD.vertices, lambda a: fr.Mesh(a, HEAD.faces).vertices),
    (
        "mesh, uv",
        "uv",
        HEAD.uv,
        lambda a: fr.Mesh(HEAD.vertices, HEAD.faces, uv=a, uv_faces=HEAD.uv_faces).uv,
    ),
    (
        "register",
        "data",
        POINTS,
        lambda a: fr.register(a, HEAD, max_iterations=3, profile="facebuilder").model_from_data,
    ),
    (
        "register, landmarks",
        r"landmarks\[0\]",
        POINTS[:9],
        lambda a: (
            fr.register(
                POINTS,
                HEAD,
                landmarks=(a, HEAD.vertices[HEAD.vertices[:, 2] > 20.0][:9]),
                profile="facebuilder",
            ).model_from_data
        ),
    ),
    (
        "deform",
        "data",
        HEAD.vertices + 1.0,
        lambda a: fr.deform(HEAD, a, method="linear-rbf").mesh.vertices,
    ),
    (
        "deform, assignments",
        "assignments",
        HEAD.vertices[:40] + 1.0,
        lambda a: (
            fr.deform(
                HEAD, HEAD.vertices, assignments=dict(enumerate(a)), method="linear-rbf"
            ).mesh.vertices
        ),
    ),
    ("smooth", "reference", POINTS, lambda a: fr.smooth(HEAD, reference=a, steps=1).vertices),
    (
        "triangulate",
        "left",
        PAIRS,
        lambda a: fr.triangulate(CAPTURE, (a, PAIRS - [8.0, 0.0])).points,
    ),
    (
        "triangulate",
        "right",
        PAIRS,
        lambda a: fr.triangulate(CAPTURE, (PAIRS + [8.0, 0.0], a)).points,
    ),
    ("transformed", "target_from_source", np.eye(4), lambda a: HEAD.transformed(a).vertices),
]


@pytest.mark.parametrize(("name", "argument", "take"), IMAGES, ids=[i[0] for i in IMAGES])
def test_images(name: str, argument: str, take: Take) -> None:
    wanted = take(PHOTO)
    for kind, image in kinds(PHOTO).items():
        assert np.array_equal(take(image), wanted), kind
    for other in (PHOTO.astype(np.uint16) * 257, PHOTO.astype(np.float64)):
        assert np.allclose(take(other), wanted, atol=0.01), other.dtype
    colour = np.repeat(PHOTO[:, :, None], 3, axis=2)
    assert np.allclose(take(np.asfortranarray(colour)), wanted, atol=0.02)
    refused: list[tuple[Any, str]] = [
        (PHOTO.reshape(-1), r"has shape \(19200,\) .*; expected"),
        (np.zeros((4, 120, 160), np.uint8), r"has shape \(4, 120, 160\) .*; expected"),
        (np.zeros((120, 160, 3)), r"has shape \(120, 160, 3\) and type float64; expected .*uint8"),
        (np.zeros((0, 160), np.uint8), r"has shape \(0, 160\)"),
        (PHOTO.astype(np.int64), ".*type int64"),
        (PHOTO > 50, ".*type bool"),
        (PHOTO.astype(complex), ".*type complex128"),
        (PHOTO.astype(str), ".*type <U"),
        (None, ".*type object"),
        ([[1.0], [2.0, 3.0]], "is ragged"),
        (spoiled(PHOTO, np.nan), r"has shape \(120, 160\), but pixel \(1, 3\) is nan; expected"),
        (spoiled(PHOTO, -np.inf), r".*pixel \(1, 3\) is -inf"),
        (spoiled(PHOTO, 1e300), r".*pixel \(1, 3\)"),
    ]
    for bad, message in refused:
        # a capture whose plain photo is None has none
        if bad is None and "plain" in argument:
            continue
        with pytest.raises(ValueError, match=f"^{argument} {message}"):
            take(bad)


@pytest.mark.parametrize(
    ("name", "argument", "array", "take"), ROWS, ids=[f"{r[0]} {r[1]}" for r in ROWS]
)
def test_points(name: str, argument: str, array: Any, take: Take) -> None:
    # whole quarters, so that float32 holds them
    array = np.rint(array * 4.0) / 4.0
    wanted = take(array)
    for kind, given in kinds(array).items():
        assert np.array_equal(take(given), wanted), kind
    n, columns = array.shape
    refused: list[tuple[Any, str]] = [
        (
            array[:, :-1],
            rf"has shape \({n}, {columns - 1}\) .*; expected .*\(n, {columns}\) of numbers",
        ),
        (array.reshape(-1), rf"has shape \({n * columns},\)"),
        (array[None], rf"has shape \(1, {n}, {columns}\)"),
        (array.astype(complex), ".*type complex128"),
        (array.astype(str), ".*type <U"),
        (array > 0, ".*type bool"),
        (spoiled(array, np.nan), rf"has shape \({n}, {columns}\), but row 3 .*nan.*; expected"),
        (spoiled(array, np.inf), ".*row 3 .*inf"),
    ]
    for bad, message in refused:
        with pytest.raises(ValueError, match=f"^{argument} {message}"):
            take(bad)


def test_marks_outside_the_photo_are_refused() -> None:
    """The checks of the file reader hold for arrays too."""
    inside = ((80.0, 60.0), (72.0, 60.0))
    for outside in (((500.0, 60.0), (72.0, 60.0)), ((80.0, 60.0), (-40.0, 60.0))):
        with pytest.raises(ValueError, match="chin"):
            fr.Capture(PHOTO, PHOTO, landmarks={"chin": outside})
        with pytest.raises(ValueError, match="chin"):
            CAPTURE.with_landmarks({"chin": outside})
        seeds = {"head": inside, "left_ear": inside, "right_ear": outside}
        with pytest.raises(ValueError, match="right_ear"):
            fr.Capture(PHOTO, PHOTO, seeds=seeds)
    assert CAPTURE.with_landmarks({"chin": inside}).landmarks == {"chin": inside}


Make = Callable[[], Any]
#: Other arguments that are refused.
REFUSED: list[tuple[str, str, Make]] = [
    ("smooth", "mesh is a ndarray of shape", lambda: fr.smooth(HEAD.vertices)),  # type: ignore[arg-type]
    ("deform", "template is a str", lambda: fr.deform("head", POINTS)),  # type: ignore[arg-type]
    ("render", "mesh is a NoneType", lambda: fr.render(None)),  # type: ignore[arg-type]
    ("compare", "second is a list", lambda: fr.compare(HEAD, [])),  # type: ignore[arg-type]
    (
        "compare region",
        r"region has shape \(3,\)",
        lambda: fr.compare(HEAD, HEAD, region=[True] * 3),
    ),
    ("simulate", "mesh is a ndarray", lambda: fr.simulate(HEAD.vertices)),  # type: ignore[arg-type]
    ("simulate subject", "subject is -1", lambda: fr.simulate(subject=-1)),
    ("simulate setting", "distance_cm", lambda: fr.simulate(distance_cm=3)),
    ("render heat", r"heat has shape \(3,\)", lambda: fr.render(HEAD, heat=np.zeros(3))),
    ("render heat", "heat", lambda: fr.render(HEAD, heat=np.full(len(HEAD.vertices), -1.0))),
    ("render size", r"size is \(0, 5\)", lambda: fr.render(HEAD, size=(0, 5))),
    ("render size", "size is 5", lambda: fr.render(HEAD, size=5)),  # type: ignore[arg-type]
    ("render mode", "mode is 'x'|mode is \"x\"", lambda: fr.render(HEAD, mode="x")),
    ("register model", "model is a ndarray", lambda: fr.register(POINTS, HEAD.vertices)),  # type: ignore[arg-type]
    ("register landmarks", "landmarks is not a pair", lambda: fr.register(POINTS, HEAD, landmarks=3)),  # type: ignore[arg-type]
    ("triangulate", "matches is not a pair", lambda: fr.triangulate(CAPTURE, 7)),  # type: ignore[arg-type]
    ("correspond", "capture is a ndarray", lambda: fr.correspond(PHOTO)),
    (
        "register landmarks twice",
        "both given",
        lambda: fr.register(POINTS, HEAD, landmarks=(POINTS, POINTS), features=(POINTS, POINTS)),
    ),
    ("reconstruct", "params is a dict", lambda: fr.reconstruct(CAPTURE, params={})),  # type: ignore[arg-type]
    ("equalize", "method is 'x'", lambda: fr.equalize(PHOTO, "x")),
    ("sharpen", "kernel", lambda: fr.sharpen(PHOTO, np.zeros((2, 2)))),
    ("sharpen", "kernel", lambda: fr.sharpen(PHOTO, [[1.0, np.nan, 0.0]] * 3)),
    ("threshold", "level", lambda: fr.threshold(PHOTO, level=[1, 2])),
    ("capture sizes", r"right has shape \(9, 9\)", lambda: fr.Capture(PHOTO, PHOTO[:9, :9])),
    ("capture plain", "belong together", lambda: fr.Capture(PHOTO, PHOTO, PHOTO)),
    ("capture rig", "rig is a dict", lambda: fr.Capture(PHOTO, PHOTO, rig={})),  # type: ignore[arg-type]
    ("capture columns", "columns is '85'", lambda: fr.Capture(PHOTO, PHOTO, columns="85")),  # type: ignore[arg-type]
    ("capture rows", "rows is 0", lambda: fr.Capture(PHOTO, PHOTO, rows=0)),
    (
        "capture turn",
        "rotation_deg is .*nan",
        lambda: fr.Capture(PHOTO, PHOTO, rotation_deg=np.nan),
    ),
    ("capture kind", "kind is 'bars'", lambda: fr.Capture(PHOTO, PHOTO, kind="bars")),
    (
        "seeds",
        r"seeds\['head'\] has 2 numbers",
        lambda: fr.Capture(PHOTO, PHOTO, seeds={"head": (1, 2)}),
    ),
    (
        "seeds",
        r"seeds\['head'\] is ragged",
        lambda: fr.Capture(PHOTO, PHOTO, seeds={"head": ((1, 2), (3,))}),
    ),
    (
        "seeds outside",
        r"seeds.head: \(9999, 2\) is outside the left photo",
        lambda: fr.Capture(
            PHOTO,
            PHOTO,
            seeds={
                "head": ((9999, 2), (3, 4)),
                "left_ear": ((1, 2), (3, 4)),
                "right_ear": ((1, 2), (3, 4)),
            },
        ),
    ),
    (
        "landmarks outside",
        "landmarks.chin: .* is outside the right photo",
        lambda: CAPTURE.with_landmarks({"chin": ((1, 2), (3, -4))}),
    ),
    (
        "landmarks",
        r"landmarks\['chin'\] .*nan",
        lambda: CAPTURE.with_landmarks({"chin": ((1, 2), (3, np.nan))}),
    ),
    (
        "rig K1",
        r"rig.K1 has shape \(2, 2\)",
        lambda: fr.Rig(np.eye(2), [], np.eye(3), [], np.eye(3), [1, 0, 0]),
    ),
    (
        "rig R",
        "rig.R .*nan",
        lambda: fr.Rig(np.eye(3), [], np.eye(3), [], np.full((3, 3), np.nan), [1, 0, 0]),
    ),
    (
        "rig D1",
        "rig.D1 has 9 numbers",
        lambda: fr.Rig(np.eye(3), [0] * 9, np.eye(3), [], np.eye(3), [1, 0, 0]),
    ),
    (
        "rig D1",
        "rig.D1 .*type",
        lambda: fr.Rig(np.eye(3), "no lens", np.eye(3), [], np.eye(3), [1, 0, 0]),
    ),
    (
        "rig size",
        "image_size",
        lambda: fr.Rig(np.eye(3), [], np.eye(3), [], np.eye(3), [1, 0, 0], (0, 4)),
    ),
    ("extra", r"extra\[0\] lacks", lambda: fr.Capture(PHOTO, PHOTO, extra=[{"image": PHOTO}])),
    ("batch", "workers is 0", lambda: fr.batch([], "nowhere", workers=0)),
    ("batch", "frame is 'sideways'", lambda: fr.batch([], "nowhere", frame="sideways")),
    ("params", "smooth.steps", lambda: fr.Params(smooth={"steps": "three"})),
    ("params", "smooth.steps is a object", lambda: fr.Params(smooth={"steps": object()})),
    (
        "viz",
        "capture is missing",
        lambda: viz.matches(fr.Matches(PAIRS, PAIRS, PAIRS[:, 0], PAIRS, PAIRS, PAIRS[:, 0])),
    ),
    ("viz", r"values has shape \(4,\)", lambda: viz.heat(HEAD, np.zeros(4))),
]


@pytest.mark.parametrize(
    ("name", "message", "make"), REFUSED, ids=[f"{i} {r[0]}" for i, r in enumerate(REFUSED)]
)
def test_other_arguments_are_refused_by_name(name: str, message: str, make: Make) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        make()
    assert isinstance(caught.value, fr.FaceReconError), type(caught.value)


def test_empty_and_tiny_inputs_give_an_error() -> None:
    none = np.zeros((0, 3))
    empty = fr.Mesh(none, np.zeros((0, 3), np.uint32))
    for make in (
        lambda: fr.register(none, HEAD),
        lambda: fr.deform(HEAD, none),
        lambda: fr.fit(HEAD, none),
        lambda: fr.deform(empty, POINTS),
        lambda: fr.render(empty),
        lambda: fr.compare(empty, HEAD),
        lambda: fr.smooth(empty),
        lambda: fr.simulate(empty),
        lambda: fr.texture(empty, CAPTURE),
        lambda: fr.detect(np.zeros((1, 1))),
        lambda: fr.correspond(fr.Capture(np.zeros((1, 1)), np.zeros((1, 1)))),
        lambda: fr.reconstruct(CAPTURE),
    ):
        with pytest.raises(fr.FaceReconError, match="."):
            make()
    assert "0 vertices" in empty._repr_html_()
    assert "0 points" in fr.Cloud(none)._repr_html_()


def test_huge_coordinates_give_an_error_or_a_result() -> None:
    far = fr.Mesh(HEAD.vertices * 1e200, HEAD.faces)
    for make in (lambda: fr.render(far), lambda: fr.compare(far, HEAD), lambda: fr.smooth(far)):
        try:
            make()
        except fr.FaceReconError as error:
            assert str(error)

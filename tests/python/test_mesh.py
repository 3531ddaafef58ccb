"""Meshes from arrays of every layout, and through every format."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import facerecon as fr
import numpy as np
import pytest

HEAD = fr.head("head-coarse")


def layouts(array: Any) -> dict[str, Any]:
    """The same numbers laid out differently."""
    wide = np.zeros((len(array) * 2, array.shape[1] * 3), dtype=array.dtype)
    strided = wide[::2, ::3]
    strided[...] = array
    frozen = array.copy()
    frozen.flags.writeable = False
    turned = np.ascontiguousarray(array[::-1])[::-1]
    return {
        "fortran": np.asfortranarray(array),
        "strided": strided,
        "frozen": frozen,
        "turned": turned,
        "list": array.tolist(),
    }


@pytest.mark.parametrize("layout", ["fortran", "strided", "frozen", "turned", "list"])
def test_every_layout_is_the_same_mesh(layout: str) -> None:
    vertices, faces = layouts(HEAD.vertices)[layout], layouts(HEAD.faces)[layout]
    mesh = fr.Mesh(vertices, faces)
    assert np.array_equal(mesh.vertices, HEAD.vertices) and np.array_equal(mesh.faces, HEAD.faces)
    wanted = fr.smooth(fr.Mesh(HEAD.vertices, HEAD.faces), steps=2).vertices
    assert np.array_equal(fr.smooth(mesh, steps=2).vertices, wanted)


def test_fitting_arrays_are_not_copied() -> None:
    assert np.shares_memory(fr.Mesh(HEAD.vertices, HEAD.faces).vertices, HEAD.vertices)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int32])
def test_other_number_types_are_taken(dtype: Any) -> None:
    vertices = np.rint(HEAD.vertices).astype(dtype)
    assert np.array_equal(fr.Mesh(vertices, HEAD.faces).vertices, vertices)
    faces = HEAD.faces.astype(np.int64)
    assert np.array_equal(fr.Mesh(HEAD.vertices, faces).faces, HEAD.faces)


def broken(vertex: int, value: float) -> Any:
    vertices = HEAD.vertices.copy()
    vertices[vertex, 1] = value
    return vertices


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((HEAD.vertices[:, :2], HEAD.faces), r"vertices has shape \(\d+, 2\).*\(n, 3\)"),
        ((HEAD.vertices.T, HEAD.faces), r"vertices has shape \(3, \d+\)"),
        ((HEAD.vertices.reshape(-1), HEAD.faces), r"vertices has shape \(\d+,\)"),
        ((HEAD.vertices.astype(complex), HEAD.faces), "vertices .*complex"),
        (([[1.0, 2.0], [3.0]], HEAD.faces), "vertices is ragged"),
        ((broken(7, np.nan), HEAD.faces), r"vertices .*row 7 .*finite"),
        ((broken(8, np.inf), HEAD.faces), r"vertices .*row 8 .*finite"),
        ((HEAD.vertices, HEAD.faces.astype(float)), "faces .*whole numbers"),
        ((HEAD.vertices, HEAD.faces[:, :2]), r"faces has shape \(\d+, 2\)"),
        ((HEAD.vertices, HEAD.faces.astype(np.int64) - 1), "faces .*-1"),
        ((HEAD.vertices[:100], HEAD.faces), "faces .*0 to 99"),
    ],
)
def test_wrong_arrays_are_refused(arguments: tuple[Any, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        fr.Mesh(*arguments)
    assert isinstance(caught.value, fr.FaceReconError)


def test_what_belongs_together_is_checked() -> None:
    v, f = HEAD.vertices, HEAD.faces
    with pytest.raises(ValueError, match="uv has shape"):
        fr.Mesh(v, f, uv=np.zeros((3, 2)))
    with pytest.raises(ValueError, match="uv_faces has shape"):
        fr.Mesh(v, f, uv=np.zeros((3, 2)), uv_faces=[[0, 1, 2]])
    with pytest.raises(ValueError, match="colors has shape"):
        fr.Mesh(v, f, colors=np.zeros((3, 3), dtype=np.uint8))
    with pytest.raises(ValueError, match="texture has shape"):
        fr.Mesh(v, f, texture=np.zeros((3, 3)))
    with pytest.raises(ValueError, match="nose_tip is vertex 9999"):
        fr.Mesh(v, f, landmarks={"nose_tip": 9999})
    changed = fr.Mesh(v.copy(), f)
    changed.vertices[3] = np.nan
    with pytest.raises(ValueError, match="row 3"):
        fr.smooth(changed)


@pytest.mark.parametrize("ending", ["obj", "ply", "glb", "stl"])
def test_files_keep_the_mesh(ending: str, tmp_path: Path) -> None:
    texture = np.random.default_rng(1).integers(0, 256, (32, 32, 3), dtype=np.uint8)
    mesh = fr.Mesh(HEAD.vertices, HEAD.faces, uv=HEAD.uv, uv_faces=HEAD.uv_faces, texture=texture)
    path = tmp_path / f"head.{ending}"
    mesh.save(path)
    read = fr.Mesh.load(path)
    assert len(read.faces) == len(mesh.faces)
    corners, wanted = read.vertices[read.faces], mesh.vertices[mesh.faces]
    assert np.allclose(corners, wanted, atol=2e-3)
    if ending != "stl":
        assert read.texture is not None and np.array_equal(read.texture, texture)
    with pytest.raises(OSError, match="head.xyz"):
        mesh.save(tmp_path / "head.xyz")


def test_trimesh_and_back() -> None:
    trimesh = pytest.importorskip("trimesh")
    texture = np.full((8, 8, 3), 120, dtype=np.uint8)
    mesh = fr.Mesh(HEAD.vertices, HEAD.faces, uv=HEAD.uv, uv_faces=HEAD.uv_faces, texture=texture)
    other = mesh.to_trimesh()
    assert isinstance(other, trimesh.Trimesh)
    back = fr.Mesh.from_trimesh(other)
    assert np.allclose(back.vertices[back.faces], mesh.vertices[mesh.faces])
    assert back.uv is not None and back.uv_faces is not None and mesh.uv is not None
    assert np.allclose(back.uv[back.uv_faces], mesh.uv[mesh.uv_faces])
    assert back.texture is not None and np.array_equal(back.texture, texture)
    colors = np.full((len(HEAD.vertices), 3), 9, np.uint8)
    bare = fr.Mesh.from_trimesh(fr.Mesh(HEAD.vertices, HEAD.faces, colors=colors).to_trimesh())
    assert bare.colors is not None and np.array_equal(bare.colors, colors)


def test_open3d() -> None:
    pytest.importorskip("open3d")
    assert np.array_equal(np.asarray(HEAD.to_open3d().vertices), HEAD.vertices)


def test_a_mesh_shows_itself() -> None:
    picture = HEAD.render(size=(120, 140))
    assert picture.shape == (140, 120, 3) and picture.std() > 10
    assert "data:image/png" in HEAD._repr_html_() and "vertices" in repr(HEAD)


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.zeros((4, 4, 4), np.uint8), r"\(4, 4, 4\)"),
        (np.zeros((4,)), r"\(4,\)"),
        (np.full((9, 9), np.nan), r"pixel \(0, 0\)"),
        (np.zeros((0, 5), np.float32), r"\(0, 5\)"),
        (np.zeros((5, 5), np.int64), "int64"),
        (np.zeros((5, 5), bool), "bool"),
    ],
)
def test_wrong_images_are_refused(image: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.sharpen(image)
    with pytest.raises(ValueError, match=f"right .*{message}|right has shape"):
        fr.Capture(np.zeros((50, 60, 3), np.uint8), image)

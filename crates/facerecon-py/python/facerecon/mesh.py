"""Triangle meshes as numpy arrays."""

from __future__ import annotations

import html
import importlib
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8, U32, Bool, MeshParts, colors, indices, picture, rows
from ._html import figure
from ._render import draw
from ._view3d import Triangles
from ._view3d import show as show_shapes
from .errors import FaceReconWarning, ParameterError


class Mesh:
    """A triangle mesh, optionally with texture coordinates, texture, colours and landmarks.

    Arrays of the right type and layout are kept without a copy; others are converted (Fortran
    order, strides, float32, integers, lists). They may be changed in place: every use checks them
    again.

    Args:
        vertices: (n, 3), millimetres unless stated otherwise.
        faces: (m, 3) vertex indices, counter-clockwise seen from outside.
        uv: (k, 2) texture coordinates: u right, v up, (0, 0) the lower left corner.
        uv_faces: (m, 3) indices into ``uv``; ``None`` means ``faces`` (then k = n).
        texture: (height, width, 3) uint8 sRGB; row 0 is at v = 1.
        colors: (n, 3) uint8 sRGB of the vertices.
        landmarks: vertex indices by landmark name.
        sigma: (n,) standard deviation of each vertex along its normal, unit of ``vertices``; only
            together with ``measured``.
        measured: (n,) whether measured points support the vertex.

    Raises:
        ParameterError: (a ``ValueError``) naming the argument, its shape and the expected shape.
    """

    vertices: F64
    faces: U32
    uv: F64 | None
    uv_faces: U32 | None
    texture: U8 | None
    colors: U8 | None
    landmarks: dict[str, int]
    sigma: F64 | None
    measured: Bool | None

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        *,
        uv: Any = None,
        uv_faces: Any = None,
        texture: Any = None,
        colors: Any = None,
        landmarks: Mapping[str, int] | None = None,
        sigma: Any = None,
        measured: Any = None,
    ) -> None:
        self.vertices = rows("vertices", vertices, 3)
        self.faces = indices("faces", faces, 3, len(self.vertices))
        self.uv = self.uv_faces = None
        if uv is not None:
            self.uv = rows("uv", uv, 2)
            if uv_faces is None and len(self.uv) != len(self.vertices):
                raise ParameterError(
                    f"uv has shape {self.uv.shape}; expected ({len(self.vertices)}, 2), "
                    "one for each vertex, unless uv_faces is given",
                    "parameters",
                )
            corners = self.faces if uv_faces is None else uv_faces
            self.uv_faces = indices("uv_faces", corners, 3, len(self.uv))
            if len(self.uv_faces) != len(self.faces):
                raise ParameterError(
                    f"uv_faces has shape {self.uv_faces.shape}; expected {self.faces.shape}",
                    "parameters",
                )
        elif uv_faces is not None:
            raise ParameterError("uv_faces is given without uv", "parameters")
        self.texture = None if texture is None else picture("texture", texture)
        self.colors = None if colors is None else _colors(colors, len(self.vertices))
        self.sigma, self.measured = _uncertainty(sigma, measured, len(self.vertices))
        self.landmarks = dict(landmarks or {})
        for name, vertex in self.landmarks.items():
            if not 0 <= vertex < len(self.vertices):
                raise ParameterError(
                    f"landmarks: {name} is vertex {vertex}; expected 0 to {len(self.vertices) - 1}",
                    "parameters",
                )

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Mesh:
        """Read OBJ (+MTL, texture), VRML 1.0/2.0, PLY, GLB or STL; vertices keep the file's order.

        Contents of the file that cannot be used give a :class:`FaceReconWarning`. Landmarks are
        not read; :func:`facerecon.head` reads them.

        Args:
            path: the file; its extension, else its first bytes, give the format.

        Returns:
            The mesh in the file's own units.

        Raises:
            FileError: (an ``OSError``) naming the file and what is wrong with it.
        """
        parts, texture, found = _core.read_mesh(fspath(path))
        for text in found:
            warnings.warn(f"{fspath(path)}: {text}", FaceReconWarning, stacklevel=2)
        return cls._from_parts(parts, texture)

    def save(self, path: str | PathLike[str], landmarks: bool = False) -> None:
        """Write ``.obj`` (+MTL, PNG), ``.ply``, ``.glb`` (texture inside) or ``.stl``.

        Args:
            path: the file; its extension gives the format. It is written completely or not at
                all.
            landmarks: also write ``NAME.landmarks.toml`` beside it, so that
                ``fr.head(path)`` and ``--template`` accept it as a template.

        Raises:
            FileError: (an ``OSError``) for an unknown extension, or when the file cannot be
                written.
        """
        _core.write_mesh(fspath(path), self._parts(), self._texture())
        if landmarks:
            _core.write_landmarks(fspath(path), self.landmarks)

    @classmethod
    def from_trimesh(cls, mesh: Any) -> Mesh:
        """Convert a ``trimesh.Trimesh`` with its texture or vertex colours.

        Args:
            mesh: the mesh; convert a ``trimesh.Scene`` with ``scene.to_geometry()`` first.

        Raises:
            ParameterError: (a ``ValueError``) for anything but a triangle mesh.
        """
        if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
            raise ParameterError(
                f"mesh is a {type(mesh).__name__}; expected a trimesh.Trimesh", "parameters"
            )
        visual = getattr(mesh, "visual", None)
        kind = getattr(visual, "kind", None)
        uv = texture = vertex_colors = None
        if kind == "texture" and visual is not None and visual.uv is not None:
            uv = visual.uv
            material = visual.material
            image = getattr(material, "image", None)
            if image is None:
                image = getattr(material, "baseColorTexture", None)
            if image is not None:
                texture = np.asarray(image.convert("RGB"))
        elif kind == "vertex" and visual is not None:
            vertex_colors = np.asarray(visual.vertex_colors)[:, :3]
        return cls(mesh.vertices, mesh.faces, uv=uv, texture=texture, colors=vertex_colors)

    def to_trimesh(self) -> Any:
        """Convert to a ``trimesh.Trimesh`` (extra ``[mesh]``).

        trimesh has one texture coordinate per vertex: vertices on texture seams are duplicated and
        vertices without a face are left out. Without ``uv`` the vertex indices do not change.

        Raises:
            ImportError: without trimesh.
        """
        trimesh = _optional("trimesh")

        if self.uv is None or self.uv_faces is None:
            return trimesh.Trimesh(
                self.vertices, self.faces, vertex_colors=self.colors, process=False
            )
        vertices, faces, uv = self._unwelded()
        image = None
        if self.texture is not None:
            image = _optional("PIL.Image").fromarray(self.texture)
        visual = trimesh.visual.TextureVisuals(uv=uv, image=image)
        return trimesh.Trimesh(vertices, faces, visual=visual, process=False)

    def to_open3d(self) -> Any:
        """Convert to an ``open3d.geometry.TriangleMesh`` with the same vertex indices.

        Raises:
            ImportError: without open3d.
        """
        o3d = _optional("open3d")

        mesh = o3d.geometry.TriangleMesh(
            o3d.utility.Vector3dVector(self.vertices),
            o3d.utility.Vector3iVector(self.faces.astype(np.int32)),
        )
        if self.colors is not None:
            mesh.vertex_colors = o3d.utility.Vector3dVector(self.colors / 255.0)
        if self.uv is not None and self.uv_faces is not None:
            corners = self.uv[self.uv_faces.reshape(-1)]
            mesh.triangle_uvs = o3d.utility.Vector2dVector(corners)
            mesh.triangle_material_ids = o3d.utility.IntVector(
                np.zeros(len(self.faces), dtype=np.int32)
            )
            if self.texture is not None:
                mesh.textures = [o3d.geometry.Image(np.flipud(self.texture).copy())]
        mesh.compute_vertex_normals()
        return mesh

    def transformed(self, target_from_source: Any) -> Mesh:
        """The mesh in another frame: ``x -> A x + t``.

        Args:
            target_from_source: (4, 4) matrix ``[[A, t], [0, 1]]``.

        Raises:
            ParameterError: (a ``ValueError``) for another shape.
        """
        matrix = rows("target_from_source", target_from_source, 4)
        if matrix.shape != (4, 4):
            raise ParameterError(
                f"target_from_source has shape {matrix.shape}; expected (4, 4)", "parameters"
            )
        mesh = self._with_vertices(self.vertices @ matrix[:3, :3].T + matrix[:3, 3])
        if self.sigma is not None:
            # exact for a rigid motion or a similarity
            mesh.sigma = self.sigma * abs(float(np.linalg.det(matrix[:3, :3]))) ** (1.0 / 3.0)
        return mesh

    def render(
        self,
        view: str | Sequence[str] = "front",
        mode: str | None = None,
        size: tuple[int, int] = (400, 460),
    ) -> U8:
        """Render to an image (height, width, 3) uint8, like :func:`facerecon.render`.

        Args:
            view: ``front``, ``three-quarter``, ``profile`` ..., or several.
            mode: ``shaded``, ``textured``, ``lit``, ``wireframe`` or ``uncertainty`` (needs
                ``sigma``); by default ``lit`` for a mesh with colours, else ``shaded``.
            size: (width, height) of each view, pixels.
        """
        return draw(self._parts(), self._texture(), view, mode=mode, size=size)

    def show(self) -> Any:
        """An interactive view for notebooks (extra ``[viz]``): make it the last value of a cell.

        Raises:
            ImportError: without k3d.
        """
        return show_shapes(self._shape3d())

    def _shape3d(self) -> Triangles:
        """The mesh as the 3D view takes it."""
        if self.uv is None or self.texture is None:
            return Triangles(self.vertices, self.faces, None, None, self.colors)
        vertices, faces, uv = self._unwelded()
        return Triangles(vertices, faces, uv, self.texture, None)

    def _unwelded(self) -> tuple[F64, U32, F64]:
        """Vertices duplicated where their texture coordinates differ; unused vertices left out."""
        assert self.uv is not None and self.uv_faces is not None
        pairs = np.stack([self.faces.reshape(-1), self.uv_faces.reshape(-1)], axis=1)
        unique, inverse = np.unique(pairs, axis=0, return_inverse=True)
        faces = inverse.reshape(-1, 3).astype(np.uint32)
        return self.vertices[unique[:, 0]], faces, self.uv[unique[:, 1]]

    def _with_vertices(self, vertices: F64) -> Mesh:
        return Mesh(
            vertices,
            self.faces,
            uv=self.uv,
            uv_faces=self.uv_faces,
            texture=self.texture,
            colors=self.colors,
            landmarks=self.landmarks,
            sigma=self.sigma,
            measured=self.measured,
        )

    def _parts(self) -> MeshParts:
        """The arrays, checked again: the user may have changed them."""
        checked = self._with_vertices(self.vertices)
        return (
            checked.vertices,
            checked.faces,
            checked.uv,
            checked.uv_faces,
            checked.colors,
            checked.sigma,
            checked.measured,
        )

    def _texture(self) -> U8 | None:
        return None if self.texture is None else picture("texture", self.texture)

    @classmethod
    def _from_parts(
        cls,
        parts: MeshParts,
        texture: U8 | None = None,
        landmarks: Mapping[str, int] | None = None,
    ) -> Mesh:
        vertices, faces, uv, uv_faces, vertex_colors, sigma, measured = parts
        return cls(
            vertices,
            faces,
            uv=uv,
            uv_faces=uv_faces,
            texture=texture,
            colors=vertex_colors,
            landmarks=landmarks,
            sigma=sigma,
            measured=measured,
        )

    def __repr__(self) -> str:
        extra = [
            word
            for word, has in (
                ("uv", self.uv),
                ("texture", self.texture),
                ("colors", self.colors),
                ("sigma", self.sigma),
            )
            if has is not None
        ]
        contents = f", with {', '.join(extra)}" if extra else ""
        return f"<facerecon.Mesh: {len(self.vertices)} vertices, {len(self.faces)} faces{contents}>"

    def _repr_html_(self) -> str:
        if not len(self.faces):
            return f"<p>{html.escape(repr(self))}</p>"
        views = ("front", "three-quarter", "profile")
        return figure(self.render(views, size=(260, 300)), repr(self))


def as_mesh(name: str, value: Any) -> Mesh:
    """The value, if it is a mesh."""
    if isinstance(value, Mesh):
        return value
    shape = f" of shape {value.shape}" if isinstance(value, np.ndarray) else ""
    raise ParameterError(
        f"{name} is a {type(value).__name__}{shape}; expected a facerecon.Mesh", "parameters"
    )


def _colors(value: Any, count: int) -> U8:
    array = colors("colors", value)
    if len(array) != count:
        raise ParameterError(
            f"colors has shape {array.shape}; expected ({count}, 3), one for each vertex",
            "parameters",
        )
    return array


def _uncertainty(sigma: Any, measured: Any, count: int) -> tuple[F64 | None, Bool | None]:
    """Both, checked, or neither."""
    if sigma is None and measured is None:
        return None, None
    if sigma is None or measured is None:
        raise ParameterError("sigma and measured are given together or not at all", "parameters")
    values = np.ascontiguousarray(sigma, dtype=np.float64)
    flags = np.ascontiguousarray(measured, dtype=np.bool_)
    for name, shape in (("sigma", values.shape), ("measured", flags.shape)):
        if shape != (count,):
            raise ParameterError(
                f"{name} has shape {shape}; expected ({count},), one for each vertex", "parameters"
            )
    if not (np.isfinite(values).all() and (values >= 0).all()):
        raise ParameterError("sigma has values that are not finite or below 0", "parameters")
    return values, flags


def _optional(module: str) -> Any:
    """Import an optional package, or say what to install."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        what = "open3d" if module == "open3d" else "'facerecon[mesh]'"
        raise ImportError(f"this needs {module}: pip install {what}") from error

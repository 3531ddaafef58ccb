"""The interactive 3D view (k3d) of shapes given as arrays; below mesh, result and viz."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._arrays import F64, U8, U32, picture
from .errors import ParameterError

#: Largest number of vertices of a mesh that is passed to the browser.
MAX_VERTICES = 500_000
#: Colours of points and of meshes that have none, 0xRRGGBB.
POINT_COLOR = 0xF0C020
MESH_COLOR = 0xD8C8BC


@dataclass(frozen=True, eq=False)
class Points:
    """Points (n, 3), mm, with colours (n, 3) uint8 or ``None``."""

    points: F64
    colors: U8 | None


@dataclass(frozen=True, eq=False)
class Triangles:
    """A mesh whose texture coordinates, if any, are one per vertex."""

    vertices: F64
    faces: U32
    uv: F64 | None
    texture: U8 | None
    colors: U8 | None


def show(*shapes: Points | Triangles) -> Any:
    """A ``k3d.Plot`` of the shapes, from the front, y up."""
    try:
        import k3d
    except ImportError as error:
        raise ImportError("the 3D view needs k3d: pip install 'facerecon[viz]'") from error
    plot = k3d.plot(grid_visible=False, camera_auto_fit=False)
    for shape in shapes:
        if isinstance(shape, Points):
            if not len(shape.points):
                raise ParameterError("the cloud has no points to show", "parameters")
            colors = shape.colors
            look: dict[str, Any] = {"color": POINT_COLOR}
            if colors is not None:
                look = {"colors": _packed(colors)}
            points = shape.points.astype(np.float32)
            plot += k3d.points(points, point_size=0.8, shader="flat", **look)
            continue
        if not len(shape.faces):
            raise ParameterError("the mesh has no faces to show", "parameters")
        if len(shape.vertices) > MAX_VERTICES:
            raise ParameterError(
                f"the mesh has {len(shape.vertices)} vertices; at most {MAX_VERTICES} can be shown",
                "parameters",
            )
        vertices = shape.vertices.astype(np.float32)
        plot += k3d.mesh(
            vertices, shape.faces, side="double", flat_shading=False, **_mesh_look(shape)
        )
    eye_and_target = [float(v) for v in plot.get_auto_camera(factor=0.9, yaw=0, pitch=0)[:6]]
    plot.camera = [*eye_and_target, 0.0, 1.0, 0.0]
    return plot


def _packed(colors: Any) -> Any:
    """Colours as 0xRRGGBB."""
    return colors.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)


def _mesh_look(mesh: Triangles) -> dict[str, Any]:
    """Arguments of ``k3d.mesh`` for the colour: by texture, by vertex, or uniform."""
    if mesh.texture is not None and mesh.uv is not None:
        png = _core.encode_png(picture("texture", mesh.texture))
        # k3d counts rows from the top
        uvs = (mesh.uv * [1.0, -1.0] + [0.0, 1.0]).astype(np.float32)
        return {"texture": png, "texture_file_format": "png", "uvs": uvs}
    if mesh.colors is not None:
        return {"colors": _packed(mesh.colors)}
    return {"color": MESH_COLOR}

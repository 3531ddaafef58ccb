"""Pictures of captures and results with matplotlib (extra ``[viz]``)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .errors import ParameterError
from .makers import Comparison, render
from .mesh import Mesh
from .result import Matches, Result
from .stages import Dots, Registration


def _pyplot() -> Any:
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("the plots need matplotlib: pip install 'facerecon[viz]'") from error
    return plt


def _axes(ax: Any, **figure: Any) -> Any:
    return _pyplot().subplots(**figure)[1] if ax is None else ax


def dots(photo: Any, found: Dots, ax: Any = None) -> Any:
    """The dots on their photo; gives the matplotlib axes."""
    ax = _axes(ax, figsize=(8, 6))
    ax.imshow(photo, cmap="gray")
    ax.plot(*found.positions.T, "+", color="orangered", markersize=4)
    ax.set_title(f"{len(found)} dots, {found.spacing_px:.1f} px apart")
    ax.set_axis_off()
    return ax


def matches(result: Result, axes: Any = None) -> Any:
    """The matches on both photos, coloured by disparity; gives the two axes."""
    found = result.matches
    if axes is None:
        axes = _pyplot().subplots(1, 2, figsize=(13, 5), layout="constrained")[1]
    sides = ((result.capture.left, found.left), (result.capture.right, found.right))
    for ax, (photo, places) in zip(axes, sides, strict=True):
        ax.imshow(photo)
        drawn = ax.scatter(*places.T, c=found.disparity, s=4, cmap="viridis")
        ax.set_axis_off()
    axes[0].figure.colorbar(drawn, ax=list(axes), label="disparity [px]", shrink=0.8)
    return axes


def disparity(found: Matches | Result, ax: Any = None) -> Any:
    """The disparity at the matches as a map over the left photo; gives the axes."""
    table = found.matches if isinstance(found, Result) else found
    ax = _axes(ax, figsize=(7, 5.5))
    drawn = ax.scatter(*table.left.T, c=table.disparity, s=9, cmap="viridis")
    ax.set(xlabel="x [px]", ylabel="y [px]", aspect="equal", title=f"{len(table)} matches")
    ax.invert_yaxis()
    ax.figure.colorbar(drawn, ax=ax, label="disparity [px]")
    return ax


def convergence(found: Result | Registration, ax: Any = None) -> Any:
    """The error of the registration after each step (thesis Fig. 3.1); gives the axes."""
    history = found.icp_history if isinstance(found, Result) else found.history
    ax = _axes(ax, figsize=(6, 4))
    ax.plot(range(len(history)), history, marker=".")
    ax.set(xlabel="step", ylabel="error", title="registration")
    ax.grid(alpha=0.3)
    return ax


def heat(
    mesh: Mesh,
    values: Comparison | Any,
    view: str = "front",
    limit_mm: float | None = None,
    frame: str = "model",
    ax: Any = None,
) -> Any:
    """A mesh coloured by a value a vertex, e.g. a comparison's distances; gives the axes."""
    given = values.vertex_distances if isinstance(values, Comparison) else values
    ax = _axes(ax, figsize=(6, 6))
    picture = render(mesh, view, heat=given, limit_mm=limit_mm, frame=frame, size=(700, 700))
    ax.imshow(picture)
    ax.set_axis_off()
    return ax


def show3d(mesh: Mesh | Result) -> Any:
    """An interactive view for notebooks by k3d; show it as a cell's last value."""
    try:
        import k3d
    except ImportError as error:
        raise ImportError("the 3D view needs k3d: pip install 'facerecon[viz]'") from error
    face = mesh.mesh if isinstance(mesh, Result) else mesh
    if not len(face.faces):
        raise ParameterError("mesh has no faces to show", "parameters")
    plot = k3d.plot(grid_visible=False)
    colors = _vertex_colors(face)
    options: dict[str, Any] = {"color": 0xD8C8BC} if colors is None else {"colors": colors}
    plot += k3d.mesh(
        face.vertices.astype(np.float32), face.faces, side="double", flat_shading=False, **options
    )
    return plot


def _vertex_colors(mesh: Mesh) -> Any:
    """One packed colour a vertex, from its colours or from the texture."""
    rgb = mesh.colors
    if mesh.texture is not None and mesh.uv is not None and mesh.uv_faces is not None:
        height, width, _ = mesh.texture.shape
        uv = np.zeros((len(mesh.vertices), 2))
        uv[mesh.faces.reshape(-1)] = mesh.uv[mesh.uv_faces.reshape(-1)]
        x = np.clip((uv[:, 0] * width).astype(int), 0, width - 1)
        y = np.clip(((1.0 - uv[:, 1]) * height).astype(int), 0, height - 1)
        rgb = mesh.texture[y, x]
    if rgb is None:
        return None
    return rgb.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)

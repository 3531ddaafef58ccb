"""Plots of captures and results with matplotlib, and a 3D view with k3d (extra ``[viz]``)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import column, gray
from ._view3d import Points, Triangles
from ._view3d import show as show_shapes
from .capture import Capture
from .errors import ParameterError
from .makers import Comparison, render
from .mesh import Mesh
from .photo_stages import Dots
from .result import Cloud, Matches, Result
from .shape_stages import Registration


def _pyplot() -> Any:
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("the plots need matplotlib: pip install 'facerecon[viz]'") from error
    return plt


def _axes(ax: Any, **figure: Any) -> Any:
    return _pyplot().subplots(layout="constrained", **figure)[1] if ax is None else ax


def dots(photo: Any, found: Dots, ax: Any = None) -> Any:
    """Plot the dots on their photo.

    Args:
        photo: (height, width) grey, or (height, width, 3) uint8.
        found: the dots of the photo, pixels.
        ax: matplotlib axes to draw into; by default those of a new figure.

    Returns:
        The matplotlib axes.

    Raises:
        ParameterError: (a ``ValueError``) for a photo of another shape.
        ImportError: without matplotlib.
    """
    shown = photo if np.ndim(photo) == 3 else gray("photo", photo)
    ax = _axes(ax, figsize=(8, 6))
    ax.imshow(shown, cmap="gray")
    ax.plot(*found.positions.T, "+", color="orangered", markersize=4, markeredgewidth=0.8)
    ax.set_title(f"{len(found)} dots, {found.spacing_px:.1f} px apart")
    ax.set_axis_off()
    return ax


def matches(found: Result | Matches, capture: Capture | None = None, axes: Any = None) -> Any:
    """Plot the matches on both photos, coloured by disparity (pixels).

    Args:
        found: a result, or matches together with their ``capture``.
        capture: the photos; those of the result by default.
        axes: two matplotlib axes to draw into; by default those of a new figure.

    Returns:
        The two axes.

    Raises:
        ParameterError: (a ``ValueError``) for matches without a capture.
        ImportError: without matplotlib.
    """
    table = found.matches if isinstance(found, Result) else found
    photos = found.capture if isinstance(found, Result) and capture is None else capture
    if photos is None:
        raise ParameterError("capture is missing; give the capture of the matches", "parameters")
    if axes is None:
        axes = _pyplot().subplots(1, 2, figsize=(13, 5), layout="constrained")[1]
    known = table.disparity[np.isfinite(table.disparity)]
    low, high = np.percentile(known, (1, 99)) if len(known) else (0.0, 1.0)
    for ax, image, places in zip(
        axes, (photos.left, photos.right), (table.left, table.right), strict=True
    ):
        ax.imshow(image)
        drawn = ax.scatter(*places.T, c=table.disparity, s=4, cmap="viridis", vmin=low, vmax=high)
        ax.set_axis_off()
    axes[0].figure.colorbar(drawn, ax=list(axes), label="disparity [px]", shrink=0.8)
    return axes


def disparity(found: Matches | Result, ax: Any = None) -> Any:
    """Plot the disparities (pixels) at their positions in the left photo.

    Args:
        found: matches, or a result.
        ax: matplotlib axes to draw into; by default those of a new figure.

    Returns:
        The matplotlib axes.

    Raises:
        ImportError: without matplotlib.
    """
    table = found.matches if isinstance(found, Result) else found
    ax = _axes(ax, figsize=(7, 5.5))
    known = table.disparity[np.isfinite(table.disparity)]
    low, high = np.percentile(known, (1, 99)) if len(known) else (0.0, 1.0)
    drawn = ax.scatter(*table.left.T, c=table.disparity, s=14, cmap="viridis", vmin=low, vmax=high)
    ax.set(xlabel="x [px]", ylabel="y [px]", aspect="equal", title=f"{len(table)} matches")
    ax.set_facecolor("black")
    ax.invert_yaxis()
    ax.figure.colorbar(drawn, ax=ax, label="disparity [px]")
    return ax


def convergence(found: Result | Registration, ax: Any = None) -> Any:
    """Plot the error of the registration after each step (Eq. 3.8 with ``method="besl"``).

    Args:
        found: a result, or a :class:`facerecon.Registration`.
        ax: matplotlib axes to draw into; by default those of a new figure.

    Returns:
        The matplotlib axes.

    Raises:
        ImportError: without matplotlib.
    """
    history = found.registration_history if isinstance(found, Result) else found.history
    ax = _axes(ax, figsize=(6, 4))
    ax.plot(range(len(history)), history, marker=".")
    ax.set(xlabel="step", ylabel="error", title=f"registration: {found.termination}")
    ax.set_ylim(bottom=0.0)
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
    """Plot a mesh coloured by one value per vertex, with a scale in millimetres.

    Args:
        mesh: the mesh, mm.
        values: a comparison's distances, or (n,) values, at least 0; NaN is grey.
        view: ``front``, ``three-quarter``, ``profile`` ...
        limit_mm: value at the upper end of the scale.
        frame: ``"model"`` or ``"camera"``: the mesh's axes.
        ax: matplotlib axes to draw into; by default those of a new figure.

    Returns:
        The matplotlib axes.

    Raises:
        ParameterError: (a ``ValueError``) for arguments.
        ImportError: without matplotlib.
    """
    given = values.vertex_distances if isinstance(values, Comparison) else values
    given = column("values", given, len(mesh.vertices))
    drawn = render(mesh, view, heat=given, limit_mm=limit_mm, frame=frame, size=(700, 700))
    ax = _axes(ax, figsize=(6, 6))
    ax.imshow(drawn)
    ax.set_axis_off()
    return ax


def show3d(*shown: Mesh | Cloud | Result) -> Any:
    """An interactive 3D view for notebooks (k3d): make it the last value of a cell.

    Args:
        shown: meshes, clouds or results in the same frame, mm; a result shows its mesh.

    Returns:
        The ``k3d.Plot``.

    Raises:
        ParameterError: (a ``ValueError``) for a mesh without faces or an empty cloud.
        ImportError: without k3d.
    """
    shapes: list[Points | Triangles] = []
    for item in shown:
        if isinstance(item, Cloud):
            shapes.append(Points(item.points, item.colors))
        else:
            shapes.append((item.mesh if isinstance(item, Result) else item)._shape3d())
    return show_shapes(*shapes)

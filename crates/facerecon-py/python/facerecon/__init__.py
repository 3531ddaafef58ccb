"""Textured 3D face meshes from two stereo photographs under a projected pattern.

>>> import facerecon as fr
>>> shot = fr.simulate(subject=1)          # or fr.Capture.load("my-capture")
>>> face = fr.reconstruct(shot.capture)
>>> face.mesh.save("face.glb")
"""

from . import errors
from ._core import FEATURES, __version__
from .batch import BatchResult, batch
from .capture import Capture, Rig
from .errors import FaceReconError
from .makers import Comparison, Simulation, compare, pattern, render, simulate
from .mesh import Mesh
from .params import Params
from .progress import Event
from .result import Cloud, Matches, Result, head, reconstruct
from .stages import (
    Deformed,
    Dots,
    Rectified,
    Registration,
    deform,
    detect,
    equalize,
    fit,
    icp,
    match,
    rectify,
    sharpen,
    smooth,
    texture,
    thin,
    threshold,
    triangulate,
)

__all__ = [
    "FEATURES",
    "BatchResult",
    "Capture",
    "Cloud",
    "Comparison",
    "Deformed",
    "Dots",
    "Event",
    "FaceReconError",
    "Matches",
    "Mesh",
    "Params",
    "Rectified",
    "Registration",
    "Result",
    "Rig",
    "Simulation",
    "__version__",
    "batch",
    "compare",
    "deform",
    "detect",
    "equalize",
    "errors",
    "fit",
    "head",
    "icp",
    "match",
    "pattern",
    "reconstruct",
    "rectify",
    "render",
    "sharpen",
    "simulate",
    "smooth",
    "texture",
    "thin",
    "threshold",
    "triangulate",
]

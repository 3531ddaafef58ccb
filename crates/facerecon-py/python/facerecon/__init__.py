"""Textured 3D face meshes from two stereo photographs under a projected pattern.

>>> import facerecon as fr
>>> shot = fr.simulate(subject=1)          # or fr.Capture.load("my-capture")
>>> face = fr.reconstruct(shot.capture)
>>> face.mesh.save("face.glb")
"""

from . import errors, landmarks, viz
from ._core import FEATURES, __version__
from .batch import BatchResult, batch
from .capture import Capture, Rig
from .errors import FaceReconError
from .makers import (
    Comparison,
    Finding,
    Simulation,
    check,
    compare,
    pattern,
    render,
    simulate,
)
from .mesh import Mesh
from .params import Params
from .photo_stages import (
    Dots,
    Rectified,
    detect,
    equalize,
    match,
    rectify,
    sharpen,
    thin,
    threshold,
)
from .progress import Event
from .result import Cloud, Matches, Result, head, reconstruct
from .shape_stages import (
    Deformed,
    Registration,
    deform,
    fit,
    icp,
    smooth,
    surface,
    texture,
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
    "Finding",
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
    "check",
    "compare",
    "deform",
    "detect",
    "equalize",
    "errors",
    "fit",
    "head",
    "icp",
    "landmarks",
    "match",
    "pattern",
    "reconstruct",
    "rectify",
    "render",
    "sharpen",
    "simulate",
    "smooth",
    "surface",
    "texture",
    "thin",
    "threshold",
    "triangulate",
    "viz",
]

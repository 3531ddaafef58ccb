"""Textured 3D face meshes from two stereo photographs under a projected pattern.

>>> import facerecon as fr
>>> shot = fr.simulate(subject=1)          # or fr.Capture.load("my-capture")
>>> face = fr.reconstruct(shot.capture)
>>> face.mesh.save("face.glb")
"""

from . import errors, landmarks, viz
from ._core import LANDMARK_NAMES, __version__
from .batch import BatchResult, batch
from .capture import Capture, Rig
from .errors import FaceReconError, FaceReconWarning
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
    correspond,
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
    register,
    smooth,
    surface,
    texture,
    triangulate,
)

#: Alias of :data:`LANDMARK_NAMES`.
FEATURES = LANDMARK_NAMES

__all__ = [
    "FEATURES",
    "LANDMARK_NAMES",
    "BatchResult",
    "Capture",
    "Cloud",
    "Comparison",
    "Deformed",
    "Dots",
    "Event",
    "FaceReconError",
    "FaceReconWarning",
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
    "correspond",
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
    "register",
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

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Final, TypeAlias, final

import numpy as np
import numpy.typing as npt

from ._arrays import F32, F64, U8, ExtraParts, MeshParts, PhotoParts, RigParts

_Path: TypeAlias = str | PathLike[str]
_Sets: TypeAlias = list[tuple[str, str]]
_Callback: TypeAlias = Any
# points, normals, colors, sigmas
_CloudParts: TypeAlias = tuple[F64, F64 | None, U8 | None, F64 | None]
# left, right, disparity, points, lattice, score
_MatchParts: TypeAlias = tuple[F64, F64, F64, F64, F64, F64]
# positions, sigmas, amplitudes, scores, spacing, thinned
_DotParts: TypeAlias = tuple[F64, F64, F64, F64, float, F32 | None]
_Goals: TypeAlias = tuple[list[int], F64]

__all__ = [
    "Capture",
    "FEATURES",
    "Params",
    "Reconstruction",
    "Simulation",
    "Template",
    "__version__",
    "assign",
    "batch_run",
    "batch_tables",
    "cli_main",
    "compare",
    "deform",
    "detect",
    "encode_png",
    "filter",
    "find_matches",
    "icp",
    "pattern",
    "read_mesh",
    "read_photo",
    "read_rig",
    "reconstruct",
    "rectify",
    "render",
    "sharpen",
    "simulate",
    "smooth",
    "texture",
    "threshold",
    "triangulate",
    "write_mesh",
    "write_rig",
]

__version__: Final[str]
FEATURES: Final[list[str]]

@final
class Params:
    def __new__(cls, profile: str | None, toml: str | None, sets: _Sets) -> Params: ...
    def to_toml(self) -> str: ...
    def to_json(self) -> str: ...

@final
class Capture:
    def __new__(
        cls,
        left: PhotoParts,
        right: PhotoParts,
        plain: tuple[PhotoParts, PhotoParts] | None,
        extra: Sequence[ExtraParts],
        pattern: tuple[str, int, int, float],
        rig: RigParts | None,
        seeds: Mapping[str, list[float]] | None,
        features: Mapping[str, list[float]],
    ) -> Capture: ...
    @staticmethod
    def read(path: _Path) -> Capture: ...
    def with_features(self, features: Mapping[str, list[float]]) -> Capture: ...
    def write(self, folder: _Path) -> PathLike[str]: ...
    def photo(self, name: str) -> U8 | None: ...
    @property
    def pattern(self) -> tuple[str, int, int, float]: ...
    @property
    def rig(self) -> RigParts | None: ...
    @property
    def warnings(self) -> list[str]: ...

@final
class Template:
    def __new__(cls, name: str, parts: MeshParts, landmarks: Mapping[str, int]) -> Template: ...
    @staticmethod
    def load(name: str) -> Template: ...
    def mesh(self) -> MeshParts: ...
    @property
    def landmarks(self) -> dict[str, int]: ...
    @property
    def warnings(self) -> list[str]: ...

@final
class Reconstruction:
    def mesh(self, frame: str) -> MeshParts: ...
    @property
    def landmarks(self) -> dict[str, int]: ...
    @property
    def texture(self) -> U8 | None: ...
    @property
    def coverage(self) -> U8 | None: ...
    def cloud(self, frame: str) -> _CloudParts: ...
    def matches(self, frame: str) -> _MatchParts: ...
    def depth(self) -> list[U8]: ...
    @property
    def model_from_camera(self) -> F64: ...
    def json(self) -> str: ...
    def summary(self) -> list[str]: ...
    def report_html(self) -> str: ...
    def save(self, folder: _Path, frame: str, keep_stages: bool) -> None: ...
    def artifacts(self) -> list[tuple[str, str, Any]]: ...

@final
class Simulation:
    def capture(self) -> Capture: ...
    def mesh(self) -> MeshParts: ...
    def depth(self) -> F32: ...
    def face(self) -> npt.NDArray[np.bool_]: ...
    def camera_from_model(self) -> F64: ...
    def save(self, folder: _Path) -> PathLike[str]: ...

def cli_main(arguments: Sequence[str]) -> int: ...
def read_rig(path: _Path) -> tuple[RigParts, list[str]]: ...
def write_rig(path: _Path, rig: RigParts) -> None: ...
def read_photo(path: _Path) -> U8: ...
def encode_png(image: U8) -> bytes: ...
def read_mesh(path: _Path) -> tuple[MeshParts, U8 | None, list[str]]: ...
def write_mesh(path: _Path, parts: MeshParts, texture: U8 | None) -> None: ...
def reconstruct(
    capture: Capture,
    template: Template | None,
    params: Params,
    callback: _Callback,
) -> Reconstruction: ...
def find_matches(
    capture: Capture, params: Params, callback: _Callback
) -> tuple[_MatchParts, list[int], list[str]]: ...
def batch_run(
    capture: _Path, output: _Path, template: str, params: Params, frame: str
) -> str: ...
def batch_tables(outcomes: str) -> tuple[str, str]: ...
def filter(image: F32, params: Params) -> tuple[F32 | None, F32, F32]: ...
def sharpen(image: F32, params: Params) -> F32: ...
def threshold(image: F32, params: Params) -> F32: ...
def detect(image: F32, binary: bool, params: Params) -> _DotParts: ...
def rectify(capture: Capture, params: Params) -> dict[str, Any]: ...
def triangulate(
    capture: Capture, left: F64, right: F64, params: Params
) -> tuple[_CloudParts, bool]: ...
def icp(
    data: F64,
    model: Template,
    metric: bool,
    features: tuple[F64, F64] | None,
    params: Params,
    callback: _Callback,
) -> tuple[F64, str, list[float], list[int]]: ...
def deform(
    head: MeshParts,
    data: F64,
    assigned: _Goals | None,
    features: _Goals | None,
    params: Params,
    callback: _Callback,
) -> tuple[MeshParts, float, float, int]: ...
def smooth(
    parts: MeshParts, reference: F64 | None, params: Params
) -> tuple[MeshParts, int, list[float], list[float]]: ...
def texture(
    capture: Capture, parts: MeshParts, params: Params, callback: _Callback
) -> tuple[U8, U8]: ...
def assign(data: F64, vertices: F64) -> tuple[list[int], F64]: ...
def simulate(
    subject: int,
    parts: MeshParts | None,
    texture: U8 | None,
    sets: _Sets,
    callback: _Callback,
) -> Simulation: ...
def pattern(sets: _Sets) -> U8: ...
def render(
    parts: MeshParts,
    texture: U8 | None,
    heat: F64 | None,
    limit: float | None,
    views: list[str],
    mode: str,
    frame: str,
    size: tuple[int, int],
) -> U8: ...
def compare(
    first: MeshParts,
    second: MeshParts,
    region: list[bool] | None,
    sets: _Sets,
) -> tuple[str, F64]: ...

"""What can go wrong: every exception is a :class:`FaceReconError` and says what to do next."""

from __future__ import annotations


class FaceReconError(Exception):
    """Anything that ends a run.

    Attributes:
        stage: name of the stage that failed, or ``"file"``, ``"parameters"``, ``"input"``.
        hint: what to try next, or ``None``.
    """

    stage: str
    hint: str | None

    def __init__(self, message: str, stage: str = "", hint: str | None = None) -> None:
        super().__init__(message)
        self.stage = stage
        self.hint = hint


class ParameterError(FaceReconError, ValueError):
    """An argument or a parameter that cannot be used; also a :class:`ValueError`."""


class FileError(FaceReconError, OSError):
    """A file that cannot be read, understood or written; also an :class:`OSError`."""


class InputError(FaceReconError):
    """Something that the input lacks."""


class TemplateError(FaceReconError):
    """A generic head that cannot be used."""


class RectifyError(FaceReconError):
    """Photos that cannot be rectified."""


class FilterError(FaceReconError):
    """A photo that cannot be filtered."""


class DetectError(FaceReconError):
    """Dots that cannot be found."""


class CorrespondError(FaceReconError):
    """Dots that cannot be matched."""


class RefineError(FaceReconError):
    """Matches that cannot be refined."""


class TriangulateError(FaceReconError):
    """Matches that give no points."""


class RegisterError(FaceReconError):
    """Points that do not fit the head."""


class DeformError(FaceReconError):
    """A head that cannot be bent."""


class SmoothError(FaceReconError):
    """A mesh that cannot be smoothed."""


class SurfaceError(FaceReconError):
    """A surface that cannot be made."""


class TextureError(FaceReconError):
    """A mesh that cannot be coloured."""


class RenderError(FaceReconError):
    """A picture that cannot be drawn."""


class PatternError(FaceReconError):
    """A pattern that cannot be made."""


class SimulateError(FaceReconError):
    """A capture that cannot be simulated."""


class CompareError(FaceReconError):
    """Meshes that cannot be compared."""

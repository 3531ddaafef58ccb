"""Exceptions, all :class:`FaceReconError`, and the warning category :class:`FaceReconWarning`."""

from __future__ import annotations


class FaceReconError(Exception):
    """Base class of all exceptions of the package.

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


class FaceReconWarning(UserWarning):
    """A result that needs attention, for example photos out of focus or rows out of level.

    Functions whose result has ``warnings`` (:func:`facerecon.reconstruct`,
    :func:`facerecon.rectify`, :meth:`facerecon.Capture.load`) put them there. All others issue
    them with :func:`warnings.warn` in this category. A progress function gets every warning as
    an :class:`facerecon.Event`.
    """


class ParameterError(FaceReconError, ValueError):
    """An argument or a parameter that cannot be used; also a :class:`ValueError`."""


class FileError(FaceReconError, OSError):
    """A file that cannot be read, understood or written; also an :class:`OSError`."""


class InputError(FaceReconError):
    """Input that is incomplete or inconsistent."""


class TemplateError(FaceReconError):
    """A template that cannot be used."""


class RectifyError(FaceReconError):
    """Photos that cannot be rectified."""


class FilterError(FaceReconError):
    """A photo that cannot be filtered."""


class DetectError(FaceReconError):
    """A photo without enough dots."""


class CorrespondError(FaceReconError):
    """Dots that cannot be matched."""


class RefineError(FaceReconError):
    """Matches that cannot be refined."""


class TriangulateError(FaceReconError):
    """Matches that give no points."""


class RegisterError(FaceReconError):
    """Points that cannot be registered with the template."""


class DeformError(FaceReconError):
    """A template that cannot be deformed."""


class SmoothError(FaceReconError):
    """A mesh that cannot be smoothed."""


class SurfaceError(FaceReconError):
    """Points that form no surface."""


class TextureError(FaceReconError):
    """A mesh that cannot be textured."""


class RenderError(FaceReconError):
    """A mesh that cannot be rendered."""


class PatternError(FaceReconError):
    """A pattern that cannot be drawn."""


class SimulateError(FaceReconError):
    """A capture that cannot be simulated."""


class CompareError(FaceReconError):
    """Meshes that cannot be compared."""

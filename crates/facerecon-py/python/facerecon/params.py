"""Parameters: those of the command line, with the same names, ranges and defaults."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from . import _core
from .errors import FileError, ParameterError


class Params:
    """All parameters of a reconstruction.

    Later values win: the profile, then ``config``, then the keyword arguments.

    Args:
        profile: ``"precise"`` or ``"facebuilder"``; ``None`` for the profile of ``config``,
            else ``"precise"``.
        config: path of a TOML file, as ``facerecon params`` prints it.
        settings: groups as dictionaries, ``smooth={"steps": 3, "lambda_": 0.4}`` (a trailing
            underscore is ignored), or dotted names in a dictionary,
            ``**{"smooth.steps": 3}``. ``print(Params().to_toml())`` lists all of them with meaning,
            unit and range.

    Raises:
        ParameterError: (a ``ValueError``) for unknown names and values out of range.
        FileError: (an ``OSError``) when ``config`` cannot be read.
    """

    def __init__(
        self,
        profile: str | None = None,
        config: str | PathLike[str] | None = None,
        **settings: Any,
    ) -> None:
        text = None
        if config is not None:
            try:
                text = Path(config).read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                raise FileError(f"cannot read parameters {config}: {error}", "file") from error
        self._core = _core.Params(profile, text, to_sets(settings))

    def to_toml(self) -> str:
        """All parameters as commented TOML, a file for ``--config``.

        Returns:
            Each value with its meaning, unit, range and default.
        """
        return self._core.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """All values as nested dictionaries."""
        values: dict[str, Any] = json.loads(self._core.to_json())
        return values

    def save(self, path: str | PathLike[str]) -> None:
        """Write :meth:`to_toml` to a file.

        Raises:
            FileError: (an ``OSError``) when it cannot be written.
        """
        try:
            Path(path).write_text(self.to_toml(), encoding="utf-8")
        except OSError as error:
            raise FileError(f"cannot write parameters {path}: {error}", "file") from error

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Params) and self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restore, (self.to_toml(),))

    def __repr__(self) -> str:
        return f"<facerecon.Params, profile {self.to_dict()['profile']!r}>"

    def _repr_html_(self) -> str:
        summary, text = html.escape(repr(self)), html.escape(self.to_toml())
        return f"<details><summary>{summary}</summary><pre>{text}</pre></details>"


def _restore(toml: str) -> Params:
    params = Params()
    params._core = _core.Params(None, toml, [])
    return params


def to_sets(settings: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Nested settings as dotted names with values as TOML text."""
    sets: list[tuple[str, str]] = []
    for name, value in settings.items():
        if isinstance(value, Mapping):
            sets += to_sets(value, f"{prefix}{name}.")
        elif value is not None:
            # lambda_ stands for lambda, a keyword of Python
            dotted = prefix + name.removesuffix("_")
            sets.append((dotted, _toml(dotted, value)))
    return sets


def _toml(name: str, value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value)
    if hasattr(value, "tolist"):  # numpy arrays and numbers
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(name, v) for v in _flat(value)) + "]"
    raise ParameterError(
        f"parameter {name} is a {type(value).__name__}; expected a number, text, bool or list",
        "parameters",
    )


def _flat(values: Any) -> list[Any]:
    """Nested lists (kernels) flattened row by row."""
    flat: list[Any] = []
    for value in values:
        flat += _flat(value) if isinstance(value, (list, tuple)) else [value]
    return flat


def given_params(
    profile: str | None, params: Params | None, settings: Mapping[str, Any]
) -> _core.Params:
    """The parameters of a run: ``params``, or a profile with settings."""
    if params is None:
        return _core.Params(profile, None, to_sets(settings))
    if profile is not None or settings:
        raise ParameterError(
            "params is given together with a profile or settings; put these into the Params",
            "parameters",
        )
    if not isinstance(params, Params):
        raise ParameterError(
            f"params is a {type(params).__name__}; expected a facerecon.Params (give single "
            'values as settings, smooth={"steps": 3})',
            "parameters",
        )
    return params._core


def params_for(stage: str, profile: str | None, settings: Mapping[str, Any]) -> _core.Params:
    """The parameters of one stage, from its keyword arguments."""
    return _core.Params(profile, None, to_sets({stage: dict(settings)}))

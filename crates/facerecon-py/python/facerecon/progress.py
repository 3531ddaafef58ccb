"""Progress of a run: events, progress functions and progress bars."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

#: The stages in order; a run has ``deform`` or ``surface``.
STAGES = (
    "rectify",
    "check",
    "detect",
    "correspond",
    "cameras",
    "refine",
    "outline",
    "triangulate",
    "landmarks",
    "register",
    "deform",
    "surface",
    "smooth",
    "texture",
)


@dataclass(frozen=True)
class Event:
    """Something that happened in a stage.

    Attributes:
        stage: name of the stage.
        kind: ``"started"``, ``"finished"``, ``"iteration"``, ``"count"`` or ``"warning"``.
        number: the step (iteration) or how many (count).
        value: the error after the step (iteration) or the duration in seconds (finished).
        text: what was counted (count) or the text of the warning.
    """

    stage: str
    kind: str
    number: int
    value: float
    text: str


Callback = Callable[[Event], object]
Raw = Callable[[str, str, int, float, str], None]


class Watcher(Protocol):
    """Receives the events of a run."""

    callback: Raw | None

    def close(self) -> None:
        """End of the run."""


class _Silent:
    callback: Raw | None = None

    def close(self) -> None:
        pass


class _Calls:
    def __init__(self, to: Callback) -> None:
        def call(stage: str, kind: str, number: int, value: float, text: str) -> None:
            to(Event(stage, kind, number, value, text))

        self.callback: Raw | None = call

    def close(self) -> None:
        pass


class _Bar:
    """A bar over the stages; for a single stage it shows the steps only."""

    def __init__(self, stages: tuple[str, ...]) -> None:
        self.stages = stages
        self.bar: Any = _tqdm()(
            total=len(stages),
            unit="stage",
            bar_format="{desc:<11}|{bar}| {n_fmt}/{total_fmt} stages [{elapsed}{postfix}]"
            if len(stages) > 1
            else "{desc:<11} [{elapsed}{postfix}]",
        )
        self.callback: Raw | None = self._show

    def _show(self, stage: str, kind: str, number: int, value: float, text: str) -> None:
        if kind == "started":
            self.bar.set_postfix_str("", refresh=False)
            self.bar.set_description_str(stage)
        elif kind == "finished" and stage in self.stages:
            self.bar.n = max(self.bar.n, self.stages.index(stage) + 1)
            self.bar.refresh()
        elif kind == "iteration":
            self.bar.set_postfix_str(f"step {number}, error {value:.4g}")

    def close(self) -> None:
        self.bar.close()


def watcher(progress: bool | Callback, stages: tuple[str, ...] = STAGES) -> Watcher:
    """The watcher for ``progress=``: ``False`` none, ``True`` a bar, else a function."""
    if callable(progress):
        return _Calls(progress)
    return _Bar(stages) if progress else _Silent()


@contextmanager
def bar(total: int, unit: str, progress: bool) -> Iterator[Callable[[], object]]:
    """A bar, given as the function that advances it by one; without ``progress`` a no-op."""
    if not progress:
        yield lambda: None
        return
    with _tqdm()(total=total, unit=unit) as drawn:
        yield drawn.update


def _tqdm() -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError as error:
        raise ImportError(
            "progress=True needs tqdm: pip install 'facerecon[viz]', or pass a function"
        ) from error
    return tqdm

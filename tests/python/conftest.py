"""Shared fixtures: one simulated person, one reconstruction."""

from __future__ import annotations

from pathlib import Path

import facerecon as fr
import pytest


@pytest.fixture(scope="session")
def shot() -> fr.Simulation:
    """A simulated capture."""
    return fr.simulate(subject=1)


@pytest.fixture(scope="session")
def folder(shot: fr.Simulation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its capture folder."""
    path = tmp_path_factory.mktemp("capture") / "person"
    shot.save(path)
    return path


@pytest.fixture(scope="session")
def result(folder: Path) -> fr.Result:
    """Its reconstruction."""
    return fr.reconstruct(folder)

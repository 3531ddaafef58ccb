"""The notebooks run from top to bottom, and are stored without outputs."""

from __future__ import annotations

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))


def test_there_are_four() -> None:
    assert [p.name[0] for p in NOTEBOOKS] == ["1", "2", "3", "4"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    assert all(not c.get("outputs") for c in notebook.cells), "clear the outputs"
    nbclient.NotebookClient(
        notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    assert all(c.execution_count for c in notebook.cells if c.cell_type == "code")
    outputs = [o for c in notebook.cells for o in c.get("outputs", ())]
    words = [o.text for o in outputs if o.get("name") == "stderr"]
    assert not any("Warning" in w for w in words), words
    pictures = [o for o in outputs if "image/png" in o.get("data", ())]
    assert pictures or any("data:image/png" in str(o) for o in outputs)


def test_the_thesis_figures_are_all_there() -> None:
    text = NOTEBOOKS[1].read_text()
    figures = "2.2 2.3 2.4 2.5 3.1 3.2 4.1 4.2 4.3 5.1 5.2 5.3 5.4 5.5 5.6"
    assert [f for f in figures.split() if f"Fig. {f}:" not in text] == []

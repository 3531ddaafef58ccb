"""Documentation: docstrings of every public name, the code of the READMEs, metadata of the wheel."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import facerecon as fr
import pytest
from facerecon import landmarks, viz

ROOT = Path(__file__).parents[2]


def public() -> dict[str, Any]:
    """Every public class, function, method and property by its dotted name."""
    found: dict[str, Any] = {}
    names = [(f"fr.{n}", getattr(fr, n)) for n in fr.__all__]
    for module in (viz, landmarks):
        short = module.__name__.removeprefix("facerecon.")
        names += [
            (f"fr.{short}.{n}", v)
            for n, v in vars(module).items()
            if not n.startswith("_") and getattr(v, "__module__", "") == module.__name__
        ]
    for name, value in names:
        if inspect.isclass(value):
            found[name] = value
            for part, member in vars(value).items():
                inner = member.__func__ if isinstance(member, classmethod) else member
                if not part.startswith("_") and (
                    inspect.isfunction(inner) or isinstance(inner, property)
                ):
                    found[f"{name}.{part}"] = inner
        elif inspect.isfunction(value):
            found[name] = value
    return found


PUBLIC = public()
FUNCTIONS = {n: v for n, v in PUBLIC.items() if inspect.isfunction(v)}
#: Functions that follow equations or sections of the thesis.
THESIS = (
    "equalize sharpen threshold thin detect correspond triangulate rectify register deform "
    "smooth texture"
).split()


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_explained(name: str) -> None:
    text = inspect.getdoc(PUBLIC[name])
    assert text and text[0].isupper() | text.startswith(("``", "(")), f"{name}: {text}"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_is_explained(name: str) -> None:
    text = inspect.getdoc(FUNCTIONS[name]) or ""
    arguments = [
        a for a in inspect.signature(FUNCTIONS[name]).parameters if a not in ("self", "cls")
    ]
    if len(arguments) > 1 or name.count(".") == 1:
        assert not arguments or "Args:" in text, name
    if "Args:" in text:
        missing = [a for a in arguments if not re.search(rf"\b{a}\b", text.split("Args:")[1])]
        assert not missing, f"{name} does not explain {missing}"
    if name.count(".") == 1:
        assert "Raises:" in text, f"{name} does not say what it raises"


@pytest.mark.parametrize("name", THESIS)
def test_stages_name_their_place_in_the_thesis(name: str) -> None:
    text = inspect.getdoc(getattr(fr, name)) or ""
    assert re.search(r"Eq\. \d|thesis (section|chapter) \d|sections? \d", text), name
    assert re.search(r"pixels|mm|millimetres|\(height, width\)|\(n, \d\)", text), f"{name}: no unit"


def test_the_readme_cells_work_as_written(tmp_path: Path) -> None:
    for readme in (ROOT / "README.md", ROOT / "crates/facerecon-py/README.md"):
        cells = re.findall(r"```python\n(.*?)```", readme.read_text(), re.S)
        assert cells, readme
        script = tmp_path / "cells.py"
        script.write_text("\n".join(cells))
        done = subprocess.run(
            [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "face.glb").exists()


def test_the_wheel_says_what_it_is(tmp_path: Path) -> None:
    facts = metadata.metadata("facerecon")
    assert facts["License-Expression"] == "MIT OR Apache-2.0"
    assert facts["Requires-Python"] == ">=3.10" and facts["Version"] == fr.__version__
    classifiers = facts.get_all("Classifier") or []
    assert "Typing :: Typed" in classifiers and "Programming Language :: Rust" in classifiers
    assert {"viz", "mesh", "landmarks", "dask"} <= set(facts.get_all("Provides-Extra") or [])
    wheel = metadata.distribution("facerecon")
    assert "# facerecon" in (wheel.read_text("METADATA") or "")
    assert "Tag: cp310-abi3-" in (wheel.read_text("WHEEL") or "")
    files = {Path(str(f)).name: Path(str(wheel.locate_file(f))) for f in wheel.files or []}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "py.typed", "_core.pyi", "_core.abi3.so"} <= set(files)
    with zipfile.ZipFile(tmp_path / "all.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        for path in files.values():
            if path.is_file():
                packed.write(path)
    assert (tmp_path / "all.zip").stat().st_size < 15e6


def test_both_ways_to_build_the_wheel_agree() -> None:
    tomllib = pytest.importorskip("tomllib")
    root, crate = (
        tomllib.loads((ROOT / folder / "pyproject.toml").read_text())["project"]
        for folder in (".", "crates/facerecon-py")
    )
    assert root == crate

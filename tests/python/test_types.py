"""Types: mypy --strict on the facade and these tests, the stubs against the extension."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "pyproject.toml"


def run(*arguments: object) -> None:
    done = subprocess.run(
        [sys.executable, "-m", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        cwd=HERE,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_facade_is_strictly_typed() -> None:
    run("mypy", "--strict", "--config-file", CONFIG, "-p", "facerecon")


def test_users_see_the_types() -> None:
    run("mypy", "--strict", "--config-file", CONFIG, HERE)


def test_the_stubs_say_what_the_extension_has() -> None:
    run("mypy.stubtest", "facerecon._core", "--mypy-config-file", CONFIG)

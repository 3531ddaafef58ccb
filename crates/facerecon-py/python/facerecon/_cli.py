"""The ``facerecon`` command of the wheel: the same code as the cargo-installed one."""

import sys

from . import _core


def main() -> None:
    """Run the command line and exit with its code."""
    sys.exit(_core.cli_main(sys.argv))

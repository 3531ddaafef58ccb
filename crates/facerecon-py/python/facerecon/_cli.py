"""The ``facerecon`` command of the wheel: the same code as the cargo-installed one."""

import signal
import sys

from . import _core


def main() -> None:
    """Run the command line and exit with its code."""
    # Python's own handler would react only after the command has ended
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_core.cli_main(sys.argv))

"""The ``magician`` command: ports, doctor, sim, run, draw and the rest, as ``magician`` or ``python -m magician``."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

from ._magician import run_command

__all__ = ["main"]


def main() -> NoReturn:
    """Runs the command with the arguments of this process, and ends with its exit status."""
    # The command handles Ctrl-C itself. Python's handler would raise a second time, with a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_command(["magician", *sys.argv[1:]]))

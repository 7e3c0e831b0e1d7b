"""``python -m magician``: the command, for a Python whose scripts are not on the path."""

from ._command import main

main()

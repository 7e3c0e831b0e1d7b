"""Stand-ins in child processes.

A forked process inherits them. A process that ``multiprocessing`` spawns, as it does on Windows and macOS, and on Linux
from Python 3.14 on, imports the program again and must install them first.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from . import _line, _modules

__all__ = ["Replacement", "install_in_children", "install_stand_ins"]


class Replacement(NamedTuple):
    """Meaning of a program's imports, and the arm that it connects to."""

    port: str | None
    pydobot: str
    dobotdll: str
    packages: Collection[str]
    own: Collection[str]
    wrappers: Sequence[Path]


def install_stand_ins(chosen: Replacement) -> None:
    """Replaces the libraries by the stand-ins."""
    _line.redirect_to(chosen.port)
    _modules.install(chosen.pydobot, chosen.dobotdll, chosen.packages, own=chosen.own, wrappers=chosen.wrappers)


def install_in_children(chosen: Replacement, sources: Collection[str]) -> None:
    """Makes processes that the program spawns install the stand-ins before they import it."""
    if not any("multiprocessing" in source or "ProcessPool" in source for source in sources):
        return
    import multiprocessing
    from multiprocessing import spawn

    prepared = spawn.get_preparation_data
    inherited = _Inherited(chosen)

    def preparation_data(name: str) -> dict[str, Any]:
        # The first object that a new process unpickles, so the stand-ins are installed before the program is imported.
        return {"magician.compat": inherited, **prepared(name)}

    spawn.get_preparation_data = preparation_data
    if "forkserver" in multiprocessing.get_all_start_methods():
        # Otherwise the server would import the program itself, without the stand-ins.
        multiprocessing.set_forkserver_preload([])


class _Inherited:
    """Installs the stand-ins when it is unpickled."""

    def __init__(self, chosen: Replacement) -> None:
        self.chosen = chosen

    def __reduce__(self) -> tuple[Any, ...]:
        return install_stand_ins, (self.chosen,)

"""The names under which programs import what stands in."""

from __future__ import annotations

import importlib
import sys

from . import _serial, dobotdll

__all__ = ["PYDOBOTS", "install"]

PYDOBOTS = ("pydobot", "pydobotplus", "pydobot2")


def install(pydobot: str = "pydobot", family: str = "v3") -> None:
    """Lets programs of this process import the stand-ins.

    ``pydobot`` is the library that is meant by that name, ``family`` that of ``DobotDllType``.
    """
    _serial.install()
    for name in PYDOBOTS:
        _name(name, f"{__package__}.{name}")
    if pydobot != "pydobot":
        for name in [name for name in sys.modules if name.split(".")[0] == "pydobot"]:
            del sys.modules[name]
        _name("pydobot", f"{__package__}.{pydobot}")
    # The example of pydobotplus imports its inner module by that name.
    sys.modules["dobotplus"] = sys.modules["pydobotplus"]
    sys.modules["DobotDllType"] = dobotdll.family(family)


def _name(name: str, module: str) -> None:
    importlib.import_module(module)
    for inner in [inner for inner in sys.modules if inner == module or inner.startswith(module + ".")]:
        sys.modules[name + inner[len(module) :]] = sys.modules[inner]

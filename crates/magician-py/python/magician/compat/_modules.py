"""The names under which programs import what stands in."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Collection, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

from . import _serial
from ._program import WRAPPER

__all__ = ["PYDOBOTS", "install"]

PYDOBOTS = ("pydobot", "pydobotplus", "pydobot2")


class _Names(MetaPathFinder):
    """Finds what stands in before what is installed."""

    def __init__(self, pydobot: str, family: str) -> None:
        self.family = family
        self.homes = {name: f"{__package__}.{name}" for name in PYDOBOTS}
        self.homes["pydobot"] = self.homes[pydobot]
        # The example of pydobotplus imports its inner module by this name.
        self.homes["dobotplus"] = self.homes["pydobotplus"]

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        # Whatever package a program keeps it in.
        if fullname.rpartition(".")[2] == WRAPPER:
            return ModuleSpec(fullname, _Family(self.family))
        root, dot, rest = fullname.partition(".")
        home = self.homes.get(root)
        return ModuleSpec(fullname, _Same(home + dot + rest)) if home else None


class _Packages(MetaPathFinder):
    """Finds the packages of the vendor's wrapper that nobody else finds: a program without its copy of the wrapper."""

    def __init__(self, names: Collection[str]) -> None:
        self.names = names

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, None, is_package=True) if fullname in self.names else None


class _Same(Loader):
    """Loads a module under another name: both are the same."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.spec: ModuleSpec | None = None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(self.name)
        self.spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self.spec


class _Family(_Same):
    """Loads a family of ``DobotDllType``."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        from . import dobotdll

        module = dobotdll.family(self.name)
        self.spec = module.__spec__
        return module


def install(pydobot: str = "pydobot", family: str = "v3", packages: Collection[str] = ()) -> None:
    """Lets programs of this process import the stand-ins.

    ``pydobot`` is the library that is meant by that name, ``family`` that of ``DobotDllType``, ``packages`` those that
    it is imported from.
    """
    _serial.install()
    sys.meta_path.insert(0, _Names(pydobot, family))
    sys.meta_path.append(_Packages(packages))

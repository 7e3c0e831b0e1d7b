"""Import hooks for the names of the replaced libraries."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Collection, Mapping, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from . import _library, _script, _serial
from ._program import OTHER_WRAPPERS, WRAPPER, is_wrapper

__all__ = ["PYDOBOTS", "STAND_INS", "dobotlab_globals", "install", "needed_copies"]

PYDOBOTS = ("pydobot", "pydobotplus", "pydobot2")
# Imported module, and its stand-in.
STAND_INS = {
    **{name: name for name in PYDOBOTS},
    # The example of pydobotplus imports its inner module by this name.
    "dobotplus": "pydobotplus",
    "pydobotpp": "pydobotpp",
    "pydobotlab": "pydobotlab",
    "dobotapi": "dobotapi",
    "dobotWrapperPy": "dobotwrapperpy",
    "DobotEDU": "dobotedu",
    "dobot_edu": "dobotedu",
    "dobotEdu": "dobotedu",
    "DobotRPC": "dobotrpc",
}


class _StandInFinder(MetaPathFinder):
    """Finds the stand-ins before installed packages, except for libraries whose own copy a program needs."""

    def __init__(self, pydobot: str, family: str, own: Collection[str], wrappers: Sequence[Path]) -> None:
        self.family, self.wrappers = family, wrappers
        self.homes = {name: f"{__package__}.{home}" for name, home in STAND_INS.items() if name not in own}
        if "pydobot" in self.homes:
            self.homes["pydobot"] = f"{__package__}.{pydobot}"

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        # In any package: programs carry copies of it.
        if is_wrapper(fullname.rpartition(".")[2]):
            return ModuleSpec(fullname, _FamilyLoader(self.family, self.wrappers))
        root, dot, rest = fullname.partition(".")
        home = self.homes.get(root)
        return ModuleSpec(fullname, _AliasLoader(home + dot + rest)) if home else None


class _FallbackFinder(MetaPathFinder):
    """Finds modules that nothing else finds: the packages of the vendor's wrapper for a program without a copy of it,
    and the wrapper under similar names. Each of the latter has its own connections, as it had its own library."""

    def __init__(self, names: Collection[str], family: str) -> None:
        self.names, self.family = names, family

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if OTHER_WRAPPERS.fullmatch(fullname.rpartition(".")[2]):
            return ModuleSpec(fullname, _InstanceLoader(self.family), is_package=True)
        return ModuleSpec(fullname, None, is_package=True) if fullname in self.names else None


class _AliasLoader(Loader):
    """Loads a module under another name; both names give the same module."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.spec: ModuleSpec | None = None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(self.name)
        self.spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self.spec


class _FamilyLoader(_AliasLoader):
    """Loads a family of ``DobotDllType``. Names that exist only in a program's modified copy come from that copy."""

    def __init__(self, name: str, wrappers: Sequence[Path]) -> None:
        super().__init__(name)
        self.wrappers = wrappers

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        from . import dobotdll

        module = dobotdll.family(self.name)
        # `from DobotDllType import DobotDllType` gives the same module.
        module.__dict__.setdefault(WRAPPER, module)
        module.__dict__["__getattr__"] = _CopiedNames(self.wrappers)
        self.spec = module.__spec__
        return module


class _InstanceLoader(_AliasLoader):
    """Loads another instance of a family of ``DobotDllType``."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        from . import dobotdll

        module = dobotdll.family(self.name, again=True)
        module.__dict__.update(dict.fromkeys((WRAPPER, "dType"), module), __path__=[])
        self.spec = module.__spec__
        return module


class _CopiedNames:
    """``__getattr__`` of a module, which searches a program's own copies of the vendor's wrapper."""

    def __init__(self, files: Sequence[Path]) -> None:
        self.files = files
        self.modules: list[ModuleType] | None = None

    def __call__(self, name: str) -> object:
        if not name.startswith("__"):
            if self.modules is None:
                self.modules = []
                for file in self.files:
                    if (spec := spec_from_file_location(f"{__name__}.copy", file)) and spec.loader:
                        module = module_from_spec(spec)
                        spec.loader.exec_module(module)
                        self.modules.append(module)
            for module in self.modules:
                if name in module.__dict__:
                    return module.__dict__[name]
        raise AttributeError(f"module '{WRAPPER}' has no attribute '{name}'")


def dobotlab_globals() -> dict[str, object]:
    """Returns the names that DobotLab injects into scripts."""
    from . import dobotedu

    return {name: getattr(dobotedu, name) for name in ("magician", "magicbox", "m_lite", "go", "dobot_edu")}


def needed_copies(copies: Mapping[str, str], sources: Collection[str], pydobot: str) -> list[str]:
    """Returns the libraries of which the program has a copy (text by name) and uses names that are missing here."""
    found: list[str] = []
    for name, copy in copies.items():
        home = pydobot if name == "pydobot" else STAND_INS[name]
        modules = [importlib.import_module(f"{__package__}.{home}")]
        modules += [each for each in vars(modules[0]).values() if isinstance(each, ModuleType)]
        ours = {name for module in modules for name in vars(module)}
        ours |= {name for module in modules for name in dir(getattr(module, "Dobot", None))}
        if _script.needs_copy(*sources, copy=copy, ours=ours):
            found.append(name)
    return found


def install(
    pydobot: str = "pydobot",
    family: str = "v3",
    packages: Collection[str] = (),
    *,
    own: Collection[str] = (),
    wrappers: Sequence[Path] = (),
) -> None:
    """Makes the programs of this process import the stand-ins, load the stand-in for the vendor's library, and open the
    arm's port.

    ``pydobot`` is the library that ``import pydobot`` means, ``family`` the family of ``DobotDllType``, ``packages``
    the packages from which that is imported, ``own`` the libraries of which the program needs its copy, and
    ``wrappers`` the copies of the wrapper.
    """
    _serial.install()
    _library.install(family)
    sys.meta_path.insert(0, _StandInFinder(pydobot, family, own, wrappers))
    sys.meta_path.append(_FallbackFinder(packages, family))

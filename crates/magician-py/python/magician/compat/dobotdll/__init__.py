"""``DobotDllType`` without the C library.

``v1``, ``v2`` and ``v3`` are the unchanged modules that come with our C library (``tools/dobotdll.py``). Here they get
an ``api`` that replaces the C library.
"""

from __future__ import annotations

import importlib
import importlib.util
from types import ModuleType

from ._api import LibraryApi

__all__ = ["FAMILIES", "LibraryApi", "family"]

FAMILIES = ("v1", "v2", "v3")


def family(name: str, *, again: bool = False) -> ModuleType:
    """Returns the module for programs without ids (``v1``), with ``dobotId`` (``v2``), or with ``masterId`` (``v3``).

    With ``again``, creates another instance, since programs load the C library twice for two arms.
    """
    if name not in FAMILIES:
        raise ValueError(f"{name} is no family of DobotDllType; there are {', '.join(FAMILIES)}")
    module = importlib.import_module(f"{__package__}.{name}")
    if again and (spec := module.__spec__) and spec.loader:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    module.__dict__["load"] = lambda: LibraryApi(module)
    return module

"""Stand-in for the vendor's C library, for programs that load it themselves."""

from __future__ import annotations

import ctypes
import os
import re
from typing import Any

__all__ = ["install"]

LIBRARY = re.compile(r"(lib)?dobot\w*(\.dll|\.so[.\d]*|\.dylib|\.\d[.\d]*)?|(lib)?dobot\w*dll[\w.]*", re.IGNORECASE)


def install(family: str) -> None:
    """Makes ``ctypes.CDLL`` and its callers load the stand-in by the file's name. Other libraries load as usual."""

    def new(kind: type[Any], name: Any = None, *_: Any, **__: Any) -> Any:
        if isinstance(name, (str, os.PathLike)) and LIBRARY.fullmatch(re.split(r"[/\\\\]", os.fspath(name))[-1]):
            from . import dobotdll

            return dobotdll.LibraryApi(dobotdll.family(family))
        return object.__new__(kind)

    ctypes.CDLL.__new__ = new  # type: ignore[method-assign,assignment]

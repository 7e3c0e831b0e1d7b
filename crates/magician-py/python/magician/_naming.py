"""Lookup of commands by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from . import _magician, commands
from ._protocol import Answer, Command, Query, Writable
from ._values import fields as fields_of
from .errors import InvalidInputError


def find(name: str, form: str, fields: dict[str, Any]) -> Any:
    """Finds the class, or builds the object, of ``commands`` for a name and fields; ``form`` is ``"get"`` or
    ``"set"``.
    """
    try:
        cls: type[Any] = getattr(commands, _magician.find(name, form))
    except InvalidInputError as error:
        raise InvalidInputError(f"{error}{_suggestion(name, _names_of(form))}") from None
    if form == "get" and issubclass(cls, Answer):
        if fields:
            raise TypeError(f"{cls.__name__} is asked for without {', '.join(fields)}")
        return cls
    known = fields_of(cls)
    for field in fields:
        if field not in known:
            there = f"; it has {', '.join(known)}" if known else "; it has none"
            raise TypeError(f"{cls.__name__} has no field `{field}`{_suggestion(field, known) or there}")
    missing = [name for name, has_default in known.items() if not has_default and name not in fields]
    if missing:
        raise TypeError(f"{cls.__name__} takes {', '.join(missing)} as well")
    return cls(**fields)


def _names_of(form: str) -> list[str]:
    """Returns the names of all commands that can be read or set."""
    kinds: tuple[type[Command], ...] = (Answer, Query) if form == "get" else (Writable,)
    everything: Mapping[str, Any] = vars(commands)
    return [name for name, each in everything.items() if hasattr(each, "LAYOUT") and issubclass(each, kinds)]


def _suggestion(name: str, known: Iterable[str]) -> str:
    """Suggests similar names."""
    import difflib

    plain = {_normalized(each): each for each in known}
    near = difflib.get_close_matches(_normalized(name), plain, 3, 0.6)
    return f"; did you mean {' or '.join(plain[each] for each in near)}?" if near else ""


def _normalized(name: str) -> str:
    """Normalizes a name for comparison: without case, underscores and the vendor's verbs."""
    return name.lower().replace("_", "").replace("-", "").removeprefix("get").removeprefix("set")

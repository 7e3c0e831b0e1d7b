"""Numbers that a program gives: what is none, or out of range, is refused under the name that its caller gave it."""

from __future__ import annotations

import contextlib
import math
import operator
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, SupportsIndex, TypeVar, overload

from ._protocol import Command
from .errors import InvalidInputError

__all__ = [
    "DAY",
    "addresses",
    "as_json",
    "checked",
    "ending",
    "flag",
    "flags",
    "hearing",
    "instance",
    "not_a_file",
    "number",
    "numbers",
    "seconds",
    "text",
    "whole",
]

_T = TypeVar("_T")

DAY = 86_400.0
"""More seconds than this are no time that a program waits."""


def whole(name: str, value: SupportsIndex, least: int, most: int) -> int:
    """A whole number from ``least`` to ``most``.

    Raises ``TypeError`` for what is no whole number, truth values among it.
    """
    if isinstance(value, bool):
        raise TypeError(f"{name} is {value}; it takes a whole number")
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is {_shown(value)}; it takes a whole number") from None
    if not least <= found <= most:
        text = f"{name} is {found}; it takes a whole number from {least} to {most}"
        raise InvalidInputError(text, value=found, limit=least if found < least else most)
    return found


@overload
def number(
    name: str,
    value: float,
    *,
    above: float | None = None,
    least: float = -math.inf,
    most: float = math.inf,
    unit: str | None = None,
) -> float: ...
@overload
def number(
    name: str,
    value: float | None,
    *,
    above: float | None = None,
    least: float = -math.inf,
    most: float = math.inf,
    unit: str | None = None,
) -> float | None: ...
def number(
    name: str,
    value: float | None,
    *,
    above: float | None = None,
    least: float = -math.inf,
    most: float = math.inf,
    unit: str | None = None,
) -> float | None:
    """A number, neither NaN nor infinite: greater than ``above``, or at least ``least``, and at most ``most``.

    ``None`` is what is left out. Raises ``TypeError`` for what is not a number, texts and truth values among it.
    """
    if value is None:
        return None
    found = _real(name, value)
    low = least if above is None else above
    if math.isfinite(found) and found <= most and (found >= low if above is None else found > low):
        return found
    text = f"{name} is {_figure(found)}{_behind(unit)}; it takes {_range(above, least, most)}"
    limit = low if found <= low else most
    raise InvalidInputError(text, value=found, limit=limit if math.isfinite(limit) else None, unit=unit)


def checked(**values: float) -> list[float]:
    """Numbers, neither NaN nor infinite, each under its own name."""
    return [number(name, value) for name, value in values.items()]


def seconds(name: str, value: float, *, above: float | None = None, least: float = 0.0, most: float = DAY) -> float:
    """A time."""
    return number(name, value, above=above, least=least, most=most, unit="s")


def numbers(name: str, values: Iterable[float], count: int, *, unit: str | None = None) -> tuple[float, ...]:
    """So many numbers, neither NaN nor infinite."""
    try:
        found = None if isinstance(values, (str, bytes)) else tuple(values)
    except TypeError:
        found = None
    if found is None:
        raise TypeError(f"{name} is {_shown(values)}; it takes {count} numbers")
    if len(found) != count:
        raise InvalidInputError(f"{name} has {len(found)} numbers; it takes {count}", value=len(found), limit=count)
    return tuple(number(f"{name}[{nth}]", each, unit=unit) for nth, each in enumerate(found))


def flag(name: str, value: Any) -> bool:
    """True or False, 1 or 0, and NumPy's."""
    if isinstance(value, int) or type(value).__module__ == "numpy":
        with contextlib.suppress(ValueError):
            if value == 0 or value == 1:
                return bool(value)
    raise TypeError(f"{name} is {_shown(value)}; it takes True or False")


def flags(**values: bool) -> dict[str, bool]:
    """The same, each under its own name."""
    return {name: flag(name, value) for name, value in values.items()}


def ending(stay: bool, park: Iterable[float] | None, lift: float | None) -> dict[str, Any]:
    """What becomes of pen and arm at the end of a run."""
    asked = flags(stay=stay)
    if asked["stay"] and park is not None:
        raise InvalidInputError("stay leaves the pen where it is, and park takes it elsewhere: give one of them")
    return {
        **asked,
        "park": None if park is None else numbers("park", park, 3, unit="mm"),
        "lift": number("lift", lift, above=0, unit="mm"),
    }


def text(name: str, value: Any) -> Any:
    """A text, or ``None`` for what is left out."""
    if value is None or isinstance(value, str):
        return value
    raise TypeError(f"{name} is {_shown(value)}; it takes a text")


def as_json(name: str, value: Any) -> Any:
    """A value that JSON can say, of one that Python can: tuples, arrays, NumPy's numbers.

    A number that is none, or infinite, becomes its name, which is refused as every other text.
    """
    found: Any = value.tolist() if hasattr(value, "tolist") else value
    if found is None or isinstance(found, (str, bool)):
        return found
    if isinstance(found, Mapping):
        pairs: Mapping[Any, Any] = found  # pyright: ignore[reportUnknownVariableType]
        return {str(key): as_json(name, each) for key, each in pairs.items()}
    if hasattr(found, "__index__"):
        whole = operator.index(found)
        return whole if abs(whole) < 2**53 else as_json(name, _real(name, whole))
    if hasattr(found, "__float__"):
        real = _real(name, found)
        return real if math.isfinite(real) else str(real)
    if isinstance(found, Iterable) and not isinstance(found, (bytes, bytearray)):
        items: Iterable[Any] = found  # pyright: ignore[reportUnknownVariableType]
        return [as_json(name, each) for each in items]
    raise TypeError(f"{name} is {_shown(value)}; it takes no such value")


def hearing(value: Any) -> None:
    """Refuses what cannot be told of progress."""
    if value is not None and not isinstance(value, bool) and not callable(value):
        raise TypeError(f"progress is {_shown(value)}; it takes a function")


def addresses(name: str, values: Iterable[int]) -> list[int]:
    """The EIO addresses of some pins."""
    return [whole(f"{name}[{nth}]", each, 1, 20) for nth, each in enumerate(values)]


def _real(name: str, value: Any) -> float:
    convert: Callable[[], float] | None = getattr(value, "__float__", None) or getattr(value, "__index__", None)
    try:
        if convert is None or isinstance(value, bool):
            raise TypeError
        return float(value)
    except TypeError:
        raise TypeError(f"{name} is {_shown(value)}; it takes a number") from None
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def _shown(value: object) -> str:
    """A value and what it is, in short."""
    shown = repr(value)
    shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
    return shown if value is None or isinstance(value, bool) else f"{shown} ({type(value).__name__})"


def _figure(value: float) -> str:
    return f"{value:.12g}"


def _behind(unit: str | None) -> str:
    return f" {unit}" if unit else ""


def _range(above: float | None, least: float, most: float) -> str:
    if above is not None:
        return f"a number above {_figure(above)}" + (f", at most {_figure(most)}" if math.isfinite(most) else "")
    match math.isfinite(least), math.isfinite(most):
        case True, True:
            return f"a number from {_figure(least)} to {_figure(most)}"
        case True, False:
            return f"a number, {_figure(least)} or more"
        case False, True:
            return f"a number, {_figure(most)} or less"
        case _:
            return "a finite number"


def instance(name: str, value: object, kind: type[_T], hint: str) -> _T:
    """What is of this class."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} is {_shown(value)} ({type(value).__name__}); it takes a {kind.__name__}: {hint}")
    return value


def not_a_file(commands: Iterable[_T]) -> Iterable[_T]:
    """The commands, unless they are the name of a file: people try that."""
    if isinstance(commands, Command):
        raise TypeError(f"a program is commands in a list: [{type(commands).__name__}(...)]")
    if not hasattr(commands, "__iter__"):
        run = "arm.run(plan) runs a Plan" if type(commands).__name__ == "Plan" else "magician.words makes them"
        raise TypeError(f"a program is commands in a list, not {_shown(commands)}: {run}")
    if isinstance(commands, (str, os.PathLike)):
        raise TypeError(f"a program is a Plan, or commands: magician.load({os.fspath(commands)!r}) makes one of a file")
    return commands

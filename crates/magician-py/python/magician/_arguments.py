"""Validation of arguments. Errors name the argument of the caller."""

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
    "check_progress",
    "ending_options",
    "finite_numbers",
    "flag",
    "flags",
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
"""Largest accepted time, s."""


def whole(name: str, value: SupportsIndex, least: int, most: int) -> int:
    """Checks a whole number from ``least`` to ``most``.

    Raises ``TypeError`` for other types, including bool.
    """
    if isinstance(value, bool):
        raise TypeError(f"{name} is {value}; it takes a whole number")
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is {_described(value)}; it takes a whole number") from None
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
    """Checks a finite number: greater than ``above``, or at least ``least``, and at most ``most``.

    ``None`` stands for an omitted argument. Raises ``TypeError`` for other types, including str and bool.
    """
    if value is None:
        return None
    found = _real(name, value)
    low = least if above is None else above
    if math.isfinite(found) and found <= most and (found >= low if above is None else found > low):
        return found
    text = f"{name} is {_number_text(found)}{_unit_suffix(unit)}; it takes {_range(above, least, most)}"
    limit = low if found <= low else most
    raise InvalidInputError(text, value=found, limit=limit if math.isfinite(limit) else None, unit=unit)


def finite_numbers(**values: float) -> list[float]:
    """Checks finite numbers, each under its own name."""
    return [number(name, value) for name, value in values.items()]


def seconds(name: str, value: float, *, above: float | None = None, least: float = 0.0, most: float = DAY) -> float:
    """Checks a time, s."""
    return number(name, value, above=above, least=least, most=most, unit="s")


def numbers(name: str, values: Iterable[float], count: int, *, unit: str | None = None) -> tuple[float, ...]:
    """Checks a sequence of finite numbers with the given length."""
    try:
        found = None if isinstance(values, (str, bytes)) else tuple(values)
    except TypeError:
        found = None
    if found is None:
        raise TypeError(f"{name} is {_described(values)}; it takes {count} numbers")
    if len(found) != count:
        raise InvalidInputError(f"{name} has {len(found)} numbers; it takes {count}", value=len(found), limit=count)
    return tuple(number(f"{name}[{nth}]", each, unit=unit) for nth, each in enumerate(found))


def flag(name: str, value: Any) -> bool:
    """Checks a bool: True or False, 1 or 0, or a NumPy bool."""
    if isinstance(value, int) or type(value).__module__ == "numpy":
        with contextlib.suppress(ValueError):
            if value == 0 or value == 1:
                return bool(value)
    raise TypeError(f"{name} is {_described(value)}; it takes True or False")


def flags(**values: bool) -> dict[str, bool]:
    """Checks bools, each under its own name."""
    return {name: flag(name, value) for name, value in values.items()}


def ending_options(stay: bool, park: Iterable[float] | None, lift: float | None) -> dict[str, Any]:
    """Checks the options for pen and arm at the end of a run."""
    asked = flags(stay=stay)
    if asked["stay"] and park is not None:
        raise InvalidInputError("stay leaves the pen where it is, and park takes it elsewhere: give one of them")
    return {
        **asked,
        "park": None if park is None else numbers("park", park, 3, unit="mm"),
        "lift": number("lift", lift, above=0, unit="mm"),
    }


def text(name: str, value: Any) -> Any:
    """Checks a string; ``None`` stands for an omitted argument."""
    if value is None or isinstance(value, str):
        return value
    raise TypeError(f"{name} is {_described(value)}; it takes a text")


def as_json(name: str, value: Any) -> Any:
    """Converts tuples, arrays and NumPy numbers to values for JSON.

    NaN and infinity become their names, which are refused like any other string.
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
    raise TypeError(f"{name} is {_described(value)}; it takes no such value")


def check_progress(value: Any) -> None:
    """Checks a progress argument."""
    if value is not None and not isinstance(value, bool) and not callable(value):
        raise TypeError(f"progress is {_described(value)}; it takes a function")


def addresses(name: str, values: Iterable[int]) -> list[int]:
    """Returns the EIO addresses of pins."""
    return [whole(f"{name}[{nth}]", each, 1, 20) for nth, each in enumerate(values)]


def _real(name: str, value: Any) -> float:
    convert: Callable[[], float] | None = getattr(value, "__float__", None) or getattr(value, "__index__", None)
    try:
        if convert is None or isinstance(value, bool):
            raise TypeError
        return float(value)
    except TypeError:
        raise TypeError(f"{name} is {_described(value)}; it takes a number") from None
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def _described(value: object) -> str:
    """Describes a value and its type, abbreviated."""
    shown = repr(value)
    shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
    return shown if value is None or isinstance(value, bool) else f"{shown} ({type(value).__name__})"


def _number_text(value: float) -> str:
    return f"{value:.12g}"


def _unit_suffix(unit: str | None) -> str:
    return f" {unit}" if unit else ""


def _range(above: float | None, least: float, most: float) -> str:
    if above is not None:
        return f"a number above {_number_text(above)}" + (
            f", at most {_number_text(most)}" if math.isfinite(most) else ""
        )
    match math.isfinite(least), math.isfinite(most):
        case True, True:
            return f"a number from {_number_text(least)} to {_number_text(most)}"
        case True, False:
            return f"a number, {_number_text(least)} or more"
        case False, True:
            return f"a number, {_number_text(most)} or less"
        case _:
            return "a finite number"


def instance(name: str, value: object, kind: type[_T], hint: str) -> _T:
    """Checks that a value is an instance of this class."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} is {_described(value)} ({type(value).__name__}); it takes a {kind.__name__}: {hint}")
    return value


def not_a_file(commands: Iterable[_T]) -> Iterable[_T]:
    """Refuses a file name passed in place of commands, a common mistake."""
    if isinstance(commands, Command):
        raise TypeError(f"a program is commands in a list: [{type(commands).__name__}(...)]")
    if not hasattr(commands, "__iter__"):
        run = "arm.run(plan) runs a Plan" if type(commands).__name__ == "Plan" else "magician.words makes them"
        raise TypeError(f"a program is commands in a list, not {_described(commands)}: {run}")
    if isinstance(commands, (str, os.PathLike)):
        raise TypeError(f"a program is a Plan, or commands: magician.load({os.fspath(commands)!r}) makes one of a file")
    return commands

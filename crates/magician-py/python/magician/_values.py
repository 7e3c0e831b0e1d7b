"""Base of immutable value classes with named fields.

They behave like ``dataclass(frozen=True, slots=True)`` without its import cost: dataclass generates and executes code
for each class, which for a hundred classes takes as long as the rest of the import.
"""

# pyright: reportPrivateUsage=false

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from inspect import Signature

    from typing_extensions import Self, dataclass_transform
else:

    def dataclass_transform(**_how: object) -> Callable[[Any], Any]:
        """For type checkers."""
        return lambda made: made


__all__ = ["Value", "ValueType", "fields"]


@dataclass_transform(frozen_default=True)
class ValueType(type):
    """Creates a class from the fields of its body, in order, after those of its bases."""

    _fields: tuple[str, ...]
    _defaults: dict[str, Any]
    _setters: tuple[Callable[[Any, Any], None], ...]

    def __new__(cls, name: str, bases: tuple[type, ...], body: dict[str, Any], **how: Any) -> ValueType:
        hints: dict[str, str] = body.get("__annotations__", {})
        own = [each for each, hint in hints.items() if "ClassVar" not in str(hint)]
        defaults = {each: body.pop(each) for each in own if each in body}
        base = next((each for each in bases if isinstance(each, ValueType) and each._fields), None)
        body["__slots__"] = tuple(own)
        body["__match_args__"] = body["_fields"] = (*(base._fields if base else ()), *own)
        body["_defaults"] = {**(base._defaults if base else {}), **defaults}
        made = super().__new__(cls, name, bases, body, **how)
        made._setters = tuple(getattr(made, each).__set__ for each in made._fields)
        return made

    @property
    def __signature__(cls) -> Signature:
        from inspect import Parameter, Signature

        kind, none = Parameter.POSITIONAL_OR_KEYWORD, Parameter.empty
        hints = _hints(cls)
        return Signature(
            [
                Parameter(each, kind, default=cls._defaults.get(each, none), annotation=hints[each])
                for each in cls._fields
            ]
        )


class _OfDataclass:
    """Metadata for the functions of ``dataclasses`` (``fields``, ``asdict``, ``replace``), created on first use."""

    def __set_name__(self, _owner: type, name: str) -> None:
        self._name = name

    def __get__(self, _value: object, cls: ValueType) -> Any:
        if not cls._fields and not hasattr(cls, "LAYOUT"):
            raise AttributeError(f"{cls.__name__} has no fields")
        from dataclasses import field, make_dataclass

        hints = _hints(cls)
        made: list[Any] = [
            (name, hints[name], field(default=cls._defaults[name])) if name in cls._defaults else (name, hints[name])
            for name in cls._fields
        ]
        return getattr(make_dataclass(cls.__name__, made, frozen=True), self._name)


class Value(metaclass=ValueType):
    """Immutable value with named fields, which define comparison, hash, repr, pattern matching, copy and pickle."""

    if not TYPE_CHECKING:
        __dataclass_fields__ = _OfDataclass()
        __dataclass_params__ = _OfDataclass()

    def __init__(self, *values: Any, **named: Any) -> None:
        cls = type(self)
        if named or len(values) != len(cls._setters):
            values = _complete(cls, values, named)
        for put, value in zip(cls._setters, values, strict=True):
            put(self, value)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash(tuple(_values(self)))

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={value!r}" for name, value in zip(type(self)._fields, _values(self), strict=True))
        return f"{type(self).__qualname__}({shown})"

    def __setattr__(self, name: str, value: object) -> NoReturn:
        _frozen(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> NoReturn:
        _frozen(f"cannot delete field {name!r}")

    def __getstate__(self) -> list[Any]:
        return _values(self)

    def __setstate__(self, state: Iterable[Any]) -> None:
        for put, value in zip(type(self)._setters, state, strict=True):
            put(self, value)

    def __replace__(self, **changes: Any) -> Self:
        return type(self)(**{**dict(zip(type(self)._fields, _values(self), strict=True)), **changes})


def fields(cls: type[Value]) -> dict[str, bool]:
    """Returns the fields of a class, each with True if it is optional."""
    return {name: name in cls._defaults for name in cls._fields}


def _values(value: Value) -> list[Any]:
    return [getattr(value, name) for name in type(value)._fields]


def _complete(cls: ValueType, values: tuple[Any, ...], named: dict[str, Any]) -> tuple[Any, ...]:
    """Combines given values with the defaults of omitted ones."""
    names = cls._fields
    if len(values) > len(names):
        raise TypeError(f"{cls.__name__}() takes {len(names)} values, and {len(values)} were given")
    given = dict(zip(names, values, strict=False))
    for name, value in named.items():
        if name in given:
            raise TypeError(f"{cls.__name__}() got multiple values for {name!r}")
        if name not in names:
            raise TypeError(f"{cls.__name__}() has no field {name!r}; it has {', '.join(names) or 'none'}")
        given[name] = value
    given = {**cls._defaults, **given}
    missing = [name for name in names if name not in given]
    if missing:
        raise TypeError(f"{cls.__name__}() takes {', '.join(missing)} as well")
    return tuple(given[name] for name in names)


def _frozen(message: str) -> NoReturn:
    from dataclasses import FrozenInstanceError

    raise FrozenInstanceError(message)


def _hints(cls: type) -> dict[str, str]:
    return {
        name: hint for each in reversed(cls.__mro__) for name, hint in vars(each).get("__annotations__", {}).items()
    }

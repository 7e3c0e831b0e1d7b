"""Base classes of all commands, by the operations that they support."""

from __future__ import annotations

from enum import IntEnum
from typing import ClassVar, Generic, TypeVar

from . import _magician
from ._values import Value

__all__ = ["Answer", "Command", "OpenEnum", "Query", "Queueable", "Readable", "Writable"]

C = TypeVar("C", bound="Command")
A_co = TypeVar("A_co", bound="Command", covariant=True)


class OpenEnum(IntEnum):
    """Named values of a byte. Values without a name are accepted, as ``UNKNOWN_n``."""

    def __repr__(self) -> str:
        # A form that can be typed in again.
        named = self.name in type(self).__members__
        return f"{type(self).__name__}.{self.name}" if named else f"{type(self).__name__}({int(self)})"

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        # Defined here because their defaults differ between Python 3.10 and later versions.
        return format(int(self), spec) if spec else str(self)

    def __reduce_ex__(self, protocol: object) -> tuple[type[OpenEnum], tuple[int]]:
        # Early Python 3.11 looks up the name, which is an attribute of the class only for named values.
        return type(self), (int(self),)

    @classmethod
    def _missing_(cls, value: object) -> OpenEnum | None:
        if not isinstance(value, int) or not 0 <= value <= 0xFF:
            return None
        unknown = int.__new__(cls, value)
        unknown._name_ = f"UNKNOWN_{int(value)}"
        unknown._value_ = int(value)
        # Cache it, so that equal numbers are one object, also after pickling or copying.
        return cls._value2member_map_.setdefault(int(value), unknown)  # type: ignore[return-value]


class Command(Value):
    """The fields of a command, as attributes."""

    ID: ClassVar[int]
    """Id in the frame."""
    LAYOUT: ClassVar[str]
    """Name of the layout in the protocol's table, and of the class."""

    def __bytes__(self) -> bytes:
        """Encoded parameters, without the frame."""
        return _magician.encode(self)

    @classmethod
    def from_bytes(cls: type[C], params: bytes) -> C:
        """Decodes a command from its parameters, in any form that the arm accepts.

        Raises :class:`~magician.errors.UnexpectedError` if there are too few, or they match no form.
        """
        return _magician.decode(cls, params)


class Answer(Command):
    """Answer of the arm to a query: see :class:`Query`."""


class Readable(Answer):
    """A value that can be read by its class: ``arm.get(commands.Pose)``."""


class Query(Command, Generic[A_co]):
    """Query for a pin, a port or a target: ``arm.get(commands.GetIoDi(address=19))``."""


class Writable(Command):
    """A value or an action that can be set at once: ``arm.set(...)``."""


class Queueable(Writable):
    """Command that can also be queued: ``arm.enqueue(...)``, ``arm.perform([...])``."""

"""Exceptions of this package, by kind.

Every exception of this package is an :class:`Error`. The class is the kind. The text names the command and, if a limit
is broken, the value and the limit; the attributes hold them as numbers. Kinds with a Python equivalent derive from it
too: an :class:`UnreachableError` is a ``ValueError``, a :class:`ResponseTimeoutError` a ``TimeoutError``, a
:class:`PortError` an ``OSError``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .alarms import Alarm

__all__ = [
    "AlarmError",
    "BusyError",
    "CheckFailedError",
    "ClosedError",
    "DangerousError",
    "Error",
    "ForbiddenError",
    "InvalidInputError",
    "LeaseError",
    "PortError",
    "QueueFullError",
    "ResponseTimeoutError",
    "StationError",
    "StoppedError",
    "TooManyError",
    "UncertainError",
    "UnexpectedError",
    "UnreachableError",
    "UnsupportedError",
]


class Error(Exception):
    """Base class of all exceptions of this package."""

    kind: str = "bug"
    """Name of the kind, the same as on the command line: ``"queue-full"``."""

    code: str
    """Error code, such as ``"not-homed"``: finer than the kind, and as stable. It distinguishes a stop (``"stopped"``)
    from a closed connection (``"closed"``).
    """

    step: int | None
    """Index of the command in the list passed by the caller, from 0, or ``None``."""

    remedies: tuple[str, ...]
    """Names of the remedies, best first: ``("home", "unhomed")``. The text of the error explains them."""

    def __init__(
        self,
        message: str,
        *,
        code: str | None = None,
        step: int | None = None,
        remedies: Sequence[str] = (),
        command: str | None = None,
        value: float | None = None,
        limit: float | None = None,
        unit: str | None = None,
        from_index: int | None = None,
        to_index: int | None = None,
        alarms: Sequence[int] | None = None,
        station: str | None = None,
    ) -> None:
        super().__init__(message)
        self.code = self.kind if code is None else code
        self.step = step
        self.remedies = tuple(remedies)
        self.command = command
        """Vendor name of the command concerned, or ``None``."""
        self.value = value
        """The value out of range, or ``None``."""
        self.limit = limit
        """The limit for the value, or ``None``."""
        self.unit = unit
        """Unit of value and limit, or ``None``."""
        self.from_index = from_index
        """First queue index whose execution is uncertain, or ``None``."""
        self.to_index = to_index
        """Last queue index whose execution is uncertain, or ``None``."""
        self.alarms = None if alarms is None else tuple(Alarm(code) for code in alarms)
        """Active alarms, or ``None``. Empty if the alarm was cleared but its effect still holds the queue.
        """
        self.station = station
        """Address of the local station that has the port open, or ``None``:
        ``magician.Station(error.station)`` uses the arm through it.
        """

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), *self.args), self.__dict__


def _again(cls: type[Error], message: str) -> Error:
    return cls(message)


class InvalidInputError(Error, ValueError):
    """The request is invalid: a NaN, an unknown name, a queue that belongs to another program."""

    kind = "invalid-input"


class UnreachableError(Error, ValueError):
    """The target or the path is out of the arm's reach."""

    kind = "unreachable"


class PortError(Error, OSError):
    """The port does not exist, access is denied, it is in use, or the line was lost."""

    kind = "port"


class ResponseTimeoutError(Error, TimeoutError):
    """No answer arrived before the deadline."""

    kind = "timeout"


class UnexpectedError(Error):
    """The peer sent an unexpected answer."""

    kind = "unexpected"


class UnsupportedError(Error):
    """This build, system or peer does not support the request."""

    kind = "unsupported"


class QueueFullError(Error):
    """The arm's queue is full."""

    kind = "queue-full"


class AlarmError(Error):
    """An active alarm holds the queue: see :attr:`Error.alarms`."""

    kind = "alarm"


class UncertainError(Error):
    """The outcome of a command is uncertain: see :attr:`Error.from_index` and :attr:`Error.to_index`."""

    kind = "uncertain"


class ClosedError(Error):
    """The connection was closed, or a stop cancelled the request."""

    kind = "closed"


class StationError(Error):
    """A station refused a request: see :class:`magician.Station`."""

    kind = "station"

    def __init__(self, message: str, *, data: Mapping[str, Any] | None = None, **parts: Any) -> None:
        super().__init__(message, **parts)
        self.data = dict(data or {})
        """Details from the station, by name."""


class LeaseError(StationError):
    """The session does not hold the lease needed to move the arm: another session has it (``data["holder"]``), or it
    expired."""

    kind = "lease"


class ForbiddenError(StationError):
    """The role of the session does not permit the request."""

    kind = "forbidden"


class BusyError(StationError):
    """A job or a jog is using the arm."""

    kind = "busy"


class CheckFailedError(StationError):
    """The check of a program failed, and nothing was sent: see ``data["report"]``."""

    kind = "check-failed"


class DangerousError(StationError):
    """The request is dangerous or may burn on a real arm, and ``yes=True`` was not given."""

    kind = "dangerous"


class TooManyError(StationError):
    """A session exceeded its limit of requests."""

    kind = "too-many"


class StoppedError(StationError):
    """A stop cancelled the request."""

    kind = "stopped"

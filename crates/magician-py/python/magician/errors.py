"""What can go wrong, sorted by whose problem it is.

Every exception of this package is an :class:`Error`. Its class is the kind, its text names the command and both values
where it is a matter of how much, and its attributes have them as numbers. Kinds that Python has too are caught as such
as well: an :class:`UnreachableError` is a ``ValueError``, a :class:`ResponseTimeoutError` a ``TimeoutError``, a
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
    """Something could not be done."""

    kind: str = "bug"
    """Name of the kind, as on the command line: ``"queue-full"``."""

    code: str
    """Which error it is: ``"not-homed"``. Finer than the kind, and as stable. A stop (``"stopped"``) is apart from a
    connection that is closed (``"closed"``).
    """

    step: int | None
    """The place of the command in the list that it came in, from 0, or ``None``."""

    remedies: tuple[str, ...]
    """What to do about it, the best first, by name: ``("home", "unhomed")``. The text says it in words."""

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
        """The command it is about, as the vendor calls it, or ``None``."""
        self.value = value
        """The value that was too much or too little, or ``None``."""
        self.limit = limit
        """What it may be, or ``None``."""
        self.unit = unit
        """Unit of both, or ``None``."""
        self.from_index = from_index
        """First queue index in doubt, or ``None``."""
        self.to_index = to_index
        """Last queue index in doubt, or ``None``."""
        self.alarms = None if alarms is None else tuple(Alarm(code) for code in alarms)
        """The alarms that stand, or ``None``. None of them when an alarm has gone and what is left of it holds the
        queue.
        """
        self.station = station
        """Address of the station of this computer that has the port, or ``None``:
        ``magician.Station(error.station)`` uses the arm through it.
        """

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), *self.args), self.__dict__


def _again(cls: type[Error], message: str) -> Error:
    return cls(message)


class InvalidInputError(Error, ValueError):
    """The request makes no sense: a NaN, a wrong name, a queue that belongs to another program."""

    kind = "invalid-input"


class UnreachableError(Error, ValueError):
    """The arm cannot get there."""

    kind = "unreachable"


class PortError(Error, OSError):
    """The port is not there, not allowed, in use, or gone."""

    kind = "port"


class ResponseTimeoutError(Error, TimeoutError):
    """No answer by the deadline."""

    kind = "timeout"


class UnexpectedError(Error):
    """The peer answered what it should not."""

    kind = "unexpected"


class UnsupportedError(Error):
    """This build or this peer cannot do it."""

    kind = "unsupported"


class QueueFullError(Error):
    """The arm's queue has no room."""

    kind = "queue-full"


class AlarmError(Error):
    """An alarm stands that holds the queue; :attr:`Error.alarms` says which."""

    kind = "alarm"


class UncertainError(Error):
    """A command may or may not have been taken; :attr:`Error.from_index` and :attr:`Error.to_index` say which."""

    kind = "uncertain"


class ClosedError(Error):
    """The connection has been closed, or a stop came first."""

    kind = "closed"


class StationError(Error):
    """A station refuses a request: :class:`magician.Station`."""

    kind = "station"

    def __init__(self, message: str, *, data: Mapping[str, Any] | None = None, **parts: Any) -> None:
        super().__init__(message, **parts)
        self.data = dict(data or {})
        """What the station says about it, by name."""


class LeaseError(StationError):
    """Moving the arm needs its lease: another session has it (``data["holder"]``), or it has ended."""

    kind = "lease"


class ForbiddenError(StationError):
    """The role of the session does not allow it."""

    kind = "forbidden"


class BusyError(StationError):
    """A job or a jog has the arm."""

    kind = "busy"


class CheckFailedError(StationError):
    """The arm cannot do all of a program, and nothing was sent: ``data["report"]``."""

    kind = "check-failed"


class DangerousError(StationError):
    """It is dangerous or may burn on a real arm, and ``yes=True`` was not given."""

    kind = "dangerous"


class TooManyError(StationError):
    """More than a session may ask for."""

    kind = "too-many"


class StoppedError(StationError):
    """A stop came first."""

    kind = "stopped"

"""Conversion of native results to values and exceptions of this package."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from .alarms import Alarm
from .errors import (
    AlarmError,
    BusyError,
    CheckFailedError,
    ClosedError,
    DangerousError,
    Error,
    ForbiddenError,
    InvalidInputError,
    LeaseError,
    PortError,
    QueueFullError,
    ResponseTimeoutError,
    StationError,
    StoppedError,
    TooManyError,
    UncertainError,
    UnexpectedError,
    UnreachableError,
    UnsupportedError,
)
from .events import (
    AlarmCleared,
    AlarmRaised,
    CommandFinished,
    Event,
    LinkFound,
    LinkLost,
    Missed,
    Reset,
    Unaccounted,
)
from .readings import Link, Status

if TYPE_CHECKING:
    from ._protocol import Command
    from .traffic import Decoded

_ERRORS: dict[str, type[Error]] = {
    each.kind: each
    for each in (
        InvalidInputError,
        UnreachableError,
        PortError,
        ResponseTimeoutError,
        UnexpectedError,
        UnsupportedError,
        QueueFullError,
        AlarmError,
        UncertainError,
        ClosedError,
    )
}


def error(
    kind: str,
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
) -> Error:
    """Creates the exception for a kind."""
    return _ERRORS.get(kind, Error)(
        message,
        code=code,
        step=step,
        remedies=remedies,
        command=command,
        value=value,
        limit=limit,
        unit=unit,
        from_index=from_index,
        to_index=to_index,
        alarms=alarms,
        station=station,
    )


_REFUSALS: dict[str, type[StationError]] = {
    each.kind: each
    for each in (
        LeaseError,
        ForbiddenError,
        BusyError,
        CheckFailedError,
        DangerousError,
        TooManyError,
        StoppedError,
    )
}


def refused(code: int, message: str, data: str | None) -> Error:
    """Creates the exception for a station's error; code 0 stands for a lost or failed connection."""
    import json

    if code == 0:
        return PortError(message)
    if code == -32602:
        return InvalidInputError(message)
    if code == -32601:
        return UnsupportedError(message)
    about: dict[str, Any] = (json.loads(data) if data else None) or {}
    return failure(message, about)


def failure(message: str, about: dict[str, Any]) -> Error:
    """Creates the exception for a station's error from its details."""
    kind = about.get("kind", "unexpected")
    if kind in _REFUSALS:
        return _REFUSALS[kind](message, data=about)
    steps = about.get("step")
    return error(
        kind,
        message,
        code=about.get("code"),
        step=None if steps is None else steps - 1,
        command=about.get("command"),
        value=about.get("value"),
        limit=about.get("limit"),
        unit=about.get("unit"),
        from_index=about.get("from"),
        to_index=about.get("to"),
        alarms=about.get("alarms"),
        station=about.get("station"),
    )


_EVENTS: dict[str, type[Event]] = {
    each.__name__: each
    for each in (AlarmRaised, AlarmCleared, CommandFinished, LinkLost, LinkFound, Reset, Unaccounted, Missed)
}


def event(parts: tuple[str, tuple[Any, ...]]) -> Event:
    """Converts an event."""
    name, fields = parts
    kind = _EVENTS[name]
    if kind is AlarmRaised or kind is AlarmCleared:
        return kind(Alarm(fields[0]))
    return kind(*fields)


def link(parts: tuple[Any, ...]) -> Link:
    """Converts the state of the line."""
    state, why, sought, ago = parts
    return Link(state, why, sought, time.monotonic() - ago if state == "lost" else None)


def status(parts: tuple[Any, ...]) -> Status:
    """Converts a reading of the arm's state."""
    pose, current, space, alarms, line, ago, inputs, outputs, analogs = parts
    return Status(
        pose,
        current,
        space,
        alarms,
        link(line),
        time.monotonic() - ago,
        {address: level != 0 for address, level in inputs},
        {address: level != 0 for address, level in outputs},
        dict(analogs),
    )


def decoded(
    seen: tuple[int, bytes, str | None, float | None],
    form: tuple[int, str, Literal["request", "reply"]],
    flags: tuple[bool, bool],
    carried: tuple[Command | None, int | None, bytes],
    notes: tuple[str, ...],
) -> Decoded:
    """Converts a decoded frame."""
    from .traffic import Decoded

    offset, data, link, at = seen
    id, command, direction = form
    write, queued = flags
    value, index, params = carried
    return Decoded(offset, data, id, command, direction, write, queued, value, index, params, notes, link, at)

"""Events of an arm: ``for event in arm.events()``."""

from __future__ import annotations

from ._values import Value
from .alarms import Alarm

__all__ = [
    "AlarmCleared",
    "AlarmRaised",
    "CommandFinished",
    "Event",
    "LinkFound",
    "LinkLost",
    "Missed",
    "Reset",
    "Unaccounted",
]


class AlarmRaised(Value):
    """An alarm became active since the alarms were last read."""

    alarm: Alarm
    """The alarm, with its cause and remedy."""


class AlarmCleared(Value):
    """An alarm was cleared."""

    alarm: Alarm
    """The alarm."""


class CommandFinished(Value):
    """Queued commands of any program finished: one, or all between two readings of the queue index."""

    first: int
    """Queue index of the first command."""
    last: int
    """Queue index of the last command."""


class LinkLost(Value):
    """The line to the arm was lost."""

    why: str
    """The cause, in a sentence."""


class LinkFound(Value):
    """The driver reconnected to the same arm."""

    reset: bool
    """True if the arm was reset meanwhile, so its queue is empty. A :class:`Reset` event precedes this one."""


class Reset(Value):
    """The arm was reset, or switched off and on."""

    first: int | None
    """Queue index of the first unfinished command of this connection; ``None`` if all had finished."""
    last: int | None
    """Queue index of the last unfinished command of this connection; ``None`` if all had finished."""


class Unaccounted(Value):
    """The arm accepted more commands than this connection sent: a frame was duplicated, or another program uses the
    arm."""

    first: int
    """First queue index."""
    last: int
    """Last queue index."""


class Missed(Value):
    """The listener fell behind, and the oldest events were dropped."""

    count: int
    """Number of dropped events."""


Event = AlarmRaised | AlarmCleared | CommandFinished | LinkLost | LinkFound | Reset | Unaccounted | Missed
"""Any event of this module."""

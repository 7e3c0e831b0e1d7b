"""What happens at an arm: ``for event in arm.events()``."""

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
    """An alarm stands that did not at the last reading."""

    alarm: Alarm
    """Which one, with its cause and its cure."""


class AlarmCleared(Value):
    """An alarm stands no more."""

    alarm: Alarm
    """Which one."""


class CommandFinished(Value):
    """Queued commands have finished, from any program: one, or all from first to last between two readings."""

    first: int
    """Queue index of the first."""
    last: int
    """Queue index of the last."""


class LinkLost(Value):
    """The line broke."""

    why: str
    """How, in a sentence."""


class LinkFound(Value):
    """The line is back, and the same arm is at it."""

    reset: bool
    """The arm was reset meanwhile: what was in its queue is gone. A :class:`Reset` went before."""


class Reset(Value):
    """The arm was switched off and on, or reset."""

    first: int | None
    """Queue index of the first command that this connection had queued and that had not finished, or ``None``."""
    last: int | None
    """Queue index of the last one, or ``None``."""


class Unaccounted(Value):
    """The arm has taken more commands than this connection sent: one was doubled, or it is in other hands too."""

    first: int
    """First queue index."""
    last: int
    """Last queue index."""


class Missed(Value):
    """Events were not read for so long that the oldest were dropped."""

    count: int
    """How many."""


Event = AlarmRaised | AlarmCleared | CommandFinished | LinkLost | LinkFound | Reset | Unaccounted | Missed
"""Anything that happens."""

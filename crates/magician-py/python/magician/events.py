"""What happens at an arm: ``for event in arm.events()``."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True)
class AlarmRaised:
    """An alarm stands that did not at the last reading."""

    alarm: Alarm
    """Which one, with its cause and its cure."""


@dataclass(frozen=True, slots=True)
class AlarmCleared:
    """An alarm stands no more."""

    alarm: Alarm
    """Which one."""


@dataclass(frozen=True, slots=True)
class CommandFinished:
    """Queued commands have finished, from any program: one, or all from first to last between two readings."""

    first: int
    """Queue index of the first."""
    last: int
    """Queue index of the last."""


@dataclass(frozen=True, slots=True)
class LinkLost:
    """The line broke."""

    why: str
    """How, in a sentence."""


@dataclass(frozen=True, slots=True)
class LinkFound:
    """The line is back, and the same arm is at it."""

    reset: bool
    """The arm was reset meanwhile: what was in its queue is gone. A :class:`Reset` went before."""


@dataclass(frozen=True, slots=True)
class Reset:
    """The arm was switched off and on, or reset."""

    first: int | None
    """Queue index of the first command that this connection had queued and that had not finished, or ``None``."""
    last: int | None
    """Queue index of the last one, or ``None``."""


@dataclass(frozen=True, slots=True)
class Unaccounted:
    """The arm has taken more commands than this connection sent: one was doubled, or it is in other hands too."""

    first: int
    """First queue index."""
    last: int
    """Last queue index."""


@dataclass(frozen=True, slots=True)
class Missed:
    """Events were not read for so long that the oldest were dropped."""

    count: int
    """How many."""


Event = AlarmRaised | AlarmCleared | CommandFinished | LinkLost | LinkFound | Reset | Unaccounted | Missed
"""Anything that happens."""

"""Readings: the arm's identity, its state, and the results of runs."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ._magician import draw_arm
from ._meaning import Color, Joints, Position
from ._values import Value
from .alarms import Alarm
from .commands import Pose

__all__ = ["Color", "Info", "Joints", "Link", "Pose", "Position", "Progress", "Ran", "Stats", "Status"]


class Link(Value):
    """Whether there is a line to the arm."""

    state: Literal["up", "lost", "closed"]
    """``"up"``, ``"lost"`` (it broke) or ``"closed"`` (the connection has ended)."""
    why: str | None = None
    """What is wrong with a lost one, in a sentence."""
    sought: bool = False
    """Whether a lost one is looked for again."""
    since: float | None = None
    """When a lost one broke, in the seconds of :func:`time.monotonic`."""

    def __bool__(self) -> bool:
        """Whether it is up."""
        return self.state == "up"


class Status(Value):
    """The state of an arm as it was read last."""

    pose: Pose
    """Where the tool is, and the joints."""
    current_index: int
    """The queued command that was finished last."""
    left_space: int
    """Free places in the queue."""
    alarms: tuple[Alarm, ...]
    """The alarms that stand."""
    link: Link
    """Whether there is a line; while there is none the rest is of before."""
    time: float
    """When the pose was read, in the seconds of :func:`time.monotonic`. The rest was read within one period of it."""
    inputs: dict[int, bool]
    """Levels of the digital inputs that somebody watches, by EIO address."""
    outputs: dict[int, bool]
    """Levels of the digital outputs that somebody watches, by EIO address."""
    analogs: dict[int, int]
    """Counts (0 to 4095, 4095 at 3.3 V) of the analog inputs that somebody watches, by EIO address."""

    def _repr_svg_(self) -> str:
        facts = [f"queue index {self.current_index} finished", f"{self.left_space} places free"]
        if not self.link:
            facts.append(f"the line is {self.link.state}")
        return draw_arm("Arm", self.pose.position, self.pose.joints, self.alarms, facts).svg


class Progress(NamedTuple):
    """How far a wait or a run has come."""

    current: int
    """Index of the queued command that was finished last."""
    last: int
    """Index of the last command that was put into the queue, or that is waited for."""
    sent: int
    """Commands that this run has put into the queue."""
    total: int | None
    """Commands that this run has in all, when that is known."""
    silent: float = 0.0
    """How long the arm has not answered while a run waits for it, seconds; 0 as long as it answers."""


class Ran(NamedTuple):
    """The result of a run."""

    commands: int
    """How many commands the arm took and finished."""
    first: int | None
    """Queue index of the first."""
    last: int | None
    """Queue index of the last."""


class Stats(NamedTuple):
    """Counts of the traffic on the line so far."""

    sent: int
    """Frames sent."""
    resent: int
    """Frames sent again."""
    bytes: int
    """Bytes received."""
    frames: int
    """Whole frames received."""
    late: int
    """Frames that came too late and were dropped."""
    unsolicited: int
    """Frames nobody had asked for."""
    noise: int
    """Damaged frames and runs of foreign bytes."""
    capacity: int
    """How many commands the arm's queue holds."""


class Info(Value):
    """The identity of an arm."""

    port: str
    """What the connection is called."""
    name: str
    """Name of the arm."""
    serial_number: str
    """Serial number of the arm."""
    firmware: str
    """Version of the controller's firmware: ``"3.6.5"``."""
    processor_id: tuple[int, int, int] | None
    """Unique id of the controller's processor; older firmware has none to tell."""
    uptime: float
    """Seconds since the controller was switched on; they begin anew after 49 days."""
    rail: bool
    """Whether it stands on a sliding rail that is in use."""
    laser: bool | None = None
    """Whether the laser is on; ``None`` where the arm does not say."""

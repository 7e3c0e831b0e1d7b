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
    """State of the line to the arm."""

    state: Literal["up", "lost", "closed"]
    """``"up"``, ``"lost"`` (it broke) or ``"closed"`` (the connection has ended)."""
    why: str | None = None
    """Why the line was lost, in a sentence."""
    sought: bool = False
    """True if a lost line is reconnected automatically."""
    since: float | None = None
    """When the line was lost, s of :func:`time.monotonic`."""

    def __bool__(self) -> bool:
        """True if the line is up."""
        return self.state == "up"


class Status(Value):
    """Latest reading of an arm's state."""

    pose: Pose
    """Pose of the tool, and joint angles."""
    current_index: int
    """Index of the last finished queued command."""
    left_space: int
    """Free places in the queue."""
    alarms: tuple[Alarm, ...]
    """Active alarms."""
    link: Link
    """State of the line. While it is lost the other values are the last ones read."""
    time: float
    """When the pose was read, s of :func:`time.monotonic`. The other values were read within one period of it."""
    inputs: dict[int, bool]
    """Levels of the watched digital inputs, by EIO address."""
    outputs: dict[int, bool]
    """Levels of the watched digital outputs, by EIO address."""
    analogs: dict[int, int]
    """Counts (0 to 4095, 4095 at 3.3 V) of the watched analog inputs, by EIO address."""

    def _repr_svg_(self) -> str:
        facts = [f"queue index {self.current_index} finished", f"{self.left_space} places free"]
        if not self.link:
            facts.append(f"the line is {self.link.state}")
        return draw_arm("Arm", self.pose.position, self.pose.joints, self.alarms, facts).svg


class Progress(NamedTuple):
    """Progress of a wait or a run."""

    current: int
    """Index of the last finished queued command."""
    last: int
    """Index of the last command that was queued, or that the wait is for."""
    sent: int
    """Number of commands that this run has queued."""
    total: int | None
    """Total number of commands of this run, or ``None`` if it is unknown."""
    silent: float = 0.0
    """Time since the arm last answered while a run waits for it, s; 0 while it answers."""


class Ran(NamedTuple):
    """The result of a run."""

    commands: int
    """Number of commands that the arm finished."""
    first: int | None
    """Queue index of the first command."""
    last: int | None
    """Queue index of the last command."""


class Stats(NamedTuple):
    """Traffic counters of the line."""

    sent: int
    """Frames sent."""
    resent: int
    """Frames retransmitted."""
    bytes: int
    """Bytes received."""
    frames: int
    """Whole frames received."""
    late: int
    """Late replies that were dropped."""
    unsolicited: int
    """Unsolicited frames."""
    noise: int
    """Damaged frames, and sequences of bytes that are no frame."""
    capacity: int
    """Capacity of the arm's queue, commands."""


class Info(Value):
    """The identity of an arm."""

    port: str
    """Name of the connection."""
    name: str
    """Name of the arm."""
    serial_number: str
    """Serial number of the arm."""
    firmware: str
    """Version of the controller's firmware: ``"3.6.5"``."""
    processor_id: tuple[int, int, int] | None
    """Unique id of the controller's processor; ``None`` with older firmware."""
    uptime: float
    """Time since power-up, s; wraps after 49 days."""
    rail: bool
    """True if the arm is set up for a sliding rail."""
    laser: bool | None = None
    """True if the laser is on; ``None`` if the arm does not report it."""

"""Virtual arms with an observable world, for tests and for trying programs without an arm.

A :class:`VirtualArm` answers byte for byte like the real controller, moves like the real arm, and has a simulated
world: a table, objects, a conveyor, sensors, a pen on paper. A *scenario*, a TOML text, describes this world.

Lengths are mm, angles degrees, times seconds. A height is the z that the arm reports when its tool touches there.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

from . import _magician, words
from ._arguments import flag, instance, number, numbers, whole
from ._blocking import Arm
from ._bound import Bound
from ._magician import Call, Core
from ._meaning import Joints, Position
from ._pictures import Drawing, Picture
from ._scenarios import clock_speed, scenario_text, tool_bias
from .alarms import Alarm
from .pins import PinLike, pin
from .serving import Paths, Served, endpoints

__all__ = ["Place", "Snapshot", "VirtualArm", "WorldObject"]


_MAX_ADVANCE = 1e10
"""Upper bound of one clock advance, s (about 300 years): larger than any sensible step of the microsecond clock."""


class Place(NamedTuple):
    """Position and rotation of an object: the centre of its underside, and its yaw."""

    x: float
    """Forward, mm."""
    y: float
    """To the arm's left, mm."""
    z: float
    """Up, at the underside, mm."""
    yaw: float
    """Counter-clockwise seen from above, degrees."""


class Snapshot(Bound):
    """Snapshot of a virtual arm and its world: queue, settings, alarms, motions and clock."""

    __slots__ = ("native",)

    def __init__(self, native: _magician.Saved) -> None:
        self.native = native

    def __repr__(self) -> str:
        return f"<Snapshot at {self.native.time():.3f} s>"


class WorldObject(Bound):
    """An object in the world of a virtual arm. Each property reads the current state."""

    __slots__ = ("_look", "_name")

    def __init__(self, name: str, look: Callable[[str], dict[str, Any]]) -> None:
        self._name = name
        self._look = look

    @property
    def name(self) -> str:
        """Name in the scenario."""
        return self._name

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width and height, mm."""
        length, width, height = self._now()["size"]
        return length, width, height

    @property
    def color(self) -> tuple[int, int, int]:
        """Red, green and blue, 0 to 255."""
        red, green, blue = self._now()["color"]
        return red, green, blue

    @property
    def position(self) -> Place:
        """Current position and rotation."""
        return Place(*self._now()["place"])

    @property
    def rests_on(self) -> str:
        """Support of the object: ``"table"``, ``"belt"``, ``"shelf"`` (fixed in the air), ``"tool"``,
        ``"floor"``, or the name of another object."""
        found: str = self._now()["rest"]
        return found

    @property
    def on_belt(self) -> bool:
        """True if it stands directly on the conveyor belt."""
        return self.rests_on == "belt"

    @property
    def on_table(self) -> bool:
        """True if it stands directly on the table."""
        return self.rests_on == "table"

    @property
    def held(self) -> bool:
        """True if the tool holds it."""
        return self.rests_on == "tool"

    @property
    def lost(self) -> bool:
        """True if it has fallen to the floor."""
        return self.rests_on == "floor"

    def on(self, name: str) -> bool:
        """True if it stands directly on the object with this name."""
        self._look(name)
        return self.rests_on == name

    def seen_by(self, port: Literal["GP1", "GP2", "GP4", "GP5"]) -> bool:
        """True if the sensor at a connector has seen it since power-up."""
        return port in self._now()["seen_by"]

    def _now(self) -> dict[str, Any]:
        return self._look(self._name)

    def __repr__(self) -> str:
        now = self._now()
        x, y, z, _ = now["place"]
        return f"<{self._name!r} on {now['rest']} at x {x:.1f}, y {y:.1f}, z {z:.1f}>"


class VirtualArm(Bound):
    """A virtual arm and its world. Notebooks display its picture.

    By default the arm runs on a virtual clock. Motions take no real time. While the arm is idle the clock stands still,
    and only :meth:`advance` lets belts and scenarios proceed, so every run is identical. With a ``speed`` the clock
    follows the wall clock.

    A run (``run``, ``perform``, ``move_to`` and other waiting calls) takes the duration predicted by its check,
    regardless of the host's speed: the clock advances only when the queue holds the next commands. It advances while
    your program does other work or is paused in a debugger; suspending the whole process suspends the arm too. Commands
    queued without a run finish before the next command arrives.

    Example:
        >>> cell = VirtualArm('''
        ...     tool = { kind = "suction" }
        ...     table = { height = -60 }
        ...     object = [{ name = "red cube", size = [20, 20, 20], at = [220, 80], color = "red" }]
        ... ''')
        >>> cell.object("red cube").on_table
        True
    """

    __slots__ = ("_native",)

    def __init__(
        self,
        scenario: str | os.PathLike[str] | None = None,
        *,
        speed: float | Literal["max"] | None = None,
        tool: words.Tool | Sequence[float] | None = None,
    ) -> None:
        """Creates a virtual arm and switches it on.

        :param scenario: Path of a scenario file, or its text (several lines, or with a ``=``). Without it the world is
            empty.
        :param speed: Clock speed relative to real time; ``"max"`` skips time while the arm is busy and is real time
            otherwise, as with the port ``"sim"``. Without it the clock advances only by the arm's commands and by
            :meth:`advance`.
        :param tool: Tool set before power-up: its name, or its bias (x, y, z) in mm. Defaults to that of the scenario,
            or else ``"suction"``; ``"none"`` means that no tool was ever set.
        :raises InvalidInputError: The scenario is invalid (with line and column), the speed is not above 0, or the tool
            is unknown.
        :raises OSError: The file cannot be read.
        """
        times = None if speed is None else clock_speed(speed)
        self._native = _magician.Cell(scenario_text(scenario), times, tool_bias(tool))

    # Connections.

    def arm(self, *, timeout: float = 3.0, window: int = 1) -> Arm:
        """Connects to the arm, as ``magician.Arm(cell)`` does. With asyncio use ``magician.aio.Arm.connect(cell)``."""
        return Arm(self, timeout=timeout, window=window)

    def connect_core(
        self,
        *,
        timeout: float,
        window: int,
        probe: bool,
        reconnect: bool,
        echo: float,
        fence: str | None,
        trace: str | None,
    ) -> Call[Core]:
        """Starts a connection, for :class:`magician.Arm`."""
        how = {"probe": probe, "reconnect": reconnect}
        return self._native.connect(timeout=timeout, window=window, echo=echo, fence=fence, trace=trace, **how)

    def serve(self, *, pty: Paths | None = None, udp: str | None = None, tcp: str | None = None) -> Served:
        """Serves the arm to other programs, and returns when it accepts connections. This program can still inspect the
        arm, and connect to it too.

        >>> cell = VirtualArm()
        >>> with cell.serve(tcp="127.0.0.1:0") as served:
        ...     print(served.tcp)

        The clock is unchanged. Without a ``speed`` commands of other programs finish at once, so a program that polls
        for motion finds the arm at rest. With ``speed=1`` they take the time of a real arm. Belts, jogs and scenarios
        follow the clock: by :meth:`advance`, or with a ``speed``.

        :param pty: Path of a symlink to a new pseudo-terminal, or several paths. Not on Windows.
        :param udp: ``"HOST[:PORT]"``; the port defaults to 8899, and 0 selects a free one. On port 8899 it also answers
            discovery.
        :param tcp: ``"HOST:PORT"``; port 0 selects a free one.
        :returns: The server, which ends with its ``with`` block; the arm remains. :func:`magician.sim` serves an arm
            without inspection.
        :raises InvalidInputError: No endpoint is given, or an address is invalid.
        :raises PortError: A port or path is in use or unavailable.
        :raises UnsupportedError: This system does not support pseudo-terminals.
        """
        return Served(self._native.serve(endpoints(pty, udp, tcp)))

    @property
    def native(self) -> _magician.Cell:
        """For :func:`magician.proxy`."""
        return self._native

    # World.

    def object(self, name: str) -> WorldObject:
        """Returns the object with this name.

        :raises KeyError: There is no such object; the message lists the names.
        """
        self._found(name)
        return WorldObject(name, self._found)

    @property
    def objects(self) -> list[WorldObject]:
        """All objects, in the order of the scenario."""
        return [WorldObject(each["name"], self._found) for each in self._native.objects()]

    @property
    def held(self) -> WorldObject | None:
        """The object that the tool holds."""
        return next((each for each in self.objects if each.held), None)

    @property
    def drawing(self) -> Drawing:
        """Strokes of pen and laser so far."""
        return Drawing(self._native.drawing())

    def picture(self, path: str | os.PathLike[str] | None = None) -> Picture:
        """Draws arm and world in their current state, from above and from the side. With ``path`` also writes a
        ``.svg`` or ``.png`` file."""
        picture = Picture(self._native.snapshot())
        if path is not None:
            picture.save(path)
        return picture

    def events(self) -> list[str]:
        """Returns the events since the last call, as text: ``"the tool takes red cube"``, ``"alarm 0x20 raised"``.
        Commands are omitted. The log keeps the last 256 events, including commands."""
        return self._native.events()

    @property
    def title(self) -> str | None:
        """Title of the scenario."""
        return self._native.title()

    # Clock.

    @property
    def time(self) -> float:
        """The arm's clock: seconds since power-up."""
        return float(self._state("time"))

    def advance(self, seconds: float) -> None:
        """Advances the clock by a time, s: belts, jogs and scenarios proceed. With a numeric ``speed`` the time is
        wall-clock time."""
        self._native.advance(number("seconds", seconds, least=0, most=_MAX_ADVANCE, unit="s"))

    def snapshot(self) -> Snapshot:
        """Takes a snapshot of the arm and its world, also during motion."""
        return Snapshot(self._native.save())

    def restore(self, snapshot: Snapshot) -> None:
        """Restores arm, world and clock from a snapshot.

        :raises InvalidInputError: A connection is open, whose view of queue and settings would be stale: close the arm
            first, and connect again.
        """
        self._native.restore(instance("snapshot", snapshot, Snapshot, "snapshot() makes one").native)

    # State of the arm.

    @property
    def position(self) -> Position:
        """Pose of the tool as known by the controller."""
        return Position(*self._state("pose"))

    @property
    def joints(self) -> Joints:
        """Joint angles as known by the controller, degrees."""
        return Joints(*self._state("joints"))

    @property
    def true_joints(self) -> Joints:
        """True joint angles, degrees. They differ after lost steps, and for the base before homing."""
        return Joints(*self._state("true_joints"))

    @property
    def moving(self) -> bool:
        """True if the arm is moving."""
        return bool(self._state("moving"))

    @property
    def homed(self) -> bool:
        """True if it has been homed since power-up."""
        return bool(self._state("homed"))

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Active alarms."""
        found: tuple[Alarm, ...] = self._state("alarms")
        return found

    @property
    def queue_index(self) -> int:
        """Index of the last finished queued command."""
        return int(self._state("index"))

    @property
    def waiting(self) -> int:
        """Number of commands waiting in the queue."""
        return int(self._state("waiting"))

    @property
    def suction(self) -> bool:
        """True if the suction cup sucks."""
        return bool(self._state("suction"))

    @property
    def gripper_closed(self) -> bool:
        """True if the gripper was closed."""
        return bool(self._state("gripper_closed"))

    @property
    def laser(self) -> float:
        """Power of the laser, percent; 0 is off."""
        return float(self._state("laser"))

    @property
    def rail(self) -> float | None:
        """Position of the carriage on the rail, mm; ``None`` without a rail."""
        found: float | None = self._state("rail")
        return found

    @property
    def belt_travel(self) -> float:
        """Distance that the conveyor belt has travelled in its direction, mm."""
        return float(self._state("belt"))

    # Actions from outside.

    def set_input(self, address: PinLike, level: bool) -> None:
        """Sets the level of a digital input, EIO address 1 to 20, as a push button does."""
        self._native.set_input(pin("address", address), flag("level", level))

    def set_analog(self, address: PinLike, value: int) -> None:
        """Sets the value of an analog input, EIO address 1 to 20: 0 to 4095 for 0 to 3.3 V."""
        self._native.set_analog(pin("address", address), whole("value", value, 0, 4095))

    def press_key(self, *, long: bool = False) -> None:
        """Presses the key at the base: a short press starts or stops the stored program, a long press homes the arm."""
        self._native.press_key(flag("long", long))

    def guide(self, joints: Sequence[float]) -> None:
        """Moves the arm by hand: holds the unlock key, moves J1 to J4 to these angles, degrees, and releases the
        key."""
        j1, j2, j3, j4 = numbers("joints", joints, 4, unit="deg")
        self._native.unlock(True)
        self._native.guide((j1, j2, j3, j4))
        self._native.unlock(False)

    def hold_unlock_key(self, held: bool) -> None:
        """Holds or releases the unlock key on the forearm."""
        self._native.unlock(flag("held", held))

    def slip(self, joint: int, degrees: float) -> None:
        """Makes a joint, 1 to 4, slip: its true angle then differs from the controller's."""
        self._native.slip(whole("joint", joint, 1, 4), number("degrees", degrees, unit="deg"))

    def raise_alarm(self, code: int) -> None:
        """Raises an alarm by its code."""
        self._native.raise_alarm(whole("code", code, 0, 255))

    def unplug(self) -> None:
        """Disconnects the cable."""
        self._native.plug(False)

    def plug(self) -> None:
        """Reconnects the cable."""
        self._native.plug(True)

    def delay_answers(self, seconds: float) -> None:
        """Delays every answer by a time, s; 0 removes the delay."""
        self._native.delay(number("seconds", seconds, least=0, most=_MAX_ADVANCE, unit="s"))

    def reset(self) -> None:
        """Resets the controller: queue and settings are lost."""
        self._native.reset()

    def _state(self, name: str) -> Any:
        return self._native.state()[name]

    def _found(self, name: str) -> dict[str, Any]:
        found = self._native.objects()
        for each in found:
            if each["name"] == name:
                return each
        names = ", ".join(repr(each["name"]) for each in found) or "none"
        raise KeyError(f"unknown object {name!r}; known are {names}")

    def __repr__(self) -> str:
        if not hasattr(self, "_native"):
            # Shown in a traceback of the constructor, before the attributes exist.
            return "<VirtualArm, not made>"
        x, y, z, r = self.position
        title = f"{self.title} " if self.title else ""
        return f"<VirtualArm {title}at x {x:.1f}, y {y:.1f}, z {z:.1f}, r {r:.1f}, {self.time:.3f} s>"

    def _repr_svg_(self) -> str:
        return self.picture().svg

"""Virtual arms that can be looked at from outside: for tests, and to try programs without an arm.

A :class:`VirtualArm` answers byte for byte as the real controller does, moves as the real arm does, and stands in a
world of its own: a table, objects, a conveyor, sensors, a pen on paper. What that world is a *scenario* says, a text in
TOML.

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


_LONGEST = 1e10
"""Some 300 years, s: more than the arm's clock, of microseconds, is ever let run at once."""


class Place(NamedTuple):
    """Where something stands: the middle of its underside, and how it is turned."""

    x: float
    """Forward, mm."""
    y: float
    """To the arm's left, mm."""
    z: float
    """Up, of the underside, mm."""
    yaw: float
    """Counter-clockwise seen from above, degrees."""


class Snapshot(Bound):
    """A virtual arm and its world at an instant: its queue, its settings, its alarms, what moves, and its clock."""

    __slots__ = ("native",)

    def __init__(self, native: _magician.Saved) -> None:
        self.native = native

    def __repr__(self) -> str:
        return f"<Snapshot at {self.native.time():.3f} s>"


class WorldObject(Bound):
    """An object in the world of a virtual arm, as it is at the moment when it is asked."""

    __slots__ = ("_look", "_name")

    def __init__(self, name: str, look: Callable[[str], dict[str, Any]]) -> None:
        self._name = name
        self._look = look

    @property
    def name(self) -> str:
        """Its name in the scenario."""
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
        """Where it is."""
        return Place(*self._now()["place"])

    @property
    def rests_on(self) -> str:
        """What it stands on: ``"table"``, ``"belt"``, ``"shelf"`` (a place of its own in the air), ``"tool"``,
        ``"floor"``, or the name of another object."""
        found: str = self._now()["rest"]
        return found

    @property
    def on_belt(self) -> bool:
        """True if it stands on the conveyor's belt itself."""
        return self.rests_on == "belt"

    @property
    def on_table(self) -> bool:
        """True if it stands on the table itself."""
        return self.rests_on == "table"

    @property
    def held(self) -> bool:
        """True if the tool holds it."""
        return self.rests_on == "tool"

    @property
    def lost(self) -> bool:
        """True if it has fallen off everything."""
        return self.rests_on == "floor"

    def on(self, name: str) -> bool:
        """True if it stands on the object of that name itself."""
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
    """A virtual arm and its world. A notebook shows its picture.

    Its clock is its own. Whatever the arm does takes no time, and while it has nothing to do its clock stands, however
    long the program takes: belts run on and scenarios go on when :meth:`advance` says so, and every run is the same
    run. With a ``speed`` the clock follows the wall's.

    A run (``run``, ``perform``, ``move_to``, whatever waits for the arm) takes the arm the time that its check says,
    however slow the host is: the clock goes on only when the queue has what it takes of the next commands. It goes on
    while your program does something else meanwhile, or is held in a debugger; a process that is held as a whole holds
    the arm too. What is put into the queue without a run is done before the next command comes.

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
        """Switches on a virtual arm.

        :param scenario: A path of a scenario file, or the text of one (more than one line, or with a ``=``). Without it
            the world is empty.
        :param speed: How many times as fast as a real arm, 1 being real time; ``"max"`` for no time while the arm is
            busy and real time else, as the port ``"sim"``. Without it the clock runs for what the arm does, and for
            :meth:`advance`.
        :param tool: The tool that was chosen before it was switched on, by its name or its bias (x, y, z) in mm.
            Without it that of the scenario, else ``"suction"``; ``"none"`` is an arm that was never told of a tool.
        :raises InvalidInputError: The scenario has a mistake (with line and column), the speed is not above 0, or the
            tool is unknown.
        :raises OSError: The file cannot be read.
        """
        times = None if speed is None else clock_speed(speed)
        self._native = _magician.Cell(scenario_text(scenario), times, tool_bias(tool))

    # Connections.

    def arm(self, *, timeout: float = 3.0, window: int = 1) -> Arm:
        """Connects to it, as ``magician.Arm(cell)`` does; ``magician.aio.Arm.connect(cell)`` for asyncio."""
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
        """Begins to connect to it; for :class:`magician.Arm`."""
        how = {"probe": probe, "reconnect": reconnect}
        return self._native.connect(timeout=timeout, window=window, echo=echo, fence=fence, trace=trace, **how)

    def serve(self, *, pty: Paths | None = None, udp: str | None = None, tcp: str | None = None) -> Served:
        """Offers it to other programs, and returns when it accepts connections: they talk to the arm that this program
        looks at, and may be connected to as well.

        >>> cell = VirtualArm()
        >>> with cell.serve(tcp="127.0.0.1:0") as served:
        ...     print(served.tcp)

        Its clock stays its own. Without a ``speed`` what other programs say is done at once; a program that looks
        whether the arm still moves finds it at rest. With ``speed=1`` it takes the time of a real arm. A belt, a jog
        and a scenario go on with the clock: by :meth:`advance`, or with a ``speed``.

        :param pty: A path for a new pseudo-terminal, which becomes a symlink to it, or several paths. Not on Windows.
        :param udp: ``"HOST[:PORT]"``; 8899 if the port is left out, 0 is any free one. On port 8899 it answers programs
            that look for arms, too.
        :param tcp: ``"HOST:PORT"``; 0 is any free port.
        :returns: What ends with its ``with`` block; the arm stays. :func:`magician.sim` serves an arm that nobody looks
            at.
        :raises InvalidInputError: There is no endpoint, or an address makes no sense.
        :raises PortError: A port or path is taken, or not to be had.
        :raises UnsupportedError: This system has no pseudo-terminals.
        """
        return Served(self._native.serve(endpoints(pty, udp, tcp)))

    @property
    def native(self) -> _magician.Cell:
        """For :func:`magician.proxy`."""
        return self._native

    # World.

    def object(self, name: str) -> WorldObject:
        """The object of that name.

        :raises KeyError: There is none; the message has the names that there are.
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
        """What pen and laser have left by now."""
        return Drawing(self._native.drawing())

    def picture(self, path: str | os.PathLike[str] | None = None) -> Picture:
        """The arm and its world as they stand, from above and from the side; written to ``path`` (``.svg`` or ``.png``)
        too."""
        picture = Picture(self._native.snapshot())
        if path is not None:
            picture.save(path)
        return picture

    def events(self) -> list[str]:
        """What has happened since the last call, in words: ``"the tool takes red cube"``, ``"alarm 0x20 raised"``.
        Commands that come and go are left out. It keeps the last 256 happenings, commands included."""
        return self._native.events()

    @property
    def title(self) -> str | None:
        """What the scenario is called."""
        return self._native.title()

    # Clock.

    @property
    def time(self) -> float:
        """The arm's clock: seconds since power-up."""
        return float(self._state("time"))

    def advance(self, seconds: float) -> None:
        """Lets so much time pass at once: belts, jogs and scenarios go on. With a ``speed`` given as a number it is
        time of the wall's clock."""
        self._native.advance(number("seconds", seconds, least=0, most=_LONGEST, unit="s"))

    def snapshot(self) -> Snapshot:
        """The arm and its world at this instant, in the midst of what they do."""
        return Snapshot(self._native.save())

    def restore(self, snapshot: Snapshot) -> None:
        """Puts arm and world back to a snapshot, its clock too.

        :raises InvalidInputError: A connection is open, and would keep its old picture of the arm's queue and settings:
            close the arm first, and connect again.
        """
        self._native.restore(instance("snapshot", snapshot, Snapshot, "snapshot() makes one").native)

    # State of the arm.

    @property
    def position(self) -> Position:
        """Where the controller takes the tool to be."""
        return Position(*self._state("pose"))

    @property
    def joints(self) -> Joints:
        """What the controller takes the joints to be."""
        return Joints(*self._state("joints"))

    @property
    def true_joints(self) -> Joints:
        """Where the joints really stand: elsewhere after lost steps, and the base before homing."""
        return Joints(*self._state("true_joints"))

    @property
    def moving(self) -> bool:
        """True if anything moves."""
        return bool(self._state("moving"))

    @property
    def homed(self) -> bool:
        """True if it has been homed since power-up."""
        return bool(self._state("homed"))

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """The alarms that stand."""
        found: tuple[Alarm, ...] = self._state("alarms")
        return found

    @property
    def queue_index(self) -> int:
        """Index of the queued command that finished last."""
        return int(self._state("index"))

    @property
    def waiting(self) -> int:
        """How many commands wait in the queue."""
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
        """Where the carriage on the rail is, mm; ``None`` without a rail."""
        found: float | None = self._state("rail")
        return found

    @property
    def belt_travel(self) -> float:
        """How far the conveyor's belt has run in its direction, mm."""
        return float(self._state("belt"))

    # Actions from outside.

    def set_input(self, address: PinLike, level: bool) -> None:
        """Puts a level on a digital input, EIO address 1 to 20: somebody presses a button."""
        self._native.set_input(pin("address", address), flag("level", level))

    def set_analog(self, address: PinLike, value: int) -> None:
        """Puts a voltage on an analog input, EIO address 1 to 20: 0 to 4095 for 0 to 3.3 V."""
        self._native.set_analog(pin("address", address), whole("value", value, 0, 4095))

    def press_key(self, *, long: bool = False) -> None:
        """Presses the key at the base: short runs the stored program or stops it, long homes the arm."""
        self._native.press_key(flag("long", long))

    def guide(self, joints: Sequence[float]) -> None:
        """Moves the arm by hand: holds the unlock key, brings J1 to J4 to these degrees, lets go of the key."""
        j1, j2, j3, j4 = numbers("joints", joints, 4, unit="deg")
        self._native.unlock(True)
        self._native.guide((j1, j2, j3, j4))
        self._native.unlock(False)

    def hold_unlock_key(self, held: bool) -> None:
        """Holds or releases the unlock key on the forearm."""
        self._native.unlock(flag("held", held))

    def slip(self, joint: int, degrees: float) -> None:
        """Lets a joint, 1 to 4, slip: it stands elsewhere than the controller believes."""
        self._native.slip(whole("joint", joint, 1, 4), number("degrees", degrees, unit="deg"))

    def raise_alarm(self, code: int) -> None:
        """Raises an alarm by its code."""
        self._native.raise_alarm(whole("code", code, 0, 255))

    def unplug(self) -> None:
        """Pulls the cable."""
        self._native.plug(False)

    def plug(self) -> None:
        """Plugs the cable in again."""
        self._native.plug(True)

    def delay_answers(self, seconds: float) -> None:
        """Lets every answer come so much later; 0 is as before."""
        self._native.delay(number("seconds", seconds, least=0, most=_LONGEST, unit="s"))

    def reset(self) -> None:
        """Resets the controller: what was queued and set is gone."""
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

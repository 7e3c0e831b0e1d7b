"""Command builders: functions named for the arm's motions, tools and settings.

Each returns a command as a value and does nothing else: ``arm.perform([...])`` checks and runs them, ``arm.enqueue``
queues one at a time, and programs may keep them in lists. The methods of an arm with the same names run the command and
wait.

Lengths are mm, angles degrees, times seconds; the frame is the arm's: origin where the base axis meets the shoulder
axis, X forward, Y to the arm's left, Z up. The table is below z = 0. E numbers cite the errata to the vendor's
document.

The file is long because it lists all of them, each with its documentation.

>>> from magician import words
>>> pick = [
...     words.jump_to(220, 40, -30, 0),
...     words.suction(True),
...     words.wait(0.3),
...     words.jump_to(220, -40, -30, 0),
...     words.suction(False),
... ]
>>> len(pick)
5
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal, overload

from . import _magician, commands
from ._arguments import checked, flag, number, numbers, whole
from ._targets import KEPT, JointTarget, Target, joints, spot
from .commands import JogCommand, Output, PtpMode, RailVersion, TriggerCondition, TriggerMode
from .errors import InvalidInputError
from .pins import (
    FunctionLike,
    PinLike,
    PortLike,
    StepperLike,
    VersionLike,
    pin,
    rail_version,
    sensor_version,
    stepper,
)
from .pins import function as _function
from .pins import port as _port

__all__ = [
    "CONVEYOR_FARTHEST",
    "CONVEYOR_FASTEST",
    "CONVEYOR_PULSES_PER_MM",
    "Direction",
    "Four",
    "Move",
    "Tool",
    "analog_at",
    "arc_speed",
    "arc_to",
    "bias_of",
    "check_lost_steps",
    "circle",
    "color_at",
    "color_sensor",
    "conveyor",
    "conveyor_by",
    "engrave_by",
    "engrave_to",
    "grip",
    "home",
    "home_at",
    "infrared",
    "infrared_at",
    "jog",
    "jog_axis_speed",
    "jog_joint_speed",
    "jog_rail_speed",
    "jog_speed",
    "joint_speed",
    "jump_height",
    "jump_heights",
    "jump_joints",
    "jump_line_to",
    "jump_to",
    "laser",
    "level_at",
    "line_by",
    "line_joints",
    "line_speed",
    "line_to",
    "lost_step_threshold",
    "motor",
    "motor_by",
    "move_by",
    "move_joints",
    "move_joints_by",
    "move_to",
    "move_with_rail",
    "multiplex",
    "output",
    "path_by",
    "path_speed",
    "path_to",
    "pump_off",
    "pwm",
    "rail",
    "rail_by",
    "rail_speed",
    "rail_to",
    "release",
    "servo",
    "speed",
    "suction",
    "tool",
    "wait",
    "wait_above",
    "wait_at_least",
    "wait_at_most",
    "wait_below",
    "wait_for_level",
    "with_outputs",
    "with_rail",
]

Move = commands.PtpCmd | commands.PtpPoCmd | commands.PtpWithLCmd | commands.PtpPoWithLCmd
"""A point-to-point move, with outputs and with the rail if it has them."""

Tool = Literal["none", "suction", "gripper", "pen", "laser"]
"""A tool whose place is known."""

Direction = Literal[
    "x+",
    "x-",
    "y+",
    "y-",
    "z+",
    "z-",
    "r+",
    "r-",
    "j1+",
    "j1-",
    "j2+",
    "j2-",
    "j3+",
    "j3-",
    "j4+",
    "j4-",
    "rail+",
    "rail-",
]
"""What to jog, and which way."""

_TOOLS = dict(_magician.tools())

CONVEYOR_PULSES_PER_MM = _magician.CONVEYOR_PULSES_PER_MM
"""Pulses that move the vendor's belt by 1 mm: 16,000 for a turn of its roller, which is 34 mm across."""

CONVEYOR_FASTEST = _magician.CONVEYOR_FASTEST
"""Highest speed of the kit's belt, mm/s: above it its motor stalls."""

CONVEYOR_FARTHEST = _magician.CONVEYOR_FARTHEST
"""The longest way that a belt is told to move, mm: about 28 km."""

Four = Sequence[float]
"""Four numbers."""


def _four(name: str, values: Four) -> tuple[float, float, float, float]:
    a, b, c, d = numbers(name, values, 4)
    return a, b, c, d


def _move(move: object) -> None:
    if not isinstance(move, Move):
        raise TypeError(f"{move!r} is not a point-to-point move: move_to, jump_to and the like make one")


def _power(power: float) -> float:
    return number("power", power, least=0, most=100, unit="%")


def _speed(velocity: float, acceleration: float) -> tuple[float, float]:
    return number("velocity", velocity, above=0), number("acceleration", acceleration, above=0)


def _ratios(velocity: float, acceleration: float | None) -> tuple[float, float]:
    velocity = number("velocity", velocity, above=0, unit="%")
    return velocity, velocity if acceleration is None else number("acceleration", acceleration, above=0, unit="%")


def _counts(threshold: int) -> int:
    return whole("threshold", threshold, 0, 4095)


def _pin(address: PinLike) -> int:
    return pin("address", address)


def _spot(x: Any, y: float | None, z: float | None, r: float | None) -> tuple[float, float, float, float]:
    *place, turned = spot(x, y, z, r)
    return place[0], place[1], place[2], KEPT if turned is None else turned


def _joints(j1: Any, j2: float | None, j3: float | None, j4: float | None) -> tuple[float, float, float, float]:
    *three, last = joints(j1, j2, j3, j4)
    if last is None:
        raise TypeError("j4 is left out; it takes a number")
    return three[0], three[1], three[2], last


# Motion.


@overload
def move_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def move_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def move_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Goes to a pose, all joints together; the tool's way is a curve (document 1.10.5, MOVJ).

    :param x: x in mm, or a whole pose (``arm.pose()``), or x, y, z and perhaps r in a row.
    :param r: Rotation of the tool, degrees; left out keeps that of the move before, or of the arm.
    """
    return commands.PtpCmd(PtpMode.MOVJ_XYZ, *_spot(x, y, z, r))


@overload
def line_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def line_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def line_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Goes to a pose on a straight line (MOVL); its target as that of :func:`move_to`."""
    return commands.PtpCmd(PtpMode.MOVL_XYZ, *_spot(x, y, z, r))


@overload
def jump_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def jump_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def jump_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Goes to a pose over obstacles: up, across with all joints together, down (JUMP).

    :func:`jump_height` says how high.
    """
    return commands.PtpCmd(PtpMode.JUMP_XYZ, *_spot(x, y, z, r))


@overload
def jump_line_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def jump_line_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def jump_line_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """As :func:`jump_to`, across on a straight line (E28: seen to do nothing on some firmware)."""
    return commands.PtpCmd(PtpMode.JUMP_MOVL_XYZ, *_spot(x, y, z, r))


@overload
def move_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def move_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def move_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Goes to joint angles, degrees; or to those of a pose."""
    return commands.PtpCmd(PtpMode.MOVJ_ANGLE, *_joints(j1, j2, j3, j4))


@overload
def line_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def line_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def line_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Goes to joint angles with the tool on a straight line."""
    return commands.PtpCmd(PtpMode.MOVL_ANGLE, *_joints(j1, j2, j3, j4))


@overload
def jump_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def jump_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def jump_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Goes to joint angles over obstacles."""
    return commands.PtpCmd(PtpMode.JUMP_ANGLE, *_joints(j1, j2, j3, j4))


def move_by(dx: float = 0, dy: float = 0, dz: float = 0, dr: float = 0) -> commands.PtpCmd:
    """Moves by a distance (mm, degrees) from the pose that the arm then has, all joints together."""
    return commands.PtpCmd(PtpMode.MOVJ_XYZ_INC, *checked(dx=dx, dy=dy, dz=dz, dr=dr))


def line_by(dx: float = 0, dy: float = 0, dz: float = 0, dr: float = 0) -> commands.PtpCmd:
    """Moves by a distance (mm, degrees) from the pose that the arm then has, on a straight line."""
    return commands.PtpCmd(PtpMode.MOVL_XYZ_INC, *checked(dx=dx, dy=dy, dz=dz, dr=dr))


def move_joints_by(d1: float = 0, d2: float = 0, d3: float = 0, d4: float = 0) -> commands.PtpCmd:
    """Turns the joints by these angles, degrees, from those that they then have."""
    return commands.PtpCmd(PtpMode.MOVJ_ANGLE_INC, *checked(d1=d1, d2=d2, d3=d3, d4=d4))


def arc_to(via: Four, to: Four) -> commands.ArcCmd:
    """Goes to ``to`` along the arc through ``via``; both are x, y, z, r, and the r of ``via`` is ignored (document
    1.12.2, E33).

    The three points, the arm's own the first of them, must be apart and not on one line. :func:`arc_speed` says how
    fast.
    """
    return commands.ArcCmd(_four("via", via), _four("to", to))


def circle(via: Four, over: Four, turns: int = 1) -> commands.CircleCmd:
    """Goes round the circle through the present pose, ``via`` and ``over``, ``turns`` times, and ends where it began.

    Both are x, y, z, r; r stays what it is. Not in the vendor's document (E33).
    """
    return commands.CircleCmd(_four("via", via), _four("over", over), whole("turns", turns, 1, 0xFFFF_FFFF))


def path_to(x: float, y: float, z: float) -> commands.CpCmd:
    """Adds a segment to a continuous path, to a point (document 1.11.2, E31 and E32).

    The tool does not stop between segments that follow each other, and J4 does not turn. :func:`path_speed` says how
    fast.
    """
    return commands.CpCmd(commands.CpMode.ABSOLUTE, number("x", x), number("y", y), number("z", z), 0)


def path_by(dx: float = 0, dy: float = 0, dz: float = 0) -> commands.CpCmd:
    """Adds a segment to a continuous path, by a distance from the end of the segment before."""
    return commands.CpCmd(commands.CpMode.RELATIVE, number("dx", dx), number("dy", dy), number("dz", dz), 0)


def engrave_to(x: float, y: float, z: float, power: float) -> commands.CpLeCmd:
    """As :func:`path_to`, with the laser at ``power`` percent (0 to 100) on the way (document 1.11.3, E32).

    End the path with ``laser(False)`` or a segment of power 0.
    """
    point = number("x", x), number("y", y), number("z", z)
    return commands.CpLeCmd(commands.CpMode.ABSOLUTE, *point, _power(power))


def engrave_by(dx: float, dy: float, dz: float, power: float) -> commands.CpLeCmd:
    """As :func:`engrave_to`, by a distance from the end of the segment before."""
    way = number("dx", dx), number("dy", dy), number("dz", dz)
    return commands.CpLeCmd(commands.CpMode.RELATIVE, *way, _power(power))


def home() -> commands.HomeCmd:
    """Homes the arm, in up to half a minute (document 1.6.2).

    The method ``arm.home()`` does that and clears the alarm that the arm raises when it is switched on.
    """
    return commands.HomeCmd()


def home_at(x: float, y: float, z: float, r: float) -> commands.HomeParams:
    """Sets the home point, where :func:`home` ends from now on (document 1.6.1)."""
    return commands.HomeParams(*checked(x=x, y=y, z=z, r=r))


_AXES: dict[str, tuple[bool, JogCommand]] = {
    f"{name}{sign}": (is_joint, JogCommand(2 * at + back + 1))
    for is_joint, names in ((False, "xyzr"), (True, ("j1", "j2", "j3", "j4", "rail")))
    for at, name in enumerate(names)
    for back, sign in enumerate("+-")
}


def jog(direction: Direction) -> commands.JogCmd:
    """Moves a coordinate, a joint or the rail until it is stopped: ``"x+"``, ``"j2-"``, ``"rail+"`` (document 1.9.4,
    E25).

    It is for ``arm.jog``, which ends it; in a program it would go on until a limit ends it with an alarm.
    """
    if direction not in _AXES:
        raise InvalidInputError(f"unknown direction {direction!r}; known are {', '.join(_AXES)}")
    is_joint, command = _AXES[direction]
    return commands.JogCmd(is_joint, command)


def check_lost_steps() -> commands.LostStepCmd:
    """Compares the joints with their sensors; a lost step raises an alarm (E36)."""
    return commands.LostStepCmd()


def lost_step_threshold(degrees: float) -> commands.LostStepParams:
    """From how many degrees on a joint counts as lost; 5 at power-up (document 1.18.1).

    It cannot be queued: ``arm.set`` sets it at once.
    """
    return commands.LostStepParams(number("degrees", degrees, above=0, unit="deg"))


# Speeds and jump height.


def speed(velocity: float, acceleration: float | None = None) -> commands.PtpCommonParams:
    """Share of the set speeds and accelerations that point-to-point moves use, percent (document 1.10.4).

    Above 0; more than 100 counts as 100. The acceleration is as the velocity unless it is given.
    """
    return commands.PtpCommonParams(*_ratios(velocity, acceleration))


def joint_speed(velocity: Four, acceleration: Four) -> commands.PtpJointParams:
    """Speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves, above 0 (document 1.10.1).

    The arm goes no faster than 320 deg/s, J4 480, and 300 deg/s2.
    """
    return commands.PtpJointParams(_four("velocity", velocity), _four("acceleration", acceleration))


def line_speed(velocity: float, acceleration: float) -> commands.PtpCoordinateParams:
    """Speed (mm/s) and acceleration (mm/s2) of the tool on straight lines (document 1.10.2).

    Its rotation has half of each in degrees, as at power-up. At most 300 mm/s and 400 mm/s2 count.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.PtpCoordinateParams(velocity, velocity / 2, acceleration, acceleration / 2)


def path_speed(velocity: float, acceleration: float) -> commands.CpParams:
    """Most speed (mm/s) and acceleration (mm/s2) on a continuous path (document 1.11.1, E31).

    The arm slows down at corners by itself.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.CpParams(acceleration, velocity, acceleration, False)


def arc_speed(velocity: float, acceleration: float) -> commands.ArcParams:
    """Speed (mm/s) and acceleration (mm/s2) on arcs and circles, and of the rotation in degrees (document 1.12.1).

    By the vendor's code arcs have the speeds of :func:`line_speed` instead (model section 9): set both.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.ArcParams(velocity, velocity, acceleration, acceleration)


def jump_height(height: float, z_limit: float) -> commands.PtpJumpParams:
    """How far a jump lifts above the higher of its ends, and the z it stays below, mm (document 1.10.3, E30)."""
    return commands.PtpJumpParams(*checked(height=height, z_limit=z_limit))


def jump_heights(start: float, end: float, z_limit: float) -> commands.PtpJump2Params:
    """How far a jump lifts above its start and above its end, and the z it stays below, mm (document 1.10.8, E27)."""
    return commands.PtpJump2Params(*checked(start=start, end=end, z_limit=z_limit))


def jog_speed(velocity: float, acceleration: float | None = None) -> commands.JogCommonParams:
    """Share of the set jog speeds, percent: above 0, more than 100 counts as 100 (document 1.9.3).

    The acceleration of jogs is not scaled.
    """
    return commands.JogCommonParams(*_ratios(velocity, acceleration))


def jog_joint_speed(velocity: Four, acceleration: Four) -> commands.JogJointParams:
    """Speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in jogs of joints (document 1.9.1)."""
    return commands.JogJointParams(_four("velocity", velocity), _four("acceleration", acceleration))


def jog_axis_speed(velocity: Four, acceleration: Four) -> commands.JogCoordinateParams:
    """Speeds (mm/s; deg/s for r) and accelerations (mm/s2; deg/s2) of x, y, z and r in jogs (document 1.9.2)."""
    return commands.JogCoordinateParams(_four("velocity", velocity), _four("acceleration", acceleration))


# Tool.


def tool(name: Tool | None = None, *, x: float = 0, y: float = 0, z: float = 0) -> commands.EndEffectorParams:
    """Tells the arm its tool: by its name, or by the tip's x, y, z in mm from the wrist. Poses are those of that tip.

    >>> tool("suction").x_bias
    59.7
    """
    if name is None:
        return commands.EndEffectorParams(*checked(x=x, y=y, z=z))
    bias = bias_of(name)
    if (x, y, z) != (0, 0, 0):
        raise InvalidInputError("a tool has a name, or x, y, z")
    return commands.EndEffectorParams(*bias)


def bias_of(tool: Tool | Sequence[float]) -> tuple[float, float, float]:
    """Where the tip of a tool is, x, y, z in mm from the wrist: of its name, or as it is given.

    >>> bias_of("suction")
    (59.7, 0.0, 0.0)
    """
    if isinstance(tool, str):
        if tool not in _TOOLS:
            raise InvalidInputError(f"unknown tool {tool!r}; known are {', '.join(_TOOLS)}")
        return _TOOLS[tool]
    x, y, z = numbers("tool", tool, 3)
    return x, y, z


def suction(on: bool) -> commands.SetEndEffectorSuctionCup:
    """Sucks, or lets go; it takes about 0.3 s to hold (document 1.8.3).

    Suction cup and gripper share one pump, so the later command has the air.
    """
    return commands.SetEndEffectorSuctionCup(True, flag("on", on))


def grip() -> commands.SetEndEffectorGripper:
    """Closes the gripper, in about 0.5 s (document 1.8.4)."""
    return commands.SetEndEffectorGripper(True, True)


def release() -> commands.SetEndEffectorGripper:
    """Opens the gripper."""
    return commands.SetEndEffectorGripper(True, False)


def pump_off() -> commands.SetEndEffectorGripper:
    """Switches the air pump off; suction cup and gripper go limp."""
    return commands.SetEndEffectorGripper(False, False)


def laser(on: bool) -> commands.SetEndEffectorLaser:
    """Switches the laser, full on or off (document 1.8.2). Off ends the power of a path, too.

    A program that leaves it on, or stands or travels with it, is refused by the check ``laser``.
    """
    on = flag("on", on)
    return commands.SetEndEffectorLaser(on, on)


# Waits, triggers and pins.


def wait(seconds: float) -> commands.WaitCmd:
    """Makes the queue wait, to the millisecond and for at most 49 days (document 1.13.1, E34)."""
    return commands.WaitCmd(round(number("seconds", seconds, least=0, most=0xFFFF_FFFF / 1000, unit="s") * 1000))


def wait_for_level(address: PinLike, high: bool) -> commands.TrigCmd:
    """Makes the queue wait until a digital input (EIO address 1 to 20) has this level, for ever if need be (document
    1.14.1).
    """
    return commands.TrigCmd(_pin(address), TriggerMode.LEVEL, TriggerCondition.EQUAL_OR_BELOW, int(flag("high", high)))


def wait_below(address: PinLike, threshold: int) -> commands.TrigCmd:
    """Makes the queue wait until an analog input (EIO address 1 to 20) is below a threshold, for ever if need be.

    The threshold is 0 to 4095 counts, 4095 at 3.3 V (document 1.14.1, E35).
    """
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.EQUAL_OR_BELOW, _counts(threshold))


def wait_at_most(address: PinLike, threshold: int) -> commands.TrigCmd:
    """As :func:`wait_below`, until the input is at most the threshold."""
    return commands.TrigCmd(
        _pin(address), TriggerMode.ANALOG, TriggerCondition.DIFFERENT_OR_AT_MOST, _counts(threshold)
    )


def wait_at_least(address: PinLike, threshold: int) -> commands.TrigCmd:
    """As :func:`wait_below`, until the input is at least the threshold."""
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.AT_LEAST, _counts(threshold))


def wait_above(address: PinLike, threshold: int) -> commands.TrigCmd:
    """As :func:`wait_below`, until the input is above the threshold."""
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.ABOVE, _counts(threshold))


def multiplex(address: PinLike, function: FunctionLike) -> commands.IoMultiplexing:
    """Sets the function of an EIO pin (1 to 20), before the pin can be used (document 1.15.1, E40)."""
    return commands.IoMultiplexing(_pin(address), _function(function))


def output(address: PinLike, high: bool) -> commands.IoDo:
    """Sets the level of a digital output (EIO address 1 to 20; document 1.15.2)."""
    return commands.IoDo(_pin(address), flag("high", high))


def pwm(address: PinLike, frequency: float, duty_cycle: float) -> commands.IoPwm:
    """Sets a pulse-width output (EIO address 1 to 20): Hz (10 to 1000000), and percent of the time that it is high.

    Document 1.15.3.
    """
    return commands.IoPwm(
        _pin(address),
        number("frequency", frequency, least=10, most=1_000_000, unit="Hz"),
        number("duty_cycle", duty_cycle, least=0, most=100, unit="%"),
    )


def servo(address: PinLike, pulse_ms: float) -> commands.IoPwm:
    """Turns a hobby servo on a pulse-width pin (EIO 4, 6, 8, 11 or 14) by the length of its pulses, 50 a second.

    1.5 ms is the middle of most, 1 to 2 ms what all of them take, 0.5 to 2.5 ms what many do; 0 lets go, 20 ms is the
    most. Multiplex the pin to ``IoFunction.PWM`` first (EIO 8, 6 and 4 have driven servos).
    """
    return pwm(address, 50, 100 * number("pulse_ms", pulse_ms, least=0, most=20, unit="ms") / 20)


def with_outputs(move: Move, outputs: Iterable[Output]) -> commands.PtpPoCmd | commands.PtpPoWithLCmd:
    """Lets a point-to-point move switch outputs on its way, in any order and at most 57, with the rail 56.

    They replace the move's outputs so far (document 1.10.9 and 1.10.10, E29).

    >>> from magician.commands import Output
    >>> jump = with_outputs(jump_to(220, 0, 20, 0), [Output(percent=50, address=17, high=True)])
    """
    _move(move)
    po = tuple(Output(share, pin("address", at) if isinstance(at, str) else at, high) for share, at, high in outputs)
    most = 56 if isinstance(move, (commands.PtpWithLCmd, commands.PtpPoWithLCmd)) else 57
    if len(po) > most:
        raise InvalidInputError(f"{len(po)} outputs on the way, limit {most}")
    if isinstance(move, (commands.PtpWithLCmd, commands.PtpPoWithLCmd)):
        return commands.PtpPoWithLCmd(move.ptp_mode, move.x, move.y, move.z, move.r, move.l, po)
    return commands.PtpPoCmd(move.ptp_mode, move.x, move.y, move.z, move.r, po)


# Sliding rail under the arm. Its carriage travels from 0 to 1000 mm.


def rail(on: bool, version: RailVersion | int | str) -> commands.SetDeviceWithL:
    """Says whether the arm stands on a rail, and of which generation (document 1.3.4, E15).

    Without this command an arm moves without its rail, and raises no error.
    """
    return commands.SetDeviceWithL(flag("on", on), rail_version(version))


def move_with_rail(x: float, y: float, z: float, r: float, rail: float) -> commands.PtpWithLCmd:
    """Goes to a pose and to ``rail`` mm on the rail (0 to 1000) at the same time, as :func:`move_to` does (document
    1.10.7).
    """
    return commands.PtpWithLCmd(PtpMode.MOVJ_XYZ, *checked(x=x, y=y, z=z, r=r, rail=rail))


def with_rail(move: Move, rail: float) -> commands.PtpWithLCmd | commands.PtpPoWithLCmd:
    """Adds a motion of the rail to any point-to-point move: to ``rail`` mm (0 to 1000), or by that distance if the move
    is an increment.

    Arm and rail start and end together. Outputs that the move switches stay, at most 56 (document 1.10.7 and 1.10.10).

    >>> over_there = with_rail(jump_to(220, 0, -20, 0), 600)
    """
    _move(move)
    rail = number("rail", rail, unit="mm")
    if isinstance(move, (commands.PtpPoCmd, commands.PtpPoWithLCmd)):
        if len(move.po) > 56:
            raise InvalidInputError("a move with the rail can switch at most 56 outputs")
        return commands.PtpPoWithLCmd(move.ptp_mode, move.x, move.y, move.z, move.r, rail, move.po)
    return commands.PtpWithLCmd(move.ptp_mode, move.x, move.y, move.z, move.r, rail)


def rail_to(position: float, pose: commands.Pose) -> commands.PtpWithLCmd:
    """Moves only the carriage, to this position in mm (0 to 1000): the arm keeps the joints of the pose read last.

    :func:`rail_by` needs no pose.
    """
    return commands.PtpWithLCmd(PtpMode.MOVJ_ANGLE, *pose.joint_angle, number("position", position, unit="mm"))


def rail_by(distance: float) -> commands.PtpWithLCmd:
    """Moves only the carriage, by this distance in mm; the arm keeps its joints."""
    return commands.PtpWithLCmd(PtpMode.MOVJ_ANGLE_INC, 0, 0, 0, 0, number("distance", distance, unit="mm"))


def rail_speed(velocity: float, acceleration: float) -> commands.PtpLParams:
    """Speed (mm/s) and acceleration (mm/s2) on the rail in point-to-point moves (document 1.10.6, E26).

    The ratios of :func:`speed` scale them.
    """
    return commands.PtpLParams(*_speed(velocity, acceleration))


def jog_rail_speed(velocity: float, acceleration: float) -> commands.JogLParams:
    """Speed (mm/s) and acceleration (mm/s2) of jogs on the rail; :func:`jog_speed` scales the speed (document 1.9.5,
    E25).
    """
    return commands.JogLParams(*_speed(velocity, acceleration))


# External motors, and the conveyor belt driven by one of them.


def motor(index: StepperLike, speed: int) -> commands.EMotor:
    """Runs an external motor at a speed in pulses/s (to about 1,000,000 either way); 0 stops it (document 1.15.6).

    The sign is the direction. The queue goes on at once.
    """
    speed = whole("speed", speed, -(2**31), 2**31 - 1)
    return commands.EMotor(stepper(index), speed != 0, speed)


def motor_by(index: StepperLike, speed: int, distance: int) -> commands.EMotorS:
    """Runs an external motor for a number of pulses; the sign of the speed (pulses/s) is the direction.

    In the queue it has finished when the motor has. Not in the vendor's document.
    """
    speed = whole("speed", speed, -(2**31), 2**31 - 1)
    return commands.EMotorS(stepper(index), True, speed, whole("distance", distance, 0, 2**32 - 1))


def conveyor(index: StepperLike, mm_per_s: float) -> commands.EMotor:
    """Runs the conveyor belt on this motor output at a speed in mm/s (to 120 either way; above it its motor stalls).

    The sign is the direction, 0 stops it. It runs until the next command for it, and the queue goes on at once.

    >>> from magician.commands import Stepper
    >>> feed = [conveyor(Stepper.STEPPER1, 50), wait_for_level(19, True), conveyor(Stepper.STEPPER1, 0)]
    """
    return motor(index, _pulse_rate(mm_per_s))


def conveyor_by(index: StepperLike, mm: float, mm_per_s: float) -> commands.EMotorS:
    """Moves the conveyor belt on this motor output by a distance in mm, at a speed in mm/s (of either sign).

    The sign of the distance is the direction. In the queue it has finished when the belt stands still. The arm counts
    whole pulses: the distance is exact to 0.0034 mm, and at most 28 km.
    """
    mm = number("mm", mm, least=-CONVEYOR_FARTHEST, most=CONVEYOR_FARTHEST, unit="mm")
    speed = _pulse_rate(math.copysign(number("mm_per_s", mm_per_s), mm))
    return motor_by(index, speed, round(abs(mm) * CONVEYOR_PULSES_PER_MM))


def _pulse_rate(mm_per_s: float) -> int:
    fast = number("mm_per_s", mm_per_s, least=-CONVEYOR_FASTEST, most=CONVEYOR_FASTEST, unit="mm/s")
    return round(fast * CONVEYOR_PULSES_PER_MM)


# External sensors.


def color_sensor(port: PortLike, on: bool, version: VersionLike) -> commands.SetColorSensor:
    """Switches the colour sensor on a port (document 1.15.7, E42). ``arm.color_at(port)`` reads it."""
    return commands.SetColorSensor(flag("on", on), _port(port), sensor_version(version))


def infrared(port: PortLike, on: bool, version: VersionLike) -> commands.SetIrSwitch:
    """Switches the infrared sensor on a port (document 1.15.8, E43). ``arm.infrared_at(port)`` reads it."""
    return commands.SetIrSwitch(flag("on", on), _port(port), sensor_version(version))


def color_at(port: PortLike) -> commands.GetColorSensor:
    """The query for a colour sensor: ``arm.get(words.color_at(port)).color``."""
    return commands.GetColorSensor(_port(port))


def infrared_at(port: PortLike) -> commands.GetIrSwitch:
    """The query for an infrared sensor: ``arm.get(words.infrared_at(port)).state``."""
    return commands.GetIrSwitch(_port(port))


def level_at(address: PinLike) -> commands.GetIoDi:
    """The query for a digital input (EIO address 1 to 20): ``arm.get(words.level_at(19)).level``."""
    return commands.GetIoDi(_pin(address))


def analog_at(address: PinLike) -> commands.GetIoAdc:
    """The query for an analog input (EIO address 1 to 20): ``arm.get(words.analog_at(12)).volts``."""
    return commands.GetIoAdc(_pin(address))

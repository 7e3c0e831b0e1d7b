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
from ._arguments import finite_numbers, flag, number, numbers, whole
from ._targets import CURRENT_R, JointTarget, Target, joints, position_of
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
"""A point-to-point move, optionally with outputs and with the rail."""

Tool = Literal["none", "suction", "gripper", "pen", "laser"]
"""Name of a tool with a known offset."""

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
"""Axis and direction of a jog."""

_TOOLS = dict(_magician.tools())

CONVEYOR_PULSES_PER_MM = _magician.CONVEYOR_PULSES_PER_MM
"""Pulses per mm of the vendor's belt: 16,000 per turn of its roller, 34 mm in diameter."""

CONVEYOR_FASTEST = _magician.CONVEYOR_FASTEST
"""Highest speed of the kit's belt, mm/s; its motor stalls above it."""

CONVEYOR_FARTHEST = _magician.CONVEYOR_FARTHEST
"""Longest distance of a belt move, mm: about 28 km."""

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
    *place, turned = position_of(x, y, z, r)
    return place[0], place[1], place[2], CURRENT_R if turned is None else turned


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
    """Moves to a pose with joint interpolation; the tool follows a curve (document 1.10.5, MOVJ).

    :param x: x in mm, or a whole pose (``arm.pose()``), or a sequence x, y, z and optionally r.
    :param r: Rotation of the tool, degrees; if left out, that of the previous move or of the arm.
    """
    return commands.PtpCmd(PtpMode.MOVJ_XYZ, *_spot(x, y, z, r))


@overload
def line_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def line_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def line_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Moves to a pose on a straight line (MOVL). Target as for :func:`move_to`."""
    return commands.PtpCmd(PtpMode.MOVL_XYZ, *_spot(x, y, z, r))


@overload
def jump_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def jump_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def jump_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Jumps to a pose over obstacles: up, across with joint interpolation, down (JUMP).

    :func:`jump_height` sets the height.
    """
    return commands.PtpCmd(PtpMode.JUMP_XYZ, *_spot(x, y, z, r))


@overload
def jump_line_to(x: float, y: float, z: float, r: float | None = None) -> commands.PtpCmd: ...
@overload
def jump_line_to(to: Target, /, *, r: float | None = None) -> commands.PtpCmd: ...
def jump_line_to(x: Any, y: float | None = None, z: float | None = None, r: float | None = None) -> commands.PtpCmd:
    """Jumps like :func:`jump_to`, but across on a straight line (E28: seen to do nothing on some firmware)."""
    return commands.PtpCmd(PtpMode.JUMP_MOVL_XYZ, *_spot(x, y, z, r))


@overload
def move_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def move_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def move_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Moves to joint angles, degrees, or to those of a pose."""
    return commands.PtpCmd(PtpMode.MOVJ_ANGLE, *_joints(j1, j2, j3, j4))


@overload
def line_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def line_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def line_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Moves to joint angles, degrees, with the tool on a straight line."""
    return commands.PtpCmd(PtpMode.MOVL_ANGLE, *_joints(j1, j2, j3, j4))


@overload
def jump_joints(j1: float, j2: float, j3: float, j4: float) -> commands.PtpCmd: ...
@overload
def jump_joints(to: JointTarget, /) -> commands.PtpCmd: ...
def jump_joints(j1: Any, j2: float | None = None, j3: float | None = None, j4: float | None = None) -> commands.PtpCmd:
    """Jumps to joint angles, degrees, over obstacles."""
    return commands.PtpCmd(PtpMode.JUMP_ANGLE, *_joints(j1, j2, j3, j4))


def move_by(dx: float = 0, dy: float = 0, dz: float = 0, dr: float = 0) -> commands.PtpCmd:
    """Moves by a distance (mm, degrees) from the pose at execution, with joint interpolation."""
    return commands.PtpCmd(PtpMode.MOVJ_XYZ_INC, *finite_numbers(dx=dx, dy=dy, dz=dz, dr=dr))


def line_by(dx: float = 0, dy: float = 0, dz: float = 0, dr: float = 0) -> commands.PtpCmd:
    """Moves by a distance (mm, degrees) from the pose at execution, on a straight line."""
    return commands.PtpCmd(PtpMode.MOVL_XYZ_INC, *finite_numbers(dx=dx, dy=dy, dz=dz, dr=dr))


def move_joints_by(d1: float = 0, d2: float = 0, d3: float = 0, d4: float = 0) -> commands.PtpCmd:
    """Turns the joints by these angles, degrees, relative to those at execution."""
    return commands.PtpCmd(PtpMode.MOVJ_ANGLE_INC, *finite_numbers(d1=d1, d2=d2, d3=d3, d4=d4))


def arc_to(via: Four, to: Four) -> commands.ArcCmd:
    """Moves to ``to`` along the arc through ``via``; both are x, y, z, r, and the r of ``via`` is ignored (document
    1.12.2, E33).

    The current position and the two points must be distinct and not collinear. :func:`arc_speed` sets the speed.
    """
    return commands.ArcCmd(_four("via", via), _four("to", to))


def circle(via: Four, over: Four, turns: int = 1) -> commands.CircleCmd:
    """Moves ``turns`` times along the circle through the current pose, ``via`` and ``over``, and ends where it began.

    Both are x, y, z, r; r stays unchanged. Not in the vendor's document (E33).
    """
    return commands.CircleCmd(_four("via", via), _four("over", over), whole("turns", turns, 1, 0xFFFF_FFFF))


def path_to(x: float, y: float, z: float) -> commands.CpCmd:
    """Appends a segment to a continuous path, to a point, mm (document 1.11.2, E31 and E32).

    The tool does not stop between consecutive segments, and J4 does not turn. :func:`path_speed` sets the speed.
    """
    return commands.CpCmd(commands.CpMode.ABSOLUTE, number("x", x), number("y", y), number("z", z), 0)


def path_by(dx: float = 0, dy: float = 0, dz: float = 0) -> commands.CpCmd:
    """Appends a segment to a continuous path, by a distance, mm, from the end of the previous segment."""
    return commands.CpCmd(commands.CpMode.RELATIVE, number("dx", dx), number("dy", dy), number("dz", dz), 0)


def engrave_to(x: float, y: float, z: float, power: float) -> commands.CpLeCmd:
    """Appends a segment like :func:`path_to`, with the laser at ``power`` percent (0 to 100) (document 1.11.3, E32).

    End the path with ``laser(False)`` or a segment of power 0.
    """
    point = number("x", x), number("y", y), number("z", z)
    return commands.CpLeCmd(commands.CpMode.ABSOLUTE, *point, _power(power))


def engrave_by(dx: float, dy: float, dz: float, power: float) -> commands.CpLeCmd:
    """Appends a segment like :func:`engrave_to`, by a distance, mm, from the end of the previous segment."""
    way = number("dx", dx), number("dy", dy), number("dz", dz)
    return commands.CpLeCmd(commands.CpMode.RELATIVE, *way, _power(power))


def home() -> commands.HomeCmd:
    """Homes the arm, in up to half a minute (document 1.6.2).

    The method ``arm.home()`` also clears the alarm that the arm raises at power-up.
    """
    return commands.HomeCmd()


def home_at(x: float, y: float, z: float, r: float) -> commands.HomeParams:
    """Sets the home point, where :func:`home` ends from now on (document 1.6.1)."""
    return commands.HomeParams(*finite_numbers(x=x, y=y, z=z, r=r))


_AXES: dict[str, tuple[bool, JogCommand]] = {
    f"{name}{sign}": (is_joint, JogCommand(2 * at + back + 1))
    for is_joint, names in ((False, "xyzr"), (True, ("j1", "j2", "j3", "j4", "rail")))
    for at, name in enumerate(names)
    for back, sign in enumerate("+-")
}


def jog(direction: Direction) -> commands.JogCmd:
    """Jogs a coordinate, a joint or the rail until stopped: ``"x+"``, ``"j2-"``, ``"rail+"`` (document 1.9.4,
    E25).

    Use ``arm.jog``, which ends it. In a program it would run until a limit raises an alarm.
    """
    if direction not in _AXES:
        raise InvalidInputError(f"unknown direction {direction!r}; known are {', '.join(_AXES)}")
    is_joint, command = _AXES[direction]
    return commands.JogCmd(is_joint, command)


def check_lost_steps() -> commands.LostStepCmd:
    """Checks for lost steps: compares the joints with their sensors. A lost step raises an alarm (E36)."""
    return commands.LostStepCmd()


def lost_step_threshold(degrees: float) -> commands.LostStepParams:
    """Sets the lost-step threshold: the largest allowed deviation of a joint, degrees; 5 at power-up (document 1.18.1).

    This command cannot be queued: pass it to ``arm.set``.
    """
    return commands.LostStepParams(number("degrees", degrees, above=0, unit="deg"))


# Speeds and jump height.


def speed(velocity: float, acceleration: float | None = None) -> commands.PtpCommonParams:
    """Sets the speed and acceleration ratios of point-to-point moves, percent (document 1.10.4).

    Above 0; more than 100 counts as 100. The acceleration ratio equals the velocity ratio if left out.
    """
    return commands.PtpCommonParams(*_ratios(velocity, acceleration))


def joint_speed(velocity: Four, acceleration: Four) -> commands.PtpJointParams:
    """Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves, above 0 (document 1.10.1).

    The arm limits them to 320 deg/s (J4: 480 deg/s) and 300 deg/s2.
    """
    return commands.PtpJointParams(_four("velocity", velocity), _four("acceleration", acceleration))


def line_speed(velocity: float, acceleration: float) -> commands.PtpCoordinateParams:
    """Sets speed (mm/s) and acceleration (mm/s2) of the tool on straight lines (document 1.10.2).

    The rotation gets half of each in degrees, as at power-up. The arm limits them to 300 mm/s and 400 mm/s2.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.PtpCoordinateParams(velocity, velocity / 2, acceleration, acceleration / 2)


def path_speed(velocity: float, acceleration: float) -> commands.CpParams:
    """Sets maximum speed (mm/s) and acceleration (mm/s2) of continuous paths (document 1.11.1, E31).

    The arm slows down at corners by itself.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.CpParams(acceleration, velocity, acceleration, False)


def arc_speed(velocity: float, acceleration: float) -> commands.ArcParams:
    """Sets speed (mm/s) and acceleration (mm/s2) of arcs and circles, and of the rotation in degrees (document 1.12.1).

    In the vendor's code arcs use the speeds of :func:`line_speed` instead (model section 9): set both.
    """
    velocity, acceleration = _speed(velocity, acceleration)
    return commands.ArcParams(velocity, velocity, acceleration, acceleration)


def jump_height(height: float, z_limit: float) -> commands.PtpJumpParams:
    """Sets the lift of jumps above the higher end, and the upper z limit, mm (document 1.10.3, E30)."""
    return commands.PtpJumpParams(*finite_numbers(height=height, z_limit=z_limit))


def jump_heights(start: float, end: float, z_limit: float) -> commands.PtpJump2Params:
    """Sets the lift of jumps above start and end, and the upper z limit, mm (document 1.10.8, E27)."""
    return commands.PtpJump2Params(*finite_numbers(start=start, end=end, z_limit=z_limit))


def jog_speed(velocity: float, acceleration: float | None = None) -> commands.JogCommonParams:
    """Sets the jog speed ratio, percent: above 0, more than 100 counts as 100 (document 1.9.3).

    The acceleration of jogs is not scaled.
    """
    return commands.JogCommonParams(*_ratios(velocity, acceleration))


def jog_joint_speed(velocity: Four, acceleration: Four) -> commands.JogJointParams:
    """Sets speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in joint jogs (document 1.9.1)."""
    return commands.JogJointParams(_four("velocity", velocity), _four("acceleration", acceleration))


def jog_axis_speed(velocity: Four, acceleration: Four) -> commands.JogCoordinateParams:
    """Sets speeds (mm/s; deg/s for r) and accelerations (mm/s2; deg/s2) of x, y, z and r in Cartesian jogs (document
    1.9.2)."""
    return commands.JogCoordinateParams(_four("velocity", velocity), _four("acceleration", acceleration))


# Tool.


def tool(name: Tool | None = None, *, x: float = 0, y: float = 0, z: float = 0) -> commands.EndEffectorParams:
    """Sets the tool: its name, or the offset of its tip, x, y, z in mm from the wrist. Poses refer to this tip.

    >>> tool("suction").x_bias
    59.7
    """
    if name is None:
        return commands.EndEffectorParams(*finite_numbers(x=x, y=y, z=z))
    bias = bias_of(name)
    if (x, y, z) != (0, 0, 0):
        raise InvalidInputError("a tool has a name, or x, y, z")
    return commands.EndEffectorParams(*bias)


def bias_of(tool: Tool | Sequence[float]) -> tuple[float, float, float]:
    """Returns the offset of a tool's tip from the wrist, x, y, z in mm, from a name or an offset.

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
    """Switches the suction cup on or off; it takes about 0.3 s to hold (document 1.8.3).

    Suction cup and gripper share one pump; the later command takes effect.
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
    """Switches the laser to full power or off (document 1.8.2). Off also ends the power of a path.

    The check ``laser`` refuses a program that leaves it on, or waits or travels with it on.
    """
    on = flag("on", on)
    return commands.SetEndEffectorLaser(on, on)


# Waits, triggers and pins.


def wait(seconds: float) -> commands.WaitCmd:
    """Holds the queue for a time, s, with a resolution of 1 ms and at most 49 days (document 1.13.1, E34)."""
    return commands.WaitCmd(round(number("seconds", seconds, least=0, most=0xFFFF_FFFF / 1000, unit="s") * 1000))


def wait_for_level(address: PinLike, high: bool) -> commands.TrigCmd:
    """Holds the queue until a digital input (EIO address 1 to 20) has this level, without timeout (document 1.14.1)."""
    return commands.TrigCmd(_pin(address), TriggerMode.LEVEL, TriggerCondition.EQUAL_OR_BELOW, int(flag("high", high)))


def wait_below(address: PinLike, threshold: int) -> commands.TrigCmd:
    """Holds the queue until an analog input (EIO address 1 to 20) is below a threshold, without timeout.

    The threshold is 0 to 4095 counts, 4095 at 3.3 V (document 1.14.1, E35).
    """
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.EQUAL_OR_BELOW, _counts(threshold))


def wait_at_most(address: PinLike, threshold: int) -> commands.TrigCmd:
    """Holds the queue until the input is at most the threshold, as :func:`wait_below`."""
    return commands.TrigCmd(
        _pin(address), TriggerMode.ANALOG, TriggerCondition.DIFFERENT_OR_AT_MOST, _counts(threshold)
    )


def wait_at_least(address: PinLike, threshold: int) -> commands.TrigCmd:
    """Holds the queue until the input is at least the threshold, as :func:`wait_below`."""
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.AT_LEAST, _counts(threshold))


def wait_above(address: PinLike, threshold: int) -> commands.TrigCmd:
    """Holds the queue until the input is above the threshold, as :func:`wait_below`."""
    return commands.TrigCmd(_pin(address), TriggerMode.ANALOG, TriggerCondition.ABOVE, _counts(threshold))


def multiplex(address: PinLike, function: FunctionLike) -> commands.IoMultiplexing:
    """Sets the function of an EIO pin (1 to 20), before the pin can be used (document 1.15.1, E40)."""
    return commands.IoMultiplexing(_pin(address), _function(function))


def output(address: PinLike, high: bool) -> commands.IoDo:
    """Sets the level of a digital output (EIO address 1 to 20; document 1.15.2)."""
    return commands.IoDo(_pin(address), flag("high", high))


def pwm(address: PinLike, frequency: float, duty_cycle: float) -> commands.IoPwm:
    """Sets a pulse-width output (EIO address 1 to 20): frequency, Hz (10 to 1000000), and duty cycle, percent.

    Document 1.15.3.
    """
    return commands.IoPwm(
        _pin(address),
        number("frequency", frequency, least=10, most=1_000_000, unit="Hz"),
        number("duty_cycle", duty_cycle, least=0, most=100, unit="%"),
    )


def servo(address: PinLike, pulse_ms: float) -> commands.IoPwm:
    """Sets the position of a hobby servo on a pulse-width pin (EIO 4, 6, 8, 11 or 14) by its pulse width, at 50 Hz.

    1.5 ms is the centre of most servos; all accept 1 to 2 ms, many 0.5 to 2.5 ms. 0 releases the servo; the maximum is
    20 ms. Multiplex the pin to ``IoFunction.PWM`` first (EIO 8, 6 and 4 have driven servos).
    """
    return pwm(address, 50, 100 * number("pulse_ms", pulse_ms, least=0, most=20, unit="ms") / 20)


def with_outputs(move: Move, outputs: Iterable[Output]) -> commands.PtpPoCmd | commands.PtpPoWithLCmd:
    """Adds outputs that a point-to-point move switches on its way, in any order, at most 57, or 56 with the rail.

    They replace the existing outputs of the move (document 1.10.9 and 1.10.10, E29).

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
    """Sets whether the arm is mounted on a rail, and the rail's version (document 1.3.4, E15).

    Without this command an arm moves without its rail and raises no error.
    """
    return commands.SetDeviceWithL(flag("on", on), rail_version(version))


def move_with_rail(x: float, y: float, z: float, r: float, rail: float) -> commands.PtpWithLCmd:
    """Moves to a pose and to ``rail`` mm on the rail (0 to 1000) at the same time, as :func:`move_to` (document
    1.10.7).
    """
    return commands.PtpWithLCmd(PtpMode.MOVJ_XYZ, *finite_numbers(x=x, y=y, z=z, r=r, rail=rail))


def with_rail(move: Move, rail: float) -> commands.PtpWithLCmd | commands.PtpPoWithLCmd:
    """Adds a rail motion to any point-to-point move: to ``rail`` mm (0 to 1000), or by that distance if the move is
    relative.

    Arm and rail start and end together. Outputs of the move are kept, at most 56 (document 1.10.7 and 1.10.10).

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
    """Sets speed (mm/s) and acceleration (mm/s2) of the rail in point-to-point moves (document 1.10.6, E26).

    The ratios of :func:`speed` scale them.
    """
    return commands.PtpLParams(*_speed(velocity, acceleration))


def jog_rail_speed(velocity: float, acceleration: float) -> commands.JogLParams:
    """Sets speed (mm/s) and acceleration (mm/s2) of rail jogs; :func:`jog_speed` scales the speed (document 1.9.5,
    E25).
    """
    return commands.JogLParams(*_speed(velocity, acceleration))


# External motors, and the conveyor belt driven by one of them.


def motor(index: StepperLike, speed: int) -> commands.EMotor:
    """Runs an external motor at a speed in pulses/s (to about 1,000,000 either way); 0 stops it (document 1.15.6).

    The sign is the direction. The queue continues at once.
    """
    speed = whole("speed", speed, -(2**31), 2**31 - 1)
    return commands.EMotor(stepper(index), speed != 0, speed)


def motor_by(index: StepperLike, speed: int, distance: int) -> commands.EMotorS:
    """Runs an external motor for a number of pulses; the sign of the speed (pulses/s) is the direction.

    The queue waits until the motor has finished. Not in the vendor's document.
    """
    speed = whole("speed", speed, -(2**31), 2**31 - 1)
    return commands.EMotorS(stepper(index), True, speed, whole("distance", distance, 0, 2**32 - 1))


def conveyor(index: StepperLike, mm_per_s: float) -> commands.EMotor:
    """Runs the conveyor belt on this motor output at a speed in mm/s (to 120 either way; above it its motor stalls).

    The sign is the direction, 0 stops it. The belt runs until the next command for it, and the queue continues at once.

    >>> from magician.commands import Stepper
    >>> feed = [conveyor(Stepper.STEPPER1, 50), wait_for_level(19, True), conveyor(Stepper.STEPPER1, 0)]
    """
    return motor(index, _pulse_rate(mm_per_s))


def conveyor_by(index: StepperLike, mm: float, mm_per_s: float) -> commands.EMotorS:
    """Moves the conveyor belt on this motor output by a distance in mm, at a speed in mm/s (of either sign).

    The sign of the distance is the direction. The queue waits until the belt is at rest. The arm counts whole pulses,
    so the resolution is 0.0034 mm, and the maximum 28 km.
    """
    mm = number("mm", mm, least=-CONVEYOR_FARTHEST, most=CONVEYOR_FARTHEST, unit="mm")
    speed = _pulse_rate(math.copysign(number("mm_per_s", mm_per_s), mm))
    return motor_by(index, speed, round(abs(mm) * CONVEYOR_PULSES_PER_MM))


def _pulse_rate(mm_per_s: float) -> int:
    fast = number("mm_per_s", mm_per_s, least=-CONVEYOR_FASTEST, most=CONVEYOR_FASTEST, unit="mm/s")
    return round(fast * CONVEYOR_PULSES_PER_MM)


# External sensors.


def color_sensor(port: PortLike, on: bool, version: VersionLike) -> commands.SetColorSensor:
    """Enables or disables the colour sensor on a port (document 1.15.7, E42). ``arm.color_at(port)`` reads it."""
    return commands.SetColorSensor(flag("on", on), _port(port), sensor_version(version))


def infrared(port: PortLike, on: bool, version: VersionLike) -> commands.SetIrSwitch:
    """Enables or disables the infrared sensor on a port (document 1.15.8, E43). ``arm.infrared_at(port)`` reads it."""
    return commands.SetIrSwitch(flag("on", on), _port(port), sensor_version(version))


def color_at(port: PortLike) -> commands.GetColorSensor:
    """Creates the query for a colour sensor: ``arm.get(words.color_at(port)).color``."""
    return commands.GetColorSensor(_port(port))


def infrared_at(port: PortLike) -> commands.GetIrSwitch:
    """Creates the query for an infrared sensor: ``arm.get(words.infrared_at(port)).state``."""
    return commands.GetIrSwitch(_port(port))


def level_at(address: PinLike) -> commands.GetIoDi:
    """Creates the query for a digital input (EIO address 1 to 20): ``arm.get(words.level_at(19)).level``."""
    return commands.GetIoDi(_pin(address))


def analog_at(address: PinLike) -> commands.GetIoAdc:
    """Creates the query for an analog input (EIO address 1 to 20): ``arm.get(words.analog_at(12)).volts``."""
    return commands.GetIoAdc(_pin(address))

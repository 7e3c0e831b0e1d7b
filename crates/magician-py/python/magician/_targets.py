"""Targets of motions: numbers, poses, and values taken from the arm's state."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, cast

from ._arguments import not_a_file, number, numbers
from ._meaning import Joints, Position
from .commands import (
    ArcCmd,
    CpCmd,
    CpLeCmd,
    HomeCmd,
    JogCmd,
    Pose,
    PtpCmd,
    PtpMode,
    PtpPoCmd,
    PtpPoWithLCmd,
    PtpWithLCmd,
    Queueable,
)
from .errors import InvalidInputError

__all__ = ["CURRENT_R", "JointTarget", "Target", "command_list", "fill_r", "joints", "keeps_r", "position_of"]

Target = Pose | Position | Sequence[float]
"""Cartesian target: a pose, or a sequence x, y, z and optionally r."""
JointTarget = Pose | Joints | Sequence[float]
"""Joint target: the joints of a pose, or a sequence J1 to J3 and optionally J4."""

CURRENT_R = cast(float, None)
"""Placeholder r of a move that keeps the rotation; :func:`fill_r` replaces it once known."""

_POINT_MOVES = (PtpCmd, PtpPoCmd, PtpWithLCmd, PtpPoWithLCmd)
_INCREMENTS = (PtpMode.MOVL_XYZ_INC, PtpMode.MOVJ_XYZ_INC)
# Commands that leave r open: J4 keeps its angle along a path or jog, and homing ends at its stored pose.
_R_UNKNOWN_AFTER = (CpCmd, CpLeCmd, HomeCmd, JogCmd)
_ANGLES = (PtpMode.JUMP_ANGLE, PtpMode.MOVJ_ANGLE, PtpMode.MOVL_ANGLE)


def position_of(x: Any, y: float | None, z: float | None, r: float | None) -> tuple[float, float, float, float | None]:
    """Returns x, y, z, and r if given, from four numbers or one target."""
    if isinstance(x, Pose) and y is None and z is None:
        given: Sequence[float] = x.position
    elif y is not None or z is not None or _is_number(x):
        # Separate conversions, so that an error names the argument that is missing or not a number.
        given = (
            number("x", _required("x", cast(Any, x))),
            number("y", _required("y", y)),
            number("z", _required("z", z)),
        )
        return given[0], given[1], given[2], number("r", r, unit="deg")
    else:
        values = tuple(x)
        given = numbers("to", values, 4 if len(values) == 4 else 3)
    own = given[3] if len(given) == 4 else None
    return given[0], given[1], given[2], own if r is None else number("r", r, unit="deg")


def joints(j1: Any, j2: float | None, j3: float | None, j4: float | None) -> tuple[float, float, float, float | None]:
    """Returns J1 to J3, and J4 if given, from four numbers or one target."""
    if isinstance(j1, Pose) and j2 is None and j3 is None:
        given: Sequence[float] = j1.joint_angle
    elif j2 is not None or j3 is not None or _is_number(j1):
        two, three = _required("j2", j2), _required("j3", j3)
        return number("j1", _required("j1", cast(Any, j1))), number("j2", two), number("j3", three), number("j4", j4)
    else:
        values = tuple(j1)
        given = numbers("to", values, 4 if len(values) == 4 else 3)
    own = given[3] if len(given) == 4 else None
    return given[0], given[1], given[2], own if j4 is None else number("j4", j4)


def _is_number(value: object) -> bool:
    """True for a number, false for a sequence of numbers."""
    # `__float__` does not tell: NumPy arrays have it too. An array of zero dimensions is a number.
    return isinstance(value, (str, bytes)) or not hasattr(value, "__len__") or getattr(value, "ndim", 1) == 0


def _required(name: str, value: float | None) -> float:
    if value is None:
        raise TypeError(f"{name} is left out; a move takes a pose, a row of numbers, or all of them")
    return value


def command_list(commands: Iterable[Queueable]) -> list[Queueable]:
    """Collects the commands of a program, up to the first item that is not a command, because a program may be
    endless."""
    made: list[Queueable] = []
    for each in not_a_file(commands):
        if not hasattr(each, "LAYOUT"):
            raise TypeError(f"{each!r} is not a command of magician.commands")
        made.append(each)
    return made


def keeps_r(command: object) -> bool:
    """True if a command is a move that keeps an r that is not yet known."""
    return isinstance(command, _POINT_MOVES) and cast(Any, command.r) is None


def fill_r(commands: Iterable[Queueable], r: float | None) -> list[Queueable]:
    """Fills in every r of the commands; ``r`` is that of the arm before them, if known.

    :raises InvalidInputError: A move keeps an unknown r: after a path, homing, or at the start of a plan.
    """
    return list(map(RFiller(r), command_list(commands)))


class RFiller:
    """Fills in r of commands one by one, as :func:`fill_r`."""

    def __init__(self, r: float | None) -> None:
        self._r = r
        self._step = 0

    def __call__(self, command: Queueable) -> Queueable:
        """Returns the next command with its r."""
        step, self._step = self._step, self._step + 1
        if isinstance(command, _POINT_MOVES):
            if keeps_r(command):
                if self._r is None:
                    raise InvalidInputError(
                        f"{type(command).__name__}: r is left out, and the arm's r at that point is not known: "
                        f"{'the program begins here' if step == 0 else 'a path or homing came before'}; give r",
                        step=step,
                    )
                command = _with_r(command, self._r)
            self._r = _after(command, self._r)
        elif isinstance(command, ArcCmd):
            self._r = command.to_point[3]
        elif isinstance(command, _R_UNKNOWN_AFTER):
            self._r = None
        return command


def _after(move: PtpCmd | PtpPoCmd | PtpWithLCmd | PtpPoWithLCmd, r: float | None) -> float | None:
    mode = move.ptp_mode
    if mode in _INCREMENTS:
        return None if r is None else r + move.r
    if mode in _ANGLES:
        return move.x + move.r
    if mode == PtpMode.MOVJ_ANGLE_INC:
        return None if r is None else r + move.x + move.r
    return move.r


def _with_r(
    move: PtpCmd | PtpPoCmd | PtpWithLCmd | PtpPoWithLCmd, r: float
) -> PtpCmd | PtpPoCmd | PtpWithLCmd | PtpPoWithLCmd:
    place = move.ptp_mode, move.x, move.y, move.z, r
    if isinstance(move, PtpPoWithLCmd):
        return PtpPoWithLCmd(*place, move.l, move.po)
    if isinstance(move, PtpWithLCmd):
        return PtpWithLCmd(*place, move.l)
    if isinstance(move, PtpPoCmd):
        return PtpPoCmd(*place, move.po)
    return PtpCmd(*place)

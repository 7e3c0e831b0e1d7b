"""Where things are: poses by their names, work planes, and pallets.

* :class:`Poses` keeps poses in a file, by name: ``arm.poses["tray"] = arm.pose()``, ``arm.move_to("tray")``.
* :class:`Frame` is a work plane that three points say: ``arm.line_to(frame(10, 20))``.
* :class:`Pallet` is rows by columns of places that three or four of its corners say.
* :class:`Belt` is a conveyor that runs evenly: ``arm.pick_from_belt((180, -150, -30), Belt(40))``.
* :func:`picking`, :func:`placing` and :func:`meeting` are what ``arm.pick``, ``arm.place`` and
  ``arm.pick_from_belt`` do, as commands for a program.

Lengths are mm, angles degrees. The tool of this arm always points down: a frame may slope, and the tool does not.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, MutableMapping, Sequence
from pathlib import Path
from typing import Any, Literal

from . import _magician, words
from ._arguments import checked, number, numbers, seconds, text, whole
from ._meaning import Position
from ._targets import Target
from ._values import Value
from .commands import Pose, Queueable
from .errors import InvalidInputError

__all__ = ["Belt", "Frame", "Pallet", "Point", "Poses", "meeting", "picking", "placing"]

_Point = tuple[float, float, float]

_APART = 1e-3
"""Points nearer to each other than this, or to the line through two others, say no plane, mm."""


class Frame(Value):
    """A work plane: coordinates of its own, in which things are placed on a table, a tray or a slope.

    >>> frame = Frame.from_points((200, -50, 10), (200, 50, 10), (150, -50, 10))
    >>> frame(10, 0)
    Position(x=200.0, y=-40.0, z=10.0, r=90.0)
    >>> frame.from_arm(200, -40, 15)
    Position(x=10.0, y=0.0, z=5.0, r=-90.0)
    """

    origin: tuple[float, float, float]
    """Its origin, in the arm's coordinates."""
    x_axis: tuple[float, float, float]
    """Its X, of length 1."""
    y_axis: tuple[float, float, float]
    """Its Y, of length 1, at right angles to X."""

    @classmethod
    def from_points(cls, origin: Target, on_x: Target, on_y: Target) -> Frame:
        """The plane through three points that the tool has touched, poses or x, y, z.

        :param origin: The origin.
        :param on_x: Any point of its X axis, on the positive side: the further away, the more exact.
        :param on_y: Any point on the side of its Y axis. It need not lie on the axis.
        :raises InvalidInputError: They lie on a line, or two of them on each other.
        """
        corner, right, left = _point("origin", origin), _point("on_x", on_x), _point("on_y", on_y)
        along, across = _minus(right, corner), _minus(left, corner)
        length = math.hypot(*along)
        if length < _APART:
            raise InvalidInputError("origin and on_x are the same point: a frame takes three points that are apart")
        x_axis = _times(along, 1 / length)
        across = _minus(across, _times(x_axis, _dot(across, x_axis)))
        height = math.hypot(*across)
        if height < _APART:
            raise InvalidInputError("the three points lie on a line: a frame takes on_y beside it")
        return cls(corner, x_axis, _times(across, 1 / height))

    @classmethod
    def level(cls, x: float, y: float, z: float, rotation: float = 0.0) -> Frame:
        """A level plane.

        :param x: Its origin, forward.
        :param y: Its origin, to the arm's left.
        :param z: Its height.
        :param rotation: How its X runs, from the arm's X towards its Y.
        """
        turn = math.radians(number("rotation", rotation, unit="deg"))
        cos, sin = math.cos(turn), math.sin(turn)
        x, y, z = checked(x=x, y=y, z=z)
        return cls((x, y, z), (cos, sin, 0.0), (-sin, cos, 0.0))

    @property
    def z_axis(self) -> tuple[float, float, float]:
        """Its Z, of length 1: out of the plane."""
        (a, b, c), (d, e, f) = self.x_axis, self.y_axis
        return b * f - c * e, c * d - a * f, a * e - b * d

    @property
    def rotation(self) -> float:
        """How its X runs as seen from above, from the arm's X towards its Y: what it adds to r."""
        return math.degrees(math.atan2(self.x_axis[1], self.x_axis[0]))

    @property
    def slope(self) -> float:
        """By how much it slopes: 0 is level."""
        return math.degrees(math.acos(max(-1.0, min(1.0, abs(self.z_axis[2])))))

    def to_arm(self, x: float, y: float, z: float = 0.0, r: float = 0.0) -> Position:
        """A place in this frame, in the arm's coordinates. ``frame(x, y, z, r)`` is the same.

        :param z: Height above the plane, at right angles to it.
        :param r: Rotation of the tool; 0 is along the frame's X.
        """
        x, y, z, r = checked(x=x, y=y, z=z, r=r)
        place = _plus(self.origin, _times(self.x_axis, x), _times(self.y_axis, y), _times(self.z_axis, z))
        return _position(place, _turned(r + self.rotation))

    __call__ = to_arm

    def from_arm(self, x: float, y: float, z: float, r: float = 0.0) -> Position:
        """A place in the arm's coordinates, in this frame: ``frame.from_arm(*arm.pose())``."""
        x, y, z, r = checked(x=x, y=y, z=z, r=r)
        way = _minus((x, y, z), self.origin)
        place = _dot(way, self.x_axis), _dot(way, self.y_axis), _dot(way, self.z_axis)
        return _position(place, _turned(r - self.rotation))


class Belt(Value):
    """A conveyor that runs evenly, as :meth:`magician.Arm.pick_from_belt` takes it.

    >>> Belt(40, direction=90).after((220, -100, 0), 0.5)
    Position(x=220.0, y=-80.0, z=0.0, r=0.0)
    """

    mm_per_s: float
    """Its speed; below 0 it runs backwards."""
    direction: float = 0.0
    """Where it runs, degrees from the arm's X towards its Y."""

    def __init__(self, mm_per_s: float, direction: float = 0.0) -> None:
        """A belt.

        :param mm_per_s: Its speed, mm/s, as for :meth:`magician.Arm.conveyor`.
        :param direction: Where it runs for a positive speed, degrees: 0 along the arm's X, 90 along its Y.
        """
        super().__init__(number("mm_per_s", mm_per_s, unit="mm/s"), number("direction", direction, unit="deg"))

    @property
    def velocity(self) -> tuple[float, float, float]:
        """How what lies on it moves, mm/s along x, y and z."""
        turn = math.radians(self.direction)
        return self.mm_per_s * math.cos(turn), self.mm_per_s * math.sin(turn), 0.0

    def after(self, at: Target, seconds: float) -> Position:
        """Where something that is at a place now will be after so many seconds."""
        time = number("seconds", seconds, unit="s")
        return _position(_plus(_point("at", at), _times(self.velocity, time)), _rotation(at))


class Pallet(Value):
    """Rows by columns of places: a list of :class:`~magician.Position`, row after row.

    >>> tray = Pallet(2, 3, first=(200, 0, -20), end_of_row=(200, 60, -20), last_row=(240, 0, -20))
    >>> len(tray), tray[0], tray[1, 2]
    (6, Position(x=200.0, y=0.0, z=-20.0, r=0.0), Position(x=240.0, y=60.0, z=-20.0, r=0.0))
    """

    rows: int
    """Rows."""
    columns: int
    """Places of a row."""
    first: Position
    """The first place."""
    end_of_row: Position
    """The last place of the first row."""
    last_row: Position
    """The first place of the last row."""
    opposite: Position
    """The last place."""

    def __init__(
        self,
        rows: int,
        columns: int,
        first: Target,
        end_of_row: Target,
        last_row: Target,
        opposite: Target | None = None,
    ) -> None:
        """The corners are poses, or x, y, z and perhaps r; the tool turns everywhere as at the first.

        :param rows: Rows, 1 or more.
        :param columns: Places of a row, 1 or more.
        :param first: The first place.
        :param end_of_row: The last place of its row.
        :param last_row: The first place of the last row.
        :param opposite: The last place of the last row, for a pallet that is not quite a parallelogram.
        """
        rows, columns = whole("rows", rows, 1, 10_000), whole("columns", columns, 1, 10_000)
        r = _rotation(first)
        one, right, left = _point("first", first), _point("end_of_row", end_of_row), _point("last_row", last_row)
        last = _plus(right, _minus(left, one)) if opposite is None else _point("opposite", opposite)
        super().__init__(rows, columns, *(Position(*corner, r) for corner in (one, right, left, last)))

    def __len__(self) -> int:
        return self.rows * self.columns

    def __getitem__(self, at: int | tuple[int, int]) -> Position:
        """A place by its number, from 0, or by its row and column."""
        if isinstance(at, tuple):
            row, column = at
        else:
            at = whole("at", at, -(2**63), 2**63)
            if not -len(self) <= at < len(self):
                raise IndexError(f"there is no place {at}; there are {len(self)}")
            row, column = divmod(at % len(self), self.columns)
        if not (0 <= row < self.rows and 0 <= column < self.columns):
            raise IndexError(f"there is no row {row}, column {column}; there are {self.rows} by {self.columns}")
        down, along = row / max(1, self.rows - 1), column / max(1, self.columns - 1)
        shares = (1 - down) * (1 - along), (1 - down) * along, down * (1 - along), down * along
        corners = self.first, self.end_of_row, self.last_row, self.opposite
        place = _plus(*(_times(corner[:3], share) for corner, share in zip(corners, shares, strict=True)))
        return _position(place, self.first.r)

    def __iter__(self) -> Iterator[Position]:
        return (self[at] for at in range(len(self)))


class Point(Value):
    """A point that was taught: see :meth:`magician.Arm.teach`."""

    name: str
    """Its name."""
    position: Position
    """Where it is: ``arm.move_to(point.position)``."""


class Poses(MutableMapping[str, Position]):
    """Poses by their names, kept in a JSON file that people can read and edit.

    What is set is in the file at once; what somebody else writes there is seen by the next look.

    >>> poses = Poses("tray.json")
    >>> poses["above"] = (220, 0, 60, 0)
    >>> poses["above"]
    Position(x=220.0, y=0.0, z=60.0, r=0.0)
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        """Nothing is read or written before it is asked for.

        :param path: The file; ``poses.json`` beside the program that runs if it is left out, and in the current folder
            where there is none, as in a notebook.
        """
        self.path = Path(path) if path is not None else _beside() / "poses.json"
        """The file."""

    def __getitem__(self, name: str) -> Position:
        found = self._read()
        if name not in found:
            raise KeyError(f"there is no pose {name!r} in {self.path}; there are {', '.join(found) or 'none'}")
        return found[name]

    def __setitem__(self, name: str, pose: Target) -> None:
        if not text("name", name):
            raise InvalidInputError("a pose has a name")
        x, y, z = _point("pose", pose)
        self._write({**self._read(), name: Position(x, y, z, _rotation(pose))})

    def __delitem__(self, name: str) -> None:
        found = self._read()
        self[name]
        del found[name]
        self._write(found)

    def __iter__(self) -> Iterator[str]:
        return iter(self._read())

    def __len__(self) -> int:
        return len(self._read())

    def __repr__(self) -> str:
        return f"<Poses in {str(self.path)!r}>"

    def _read(self) -> dict[str, Position]:
        import json

        try:
            found: Any = json.loads(self.path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except ValueError as error:
            raise InvalidInputError(f"{self.path} is not a file of poses: {error}") from None
        try:
            return {str(name): Position(*(float(each[axis]) for axis in "xyzr")) for name, each in found.items()}
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            why = f"{type(error).__name__}: {error}"
            raise InvalidInputError(
                f'{self.path} is not a file of poses ({why}); expected {{"NAME": {{"x": 220, "y": 0, "z": 9, "r": 0}}}}'
            ) from None

    def _write(self, poses: dict[str, Position]) -> None:
        import json

        lines = [
            f"  {json.dumps(name, ensure_ascii=False)}: {json.dumps(pose._asdict())}" for name, pose in poses.items()
        ]
        written = "{\n" + ",\n".join(lines) + "\n}\n" if lines else "{}\n"
        # The file is the old one or the new one, whatever ends the program.
        _magician.write_whole(self.path, written.encode())


def picking(
    at: tuple[float, float, float],
    r: float | None = None,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
) -> list[Queueable]:
    """The commands of :meth:`magician.Arm.pick`. Without ``r`` the tool keeps its rotation."""
    opened: list[Queueable] = [words.release()] if _is_gripper(tool) else []
    take = words.grip() if opened else words.suction(True)
    return _over(at, r, opened, take, approach, retreat, _held(hold, bool(opened)))


def placing(
    at: tuple[float, float, float],
    r: float | None = None,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
) -> list[Queueable]:
    """The commands of :meth:`magician.Arm.place`. Without ``r`` the tool keeps its rotation."""
    gripper = _is_gripper(tool)
    leave = words.release() if gripper else words.suction(False)
    return _over(at, r, [], leave, approach, retreat, _held(hold, gripper))


def meeting(
    at: tuple[float, float, float],
    r: float,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
    speed: float | None = None,
) -> tuple[list[Queueable], list[Queueable]]:
    """The commands of :meth:`magician.Arm.pick_from_belt`: until the tool is above, and from there on."""
    gripper = _is_gripper(tool)
    ready: list[Queueable] = [words.release() if gripper else words.suction(True)]
    if speed is not None:
        ready.insert(0, words.speed(speed))
    over, down, act, wait, up = _over(at, r, [], words.grip(), approach, retreat, _held(hold, gripper))
    return [*ready, over], [down, *([act] if gripper else []), wait, up]


def _over(
    at: tuple[float, float, float],
    r: float | None,
    before: list[Queueable],
    act: Queueable,
    approach: float,
    retreat: float | None,
    hold: float,
) -> list[Queueable]:
    x, y, z = at
    above = number("approach", approach, least=0, unit="mm")
    after = above if retreat is None else number("retreat", retreat, least=0, unit="mm")
    return [
        *before,
        words.move_to(x, y, z + above, r),
        words.line_to(x, y, z, r),
        act,
        words.wait(hold),
        words.line_to(x, y, z + after, r),
    ]


def _is_gripper(tool: str) -> bool:
    if tool not in ("suction", "gripper"):
        raise InvalidInputError(f"tool is {tool!r}; it takes 'suction' or 'gripper'")
    return tool == "gripper"


def _held(hold: float | None, gripper: bool) -> float:
    return (0.5 if gripper else 0.3) if hold is None else seconds("hold", hold)


def _beside() -> Path:
    """The folder of the program that runs."""
    file = getattr(sys.modules.get("__main__"), "__file__", None)
    return Path(file).resolve().parent if file else Path.cwd()


def _point(name: str, target: Target) -> _Point:
    row: Sequence[float] = target.position if isinstance(target, Pose) else target
    x, y, z, *_ = numbers(name, row, 4 if hasattr(row, "__len__") and len(row) == 4 else 3, unit="mm")
    return x, y, z


def _rotation(target: Target) -> float:
    if isinstance(target, Pose):
        return target.r
    return number("r", target[3], unit="deg") if len(target) == 4 else 0.0


def _plus(*vectors: Sequence[float]) -> _Point:
    x, y, z = (math.fsum(parts) for parts in zip(*vectors, strict=True))
    return x, y, z


def _minus(a: Sequence[float], b: Sequence[float]) -> _Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _times(a: Sequence[float], factor: float) -> _Point:
    return a[0] * factor, a[1] * factor, a[2] * factor


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return math.fsum(one * other for one, other in zip(a, b, strict=True))


def _turned(degrees: float) -> float:
    """An angle from above -180 to 180 degrees."""
    turned = math.remainder(degrees, 360.0)
    return 180.0 if turned == -180.0 else turned


def _position(place: _Point, r: float) -> Position:
    """A position without what the last digits of a float make of a round number: the arm has seven digits."""
    x, y, z = place
    return Position(round(x, 9) + 0.0, round(y, 9) + 0.0, round(z, 9) + 0.0, round(r, 9) + 0.0)

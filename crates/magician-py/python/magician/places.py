"""Named poses, work planes, pallets and belts.

* :class:`Poses` keeps poses in a file, by name: ``arm.poses["tray"] = arm.pose()``, ``arm.move_to("tray")``.
* :class:`Frame` is a work plane defined by three points: ``arm.line_to(frame(10, 20))``.
* :class:`Pallet` is a grid of rows and columns defined by three or four corners.
* :class:`Belt` is a conveyor at constant speed: ``arm.pick_from_belt((180, -150, -30), Belt(40))``.
* :func:`picking`, :func:`placing` and :func:`meeting` build the commands of ``arm.pick``, ``arm.place`` and
``arm.pick_from_belt``.

Lengths are mm, angles degrees. The tool of this arm always points down, even in a tilted frame.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, MutableMapping, Sequence
from pathlib import Path
from typing import Any, Literal

from . import _magician, words
from ._arguments import finite_numbers, number, numbers, seconds, text, whole
from ._meaning import Position
from ._targets import Target
from ._values import Value
from .commands import Pose, Queueable
from .errors import InvalidInputError

__all__ = ["Belt", "Frame", "Pallet", "Point", "Poses", "meeting", "picking", "placing"]

_Point = tuple[float, float, float]

_MIN_DISTANCE = 1e-3
"""Smallest distance, mm, between points, or from a point to the line through two others, that defines a plane."""


class Frame(Value):
    """A work plane: a coordinate frame on a table, a tray or a slope.

    >>> frame = Frame.from_points((200, -50, 10), (200, 50, 10), (150, -50, 10))
    >>> frame(10, 0)
    Position(x=200.0, y=-40.0, z=10.0, r=90.0)
    >>> frame.from_arm(200, -40, 15)
    Position(x=10.0, y=0.0, z=5.0, r=-90.0)
    """

    origin: tuple[float, float, float]
    """Origin in the arm's coordinates, mm."""
    x_axis: tuple[float, float, float]
    """Unit vector of the X axis."""
    y_axis: tuple[float, float, float]
    """Unit vector of the Y axis, at right angles to X."""

    @classmethod
    def from_points(cls, origin: Target, on_x: Target, on_y: Target) -> Frame:
        """Creates the plane through three touched points. Each is a pose, or x, y, z.

        :param origin: Origin of the frame.
        :param on_x: Any point on the positive X axis; a larger distance is more accurate.
        :param on_y: Any point on the side of the positive Y axis, not necessarily on the axis.
        :raises InvalidInputError: The points are collinear, or two of them coincide.
        """
        corner, right, left = _point("origin", origin), _point("on_x", on_x), _point("on_y", on_y)
        along, across = _minus(right, corner), _minus(left, corner)
        length = math.hypot(*along)
        if length < _MIN_DISTANCE:
            raise InvalidInputError("origin and on_x are the same point: a frame takes three points that are apart")
        x_axis = _times(along, 1 / length)
        across = _minus(across, _times(x_axis, _dot(across, x_axis)))
        height = math.hypot(*across)
        if height < _MIN_DISTANCE:
            raise InvalidInputError("the three points lie on a line: a frame takes on_y beside it")
        return cls(corner, x_axis, _times(across, 1 / height))

    @classmethod
    def level(cls, x: float, y: float, z: float, rotation: float = 0.0) -> Frame:
        """Creates a level plane.

        :param x: Origin, mm forward.
        :param y: Origin, mm to the arm's left.
        :param z: Height, mm.
        :param rotation: Direction of its X axis, degrees from the arm's X towards its Y.
        """
        turn = math.radians(number("rotation", rotation, unit="deg"))
        cos, sin = math.cos(turn), math.sin(turn)
        x, y, z = finite_numbers(x=x, y=y, z=z)
        return cls((x, y, z), (cos, sin, 0.0), (-sin, cos, 0.0))

    @property
    def z_axis(self) -> tuple[float, float, float]:
        """Unit vector of the Z axis, out of the plane."""
        (a, b, c), (d, e, f) = self.x_axis, self.y_axis
        return b * f - c * e, c * d - a * f, a * e - b * d

    @property
    def rotation(self) -> float:
        """Direction of the X axis seen from above, degrees from the arm's X towards its Y.

        :meth:`to_arm` adds it to the tool's rotation.
        """
        return math.degrees(math.atan2(self.x_axis[1], self.x_axis[0]))

    @property
    def slope(self) -> float:
        """Tilt of the plane, degrees; 0 is level."""
        return math.degrees(math.acos(max(-1.0, min(1.0, abs(self.z_axis[2])))))

    def to_arm(self, x: float, y: float, z: float = 0.0, r: float = 0.0) -> Position:
        """Converts a position from this frame to the arm's coordinates. ``frame(x, y, z, r)`` is the same.

        :param z: Height above the plane, perpendicular to it, mm.
        :param r: Rotation of the tool, degrees; 0 is along the frame's X.
        """
        x, y, z, r = finite_numbers(x=x, y=y, z=z, r=r)
        place = _plus(self.origin, _times(self.x_axis, x), _times(self.y_axis, y), _times(self.z_axis, z))
        return _position(place, _turned(r + self.rotation))

    __call__ = to_arm

    def from_arm(self, x: float, y: float, z: float, r: float = 0.0) -> Position:
        """Converts a position from the arm's coordinates to this frame: ``frame.from_arm(*arm.pose())``."""
        x, y, z, r = finite_numbers(x=x, y=y, z=z, r=r)
        way = _minus((x, y, z), self.origin)
        place = _dot(way, self.x_axis), _dot(way, self.y_axis), _dot(way, self.z_axis)
        return _position(place, _turned(r - self.rotation))


class Belt(Value):
    """A conveyor at constant speed, for :meth:`magician.Arm.pick_from_belt`.

    >>> Belt(40, direction=90).after((220, -100, 0), 0.5)
    Position(x=220.0, y=-80.0, z=0.0, r=0.0)
    """

    mm_per_s: float
    """Speed, mm/s; negative backwards."""
    direction: float = 0.0
    """Direction of travel, degrees from the arm's X towards its Y."""

    def __init__(self, mm_per_s: float, direction: float = 0.0) -> None:
        """Creates a belt.

        :param mm_per_s: Speed, mm/s, as for :meth:`magician.Arm.conveyor`.
        :param direction: Direction of travel at positive speed, degrees: 0 along the arm's X, 90 along its Y.
        """
        super().__init__(number("mm_per_s", mm_per_s, unit="mm/s"), number("direction", direction, unit="deg"))

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Velocity of objects on the belt, mm/s along x, y and z."""
        turn = math.radians(self.direction)
        return self.mm_per_s * math.cos(turn), self.mm_per_s * math.sin(turn), 0.0

    def after(self, at: Target, seconds: float) -> Position:
        """Predicts the position of an object on the belt after a time, s."""
        time = number("seconds", seconds, unit="s")
        return _position(_plus(_point("at", at), _times(self.velocity, time)), _rotation(at))


class Pallet(Value):
    """A grid of positions: a sequence of :class:`~magician.Position`, row by row.

    >>> tray = Pallet(2, 3, first=(200, 0, -20), end_of_row=(200, 60, -20), last_row=(240, 0, -20))
    >>> len(tray), tray[0], tray[1, 2]
    (6, Position(x=200.0, y=0.0, z=-20.0, r=0.0), Position(x=240.0, y=60.0, z=-20.0, r=0.0))
    """

    rows: int
    """Number of rows."""
    columns: int
    """Number of positions in a row."""
    first: Position
    """First position."""
    end_of_row: Position
    """Last position of the first row."""
    last_row: Position
    """First position of the last row."""
    opposite: Position
    """Last position."""

    def __init__(
        self,
        rows: int,
        columns: int,
        first: Target,
        end_of_row: Target,
        last_row: Target,
        opposite: Target | None = None,
    ) -> None:
        """Creates a pallet from its corners: poses, or x, y, z and optionally r. All positions use the rotation of the
        first.

        :param rows: Number of rows, at least 1.
        :param columns: Number of positions in a row, at least 1.
        :param first: First position.
        :param end_of_row: Last position of the first row.
        :param last_row: First position of the last row.
        :param opposite: Last position of the last row, for a pallet that is not exactly a parallelogram.
        """
        rows, columns = whole("rows", rows, 1, 10_000), whole("columns", columns, 1, 10_000)
        r = _rotation(first)
        one, right, left = _point("first", first), _point("end_of_row", end_of_row), _point("last_row", last_row)
        last = _plus(right, _minus(left, one)) if opposite is None else _point("opposite", opposite)
        super().__init__(rows, columns, *(Position(*corner, r) for corner in (one, right, left, last)))

    def __len__(self) -> int:
        return self.rows * self.columns

    def __getitem__(self, at: int | tuple[int, int]) -> Position:
        """Returns a position by its index, from 0, or by row and column."""
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
    """A taught point: see :meth:`magician.Arm.teach`."""

    name: str
    """Name of the point."""
    position: Position
    """Position of the point: ``arm.move_to(point.position)``."""


class Poses(MutableMapping[str, Position]):
    """Named poses, stored in a JSON file that can be edited by hand.

    Assignments are written to the file at once. Each lookup sees changes made by other programs.

    >>> poses = Poses("tray.json")
    >>> poses["above"] = (220, 0, 60, 0)
    >>> poses["above"]
    Position(x=220.0, y=0.0, z=60.0, r=0.0)
    """

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        """Creates the mapping. The file is not accessed until the first use.

        :param path: Path of the file. Defaults to ``poses.json`` beside the running program, or in the current folder
            if there is no program file, as in a notebook.
        """
        self.path = Path(path) if path is not None else _default_folder() / "poses.json"
        """Path of the file."""

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
        # Atomic: after a crash the file has either its old or its new content.
        _magician.write_whole(self.path, written.encode())


def picking(
    at: tuple[float, float, float],
    r: float | None = None,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
) -> list[Queueable]:
    """Builds the commands of :meth:`magician.Arm.pick`. Without ``r`` the tool keeps its rotation."""
    opened: list[Queueable] = [words.release()] if _is_gripper(tool) else []
    take = words.grip() if opened else words.suction(True)
    return _approach_act_retreat(at, r, opened, take, approach, retreat, _hold_time(hold, bool(opened)))


def placing(
    at: tuple[float, float, float],
    r: float | None = None,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
) -> list[Queueable]:
    """Builds the commands of :meth:`magician.Arm.place`. Without ``r`` the tool keeps its rotation."""
    gripper = _is_gripper(tool)
    leave = words.release() if gripper else words.suction(False)
    return _approach_act_retreat(at, r, [], leave, approach, retreat, _hold_time(hold, gripper))


def meeting(
    at: tuple[float, float, float],
    r: float,
    tool: Literal["suction", "gripper"] = "suction",
    approach: float = 40.0,
    retreat: float | None = None,
    hold: float | None = None,
    speed: float | None = None,
) -> tuple[list[Queueable], list[Queueable]]:
    """Builds the commands of :meth:`magician.Arm.pick_from_belt`, as two lists.

    The first ends with the tool above the object; the second lowers it, picks and lifts.
    """
    gripper = _is_gripper(tool)
    ready: list[Queueable] = [words.release() if gripper else words.suction(True)]
    if speed is not None:
        ready.insert(0, words.speed(speed))
    over, down, act, wait, up = _approach_act_retreat(
        at, r, [], words.grip(), approach, retreat, _hold_time(hold, gripper)
    )
    return [*ready, over], [down, *([act] if gripper else []), wait, up]


def _approach_act_retreat(
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


def _hold_time(hold: float | None, gripper: bool) -> float:
    return (0.5 if gripper else 0.3) if hold is None else seconds("hold", hold)


def _default_folder() -> Path:
    """Returns the folder of the running program."""
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
    """Normalizes an angle to the range above -180 to 180 degrees."""
    turned = math.remainder(degrees, 360.0)
    return 180.0 if turned == -180.0 else turned


def _position(place: _Point, r: float) -> Position:
    """Rounds a position to remove floating-point noise: the arm has seven significant digits."""
    x, y, z = place
    return Position(round(x, 9) + 0.0, round(y, 9) + 0.0, round(z, 9) + 0.0, round(r, 9) + 0.0)

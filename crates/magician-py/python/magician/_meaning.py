"""Base classes that interpret the numbers of some answers of ``commands``."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import Any, NamedTuple, Protocol

__all__ = ["Color", "Joints", "Position"]


class Position(NamedTuple):
    """Position of the tool in the arm's frame, mm and degrees. Pass it to a move: ``arm.move_to(*position)``."""

    x: float
    """Forward, mm."""
    y: float
    """To the arm's left, mm."""
    z: float
    """Up, mm."""
    r: float
    """Rotation of the tool, degrees."""


class Joints(NamedTuple):
    """Joint angles, degrees. Pass them to a move: ``arm.move_joints(*joints)``."""

    j1: float
    """Base."""
    j2: float
    """Rear arm."""
    j3: float
    """Forearm."""
    j4: float
    """End effector."""


class Color(Enum):
    """Colour that the colour sensor can distinguish."""

    RED = "red"
    GREEN = "green"
    BLUE = "blue"


class _Pose(Protocol):
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def z(self) -> float: ...
    @property
    def r(self) -> float: ...
    @property
    def joint_angle(self) -> tuple[float, float, float, float]: ...


class PoseMeaning:
    """Pose of the arm."""

    __slots__ = ()

    def __iter__(self: _Pose) -> Iterator[float]:
        """x, y, z and r, as :attr:`position` has them: ``x, y, z, r = arm.pose()``, ``arm.move_to(*arm.pose())``."""
        return iter((self.x, self.y, self.z, self.r))

    def __len__(self) -> int:
        return 4

    def __array__(self: _Pose, dtype: Any = None, copy: bool | None = None) -> Any:
        """x, y, z and r as a NumPy array."""
        from numpy import array

        return array((self.x, self.y, self.z, self.r), dtype=float if dtype is None else dtype)

    @property
    def position(self: _Pose) -> Position:
        """Position of the tool: x, y, z in mm and r in degrees."""
        return Position(self.x, self.y, self.z, self.r)

    @property
    def joints(self: _Pose) -> Joints:
        """The angles of the joints, degrees."""
        return Joints(*self.joint_angle)

    @property
    def j1(self: _Pose) -> float:
        """Angle of the base, degrees."""
        return self.joint_angle[0]

    @property
    def j2(self: _Pose) -> float:
        """Angle of the rear arm, degrees."""
        return self.joint_angle[1]

    @property
    def j3(self: _Pose) -> float:
        """Angle of the forearm, degrees."""
        return self.joint_angle[2]

    @property
    def j4(self: _Pose) -> float:
        """Angle of the end effector, degrees."""
        return self.joint_angle[3]


class _Color(Protocol):
    @property
    def r(self) -> int: ...
    @property
    def g(self) -> int: ...
    @property
    def b(self) -> int: ...


class ColorMeaning:
    """The reading of a colour sensor."""

    __slots__ = ()

    @property
    def color(self: _Color) -> Color | None:
        """Strongest channel; ``None`` if two are equally strong, or the sensor detects nothing."""
        r, g, b = self.r, self.g, self.b
        if r > g and r > b:
            return Color.RED
        if g > r and g > b:
            return Color.GREEN
        if b > r and b > g:
            return Color.BLUE
        return None


class _Infrared(Protocol):
    @property
    def state(self) -> bool: ...


class InfraredMeaning:
    """The reading of an infrared sensor."""

    __slots__ = ()

    def __bool__(self: _Infrared) -> bool:
        """True if the sensor detects an object."""
        return self.state


class _Level(Protocol):
    @property
    def level(self) -> bool: ...


class LevelMeaning:
    """The level of an input."""

    __slots__ = ()

    def __bool__(self: _Level) -> bool:
        """True if the input is high."""
        return self.level


class _Analog(Protocol):
    @property
    def value(self) -> int: ...


class AnalogMeaning:
    """The reading of an analog input."""

    __slots__ = ()

    @property
    def volts(self: _Analog) -> float:
        """The voltage at the input, V, 0 to 3.3."""
        return self.value / 4095 * 3.3

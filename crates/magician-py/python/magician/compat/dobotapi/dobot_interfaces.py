"""Types of dobotapi's values."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from .._alarm import Alarm
from .._pydobot2 import MODE_PTP

__all__ = ["GPIO", "MODE_PTP", "Alarm", "Joints", "Pose", "Position", "Position2D"]


class GPIO(IntEnum):
    """Sockets in the numbering of the arm."""

    PORT_GP1 = 0
    PORT_GP2 = 1
    PORT_GP4 = 2
    PORT_GP5 = 3


class Position(NamedTuple):
    """Position, mm, and rotation of the tool, degrees."""

    x: float
    y: float
    z: float
    rotation: float = 0.0


class Position2D(NamedTuple):
    """Position in a plane, mm."""

    x: float
    y: float


class Joints(NamedTuple):
    """Joint angles, degrees."""

    jointA: float
    jointB: float
    jointC: float
    jointD: float

    def ConvertToRadians(self) -> Joints:
        """Returns the angles in radians."""
        return Joints(*map(math.radians, self))


class Pose(NamedTuple):
    """Pose of the arm."""

    position: Position
    joints: Joints

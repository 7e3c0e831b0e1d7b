"""Types of pydobotpp's values."""

from enum import IntEnum

from .._alarm import Alarm
from .._pydobot2 import MODE_PTP as PTPMode
from .._pydobot2 import Joints, Pose, Position

__all__ = ["Alarm", "GPIOPort", "Joints", "PTPMode", "Pose", "Position"]


class GPIOPort(IntEnum):
    """Sockets in the numbering of the arm."""

    GP1 = 0
    GP2 = 1
    GP4 = 2
    GP5 = 3

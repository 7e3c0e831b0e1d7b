"""Stand-in for pydobotpp."""

from . import dobot, dobot_interface, message
from .dobot import Dobot
from .dobot_interface import Alarm, GPIOPort, Joints, Pose, Position, PTPMode

__all__ = [
    "Alarm",
    "Dobot",
    "GPIOPort",
    "Joints",
    "PTPMode",
    "Pose",
    "Position",
    "dobot",
    "dobot_interface",
    "message",
]

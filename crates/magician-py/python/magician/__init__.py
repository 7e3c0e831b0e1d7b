"""Drive a Dobot Magician desktop arm, or a virtual one.

>>> import magician
>>> with magician.Arm("sim") as arm:  # or "/dev/ttyUSB0", "COM3", "udp:192.168.1.5"
...     arm.home()
...     arm.move_to(220, 60, 20)
...     pose = arm.pose()
>>> pose.x, pose.y, pose.z
(220.0, 60.0, 20.0)

* :class:`Arm` is a connected arm; :class:`magician.aio.Arm` the same for asyncio.
* :mod:`magician.words` makes commands of intentions, for programs; :mod:`magician.commands` has every command of the
  protocol.
* :mod:`magician.errors` is what can go wrong, :mod:`magician.events` what can happen.

Lengths are mm, angles degrees, times seconds. What the driver has to say goes to the logger ``magician``.
"""

from __future__ import annotations

from . import aio, alarms, commands, errors, events, readings, words
from ._blocking import Arm, Check, Events, Jog, Run, StateWatch
from .alarms import Alarm
from .commands import Pose
from .errors import Error
from .ports import Found, SerialPort, discover, ports
from .readings import Color, Info, Joints, Link, Position, Progress, Ran, Stats, Status

__all__ = [
    "Alarm",
    "Arm",
    "Check",
    "Color",
    "Error",
    "Events",
    "Found",
    "Info",
    "Jog",
    "Joints",
    "Link",
    "Pose",
    "Position",
    "Progress",
    "Ran",
    "Run",
    "SerialPort",
    "StateWatch",
    "Stats",
    "Status",
    "aio",
    "alarms",
    "commands",
    "discover",
    "errors",
    "events",
    "ports",
    "readings",
    "words",
]

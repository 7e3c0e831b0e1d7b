"""Arm of pydobotplus."""

from __future__ import annotations

import math

from .._alarm import Alarm
from .._line import GET, QUEUED
from .._message import Message
from .._pydobot2 import (
    MAX_QUEUE_LEN,
    MM_PER_CIRCLE,
    MODE_PTP,
    STEP_PER_CIRCLE,
    DobotException,
    Joints,
    Pose,
    Position,
)
from .._pydobot2 import Dobot as _Dobot

__all__ = [
    "MAX_QUEUE_LEN",
    "MM_PER_CIRCLE",
    "MODE_PTP",
    "STEP_PER_CIRCLE",
    "Alarm",
    "CustomPosition",
    "Dobot",
    "DobotException",
    "Joints",
    "Message",
    "Pose",
    "Position",
]

_QUEUED_READ = 2


class CustomPosition:
    """Target for :meth:`Dobot.move_to`; ``None`` keeps the current value."""

    def __init__(
        self, x: float | None = None, y: float | None = None, z: float | None = None, r: float | None = None
    ) -> None:
        self.x, self.y, self.z, self.r = x, y, z, r


class Dobot(_Dobot):
    """Connected arm with the interface of pydobotplus."""

    PORT_GP1 = 0
    PORT_GP2 = 1
    PORT_GP4 = 2
    PORT_GP5 = 3

    def _set_ptp_cmd(self, x: float, y: float, z: float, r: float, mode: int, wait: bool) -> Message:
        return self._magician_ptp(mode, x, y, z, r, wait)

    def move_to(
        self,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        r: float | None = 0,
        wait: bool = True,
        mode: int | None = None,
        position: CustomPosition | Position | None = None,
    ) -> int:
        """Moves to a pose, by a joint move unless a mode is given, and waits. ``None`` keeps the current value. Returns
        the index."""
        if position is not None:
            x, y, z, r = position.x, position.y, position.z, position.r
        elif x is None and y is None and z is None:
            raise ValueError("move_to() takes x, y or z, or a position")
        if x is None or y is None or z is None or r is None:
            here = self.get_pose().position
            x, y, z, r = (now if wanted is None else wanted for now, wanted in zip(here, (x, y, z, r), strict=False))
        mode = MODE_PTP.MOVJ_XYZ if mode is None else mode
        return self._magician_queued(self._set_ptp_cmd(x, y, z, r, mode, wait=wait))

    def move_rel(self, x: float = 0, y: float = 0, z: float = 0, r: float = 0, wait: bool = True) -> None:
        """Moves by an increment from the current pose."""
        here = self.get_pose().position
        self.move_to(here.x + x, here.y + y, here.z + z, here.r + r, wait)

    def conveyor_belt_distance(
        self, speed_mm_per_sec: float, distance_mm: float, direction: int = 1, interface: int = 0
    ) -> int:
        """Moves the belt by a distance (mm) at a speed (mm/s, up to 100)."""
        if speed_mm_per_sec > 100:
            raise DobotException(f"the belt's speed is up to 100 mm/s, not {speed_mm_per_sec}")
        steps = 360.0 / 1.8 * 10.0 * 16.0 / 2.0 / (34 * math.pi)
        speed = int(speed_mm_per_sec * steps * direction)
        return self._magician_queued(self._set_stepper_motor_distance(speed, int(distance_mm * steps), interface))

    def set_hht_trig_output(self, state: bool) -> None:
        """Switches the reports of points taught by hand."""
        self._magician_command(41, _QUEUED_READ, bytes((int(state),)))

    def get_hht_trig_output(self) -> bool:
        """True if points taught by hand are reported."""
        return bool(self._magician_command(41, GET).params[0])

    def set_color(self, enable: bool = True, port: int = PORT_GP2, version: int = 1) -> int:
        """Switches the colour sensor; version 0 is the older one."""
        return self._magician_queued(self._magician_command(137, QUEUED, bytes((int(enable), port, version))))

    def get_color(self, port: int = PORT_GP2, version: int = 1) -> list[bool]:
        """Returns three values, one each for red, green and blue: true for the detected colour."""
        return [bool(value) for value in self._magician_command(137, GET, bytes((port, 1, version))).params[:3]]

    def set_ir(self, enable: bool = True, port: int = PORT_GP4) -> int:
        """Switches the infrared sensor."""
        return self._magician_queued(self._magician_command(138, _QUEUED_READ, bytes((int(enable), port))))

    def get_ir(self, port: int = PORT_GP4) -> bool:
        """True if an object is in front of the infrared sensor."""
        return bool(self._magician_command(138, GET, bytes((port,))).params[0])

"""Arm of pydobot2."""

from __future__ import annotations

from .._alarm import Alarm
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
    "Dobot",
    "DobotException",
    "Joints",
    "Message",
    "Pose",
    "Position",
]


class Dobot(_Dobot):
    """Connected arm with the interface of pydobot2."""

    def _set_ptp_cmd(self, x: float, y: float, z: float, r: float, mode: int, wait: bool = False) -> Message:
        return self._magician_ptp(mode, x, y, z, r, wait)

    def move_to(
        self, x: float, y: float, z: float, r: float = 0.0, mode: int = MODE_PTP.MOVJ_XYZ, wait: bool = False
    ) -> int:
        """Moves to a pose, by a joint move unless a mode is given. Returns the index.

        pydobot2's own example passes ``wait``: with it, the call returns when the arm is there.
        """
        return self._magician_queued(self._set_ptp_cmd(x, y, z, r, mode, wait))

    def conveyor_belt_distance(self, speed: float, distance: int, direction: int = 1, interface: int = 0) -> None:
        """Moves the belt by a number of motor steps at a speed (mm/s, up to 100)."""
        if not 0.0 <= speed <= 100.0 or direction not in (1, -1):
            raise DobotException(f"speed is 0 to 100 mm/s and direction 1 or -1, not {speed} and {direction}")
        self._set_stepper_motor_distance(speed * STEP_PER_CIRCLE / MM_PER_CIRCLE * direction, distance, interface)

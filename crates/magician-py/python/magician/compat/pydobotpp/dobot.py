"""Arm of pydobotpp."""

from __future__ import annotations

import struct

from .._line import QUEUED, SET
from .._message import Message
from .._pydobot2 import MAX_QUEUE_LEN, MM_PER_CIRCLE, STEP_PER_CIRCLE, DobotException
from ..pydobotplus.dobotplus import Dobot as _Plus
from .dobot_interface import Alarm, GPIOPort, Joints, Pose, Position, PTPMode

__all__ = [
    "MAX_QUEUE_LEN",
    "MM_PER_CIRCLE",
    "STEP_PER_CIRCLE",
    "Alarm",
    "Dobot",
    "DobotException",
    "GPIOPort",
    "Joints",
    "Message",
    "PTPMode",
    "Pose",
    "Position",
]


class Dobot(_Plus):
    """Connected arm with the interface of pydobotpp: closing it stops the arm and switches its tools off."""

    def __init__(self, port: str | None = None, should_clear_alarms: bool = True) -> None:
        super().__init__(port, should_clear_alarms=should_clear_alarms)

    def wait(self, ms: int) -> int:  # type: ignore[override]
        """Queues a wait (ms). Returns the index."""
        return self._magician_queued(self._magician_command(110, QUEUED, struct.pack("<I", int(ms))))

    def _set_queued_cmd_stop_exec(self, force: bool = False) -> Message:
        return self._magician_command(242 if force else 241, SET)

    def close(self, force_stop: bool = True) -> None:
        """Stops the arm, switches laser, gripper and suction off, and ends the connection."""
        if not self._magician_line.closed:
            self._set_queued_cmd_stop_exec(force_stop)
            self._set_queued_cmd_clear()
            self._set_queued_cmd_start_exec()
            self.laze(0, False)
            self.grip(False)
            self.wait_for_cmd(self.suck(False))
            self._set_queued_cmd_stop_exec()
            self._set_queued_cmd_clear()
        super().close()

"""Arm of pydobot."""

from __future__ import annotations

import struct
import sys
import threading
import warnings
from enum import Enum

from ...errors import Error, PortError
from .._line import GET, QUEUED, SET
from .._message import Message
from .._port import Port
from .._pydobot2 import MODE_PTP, DobotException, Joints, Methods, Pose, Position
from .enums import PTPMode
from .enums.CommunicationProtocolIDs import CommunicationProtocolIDs
from .enums.ControlValues import ControlValues

__all__ = [
    "MODE_PTP",
    "MODE_PTP_JUMP_ANGLE",
    "MODE_PTP_JUMP_MOVL_XYZ",
    "MODE_PTP_JUMP_XYZ",
    "MODE_PTP_MOVJ_ANGLE",
    "MODE_PTP_MOVJ_INC",
    "MODE_PTP_MOVJ_XYZ",
    "MODE_PTP_MOVJ_XYZ_INC",
    "MODE_PTP_MOVL_ANGLE",
    "MODE_PTP_MOVL_INC",
    "MODE_PTP_MOVL_XYZ",
    "CommunicationProtocolIDs",
    "ControlValues",
    "Dobot",
    "DobotException",
    "Joints",
    "Message",
    "PTPMode",
    "Pose",
    "Position",
]

# Programs for pydobot before 2020 use numbers for the modes.
MODE_PTP_JUMP_XYZ, MODE_PTP_MOVJ_XYZ, MODE_PTP_MOVL_XYZ = 0, 1, 2
MODE_PTP_JUMP_ANGLE, MODE_PTP_MOVJ_ANGLE, MODE_PTP_MOVL_ANGLE = 3, 4, 5
MODE_PTP_MOVJ_INC, MODE_PTP_MOVL_INC, MODE_PTP_MOVJ_XYZ_INC, MODE_PTP_JUMP_MOVL_XYZ = 6, 7, 8, 9

_BLANK = " " * 29


class Dobot(Methods):
    """Connected arm with the interface of pydobot 1.3: mm and degrees; calls wait only with ``wait=True``.

    Connecting starts and clears the queue, sets all speeds to 200 and the ratios to 100 %.
    """

    def __init__(self, port: str | None = None, verbose: bool = False) -> None:
        self._on = True
        self.verbose = verbose
        """Whether every frame is printed."""
        self.lock = threading.Lock()
        """Not needed: calls may come from any thread."""
        self._magician_open(port)
        self.ser: Port = self._magician_port
        """Serial port, with the members that programs use besides the library."""
        self._magician_say(f"{self._magician_port.name} open")
        self._magician_setup()
        self._get_pose()

    def _magician_say(self, what: str) -> None:
        if self.verbose:
            print("pydobot:", what)

    def _magician_fault(self, error: Error) -> Exception:
        return _port_fault(error) if isinstance(error, PortError) else error

    def _magician_exchange(self, msg: Message) -> Message:
        if self.verbose:
            self._magician_say(f">> {msg}")
        answer = super()._magician_exchange(msg)
        if self.verbose:
            self._magician_say(f"<< {answer}")
        return answer

    def _magician_finish(self, index: int, motion: bool = False) -> None:
        self._magician_say(f"waiting for command {index}")
        super()._magician_finish(index, motion)
        self._magician_say(f"command {index} executed")

    def _get_pose(self) -> Message:
        """Reads the pose into ``x``, ``y``, ``z``, ``r`` (mm, degrees) and ``j1`` to ``j4`` (degrees)."""
        answer = self._magician_command(10, GET)
        self.x, self.y, self.z, self.r, self.j1, self.j2, self.j3, self.j4 = pose = struct.unpack("<8f", answer.params)
        if self.verbose:
            names = ("x", "y", "z", "r", "j1", "j2", "j3", "j4")
            self._magician_say(_BLANK.join(f"{name}:{value:03.1f}" for name, value in zip(names, pose, strict=False)))
        return answer

    def _set_ptp_cmd(self, x: float, y: float, z: float, r: float, mode: int | Enum, wait: bool) -> Message:
        return self._magician_ptp(mode, x, y, z, r, wait)

    def _set_wait_cmd(self, ms: int) -> Message:
        return self._magician_command(110, QUEUED, struct.pack("<I", ms))

    def _get_eio_level(self, address: int) -> Message:
        return self._magician_command(131, GET, bytes((address,)))

    def _set_eio_level(self, address: int, level: int) -> Message:
        return self._magician_command(131, SET, bytes((address, level)))

    def get_eio(self, addr: int) -> Message:
        """Reads the level of an output: the second parameter of the reply."""
        return self._get_eio_level(addr)

    def set_eio(self, addr: int, val: int) -> Message:
        """Sets an output immediately, outside the queue."""
        return self._set_eio_level(addr, val)

    def close(self) -> None:
        """Ends the connection. The arm finishes its queued commands."""
        self._on = False
        self._magician_line.close()
        self._magician_say(f"{self._magician_port.name} closed")

    def go(self, x: float, y: float, z: float, r: float = 0.0) -> None:
        """Old name of :meth:`move_to`."""
        warnings.warn("go() is the old name of move_to()", stacklevel=2)
        self.move_to(x, y, z, r)

    def move_to(self, x: float, y: float, z: float, r: float, wait: bool = False) -> None:
        """Moves in a straight line; with ``wait``, returns when the arm is there."""
        self._set_ptp_cmd(x, y, z, r, mode=PTPMode.MOVL_XYZ, wait=wait)

    def suck(self, enable: bool) -> None:  # type: ignore[override]
        """Switches the suction cup, in the queue."""
        self._set_end_effector_suction_cup(enable)

    def grip(self, enable: bool) -> None:  # type: ignore[override]
        """Closes or opens the gripper, in the queue."""
        self._set_end_effector_gripper(enable)

    def speed(self, velocity: float = 100.0, acceleration: float = 100.0) -> None:
        """Sets ratios (%) and the tool's speed (mm/s) and acceleration (mm/s^2), in the queue."""
        self._set_ptp_common_params(velocity, acceleration)
        self._set_ptp_coordinate_params(velocity, acceleration)

    def wait(self, ms: int) -> None:
        """Queues a wait (ms). Returns at once."""
        self._set_wait_cmd(ms)

    def pose(self) -> tuple[float, float, float, float, float, float, float, float]:
        """Returns x, y, z (mm), r and four joint angles (degrees)."""
        params = self._get_pose().params
        x, y, z, r, j1, j2, j3, j4 = struct.unpack("<8f", params)
        return x, y, z, r, j1, j2, j3, j4


def _port_fault(error: PortError) -> Exception:
    """Converts a port error into one that is also pyserial's ``SerialException``.

    Returns it unchanged if the program does not use pyserial.
    """
    theirs = getattr(sys.modules.get("serial"), "SerialException", None)
    if not isinstance(theirs, type) or not issubclass(theirs, OSError):
        return error
    both: type[Exception] = type("SerialPortError", (PortError, theirs), {})
    return both(str(error))

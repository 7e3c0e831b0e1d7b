"""Methods of the forks of pydobot, and of each of its two interfaces beside the other.

Programs mix them: they call ``home()`` and ``pose()``, or were written for a modified copy. Every arm of the family has
these methods. If a library has its own method of that name, that one is called.
"""

from __future__ import annotations

import struct

from ._line import GET, QUEUED, SET
from ._message import Message
from ._robot import Robot, floats

__all__ = ["Forks"]

JUMP_XYZ, MOVJ_XYZ, MOVL_XYZ, MOVJ_ANGLE, MOVL_INC = 0, 1, 2, 4, 7


class Forks(Robot):
    """Methods that send one frame each. Moves return the reply; ``wait`` waits for the motion."""

    def home(self, wait: bool = False) -> int:
        """Homes the arm. Returns the queue index."""
        return self._magician_index(self._magician_command(31, QUEUED, b"", wait))

    def goHome(self) -> int:
        """Homes the arm."""
        return self._magician_index(self._magician_command(31, QUEUED))

    def setHomeParams(self, x: float, y: float, z: float, r: float) -> Message:
        """Sets the pose at the end of homing (mm, degrees)."""
        return self._magician_command(30, QUEUED, floats(x, y, z, r))

    def jump_to(self, x: float, y: float, z: float, r: float = 0.0, wait: bool = False) -> Message:
        """Jumps to a pose: up, across and down (mm, degrees)."""
        return self._magician_ptp(JUMP_XYZ, x, y, z, r, wait)

    def jump(self, x: float, y: float, z: float, r: float = 0.0) -> Message:
        """Jumps to a pose: up, across and down."""
        return self._magician_ptp(JUMP_XYZ, x, y, z, r, False)

    def move_to_J(self, x: float, y: float, z: float, r: float = 0.0, wait: bool = False) -> Message:
        """Moves to a pose by a joint move."""
        return self._magician_ptp(MOVJ_XYZ, x, y, z, r, wait)

    def goMovL(self, x: float, y: float, z: float, r: float = 0.0) -> Message:
        """Moves to a pose in a straight line."""
        return self._magician_ptp(MOVL_XYZ, x, y, z, r, False)

    def go_lin(self, x: float, y: float, z: float, r: float = 0.0) -> Message:
        """Moves to a pose in a straight line."""
        return self._magician_ptp(MOVL_XYZ, x, y, z, r, False)

    def move_inc_to(self, x: float, y: float, z: float, r: float, wait: bool = False) -> Message:
        """Moves by an increment in a straight line."""
        return self._magician_ptp(MOVL_INC, x, y, z, r, wait)

    def rotate_joint(self, j1: float, j2: float, j3: float, j4: float, wait: bool = False) -> Message:
        """Moves to joint angles (degrees)."""
        return self._magician_ptp(MOVJ_ANGLE, j1, j2, j3, j4, wait)

    def go_angle(self, j1: float, j2: float, j3: float, j4: float = 0.0) -> Message:
        """Moves to joint angles."""
        return self._magician_ptp(MOVJ_ANGLE, j1, j2, j3, j4, False)

    def move_to_with_l(self, x: float, y: float, z: float, r: float, l: float, wait: bool = False) -> Message:
        """Moves to a pose by a joint move, and to a position on the rail (mm)."""
        return self._magician_command(86, QUEUED, struct.pack("<B5f", MOVJ_XYZ, x, y, z, r, l), wait)

    move_to_withL = move_to_with_l

    def pose_l(self) -> float:
        """Returns the position on the rail (mm)."""
        return float(struct.unpack_from("<f", self._magician_command(13, GET).params)[0])

    def set_wait(self, ms: int, wait: bool = False) -> Message:
        """Queues a wait (ms)."""
        return self._magician_command(110, QUEUED, struct.pack("<I", int(ms)), wait)

    def start_stepper(self, pps: int, motor: int = 0, wait: bool = False) -> Message:
        """Runs a motor (pulses/s)."""
        return self._magician_command(135, QUEUED, struct.pack("<BBi", motor, 1, int(pps)), wait)

    def stop_stepper(self, motor: int = 0, wait: bool = False) -> Message:
        """Stops a motor."""
        return self._magician_command(135, QUEUED, struct.pack("<BBi", motor, 0, 0), wait)

    def stop_conveyor_belt(self) -> Message:
        """Stops the belt."""
        return self.stop_stepper()

    def _stop_gripper(self, enable: bool = False) -> Message:
        return self._magician_command(63, QUEUED, bytes(2))

    def _get_device_version(self) -> Message:
        answer = self._magician_command(2, GET)
        self.majorVersion, self.minorVersion, self.revision = answer.params[:3]
        return answer

    def get_device_name(self) -> str:
        """Returns the arm's name."""
        return bytes(self._magician_command(1, GET).params).split(b"\0")[0].decode("utf-8", "replace")

    def set_device_name(self, device_name: str) -> Message:
        """Sets the arm's name."""
        return self._magician_command(1, SET, device_name.encode() + b"\0")

    def get_device_serial_number(self) -> str:
        """Returns the arm's serial number."""
        return bytes(self._magician_command(0, GET).params).split(b"\0")[0].decode("utf-8", "replace")

    def run(self) -> None:
        """Does nothing: in older forks the arm was a thread, which programs start."""

    # Of pydobot.

    def pose(self) -> tuple[float, float, float, float, float, float, float, float]:
        """Returns x, y, z (mm), r and four joint angles (degrees)."""
        x, y, z, r, j1, j2, j3, j4 = struct.unpack("<8f", self._magician_command(10, GET).params)
        return x, y, z, r, j1, j2, j3, j4

    def wait(self, ms: int) -> None:
        """Queues a wait (ms). Returns at once."""
        self._magician_command(110, QUEUED, struct.pack("<I", int(ms)))

    def get_eio(self, addr: int) -> Message:
        """Reads the level of an output: the second parameter of the reply."""
        return self._magician_command(131, GET, bytes((addr,)))

    def set_eio(self, addr: int, val: int) -> Message:
        """Sets an output immediately, outside the queue."""
        return self._magician_command(131, SET, bytes((addr, val)))

"""Arm of dobotapi."""

from __future__ import annotations

import struct
import time

from ...errors import Error
from .._line import GET, QUEUED, SET, Line
from .._pydobot2 import MAX_QUEUE_LEN
from .conveyor_belt.belt import ConveyorBelt
from .dobot_interfaces import GPIO, MODE_PTP, Joints, Pose, Position
from .effectors.gripper import Gripper
from .effectors.suctioncup import SuctionCup
from .exceptions import DobotException

__all__ = ["GPIO", "MAX_QUEUE_LEN", "MODE_PTP", "Dobot", "DobotException", "Joints", "Pose", "Position"]


class Dobot:
    """Arm, connected by :meth:`connect`. Moves and tools return when they are done, while dobotapi sleeps 1.5 s."""

    def __init__(self, port: str | None = None, execution_delay: float = 1.5) -> None:
        self.port = port
        self.sleep_delay = execution_delay
        """What :meth:`delay` waits (s)."""
        self.gripper, self.suction_cup, self.conveyor_belt = Gripper(self), SuctionCup(self), ConveyorBelt(self)
        self._line: Line | None = None

    def connect(self) -> bool:
        """Connects, starts and clears the queue, and sets all speeds to 200."""
        try:
            self._line = Line(self.port)
        except Error as error:
            raise DobotException(str(error)) from error
        for id in (240, 245):
            self.exchange(id, SET)
        for id, values in ((80, [200.0] * 8), (81, [200.0] * 4), (82, [10.0, 200.0]), (83, [100.0, 100.0])):
            self.exchange(id, QUEUED, struct.pack(f"<{len(values)}f", *values))
        return True

    def connected(self) -> bool:
        """True if the arm is connected."""
        return self._line is not None and not self._line.closed

    def close(self) -> None:
        """Closes the gripper, stops suction and belt, and ends the connection."""
        if self._line is not None and not self._line.closed:
            self.gripper.close()
            self.suction_cup.idle()
            self.conveyor_belt.idle()
            self._line.close()

    def exchange(self, id: int, ctrl: int, params: bytes = b"", *, wait: bool = False, motion: bool = False) -> bytes:
        """Sends a frame and returns the parameters of its reply; with ``wait``, after the command has finished."""
        if self._line is None:
            raise DobotException("not connected: call connect() first")
        try:
            answer = bytes(self._line.exchange(id, ctrl, params)[1])
            if wait:
                self._line.finish(int.from_bytes(answer[:8], "little"), motion)
        except Error as error:
            raise DobotException(str(error)) from error
        return answer

    def tool(self, id: int, control: bool, on: bool) -> None:
        """Switches a tool."""
        self.exchange(id, QUEUED, bytes((control, on)), wait=True)

    def move_to(
        self,
        x: float,
        y: float,
        z: float,
        r: float = 0.0,
        mode: int = MODE_PTP.MOVL_XYZ,
        delay_overwrite: float | None = None,
    ) -> int:
        """Moves to a pose. Returns the queue index."""
        params = struct.pack("<B4f", int(mode), x, y, z, r)
        return int.from_bytes(self.exchange(84, QUEUED, params, wait=True, motion=True)[:8], "little")

    def move_to_position(
        self, position: Position, mode: int = MODE_PTP.MOVL_XYZ, delay_overwrite: float | None = None
    ) -> int:
        """Moves to a pose. Returns the queue index."""
        return self.move_to(*position, mode=mode)

    def home(self) -> int:
        """Homes the arm. Releases of dobotapi lack this method."""
        return int.from_bytes(self.exchange(31, QUEUED, wait=True, motion=True)[:8], "little")

    def get_pose(self) -> Pose:
        """Returns the pose of the arm."""
        values = struct.unpack_from("<8f", self.exchange(10, GET))
        return Pose(Position(*values[:4]), Joints(*values[4:]))

    pose = get_pose

    def ir_toggle(self, enable: bool = True, port: int = GPIO.PORT_GP4) -> int:
        """Switches the infrared sensor. Returns the queue index."""
        return int.from_bytes(self.exchange(138, QUEUED, bytes((enable, port, 1)))[:8], "little")

    def get_ir(self, port: int = GPIO.PORT_GP4) -> bool:
        """True if an object is in front of the infrared sensor."""
        return bool(self.exchange(138, GET, bytes((port, 1, 1)))[0])

    def get_alarms(self) -> tuple[int, ...]:
        """Returns the first 32 bits of the alarms."""
        return struct.unpack_from("<I", self.exchange(20, GET))

    def clear_alarms(self) -> None:
        """Clears the alarms. Releases of dobotapi lack this method."""
        self.exchange(20, SET)

    def speed(self, velocity: float = 100.0, acceleration: float = 100.0) -> None:
        """Sets ratios (%) and the tool's speed (mm/s) and acceleration (mm/s^2)."""
        self.exchange(83, QUEUED, struct.pack("<2f", velocity, acceleration))
        self.exchange(81, QUEUED, struct.pack("<4f", velocity, velocity, acceleration, acceleration))

    def wait(self, ms: int) -> None:
        """Queues a wait (ms). Returns at once."""
        self.exchange(110, QUEUED, struct.pack("<I", int(ms)))

    def delay(self, delay: float | None = None) -> None:
        """Waits (s)."""
        time.sleep(self.sleep_delay if delay is None else delay)

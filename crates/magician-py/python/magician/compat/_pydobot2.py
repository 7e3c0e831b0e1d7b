"""Arm of pydobot2, on which pydobotplus is based."""

from __future__ import annotations

import logging
import math
import struct
import threading
from collections.abc import Callable, Iterable
from enum import IntEnum
from typing import Any, NamedTuple

from ..errors import Error
from ._alarm import Alarm
from ._forks import Forks
from ._line import GET, QUEUED, SET
from ._message import Message
from ._port import Port
from ._robot import Robot, floats

__all__ = [
    "MAX_QUEUE_LEN",
    "MM_PER_CIRCLE",
    "MODE_PTP",
    "STEP_PER_CIRCLE",
    "Dobot",
    "DobotException",
    "Joints",
    "Methods",
    "Pose",
    "Position",
]

MAX_QUEUE_LEN = 32
STEP_PER_CIRCLE = 360.0 / 1.8 * 10.0 * 16.0
MM_PER_CIRCLE = 3.1415926535898 * 36.0


class MODE_PTP(IntEnum):
    """Path of a move and meaning of its four numbers: a pose, joint angles (ANGLE), or increments (INC)."""

    JUMP_XYZ = 0
    MOVJ_XYZ = 1
    MOVL_XYZ = 2
    JUMP_ANGLE = 3
    MOVJ_ANGLE = 4
    MOVL_ANGLE = 5
    MOVJ_INC = 6
    MOVL_INC = 7
    MOVJ_XYZ_INC = 8
    JUMP_MOVL_XYZ = 9


class DobotException(Exception):
    """Failure of a call; ``__cause__`` is the :class:`magician.errors.Error` with the reason."""


class Position(NamedTuple):
    """Position, mm, and rotation r, degrees."""

    x: float
    y: float
    z: float
    r: float


class Joints(NamedTuple):
    """Joint angles, degrees."""

    j1: float
    j2: float
    j3: float
    j4: float

    def in_radians(self) -> Joints:
        """Returns the angles in radians."""
        return Joints(*map(math.radians, self))


class Pose(NamedTuple):
    """Pose of the arm."""

    position: Position
    joints: Joints


class Methods(Forks):
    """Methods of the arm. A queued call returns its index, for :meth:`wait_for_cmd`."""

    def get_pose(self) -> Pose:
        """Returns the pose of the arm."""
        values = struct.unpack("<8f", self._magician_command(10, GET).params)
        return Pose(Position(*values[:4]), Joints(*values[4:]))

    def get_alarms(self) -> set[Alarm]:
        """Returns the active alarms."""
        bits = int.from_bytes(self._magician_command(20, GET).params, "little")
        return {Alarm(code) for code in range(bits.bit_length()) if bits >> code & 1}

    def clear_alarms(self) -> None:
        """Clears the alarms."""
        self._magician_command(20, SET)

    def _magician_queued(self, answer: Message) -> int:
        return self._magician_index(answer)

    @staticmethod
    def _extract_cmd_index(response: Message) -> int:
        """Returns the queue index in the reply to a queued command."""
        return Robot._magician_index(response)

    def wait_for_cmd(self, cmd_id: int) -> None:
        """Waits until the queued command with this index has finished."""
        self._magician_finish(cmd_id)

    def _set_end_effector_laser(self, power: int = 255, enable: bool = False) -> Message:
        return self._magician_command(61, QUEUED, bytes((enable is True, power)))

    def _set_home_cmd(self) -> Message:
        return self._magician_command(31, QUEUED)

    def _set_arc_cmd(
        self, x: float, y: float, z: float, r: float, cir_x: float, cir_y: float, cir_z: float, cir_r: float
    ) -> Message:
        return self._magician_command(101, QUEUED, floats(cir_x, cir_y, cir_z, cir_r, x, y, z, r))

    def _set_home_coordinate(self, x: float, y: float, z: float, r: float) -> Message:
        return self._magician_command(30, QUEUED, floats(x, y, z, r))

    def _set_jog_coordinate_params(
        self,
        vx: float,
        vy: float,
        vz: float,
        vr: float,
        ax: float = 100,
        ay: float = 100,
        az: float = 100,
        ar: float = 100,
    ) -> Message:
        return self._magician_command(71, QUEUED, floats(vx, vy, vz, vr, ax, ay, az, ar))

    def _set_jog_command(self, cmd: int) -> Message:
        return self._magician_command(73, QUEUED, bytes((0, cmd)))

    def _magician_jog(self, axis: int, v: float) -> None:
        speeds = [0.0] * 4
        speeds[axis] = abs(v)
        self._set_jog_coordinate_params(*speeds)
        key = 0 if v == 0 else 2 * axis + (1 if v > 0 else 2)
        self.wait_for_cmd(self._magician_index(self._set_jog_command(key)))

    def jog_x(self, v: float) -> None:
        """Jogs along x (mm/s) until called with 0."""
        self._magician_jog(0, v)

    def jog_y(self, v: float) -> None:
        """Jogs along y (mm/s) until called with 0."""
        self._magician_jog(1, v)

    def jog_z(self, v: float) -> None:
        """Jogs along z (mm/s) until called with 0."""
        self._magician_jog(2, v)

    def jog_r(self, v: float) -> None:
        """Rotates the tool (degrees/s) until called with 0."""
        self._magician_jog(3, v)

    def set_io(self, address: int, state: bool) -> None:
        """Sets an output (1 to 22) and waits until that is done."""
        if not 1 <= address <= 22:
            raise DobotException(f"there is no output {address}: they are 1 to 22")
        self.wait_for_cmd(self._magician_queued(self._magician_command(131, QUEUED, bytes((address, int(state))))))

    def go_arc(
        self, x: float, y: float, z: float, r: float, cir_x: float, cir_y: float, cir_z: float, cir_r: float
    ) -> int:
        """Moves along an arc through the second pose to the first."""
        return self._magician_queued(self._set_arc_cmd(x, y, z, r, cir_x, cir_y, cir_z, cir_r))

    def suck(self, enable: bool) -> int:
        """Switches the suction cup."""
        return self._magician_queued(self._set_end_effector_suction_cup(enable))

    def set_home(self, x: float, y: float, z: float, r: float = 0.0) -> None:
        """Sets the pose at the end of homing."""
        self._set_home_coordinate(x, y, z, r)

    def grip(self, enable: bool) -> int:
        """Closes or opens the gripper."""
        return self._magician_queued(self._set_end_effector_gripper(enable))

    def laze(self, power: int = 0, enable: bool = False) -> int:
        """Switches the laser."""
        return self._magician_queued(self._set_end_effector_laser(power, enable))

    def speed(self, velocity: float = 100.0, acceleration: float = 100.0) -> None:
        """Sets ratios (%) and the tool's speed (mm/s) and acceleration (mm/s^2), and waits until that is done."""
        self.wait_for_cmd(self._magician_queued(self._set_ptp_common_params(velocity, acceleration)))
        self.wait_for_cmd(self._magician_queued(self._set_ptp_coordinate_params(velocity, acceleration)))

    def conveyor_belt(self, speed: float, direction: int = 1, interface: int = 0) -> None:
        """Runs the belt at a share (0 to 1) of 50 mm/s, forward (1) or back (-1)."""
        if not 0.0 <= speed <= 1.0 or direction not in (1, -1):
            raise DobotException(f"speed is 0 to 1 and direction 1 or -1, not {speed} and {direction}")
        self._set_stepper_motor(int(50 * speed * STEP_PER_CIRCLE / MM_PER_CIRCLE * direction), interface)

    def _set_stepper_motor(self, speed: int, interface: int = 0, motor_control: bool = True) -> Message:
        head = (interface == 1, motor_control is True)
        return self._magician_command(135, QUEUED, struct.pack("<BBi", *head, int(speed)))

    def _set_stepper_motor_distance(
        self, speed: float, distance: float, interface: int = 0, motor_control: bool = True
    ) -> Message:
        head = (interface == 1, motor_control is True)
        return self._magician_command(136, QUEUED, struct.pack("<BBiI", *head, int(speed), int(distance)))

    def _set_cp_params(self, velocity: float, acceleration: float, period: float) -> Message:
        return self._magician_command(90, QUEUED, floats(acceleration, velocity, period) + b"\0")

    def _set_cple_cmd(self, x: float, y: float, z: float, power: float, absolute: bool = False) -> Message:
        if not 0 <= power <= 100:
            raise AssertionError(f"the laser's power is 0 to 100, not {power}")
        return self._magician_command(92, QUEUED, struct.pack("<B4f", int(absolute), x, y, z, power))

    def engrave(
        self,
        image: Any,
        pixel_size: float,
        low: float = 0.0,
        high: float = 40.0,
        velocity: float = 5,
        acceleration: float = 5,
        actual_acceleration: float = 5,
    ) -> None:
        """Engraves rows of grey values (0 to 255, dark burns) from the current position, along y, row by row along x.

        ``pixel_size`` is in mm, ``low`` and ``high`` are the laser's power (%) for the lightest and the darkest pixel.
        """
        rows: list[list[float]] = [[255.0 - float(value) for value in row] for row in _rows(image)]
        least, most = min(map(min, rows)), max(map(max, rows))
        scale = (high - low) / (most - least) if most > least else 0.0
        x, y, z = self.get_pose().position[:3]
        self.wait_for_cmd(self.laze(0, False))
        self._set_queued_cmd_clear()
        self.wait_for_cmd(self._magician_queued(self._set_cp_params(velocity, acceleration, actual_acceleration)))
        self._set_queued_cmd_stop_exec()
        sent = 0
        for number, row in enumerate(rows):
            columns = range(len(row)) if number % 2 == 0 else reversed(range(len(row)))
            for column in columns:
                power = (row[column] - least) * scale + low
                # A nearly full queue has to be running: from here on commands wait for room.
                if sent == MAX_QUEUE_LEN - 2:
                    self._set_queued_cmd_start_exec()
                self._set_cple_cmd(x + number * pixel_size, y + column * pixel_size, z, power, True)
                sent += 1
        self._set_queued_cmd_start_exec()
        self.wait_for_cmd(self.laze(0, False))


class Dobot(Methods):
    """Connected arm, mm and degrees.

    Connecting starts and clears the queue, sets all speeds to 200 and the ratios to 100 %, and clears the alarms.
    """

    logger = logging.Logger(__name__)
    """Hears of frames, at debug."""

    def __init__(self, port: str | None = None, verbose: bool = False, *, should_clear_alarms: bool = True) -> None:
        self._lock = threading.RLock()
        self._magician_open(port)
        self._ser: Port = self._magician_port
        self.logger.debug("%s open", self._magician_line.name)
        self._magician_setup()
        if (alarms := self.get_alarms()) and should_clear_alarms:
            # The alarm for power-up is expected: do not report it.
            if news := [alarm.name for alarm in alarms if alarm]:
                self.logger.warning("clearing alarms: %s", ", ".join(news))
            self.clear_alarms()

    def _magician_fault(self, error: Error) -> Exception:
        return DobotException(str(error))

    def _magician_exchange(self, msg: Message) -> Message:
        self.logger.debug(">> %s", msg)
        answer = super()._magician_exchange(msg)
        self.logger.debug("<< %s", answer)
        return answer

    def close(self) -> None:
        """Ends the connection. The arm finishes its queued commands."""
        self._magician_line.close()
        self.logger.debug("%s closed", self._magician_line.name)


def _rows(image: Any) -> Iterable[Iterable[Any]]:
    """Returns the rows of an array or of a sequence of rows."""
    listed: Callable[[], Iterable[Iterable[Any]]] | None = getattr(image, "tolist", None)
    return image if listed is None else listed()

"""Arm of dobotWrapperPy for asyncio: every call is awaited, and returns when it is done."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable
from typing import Any, TypeVar

from .._alarm import Alarm
from .dobotapi import DobotApi
from .dobotConnection import DobotConnection

__all__ = ["DobotAsync"]

_T = TypeVar("_T")
JUMP, JOINT, LINE, LINE_JUMP = 0, 1, 2, 9


class DobotAsync:
    """Arm. The runner handles Ctrl-C; no handler is installed here."""

    def __init__(self, port: str, verbose: bool = False) -> None:
        self.dobotApiInterface = DobotApi(DobotConnection(port=port), verbose)

    async def _run(self, call: Callable[..., _T], *given: Any) -> _T:
        return await asyncio.get_running_loop().run_in_executor(None, call, *given)

    async def _set(self, id: int, params: bytes, motion: bool = False) -> None:
        await self._run(self.dobotApiInterface._set, id, params, True, True, motion)  # pyright: ignore[reportPrivateUsage]

    async def _move(self, mode: int, x: float, y: float, z: float, r: float, *rail: float) -> None:
        await self._set(86 if rail else 84, struct.pack(f"<B{4 + len(rail)}f", mode, x, y, z, r, *rail), True)

    async def _move_by(self, mode: int, *by: float) -> None:
        here = [*(await self.pose())[:4], *([await self.pose_rail()] if len(by) == 5 else [])]
        there = [each + more for each, more in zip(here, by, strict=True)]
        await self._move(mode, *there)

    async def connect(self) -> None:
        """Starts and clears the queue, and sets all speeds to 200."""
        await self._run(self.dobotApiInterface.initialize_robot)

    async def move_xyz_linear(self, x: float, y: float, z: float, r: float) -> None:
        """Moves to a pose in a straight line."""
        await self._move(LINE, x, y, z, r)

    async def move_xyz_joint(self, x: float, y: float, z: float, r: float) -> None:
        """Moves to a pose by a joint move."""
        await self._move(JOINT, x, y, z, r)

    async def move_relative_xyz_linear(self, delta_x: float, delta_y: float, delta_z: float, delta_r: float) -> None:
        """Moves by an increment in a straight line."""
        await self._move_by(LINE, delta_x, delta_y, delta_z, delta_r)

    async def move_relative_xyz_joint(self, delta_x: float, delta_y: float, delta_z: float, delta_r: float) -> None:
        """Moves by an increment by a joint move."""
        await self._move_by(JOINT, delta_x, delta_y, delta_z, delta_r)

    async def jump(self, x: float, y: float, z: float, r: float) -> None:
        """Jumps to a pose: up, across and down."""
        await self._move(LINE_JUMP, x, y, z, r)

    async def jump_relative_xyz(self, delta_x: float, delta_y: float, delta_z: float, delta_r: float) -> None:
        """Jumps by an increment: up, across and down."""
        await self._move_by(JUMP, delta_x, delta_y, delta_z, delta_r)

    async def move_xyz_rail_linear(self, x: float, y: float, z: float, r: float, rail: float) -> None:
        """Moves to a pose in a straight line, and along the rail."""
        await self._move(LINE, x, y, z, r, rail)

    async def move_xyz_rail_joint(self, x: float, y: float, z: float, r: float, rail: float) -> None:
        """Moves to a pose by a joint move, and along the rail."""
        await self._move(JOINT, x, y, z, r, rail)

    async def move_relative_xyz_rail_linear(
        self, delta_x: float, delta_y: float, delta_z: float, delta_r: float, delta_rail: float
    ) -> None:
        """Moves by an increment in a straight line, and along the rail."""
        await self._move_by(LINE, delta_x, delta_y, delta_z, delta_r, delta_rail)

    async def move_relative_xyz_rail_joint(
        self, delta_x: float, delta_y: float, delta_z: float, delta_r: float, delta_rail: float
    ) -> None:
        """Moves by an increment by a joint move, and along the rail."""
        await self._move_by(JOINT, delta_x, delta_y, delta_z, delta_r, delta_rail)

    async def jump_rail(self, x: float, y: float, z: float, r: float, rail: float) -> None:
        """Jumps to a pose: up, across and down, and along the rail."""
        await self._move(LINE_JUMP, x, y, z, r, rail)

    async def move_in_circle(
        self,
        relative_x: float,
        relative_y: float,
        relative_z: float,
        relative_r: float,
        end_x: float,
        end_y: float,
        end_z: float,
        end_r: float,
    ) -> None:
        """Moves along the arc through the first point to the second; both are absolute."""
        through = (relative_x, relative_y, relative_z, relative_r)
        await self._set(101, struct.pack("<8f", *through, end_x, end_y, end_z, end_r), True)

    async def set_pin_purpose(self, address: int, purpose: Any) -> None:
        """Sets the function of a pin."""
        await self._set(130, bytes((address, getattr(purpose, "value", purpose))))

    async def set_pin_output(self, address: int, level: Any) -> None:
        """Sets an output."""
        await self._set(131, bytes((address, getattr(level, "value", level))))

    async def get_pin_input(self, address: int) -> Any:
        """Returns the level of an input."""
        return await self._run(self.dobotApiInterface.get_io_di, address)

    async def set_pwm(self, address: int, frequency: float, cycle: float) -> None:
        """Sets frequency (Hz) and duty cycle (%) of a pin."""
        await self._set(132, struct.pack("<B2f", address, frequency, cycle))

    async def get_adc(self, address: int) -> int:
        """Returns the value of an analogue input (0 to 4095)."""
        return int(await self._run(self.dobotApiInterface.get_io_adc, address))

    async def suck(self, enable: bool) -> None:
        """Switches the suction cup."""
        await self._set(62, bytes((1, enable)))

    async def grip(self, enable: bool, grip: bool) -> None:
        """Switches the gripper."""
        await self._set(63, bytes((enable, grip)))

    async def laser(self, enable: bool) -> None:
        """Switches the laser."""
        await self._set(61, bytes((1, enable)))

    async def speed(self, velocity: float = 100.0, acceleration: float = 100.0) -> None:
        """Sets ratios (%) and the tool's speed (mm/s) and acceleration (mm/s^2)."""
        await self._set(83, struct.pack("<2f", velocity, acceleration))
        await self._set(81, struct.pack("<4f", velocity, velocity, acceleration, acceleration))

    async def wait(self, ms: int) -> None:
        """Queues a wait (ms)."""
        await self._set(110, struct.pack("<I", ms))

    async def home(self) -> None:
        """Homes the arm."""
        await self._set(31, bytes(4), True)

    async def pose(self) -> tuple[float, ...]:
        """Returns x, y, z (mm), r and four joint angles (degrees)."""
        pose = await self._run(self.dobotApiInterface.get_pose)
        return (pose.x, pose.y, pose.z, pose.r, *pose.jointAngle)

    async def pose_rail(self) -> float:
        """Returns the position on the rail (mm)."""
        return float(await self._run(self.dobotApiInterface.get_pose_rail))

    async def clear_alarms(self) -> None:
        """Clears the alarms."""
        await self._run(self.dobotApiInterface.clear_all_alarms_state)

    async def get_alarms(self) -> set[Alarm]:
        """Returns the active alarms."""
        return await self._run(self.dobotApiInterface.get_active_alarms)

    async def set_motor(self, address: Any, enable: bool, speed: int) -> None:
        """Runs a motor (pulses/s)."""
        await self._set(135, struct.pack("<BBi", getattr(address, "value", address), enable, speed))

    def force_stop(self) -> None:
        """Stops the arm."""
        self.dobotApiInterface.set_queued_cmd_force_stop_exec()

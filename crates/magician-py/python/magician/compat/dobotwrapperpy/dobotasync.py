"""dobotWrapperPy's arm for asyncio: every call is awaited, and returns when it is done."""

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
JUMP, JOINT, LINE, RELATIVE_LINE, RELATIVE_JOINT = 9, 1, 2, 7, 8


class DobotAsync:
    """An arm. Ctrl-C is the runner's: no handler is set here."""

    def __init__(self, port: str, verbose: bool = False) -> None:
        self.dobotApiInterface = DobotApi(DobotConnection(port=port), verbose)

    async def _run(self, call: Callable[..., _T], *given: Any) -> _T:
        return await asyncio.get_running_loop().run_in_executor(None, call, *given)

    async def _set(self, id: int, params: bytes, motion: bool = False) -> None:
        await self._run(self.dobotApiInterface._set, id, params, True, True, motion)  # pyright: ignore[reportPrivateUsage]

    async def _move(self, mode: int, x: float, y: float, z: float, r: float) -> None:
        await self._set(84, struct.pack("<B4f", mode, x, y, z, r), True)

    async def connect(self) -> None:
        """Starts and clears the queue, and sets all speeds to 200."""
        await self._run(self.dobotApiInterface.initialize_robot)

    async def move_xyz_linear(self, x: float, y: float, z: float, r: float) -> None:
        """Goes there in a straight line."""
        await self._move(LINE, x, y, z, r)

    async def move_xyz_joint(self, x: float, y: float, z: float, r: float) -> None:
        """Goes there with the joints."""
        await self._move(JOINT, x, y, z, r)

    async def move_relative_xyz_linear(self, x: float, y: float, z: float, r: float) -> None:
        """Goes by so much in a straight line."""
        await self._move(RELATIVE_LINE, x, y, z, r)

    async def move_relative_xyz_joint(self, x: float, y: float, z: float, r: float) -> None:
        """Goes by so much with the joints."""
        await self._move(RELATIVE_JOINT, x, y, z, r)

    async def jump(self, x: float, y: float, z: float, r: float) -> None:
        """Goes up, across and down."""
        await self._move(JUMP, x, y, z, r)

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
        """Waits in the arm's queue (ms)."""
        await self._set(110, struct.pack("<I", ms))

    async def home(self) -> None:
        """Homes the arm."""
        await self._set(31, bytes(4), True)

    async def pose(self) -> tuple[float, ...]:
        """x, y, z (mm), r and four joint angles (degrees)."""
        pose = await self._run(self.dobotApiInterface.get_pose)
        return (pose.x, pose.y, pose.z, pose.r, *pose.jointAngle)

    async def pose_rail(self) -> float:
        """Where the arm stands on the rail (mm)."""
        return float(await self._run(self.dobotApiInterface.get_pose_rail))

    async def clear_alarms(self) -> None:
        """Clears the alarms."""
        await self._run(self.dobotApiInterface.clear_all_alarms_state)

    async def get_alarms(self) -> set[Alarm]:
        """The alarms that stand."""
        return await self._run(self.dobotApiInterface.get_active_alarms)

    async def set_motor(self, address: Any, enable: bool, speed: int) -> None:
        """Runs a motor (pulses/s)."""
        await self._set(135, struct.pack("<BBi", getattr(address, "value", address), enable, speed))

    def force_stop(self) -> None:
        """Stops the arm."""
        self.dobotApiInterface.set_queued_cmd_force_stop_exec()

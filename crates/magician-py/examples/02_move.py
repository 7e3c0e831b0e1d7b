"""Home, and move: there with asyncio, back without.

``python 02_move.py /dev/ttyUSB0`` (a virtual arm unless a port is given). The arm moves: keep clear of it.
"""

from __future__ import annotations

import asyncio
import sys

import magician
from magician import aio


async def with_asyncio(port: str) -> None:
    """There: homing, and two moves."""
    async with aio.Arm.connect(port) as arm:
        await arm.home()
        await arm.speed(50)
        await arm.move_to(200, 80, 40)
        await arm.line_by(dy=-160)
        pose = await arm.pose()
        print(f"now at {pose.x} {pose.y} {pose.z}")


def without(port: str) -> None:
    """And back."""
    with magician.Arm(port) as arm:
        arm.move_joints(0, 45, 45)
        # A target out of reach is refused before anything is sent.
        try:
            arm.move_to(500, 0, 0)
        except magician.errors.UnreachableError as error:
            print(f"as it should be: {error}")


if __name__ == "__main__":
    where = sys.argv[1] if len(sys.argv) > 1 else "sim"
    asyncio.run(with_asyncio(where))
    without(where)

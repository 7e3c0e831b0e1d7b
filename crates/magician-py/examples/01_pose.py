"""Where is the arm? First with asyncio, then without.

``python 01_pose.py /dev/ttyUSB0`` (a virtual arm unless a port is given)
"""

from __future__ import annotations

import asyncio
import sys

import magician
from magician import aio, commands


async def with_asyncio(port: str) -> None:
    """Asks with a class of ``commands``, and with a method."""
    async with aio.Arm.connect(port) as arm:
        version = await arm.get(commands.DeviceVersion)
        pose = await arm.pose()
        print(f"firmware {version.major_version}.{version.minor_version}")
        print(f"x {pose.x} y {pose.y} z {pose.z} r {pose.r}")


def without(port: str) -> None:
    """The same names, without ``await``."""
    with magician.Arm(port) as arm:
        print(f"joints {arm.joints()}")
        for alarm in arm.alarms():
            print(f"alarm {alarm}")


if __name__ == "__main__":
    where = sys.argv[1] if len(sys.argv) > 1 else "sim"
    asyncio.run(with_asyncio(where))
    without(where)

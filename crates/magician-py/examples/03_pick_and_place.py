"""Carries three parts from left to right with the suction cup, and shows how far it is.

``python 03_pick_and_place.py /dev/ttyUSB0`` (a virtual arm unless a port is given). The arm moves: keep clear of it,
and choose a height that suits your table.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Iterator

import magician
from magician import Progress, aio, words
from magician.commands import Queueable

TABLE = -40.0


def carry(start: tuple[float, float], end: tuple[float, float]) -> Iterator[Queueable]:
    """One part from here to there."""
    for (x, y), hold in ((start, True), (end, False)):
        yield words.jump_to(x, y, TABLE, 0)
        yield words.suction(hold)
        yield words.wait(0.3)


def program() -> list[Queueable]:
    """Words are values: the same program for both kinds of arm."""
    everything: list[Queueable] = [words.tool("suction"), words.jump_height(30, 100)]
    for part in (0, 25, 50):
        everything += carry((200 + part, 90), (200 + part, -90))
    return everything


def show(progress: Progress) -> None:
    """Called now and then while a program runs."""
    print(f"{progress.current} done")


async def with_asyncio(port: str) -> None:
    """Tells how long it will take, and how far it is."""
    async with aio.Arm.connect(port) as arm:
        print(f"takes {await arm.estimate(program()):.1f} s")
        await arm.perform(program(), progress=show)


def without(port: str) -> None:
    """The same once more."""
    with magician.Arm(port) as arm:
        ran = arm.perform(program())
        print(f"{ran.commands} commands")


if __name__ == "__main__":
    where = sys.argv[1] if len(sys.argv) > 1 else "sim"
    asyncio.run(with_asyncio(where))
    without(where)

"""How calls of the native part end: a thread waits for them, or an event loop is told."""

from __future__ import annotations

import asyncio
from typing import TypeVar

from ._magician import Call

T = TypeVar("T")


def wait(call: Call[T]) -> T:
    """Waits in this thread."""
    return call.wait()


async def until(call: Call[T]) -> T:
    """Waits in the running event loop. What is cancelled meanwhile is let go of."""
    loop = asyncio.get_running_loop()
    ended = loop.create_future()

    def wake() -> None:
        if not ended.done():
            ended.set_result(None)

    call.on_end(lambda: loop.call_soon_threadsafe(wake))
    try:
        await ended
    except asyncio.CancelledError:
        call.cancel()
        raise
    return call.result()

"""The arm for programs on asyncio.

The blocking interface, :class:`magician.Arm`, is made of this file by ``tools/blocking.py``: it is the same, without
``await``.
"""

from __future__ import annotations

from ._magician import Core
from ._native import until

__all__ = ["Arm"]


class Arm:
    """A connected arm.

    Lengths are mm, angles degrees, times seconds. Every call ends: with its answer, or with an exception of
    :mod:`magician.errors` by its deadline. A ``with`` block that is left by an exception stops what the arm was told to do.
    """

    def __init__(self, core: Core) -> None:
        self._core = core

    @classmethod
    async def connect(cls, port: str, *, timeout: float = 3.0, window: int = 1) -> Arm:
        """Connects to the arm at ``port``: ``"sim"`` for a virtual one, ``"/dev/ttyUSB0"``, ``"COM3"``, ``"udp:HOST"``."""
        return cls(await until(Core.connect(port, timeout=timeout, window=window)))

    async def home(self) -> None:
        """Homes the arm and waits until it is there."""
        await until(self._core.home())

    async def stop(self) -> None:
        """Stops the arm at once, whatever is going on, and empties its queue."""
        await until(self._core.stop())

    async def close(self) -> None:
        """Ends the connection; what it set going stops."""
        await until(self._core.close())

"""The arm for programs without asyncio: made of ``aio.py`` by ``tools/blocking.py``; change that."""

from __future__ import annotations

from ._magician import Core
from ._native import wait

__all__ = ["Arm"]


class Arm:
    """A connected arm.

    Lengths are mm, angles degrees, times seconds. Every call ends: with its answer, or with an exception of
    :mod:`magician.errors` by its deadline. A ``with`` block that is left by an exception stops what the arm was told to do.
    """

    def __init__(self, core: Core) -> None:
        self._core = core

    @classmethod
    def connect(cls, port: str, *, timeout: float = 3.0, window: int = 1) -> Arm:
        """Connects to the arm at ``port``: ``"sim"`` for a virtual one, ``"/dev/ttyUSB0"``, ``"COM3"``, ``"udp:HOST"``."""
        return cls(wait(Core.connect(port, timeout=timeout, window=window)))

    def home(self) -> None:
        """Homes the arm and waits until it is there."""
        wait(self._core.home())

    def stop(self) -> None:
        """Stops the arm at once, whatever is going on, and empties its queue."""
        wait(self._core.stop())

    def close(self) -> None:
        """Ends the connection; what it set going stops."""
        wait(self._core.close())

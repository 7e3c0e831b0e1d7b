"""A virtual arm for other programs: at a pseudo-terminal, over UDP, over TCP."""

from __future__ import annotations

import atexit
import os
from collections.abc import Sequence
from types import TracebackType
from typing import Literal

from . import _magician, words
from ._arguments import seconds, text
from ._bound import Bound
from ._scenarios import clock_speed, scenario_text, tool_bias
from .errors import InvalidInputError

__all__ = ["Served", "sim"]


class Served(Bound):
    """A virtual arm that is served: see :func:`magician.sim`. It ends with its ``with`` block, by :meth:`close`, or
    with the program.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _magician.Served) -> None:
        self._native = native
        # What it made, the path of a pseudo-terminal among it, goes with the program.
        atexit.register(self.close)

    def __enter__(self) -> Served:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Where it is reached, as :class:`magician.Arm` takes it, with the ports that it got: the path of a
        pseudo-terminal, ``"udp:127.0.0.1:8899"``, ``"tcp:127.0.0.1:9000"``.
        """
        return tuple(where for kind, where in self._native.endpoints() if kind != "discovery")

    @property
    def pty(self) -> str | None:
        """The path of its pseudo-terminal."""
        return self._at("pty")

    @property
    def udp(self) -> str | None:
        """Where it is reached over UDP."""
        return self._at("udp")

    @property
    def tcp(self) -> str | None:
        """Where it is reached over TCP."""
        return self._at("tcp")

    @property
    def discovery(self) -> str | None:
        """Where it answers programs that look for arms on the network; ``None`` where it does not."""
        return self._at("discovery")

    @property
    def is_open(self) -> bool:
        """Whether it is served."""
        return self._native.is_open()

    def wait(self, timeout: float | None = None) -> bool:
        """Serves until Ctrl-C, which is raised here, or for so many seconds.

        :returns: Whether it is still served; False once it was closed, or an endpoint broke down: :meth:`close` tells.
        """
        return self._native.wait(None if timeout is None else seconds("timeout", timeout))

    def close(self) -> None:
        """Ends it. Its clients are disconnected, and what it made is gone when this returns. Closing it again does
        nothing.

        :raises PortError: An endpoint had broken down.
        """
        atexit.unregister(self.close)
        self._native.close()

    def _at(self, wanted: str) -> str | None:
        return next((where for kind, where in self._native.endpoints() if kind == wanted), None)

    def __repr__(self) -> str:
        return f"<Served at {', '.join(self.endpoints)}{'' if self.is_open else ', closed'}>"


def sim(
    scenario: str | os.PathLike[str] | None = None,
    *,
    pty: str | os.PathLike[str] | None = None,
    udp: str | None = None,
    tcp: str | None = None,
    speed: float | Literal["max"] = 1.0,
    tool: words.Tool | Sequence[float] | None = None,
) -> Served:
    """Serves a virtual arm to other programs, as ``magician sim`` does, and returns when it accepts connections.

    >>> with magician.sim(tcp="127.0.0.1:0") as served:
    ...     arm = magician.Arm(served.tcp)

    At least one of ``pty``, ``udp`` and ``tcp`` is given. It is served by a thread of its own, also while this program
    is busy. A program on asyncio uses it the same way, with ``with``.

    :param scenario: The world around it, as for :class:`VirtualArm`.
    :param pty: A path for a new pseudo-terminal, which becomes a symlink to it. Not on Windows.
    :param udp: ``"HOST[:PORT]"``; 8899 if the port is left out, 0 is any free one. On port 8899 it answers programs
        that look for arms, too.
    :param tcp: ``"HOST:PORT"``; 0 is any free port.
    :param speed: How many times as fast as a real arm, or ``"max"`` for no time while it is busy.
    :param tool: The tool that was chosen before it was switched on, as for :class:`VirtualArm`.
    :raises InvalidInputError: There is no endpoint, an address makes no sense, or the scenario has a mistake.
    :raises PortError: A port or path is taken, or not to be had.
    :raises UnsupportedError: This system has no pseudo-terminals.
    """
    if pty is None and udp is None and tcp is None:
        raise InvalidInputError("no endpoint to serve: give pty, udp or tcp")
    path = None if pty is None else os.fspath(pty)
    where = {"pty": path, "udp": text("udp", udp), "tcp": text("tcp", tcp)}
    return Served(_magician.serve_sim(scenario_text(scenario), clock_speed(speed), tool_bias(tool), **where))

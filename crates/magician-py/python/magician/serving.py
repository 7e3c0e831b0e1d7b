"""Arms for other programs, at pseudo-terminals, over UDP, over TCP: virtual ones, and real ones that programs share."""

from __future__ import annotations

import atexit
import os
from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import Literal, Protocol, cast

from . import _magician, words
from ._arguments import flag, number, seconds, text
from ._bound import Bound
from ._scenarios import clock_speed, scenario_text, tool_bias
from .errors import InvalidInputError

__all__ = ["Endpoints", "Paths", "Served", "Virtual", "endpoints", "proxy", "sim"]

Paths = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]
"""The path of a pseudo-terminal, or of several."""
Endpoints = tuple[list[str], str | None, str | None]
"""Paths of pseudo-terminals, an address for UDP, one for TCP."""


class Virtual(Protocol):
    """A :class:`magician.VirtualArm`."""

    @property
    def native(self) -> _magician.Cell:
        """Its native part."""
        ...


class Served(Bound):
    """An arm that other programs can connect to: see :func:`magician.sim`, :func:`magician.proxy` and
    :meth:`VirtualArm.serve`. It ends with its ``with`` block, by :meth:`close`, or with the program.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _magician.Served) -> None:
        self._native = native
        # Remove everything it created, such as the path of a pseudo-terminal, when the program ends.
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
        """The path of its pseudo-terminal, the first if it has several."""
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
        """True if it is served."""
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
    pty: Paths | None = None,
    udp: str | None = None,
    tcp: str | None = None,
    speed: float | Literal["max"] = 1.0,
    tool: words.Tool | Sequence[float] | None = None,
) -> Served:
    """Serves a virtual arm to other programs, as ``magician sim`` does, and returns when it accepts connections.

    >>> with magician.sim(tcp="127.0.0.1:0") as served:
    ...     arm = magician.Arm(served.tcp)

    At least one of ``pty``, ``udp`` and ``tcp`` is given. It is served by a thread of its own, also while this program
    is busy. A program on asyncio uses it the same way, with ``with``. To look at the arm's world meanwhile, serve a
    :class:`VirtualArm` (:meth:`VirtualArm.serve`).

    :param scenario: The world around it, as for :class:`VirtualArm`.
    :param pty: A path for a new pseudo-terminal, which becomes a symlink to it, or several paths. Not on Windows.
    :param udp: ``"HOST[:PORT]"``; 8899 if the port is left out, 0 is any free one. On port 8899 it answers programs
        that look for arms, too.
    :param tcp: ``"HOST:PORT"``; 0 is any free port.
    :param speed: How many times as fast as a real arm, or ``"max"`` for no time while it is busy.
    :param tool: The tool that was chosen before it was switched on, as for :class:`VirtualArm`.
    :raises InvalidInputError: There is no endpoint, an address makes no sense, or the scenario has a mistake.
    :raises PortError: A port or path is taken, or not to be had.
    :raises UnsupportedError: This system has no pseudo-terminals.
    """
    where = endpoints(pty, udp, tcp)
    return Served(_magician.serve_sim(scenario_text(scenario), clock_speed(speed), tool_bias(tool), where))


def proxy(
    port: str | os.PathLike[str] | Virtual | None = None,
    *,
    pty: Paths | None = None,
    udp: str | None = None,
    tcp: str | None = None,
    faults: str | Mapping[str, float] = "",
    trace: str | os.PathLike[str] | None = None,
    fresh: float = 0.02,
    transparent: bool = False,
    keep_going: bool = False,
) -> Served:
    """Shares one arm between programs, as ``magician proxy`` does, and returns when it accepts connections.

    >>> with magician.proxy("sim", tcp="127.0.0.1:0") as shared:
    ...     one, other = magician.Arm(shared.tcp), magician.Arm(shared.tcp)

    Every program sees an arm of its own: each of its requests gets one reply, in order. The arm gets one request at a
    time; a stop overtakes all that waits. Nothing is sent twice. A line to the arm that is lost is looked for, and
    programs stay connected meanwhile. When a program disconnects, and when this ends, the jog that was begun through it
    ends too. What happens to clients and line is told to the logger ``magician``.

    At least one of ``pty``, ``udp`` and ``tcp`` is given. An address other than 127.0.0.1 lets every computer of the
    network move the arm, without a password.

    :param port: As for :class:`magician.Arm`: a port, a :class:`VirtualArm`, or nothing for the one arm that is plugged
        in. No other program may have it open, nor this one.
    :param pty: A path for a new pseudo-terminal, which becomes a symlink to it: one for each program, so usually
        several paths. Not on Windows.
    :param udp: ``"HOST[:PORT]"``; 8899 if the port is left out, 0 is any free one.
    :param tcp: ``"HOST:PORT"``; 0 is any free port. Up to 16 programs may connect.
    :param faults: Faults on the line to the arm, to try what programs make of them: ``{"drop": 1e-3, "seed": 7}`` or
        ``"drop=1e-3,seed=7"``. Rates from 0 to 1 for bytes (``flip``, ``replace``, ``drop``, ``insert``, ``duplicate``,
        ``swap``) and for chunks (``drop-chunk``, ``duplicate-chunk``, ``swap-chunk``, ``stall``, ``rechunk``,
        ``unplug``).
    :param trace: A file for all that passes (pcapng): a link for each program and one for the arm;
        :func:`magician.decode` reads it once this is closed.
    :param fresh: How old an answer may be that another program gets too, s; 0: every read goes to the arm.
    :param transparent: Whether bytes that are no frame are passed on to the arm.
    :param keep_going: Whether a jog goes on when the program that began it disconnects.
    :raises InvalidInputError: There is no endpoint, an address makes no sense, or a fault is unknown.
    :raises PortError: The arm's port, or that of an endpoint, is taken or not to be had.
    :raises UnsupportedError: This system has no pseudo-terminals.
    :raises OSError: The trace cannot be written.
    """
    where = endpoints(pty, udp, tcp)
    # Not isinstance() with a protocol: from Python 3.12 on that imports inspect, which is slow.
    arm: _magician.Cell | None = getattr(port, "native", None)
    name = None if port is None or arm is not None else os.fspath(cast("str | os.PathLike[str]", port))
    if isinstance(faults, Mapping):
        faults = ",".join(f"{key}={value}" for key, value in faults.items())
    return Served(
        _magician.serve_proxy(
            name,
            arm,
            where,
            faults=text("faults", faults) or "",
            trace=None if trace is None else os.fspath(trace),
            fresh=number("fresh", fresh, least=0, most=10, unit="s"),
            transparent=flag("transparent", transparent),
            keep_going=flag("keep_going", keep_going),
        )
    )


def endpoints(pty: Paths | None, udp: str | None, tcp: str | None) -> Endpoints:
    """Where something is to be served.

    :raises InvalidInputError: Nowhere, or twice at one path.
    """
    if pty is None:
        paths = []
    elif isinstance(pty, (str, os.PathLike)):
        paths = [os.fspath(pty)]
    else:
        paths = [os.fspath(path) for path in pty]
    if not paths and udp is None and tcp is None:
        raise InvalidInputError("no endpoint to serve: give pty, udp or tcp")
    for nth, path in enumerate(paths):
        if path in paths[:nth]:
            raise InvalidInputError(f"pty has {path} twice: give each program a path of its own")
    return paths, text("udp", udp), text("tcp", tcp)

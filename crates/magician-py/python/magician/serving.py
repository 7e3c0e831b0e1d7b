"""Servers that offer virtual or shared real arms to other programs, at pseudo-terminals, over UDP and over TCP."""

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
"""Path of a pseudo-terminal, or several paths."""
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
        """Addresses for :class:`magician.Arm`, with the actual ports: the path of a
        pseudo-terminal, ``"udp:127.0.0.1:8899"``, ``"tcp:127.0.0.1:9000"``.
        """
        return tuple(where for kind, where in self._native.endpoints() if kind != "discovery")

    @property
    def pty(self) -> str | None:
        """Path of its pseudo-terminal, the first if there are several."""
        return self._at("pty")

    @property
    def udp(self) -> str | None:
        """Address over UDP."""
        return self._at("udp")

    @property
    def tcp(self) -> str | None:
        """Address over TCP."""
        return self._at("tcp")

    @property
    def discovery(self) -> str | None:
        """Address at which it answers network discovery; ``None`` if it does not."""
        return self._at("discovery")

    @property
    def is_open(self) -> bool:
        """True while the arm is being served."""
        return self._native.is_open()

    def wait(self, timeout: float | None = None) -> bool:
        """Serves until Ctrl-C, which raises :exc:`KeyboardInterrupt` here, or for a time, s.

        :returns: True if it is still served; False once it was closed or an endpoint failed, which :meth:`close`
            raises.
        """
        return self._native.wait(None if timeout is None else seconds("timeout", timeout))

    def close(self) -> None:
        """Stops the server. Clients are disconnected, and its ports and symlinks are removed when this returns. A
        second call does nothing.

        :raises PortError: An endpoint had failed.
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

    At least one of ``pty``, ``udp`` and ``tcp`` is required. A background thread serves the arm, also while this
    program is busy. A program on asyncio uses it the same way, with ``with``. To inspect the arm's world, serve a
    :class:`VirtualArm` instead (:meth:`VirtualArm.serve`).

    :param scenario: World of the arm, as for :class:`VirtualArm`.
    :param pty: Path of a symlink to a new pseudo-terminal, or several paths. Not on Windows.
    :param udp: ``"HOST[:PORT]"``; the port defaults to 8899, and 0 selects a free one. On port 8899 it also answers
        discovery.
    :param tcp: ``"HOST:PORT"``; port 0 selects a free one.
    :param speed: Clock speed relative to real time, or ``"max"`` to skip time while the arm is busy.
    :param tool: Tool set before power-up, as for :class:`VirtualArm`.
    :raises InvalidInputError: No endpoint is given, an address is invalid, or the scenario is invalid.
    :raises PortError: A port or path is in use or unavailable.
    :raises UnsupportedError: This system does not support pseudo-terminals.
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

    Each program sees an exclusive arm: each of its requests gets one reply, in order. The proxy sends one request at a
    time; a stop overtakes pending requests. Nothing is retransmitted. If the line to the arm is lost the proxy
    reconnects, and programs stay connected meanwhile. When a program disconnects, or the proxy ends, its jog ends too.
    Events of clients and line go to the logger ``magician``.

    At least one of ``pty``, ``udp`` and ``tcp`` is required. With an address other than 127.0.0.1 every computer on the
    network can move the arm without a password.

    :param port: As for :class:`magician.Arm`: a port, a :class:`VirtualArm`, or ``None`` for the only arm plugged in.
        No program may have it open, including this one.
    :param pty: Path of a symlink to a new pseudo-terminal: one for each program, so usually several paths. Not on
        Windows.
    :param udp: ``"HOST[:PORT]"``; the port defaults to 8899, and 0 selects a free one.
    :param tcp: ``"HOST:PORT"``; port 0 selects a free one. Up to 16 programs may connect.
    :param faults: Faults injected on the line to the arm, to test programs: ``{"drop": 1e-3, "seed": 7}`` or
        ``"drop=1e-3,seed=7"``. Rates from 0 to 1 for bytes (``flip``, ``replace``, ``drop``, ``insert``, ``duplicate``,
        ``swap``) and for chunks (``drop-chunk``, ``duplicate-chunk``, ``swap-chunk``, ``stall``, ``rechunk``,
        ``unplug``).
    :param trace: File for all traffic (pcapng), with a link for each program and one for the arm.
        :func:`magician.decode` reads it after the proxy is closed.
    :param fresh: Maximum age, s, of a reply that is shared with another program; 0 sends every read to the arm.
    :param transparent: Whether bytes outside frames are forwarded to the arm.
    :param keep_going: Whether a jog continues when its program disconnects.
    :raises InvalidInputError: No endpoint is given, an address is invalid, or a fault is unknown.
    :raises PortError: The port of the arm or of an endpoint is in use or unavailable.
    :raises UnsupportedError: This system does not support pseudo-terminals.
    :raises OSError: The trace file cannot be written.
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
    """Collects the endpoints of a server.

    :raises InvalidInputError: No endpoint is given, or one path is given twice.
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

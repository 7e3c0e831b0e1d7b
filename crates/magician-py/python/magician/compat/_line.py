"""The connection that the stand-ins speak over, and which arm it leads to."""

from __future__ import annotations

import atexit
import os
import re
import threading
import weakref
from typing import TypeVar

from .._magician import Call, Cell, Core
from .._native import opened as remembered
from .._native import wait, wait_done, wait_stopped
from .._ports import ports
from ..errors import ClosedError, Error, PortError

__all__ = ["Line", "find", "opened", "send_elsewhere"]

T = TypeVar("T")

GET, SET, QUEUED = 0, 1, 3
START, STOP, FORCE_STOP, CLEAR = 240, 241, 242, 245

_elsewhere: list[str] = []
_opened: weakref.WeakSet[Line] = weakref.WeakSet()
_benches: list[_Bench] = []


def send_elsewhere(port: str | None) -> None:
    """From now on every connection goes to this port, whatever a program asks for; with ``None`` where it asks for."""
    _elsewhere[:] = [port] if port else []


def elsewhere() -> str | None:
    """The port that all connections go to, if they do."""
    return _elsewhere[0] if _elsewhere else None


def opened() -> list[Line]:
    """The lines that are open."""
    return [line for line in _opened if not line.closed]


@atexit.register
def _end() -> None:
    """At the end of a program its connections are over: what destructors ask for after that is answered without the
    native part, which cannot raise any more."""
    for line in opened():
        line.closed = True


def find(port: str | None) -> str:
    """The port to connect to, of the one a program names.

    ``MAGICIAN_PORT_COM3=sim`` sends a program elsewhere that names ``COM3``. No name means ``MAGICIAN_PORT``, else the
    first port with an arm's adapter.
    """
    if other := elsewhere():
        return other
    if not port:
        if other := os.environ.get("MAGICIAN_PORT"):
            return other
        for found in ports():
            if found.likely_arm:
                return found.path
        raise PortError("no arm found: plug it in, or name its port; MAGICIAN_PORT=sim is a virtual one")
    if other := os.environ.get("MAGICIAN_PORT_" + re.sub(r"[^A-Z0-9]", "_", port.upper())):
        return other
    device = f"/dev/{port}"
    return device if re.fullmatch(r"(tty|cu\.)\w+", port) and os.path.exists(device) else port


class Line:
    """An open connection. Its calls end: with the answer, or with an exception of :mod:`magician.errors`.

    The arm is left as it is when the connection ends, as these libraries leave it; an interrupt while it is waited
    for stops it, and one at any time that :meth:`interrupted` is told of. A program that catches the interrupt and goes
    on finds the queue empty, and running if it ran.
    """

    def __init__(self, port: str | None, *, timeout: float = 3.0) -> None:
        self.name = find(port)
        """Where the arm is."""
        self.closed = False
        """Whether the connection has been ended."""
        self.running = True
        """Whether the queue runs, as far as this connection has said so."""
        self.last = 0
        """The index of the command that this connection queued last, 0 before and after the queue was cleared."""
        self._stopped = False
        self._bench = _bench(self.name)
        self.instant = self._bench is not None and self._bench.speed == 0.0
        """Whether the arm is one that takes no time."""
        self._core: Core = remembered(wait(_connecting(self.name, self._bench, timeout)))
        self._core.detach()
        self._leaving = threading.Lock()
        _opened.add(self)

    def exchange(
        self, id: int, ctrl: int, params: bytes, *, allow: str = "", patient: bool = True
    ) -> tuple[int, bytes]:
        """Sends a frame; Ctrl and parameters of the one that answers it.

        A queued command that finds the queue full waits for room while the queue runs, unless it is not to be
        ``patient``. It is sent once; when its answer is lost, the arm's indices say whether it was taken. What can
        brick, unlearn or unlock something is sent if ``allow`` or ``MAGICIAN_ALLOW`` names it.
        """
        if self.closed:
            raise ClosedError("the connection is closed")
        allow = f"{allow},{os.environ.get('MAGICIAN_ALLOW', '')}"
        if self._stopped and self.running and ctrl & QUEUED == QUEUED:
            self._stopped = False
            self._wait(self._core.exchange(START, SET, b"", False, ""))
        answer = self._wait(self._core.exchange(id, ctrl, params, patient and self.running, allow))
        if id in (START, STOP, FORCE_STOP) and ctrl & SET:
            self.running = id == START
        if ctrl & QUEUED == QUEUED:
            self.last = int.from_bytes(answer[1][:8], "little")
        elif id == CLEAR and ctrl & SET:
            self.last = 0
        return answer

    def start_empty_queue(self) -> None:
        """Starts the queue if it is empty: nothing moves by that. What another program left in it stays."""
        self._wait(self._core.start_empty_queue())

    def finish(self, index: int, motion: bool = False) -> None:
        """Waits until a queued command has finished; of a motion, also whether it was refused."""
        self._wait(self._core.finished(index, motion))

    def _wait(self, call: Call[T]) -> T:
        try:
            return wait_done(call, self._core)
        except Error:
            raise
        except BaseException as interruption:
            # A motion that was waited for has been stopped. One that was only queued continues.
            if call.taken():
                self.stop(interruption)
            self._stopped = True
            raise

    def interrupted(self) -> None:
        """Somebody pressed Ctrl-C, whatever the program makes of it: has the arm stopped, and returns at once."""
        if not self.closed:
            self._stopped = True
            self._core.request_stop()

    def set_timeout(self, timeout: float) -> None:
        """How long (s) every call may take from now on."""
        self._core.set_timeout(timeout)

    def stop(self, because: BaseException) -> None:
        """Stops the arm and the laser at once and empties the queue; what is in doubt is noted on the exception."""
        if not self.closed:
            wait_stopped(self._core, because)

    def close(self) -> None:
        """Ends the connection."""
        with self._leaving:
            if not self.closed:
                self.closed = True
                if self._bench is not None:
                    self._bench.lock.release()
                wait(self._core.close())


class _Bench:
    """A place for a virtual arm: it stays switched on when a program disconnects, and is found again as it was left."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.cell = Cell(None, speed)
        self.lock = threading.Lock()


def _bench(port: str) -> _Bench | None:
    """The virtual arm at a port, held; ``None`` for ports of other kinds."""
    kind, _, speed = port.lower().partition(":")
    if kind != "sim":
        return None
    try:
        times = 0.0 if speed in ("", "max") else float(speed.removesuffix("x"))
    except ValueError:
        return None
    for bench in _benches:
        if bench.speed == times and bench.lock.acquire(blocking=False):
            return bench
    bench = _Bench(times)
    bench.lock.acquire()
    _benches.append(bench)
    return bench


def _connecting(port: str, bench: _Bench | None, timeout: float) -> Call[Core]:
    if bench is None:
        return Core.connect(port, timeout=timeout, window=1, probe=True, reconnect=True, echo=0.1)
    # A virtual arm answers at once; the rest is for a busy computer.
    return bench.cell.connect(timeout=max(timeout, 10.0), window=1, probe=True, reconnect=True, echo=0.1)

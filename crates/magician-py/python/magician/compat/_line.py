"""Connection of the stand-ins to an arm, and the choice of that arm."""

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

__all__ = ["Line", "find", "opened", "redirect_to"]

T = TypeVar("T")

GET, SET, QUEUED = 0, 1, 3
START, STOP, FORCE_STOP, CLEAR = 240, 241, 242, 245

_redirection: list[str] = []
_opened: weakref.WeakSet[Line] = weakref.WeakSet()
_slots: list[_VirtualArmSlot] = []


def redirect_to(port: str | None) -> None:
    """Redirects all later connections to this port, whatever port a program names. ``None`` ends that."""
    _redirection[:] = [port] if port else []


def redirected_port() -> str | None:
    """Returns the port to which all connections are redirected, or ``None``."""
    return _redirection[0] if _redirection else None


def opened() -> list[Line]:
    """Returns the open lines."""
    return [line for line in _opened if not line.closed]


@atexit.register
def _end() -> None:
    """Ends the connections at the end of a program. Later requests, as by destructors, are answered without the native
    part, which can no longer raise exceptions."""
    for line in opened():
        line.closed = True


def find(port: str | None) -> str:
    """Returns the port to connect to for the port that a program names.

    ``MAGICIAN_PORT_COM3=sim`` redirects a program that names ``COM3``. Without a name the port is ``MAGICIAN_PORT``,
    otherwise the first port with an arm's adapter.
    """
    if other := redirected_port():
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
    """Open connection. Every call ends with a reply or with an exception of :mod:`magician.errors`.

    At the end of the connection the arm is left as it is, as by these libraries. An interrupt during a wait stops it,
    and so does :meth:`interrupted` at any time. A program that catches the interrupt and continues finds the queue
    empty, and running if it ran.
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
        self._slot = _slot(self.name)
        self.instant = self._slot is not None and self._slot.speed == 0.0
        """Whether the arm is one that takes no time."""
        self._core: Core = remembered(wait(_connecting(self.name, self._slot, timeout)))
        self._core.detach()
        self._leaving = threading.Lock()
        _opened.add(self)

    def exchange(
        self, id: int, ctrl: int, params: bytes, *, allow: str = "", patient: bool = True
    ) -> tuple[int, bytes]:
        """Sends a frame. Returns Ctrl and parameters of its reply.

        If the queue is full, a queued command waits for room while the queue runs, unless ``patient`` is false. It is
        sent once; if its reply is lost, the indices of the arm show if it was accepted. Commands that can brick the
        arm, change its calibration or unlock something are sent only if ``allow`` or ``MAGICIAN_ALLOW`` names them.
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
        """Starts the queue if it is empty, which moves nothing. Commands left by another program stay in it."""
        self._wait(self._core.start_empty_queue())

    def finish(self, index: int, motion: bool = False) -> None:
        """Waits until a queued command has finished. With ``motion``, a refused motion is detected."""
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
        """Handles Ctrl-C independently of the program: requests a stop of the arm and returns at once."""
        if not self.closed:
            self._stopped = True
            self._core.request_stop()

    def set_timeout(self, timeout: float) -> None:
        """Sets the timeout of later calls, s."""
        self._core.set_timeout(timeout)

    def stop(self, because: BaseException) -> None:
        """Stops arm and laser immediately and clears the queue. If the stop is unconfirmed, adds a note to the
        exception."""
        if not self.closed:
            wait_stopped(self._core, because)

    def close(self) -> None:
        """Ends the connection."""
        with self._leaving:
            if not self.closed:
                self.closed = True
                if self._slot is not None:
                    self._slot.lock.release()
                wait(self._core.close())


class _VirtualArmSlot:
    """Slot of a virtual arm, which keeps its state when a program disconnects and connects again."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.cell = Cell(None, speed)
        self.lock = threading.Lock()


def _slot(port: str) -> _VirtualArmSlot | None:
    """Acquires the virtual arm at a port; ``None`` for other kinds of port."""
    kind, _, speed = port.lower().partition(":")
    if kind != "sim":
        return None
    try:
        times = 0.0 if speed in ("", "max") else float(speed.removesuffix("x"))
    except ValueError:
        return None
    for slot in _slots:
        if slot.speed == times and slot.lock.acquire(blocking=False):
            return slot
    slot = _VirtualArmSlot(times)
    slot.lock.acquire()
    _slots.append(slot)
    return slot


def _connecting(port: str, slot: _VirtualArmSlot | None, timeout: float) -> Call[Core]:
    if slot is None:
        return Core.connect(port, timeout=timeout, window=1, probe=True, reconnect=True, echo=0.1)
    # A virtual arm answers at once; the rest is for a busy computer.
    return slot.cell.connect(timeout=max(timeout, 10.0), window=1, probe=True, reconnect=True, echo=0.1)

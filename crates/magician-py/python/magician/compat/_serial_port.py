"""``serial.Serial`` for programs that speak the arm's protocol themselves.

Written bytes go to the arm frame by frame. Its replies can be read: the requested number of bytes, or those that have
arrived when the timeout expires.
"""

from __future__ import annotations

import threading
import time
from typing import Any

from ..errors import ClosedError, Error, InvalidInputError, PortError
from ._line import Line, redirected_port
from ._port import Port

__all__ = ["PortNotOpenError", "Serial", "SerialException", "SerialTimeoutException", "set_fallback"]

ARM_BAUD = 115200


class SerialException(OSError):
    """Replaces pyserial's exception if pyserial is not installed."""


class SerialTimeoutException(SerialException):
    """Replaces pyserial's exception if pyserial is not installed."""


class PortNotOpenError(SerialException):
    """Replaces pyserial's exception if pyserial is not installed."""


# pyserial's own port and exception, if it is installed.
_fallback: list[Any] = []


def set_fallback(port: Any, exception: Any) -> None:
    """Sets the class for ports at other baud rates than the arm's, and the exception for faults."""
    _fallback[:] = [port, exception]


def _fault(error: Error) -> Exception:
    kind: type[Exception] = _fallback[1] if _fallback else SerialException
    return kind(str(error))


class Serial:
    """Serial port with the interface of pyserial's.

    If all connections are redirected to one arm, it connects only when the first frame is written: a program may open
    it for a check, or to speak to another device at that baud rate.
    """

    def __new__(cls, port: str | None = None, baudrate: int = 9600, *rest: Any, **named: Any) -> Any:
        """Returns pyserial's port for any other baud rate than the arm's."""
        if _fallback and port is not None and baudrate != ARM_BAUD:
            return _fallback[0](port, baudrate, *rest, **named)
        return super().__new__(cls)

    def __init__(
        self,
        port: str | None = None,
        baudrate: int = 9600,
        bytesize: int = 8,
        parity: str = "N",
        stopbits: float = 1,
        timeout: float | None = None,
        xonxoff: bool = False,
        rtscts: bool = False,
        write_timeout: float | None = None,
        dsrdtr: bool = False,
        inter_byte_timeout: float | None = None,
        exclusive: bool | None = None,
        **_: object,
    ) -> None:
        self.port = self.name = self.portstr = port
        """What was named; the arm may be elsewhere."""
        self.baudrate, self.bytesize, self.parity, self.stopbits = baudrate, bytesize, parity, stopbits
        self.xonxoff, self.rtscts, self.dsrdtr, self.exclusive = xonxoff, rtscts, dsrdtr, exclusive
        self.timeout = timeout
        """How long (s) a read waits for all its bytes; ``None`` without end."""
        self.write_timeout, self.inter_byte_timeout = write_timeout, inter_byte_timeout
        self.dtr = self.rts = True
        self.cts = self.dsr = self.cd = True
        self.ri = False
        self.is_open = False
        """Whether it is open."""
        self._arm: Port | None = None
        self._writing = threading.Lock()
        self._came = threading.Condition()
        if port is not None:
            self.open()

    def open(self) -> None:
        """Opens the gripper."""
        self.name = self.portstr = self.port
        self.is_open = True
        if redirected_port() is None:
            self._port()

    def _port(self) -> Port:
        if not self.is_open:
            raise _fault(ClosedError("the port is not open"))
        if self._arm is None:
            try:
                self._arm = Port(Line(self.port))
            except Error as error:
                self.is_open = False
                raise _fault(error) from error
        return self._arm

    def isOpen(self) -> bool:
        """True if the port is open."""
        return self.is_open

    def close(self) -> None:
        """Closes the port. The arm finishes its queued commands."""
        self.is_open = False
        arm, self._arm = self._arm, None
        if arm is not None:
            arm.close()
        with self._came:
            self._came.notify_all()

    def write(self, data: Any) -> int:
        """Sends the frames in these bytes, each once it is complete, and stores the replies."""
        data = bytes(data)
        with self._writing:
            if not self.is_open:
                self._port()
            # The program talks to another device than an arm.
            if self._arm is not None or data[:1] == b"\xaa":
                try:
                    self._port().write(data)
                except (ClosedError, InvalidInputError, PortError) as error:
                    raise _fault(error) from error
                except Error:
                    # An arm does not reply to unknown frames, so a read will time out.
                    pass
        with self._came:
            self._came.notify_all()
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Reads this many bytes, or fewer if the timeout expires."""
        deadline = None if self.timeout is None else time.monotonic() + self.timeout
        with self._came:
            while self.is_open and self.in_waiting < size:
                left = None if deadline is None else deadline - time.monotonic()
                if left is not None and left <= 0:
                    break
                self._came.wait(left)
            if not self.is_open:
                self._port()
            return self._arm.read(size) if self._arm is not None else b""

    def readinto(self, buffer: Any) -> int:
        """Fills a buffer, or part of it if the timeout expires."""
        data = self.read(len(buffer))
        buffer[: len(data)] = data
        return len(data)

    def read_all(self) -> bytes:
        """Reads all available bytes."""
        return self._port().read_all() if self._arm is not None else b""

    def read_until(self, expected: bytes = b"\n", size: int | None = None) -> bytes:
        """Reads bytes up to a terminator, a number of bytes, or the timeout."""
        line = bytearray()
        while not line.endswith(expected) and (size is None or len(line) < size):
            byte = self.read(1)
            if not byte:
                break
            line += byte
        return bytes(line)

    def readline(self, size: int = -1) -> bytes:
        """Reads bytes up to the end of a line."""
        return self.read_until(size=None if size < 0 else size)

    @property
    def in_waiting(self) -> int:
        """Number of bytes that can be read."""
        return self._arm.in_waiting if self._arm is not None else 0

    def inWaiting(self) -> int:
        """Number of bytes that can be read."""
        return self.in_waiting

    out_waiting = 0
    """Bytes that are not sent: none."""

    def reset_input_buffer(self) -> None:
        """Discards unread replies."""
        if self._arm is not None:
            self._arm.reset_input_buffer()

    def reset_output_buffer(self) -> None:
        """Discards a partly written frame."""
        if self._arm is not None:
            self._arm.reset_output_buffer()

    flushInput, flushOutput = reset_input_buffer, reset_output_buffer

    def flush(self) -> None:
        """Does nothing: a frame is sent once it is complete."""

    def readable(self) -> bool:
        """Returns True."""
        return True

    writable = readable

    def setDTR(self, value: bool = True) -> None:
        """Stores the level of the line, which the arm ignores."""
        self.dtr = value

    def setRTS(self, value: bool = True) -> None:
        """Stores the level of the line, which the arm ignores."""
        self.rts = value

    def __enter__(self) -> Serial:
        if not self.is_open:
            self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

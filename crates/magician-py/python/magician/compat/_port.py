"""Serial port of a connected arm."""

from __future__ import annotations

from ._line import Line

__all__ = ["Port"]

CURRENT_INDEX = 246


class Port:
    """Serial port of a connected arm, with the members that programs use besides the library.

    Written frames are sent, and their replies can be read from it.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._written = bytearray()
        self._answers = bytearray()
        # A virtual arm that takes no time has done a command before it is asked. Programs wait until its index grows:
        # the first answer after a command is the index before.
        self._news = False
        self.port = self.name = line.name
        """The port's name."""
        self.baudrate = 115200
        """What it was told to be; not every way to an arm has one."""
        self.timeout: float | None = None
        """Not looked at: every answer comes by its deadline."""

    @property
    def is_open(self) -> bool:
        """True if the connection is open."""
        return not self._line.closed

    def isOpen(self) -> bool:
        """True if the connection is open."""
        return self.is_open

    @property
    def in_waiting(self) -> int:
        """Number of bytes that can be read."""
        return len(self._answers)

    def inWaiting(self) -> int:
        """Number of bytes that can be read."""
        return self.in_waiting

    def write(self, data: bytes | bytearray) -> int:
        """Sends the frames in these bytes, each once it is complete."""
        self._written += data
        while (start := self._written.find(b"\xaa\xaa")) >= 0 and len(self._written) > start + 2:
            end = start + 4 + self._written[start + 2]
            if len(self._written) < end:
                break
            frame = bytes(self._written[start:end])
            del self._written[:end]
            if len(frame) >= 6 and not sum(frame[3:]) & 0xFF:
                ctrl, params = self._line.exchange(frame[3], frame[4], frame[5:-1])
                if frame[4] & 2:
                    self._news = self._line.instant
                elif frame[3] == CURRENT_INDEX and self._news and any(params):
                    self._news = False
                    params = (int.from_bytes(params, "little") - 1).to_bytes(len(params), "little")
                body = bytes((frame[3], ctrl)) + params
                self._answers += b"\xaa\xaa" + bytes((len(body),)) + body + bytes((-sum(body) & 0xFF,))
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Reads this many bytes of replies, or as many as there are."""
        taken = bytes(self._answers[:size])
        del self._answers[:size]
        return taken

    def read_all(self) -> bytes:
        """Reads all bytes of replies."""
        return self.read(len(self._answers))

    def reset_input_buffer(self) -> None:
        """Discards unread replies."""
        self._answers.clear()

    flushInput = reset_input_buffer

    def reset_output_buffer(self) -> None:
        """Discards a partly written frame."""
        self._written.clear()

    flushOutput = reset_output_buffer

    def flush(self) -> None:
        """Does nothing: a frame is sent once it is complete."""

    def close(self) -> None:
        """Ends the connection."""
        self._line.close()

"""Frame of the protocol, as programs for pydobot build and read it."""

from __future__ import annotations

import builtins
from enum import Enum

__all__ = ["Message"]

HEADER = b"\xaa\xaa"


class Message:
    """Frame: ``id``, ``ctrl`` and ``params`` are its content; the rest is derived from them.

    ``id`` and ``ctrl`` may be numbers or members of the enums; ``params`` is anything that ``bytes`` accepts.
    """

    id: int | Enum

    def __init__(self, b: bytes | bytearray | None = None) -> None:
        self.header: bytes | bytearray = HEADER
        """The two bytes that a frame begins with."""
        self.len = 0
        """Bytes of id, Ctrl and parameters together."""
        self.ctrl: int | Enum = 0
        """Bit 0: set; bit 1: queued."""
        self.params: bytes | bytearray = b""
        """The parameters, little-endian."""
        self.checksum: int | None = None
        """Checksum: with it, the sum of all bytes after the length is 0 modulo 256."""
        if b is not None:
            self.header, self.len, self.id, self.ctrl = b[:2], b[2], b[3], b[4]
            self.params, self.checksum = b[5:-1], b[-1]

    @classmethod
    def answer(cls, id: int, ctrl: int, params: bytes) -> Message:
        """Creates the message of a frame received from an arm."""
        message = cls()
        message.id, message.ctrl, message.params = id, ctrl, params
        message.refresh()
        return message

    def refresh(self) -> None:
        """Converts enums to numbers, and updates length and checksum."""
        self.id, self.ctrl = _number(self.id), _number(self.ctrl)
        if self.checksum is None:
            self.len = 2 + len(self.params)
            self.checksum = -(self.id + self.ctrl + sum(self.params)) & 0xFF

    def bytes(self) -> builtins.bytes | bytearray:
        """Encodes the frame; a ``bytearray`` if it has parameters, as in pydobot."""
        self.refresh()
        assert self.checksum is not None
        head = bytearray((*HEADER, self.len, _number(self.id), _number(self.ctrl)))
        frame = head + bytearray(self.params) + bytearray((self.checksum,))
        return frame if self.params else builtins.bytes(frame)

    def __repr__(self) -> str:
        return "Message()"

    def __str__(self) -> str:
        self.refresh()
        params = bytearray(self.params).hex(" ")
        head = bytearray(self.header).hex(" ")
        return f"{head}:{self.len}:{self.id}:{self.ctrl}:{params}:{self.checksum}".upper()


def _number(value: int | Enum) -> int:
    return int(value.value) if isinstance(value, Enum) else int(value)

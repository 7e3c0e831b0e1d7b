"""Frames and other bytes on the line to an arm. :func:`decode` finds and decodes them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from . import _magician
from ._protocol import Command
from ._values import Value
from .errors import InvalidInputError

__all__ = ["Decoded", "Piece", "Rejected", "decode"]


class Decoded(Value):
    """A decoded frame."""

    offset: int
    """Offset in bytes in its direction of the link."""
    data: bytes
    """The whole frame."""
    id: int
    """Id of the command."""
    command: str
    """Vendor name of the command's form: ``"SetPTPCmd"``."""
    direction: Literal["request", "reply"]
    """Sender: the host or the arm."""
    write: bool
    """True for a set, False for a get."""
    queued: bool
    """True if the command is queued."""
    value: Command | None
    """Decoded content, a class of :mod:`magician.commands`; ``None`` if empty, or if :attr:`index` holds it."""
    index: int | None
    """Queue index in the reply to a queued command."""
    params: bytes
    """Raw parameters."""
    notes: tuple[str, ...]
    """Deviations of the frame from the vendor's document, in sentences."""
    link: str | None = None
    """Link of the trace: a port, a client."""
    time: float | None = None
    """Time in the trace, Unix seconds."""

    @property
    def ok(self) -> bool:
        """Always True: the frame was decoded."""
        return True

    def __str__(self) -> str:
        queued = " queued" if self.queued else ""
        carried = (
            f" {self.value}" if self.value is not None else f" index {self.index}" if self.index is not None else ""
        )
        return f"{self.direction} {self.command}{queued}{carried}"


class Rejected(Value):
    """Bytes that could not be decoded."""

    offset: int
    """Offset in bytes in their direction of the link."""
    data: bytes
    """The bytes."""
    error: Literal["checksum", "length", "truncated", "noise", "unknown", "trace"]
    """Kind of the fault: a checksum that does not fit; a length that no frame has, or that its command does not take;
    bytes that end inside a frame; bytes without a frame; a command that is not known; a trace file that is damaged
    here."""
    why: str
    """Description of the fault, with both values."""
    id: int | None = None
    """Id of the command, for a whole frame."""
    command: str | None = None
    """Vendor name of the command's form, for a whole frame."""
    link: str | None = None
    """Link of the trace: a port, a client."""
    time: float | None = None
    """Time in the trace, Unix seconds."""

    @property
    def ok(self) -> bool:
        """Always False: the bytes were not decoded."""
        return False

    def __str__(self) -> str:
        # Do not repeat the word if the sentence begins with it.
        kind = "" if self.why.startswith(f"{self.error} ") else f"{self.error}: "
        of = f"{self.command}: " if self.command is not None else ""
        return f"{kind}{of}{self.why} ({self.data.hex(' ')})"


Piece = Decoded | Rejected
"""A frame, or bytes without one."""


def decode(
    source: bytes | bytearray | memoryview | str | os.PathLike[str],
    *,
    sender: Literal["host", "arm"] | None = None,
) -> list[Piece]:
    """Decodes bytes of the protocol to frames, as ``magician decode`` does.

    >>> for piece in magician.decode("AA AA 02 0A 00 F6"):
    ...     print(piece)
    request GetPose

    :param source: Bytes; a text of hex digits, as people paste it (spaces, commas and ``0x`` are left out); or a file:
        a trace (pcapng, as ``magician proxy --trace`` writes it), bytes, or hex text. A text that is not hex is the
        file's name.
    :param sender: Sender of the bytes, unless a trace gives it; defaults to the side whose form fits, the host if both
        fit.
    :raises InvalidInputError: The hex text has an odd number of digits.
    :raises OSError: The file cannot be read.
    """
    if sender not in (None, "host", "arm"):
        raise InvalidInputError(f'sender is {sender!r}; it takes "host", "arm" or None')
    if isinstance(source, (bytes, bytearray, memoryview)):
        return _magician.pieces(bytes(source), False, sender)
    if isinstance(source, str):
        pasted = _magician.hex_bytes(source)
        if pasted is not None:
            return _magician.pieces(pasted, False, sender)
    elif not hasattr(source, "__fspath__"):
        raise TypeError(f"source is {source!r} ({type(source).__name__}); it takes bytes, hex text or a file")
    return _magician.pieces(Path(source).read_bytes(), True, sender)

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
    """A frame that was understood."""

    offset: int
    """Bytes before it in the same direction on the same link."""
    data: bytes
    """The whole frame."""
    id: int
    """Id of the command."""
    command: str
    """The form of the command, as the vendor calls it: ``"SetPTPCmd"``."""
    direction: Literal["request", "reply"]
    """True if the host sent it, or the arm."""
    write: bool
    """True if it sets something, or orders it."""
    queued: bool
    """True if it goes into the arm's queue."""
    value: Command | None
    """What it carries, as :mod:`magician.commands` has it; ``None`` for nothing, and where :attr:`index` says it."""
    index: int | None
    """The index that the arm gave a queued command, in the reply to it."""
    params: bytes
    """The parameters as they travel."""
    notes: tuple[str, ...]
    """Where the frame departs from the vendor's document, in sentences."""
    link: str | None = None
    """The link of a trace on which it passed: a port, a client."""
    time: float | None = None
    """When it passed, by a trace: seconds since 1970."""

    @property
    def ok(self) -> bool:
        """True: it was understood."""
        return True

    def __str__(self) -> str:
        queued = " queued" if self.queued else ""
        carried = (
            f" {self.value}" if self.value is not None else f" index {self.index}" if self.index is not None else ""
        )
        return f"{self.direction} {self.command}{queued}{carried}"


class Rejected(Value):
    """Bytes that were not understood."""

    offset: int
    """Bytes before them in the same direction on the same link."""
    data: bytes
    """The bytes."""
    error: Literal["checksum", "length", "truncated", "noise", "unknown", "trace"]
    """What is wrong: a checksum that does not fit; a length that no frame has, or that its command does not take;
    bytes that end inside a frame; bytes without a frame; a command that is not known; a trace file that is damaged
    here."""
    why: str
    """The same in a sentence, with both values."""
    id: int | None = None
    """Id of the command, of a whole frame."""
    command: str | None = None
    """Its form, as the vendor calls it, of a whole frame."""
    link: str | None = None
    """The link of a trace on which they passed: a port, a client."""
    time: float | None = None
    """When they passed, by a trace: seconds since 1970."""

    @property
    def ok(self) -> bool:
        """False: they were not understood."""
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
    """Decodes bytes of the protocol, piece by piece, as ``magician decode`` does.

    >>> for piece in magician.decode("AA AA 02 0A 00 F6"):
    ...     print(piece)
    request GetPose

    :param source: Bytes; a text of hex digits, as people paste it (spaces, commas and ``0x`` are left out); or a file:
        a trace (pcapng, as ``magician proxy --trace`` writes it), bytes, or hex text. A text that is not hex is the
        file's name.
    :param sender: Who sent the bytes, where a trace does not say; without it the side whose form fits, the host if
        both fit.
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

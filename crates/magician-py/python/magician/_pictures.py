"""Pictures as files and in notebooks, and the strokes of pen and laser."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import overload

from . import _magician
from ._arguments import number
from ._points import Floats, to_numpy, to_tuples
from ._values import Value
from .errors import InvalidInputError

__all__ = ["Drawing", "Picture", "Stroke"]

SCALE = 8.0
"""Pixels per mm: about 200 dpi."""


class Picture:
    """A picture. Notebooks display it."""

    __slots__ = ("_native",)

    def __init__(self, native: _magician.Picture) -> None:
        self._native = native

    @property
    def svg(self) -> str:
        """Returns SVG in true size."""
        return self._native.svg

    def png(self, scale: float = SCALE) -> bytes:
        """Returns PNG with ``scale`` pixels per mm, reduced if it would be too large."""
        return self._native.png(number("scale", scale, above=0, unit="pixels/mm"))

    def save(self, path: str | os.PathLike[str], *, scale: float = SCALE) -> Path:
        """Writes the picture to a ``.svg`` or ``.png`` file and returns the path.

        :raises InvalidInputError: The file has another extension.
        :raises OSError: The file cannot be written.
        """
        return _save(path, lambda: self.svg, lambda: self.png(scale))

    def _repr_svg_(self) -> str:
        return self.svg

    def __eq__(self, other: object) -> bool:
        return self._native == other._native if isinstance(other, Picture) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._native)

    def __repr__(self) -> str:
        return f"<Picture, {len(self.svg)} bytes of SVG>"


class Stroke(Value):
    """A continuous line of the pen or the laser; a single point is a dot."""

    burnt: bool
    """True if the laser made the stroke, False for the pen."""
    power: float
    """Laser power, above 0 to 100 percent; 100 for ink."""
    _data: bytes

    @property
    def points(self) -> list[tuple[float, ...]]:
        """Vertices x, y in the arm's base frame, mm."""
        return to_tuples(self._data, 2)

    def to_numpy(self) -> Floats:
        """Returns the vertices as an array of shape (n, 2), mm. Needs NumPy."""
        return to_numpy(self._data, 2)

    def __repr__(self) -> str:
        return f"<Stroke of {'the laser' if self.burnt else 'the pen'}, {len(self._data) // 16} points>"


class Drawing(Sequence[Stroke]):
    """Strokes of pen and laser, in order of creation. Notebooks display them."""

    __slots__ = ("_native",)

    def __init__(self, native: _magician.Ink) -> None:
        self._native = native

    def __len__(self) -> int:
        return len(self._native)

    @overload
    def __getitem__(self, at: int) -> Stroke: ...
    @overload
    def __getitem__(self, at: slice) -> list[Stroke]: ...
    def __getitem__(self, at: int | slice) -> Stroke | list[Stroke]:
        if isinstance(at, slice):
            return [self[each] for each in range(*at.indices(len(self)))]
        if not -len(self) <= at < len(self):
            raise IndexError("there is no such stroke")
        return Stroke(*self._native.stroke(at % len(self)))

    def __iter__(self) -> Iterator[Stroke]:
        for at in range(len(self)):
            yield Stroke(*self._native.stroke(at))

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Minimum and maximum x, y, mm; ``None`` if there are no strokes."""
        found = self._native.bounds()
        return None if found is None else ((found[0][0], found[0][1]), (found[1][0], found[1][1]))

    @property
    def svg(self) -> str:
        """Returns SVG in true size, seen from above: X to the right, Y up; the strokes with a margin."""
        return self._native.svg(False)

    def png(self, scale: float = SCALE, *, whole: bool = False) -> bytes:
        """Returns PNG with ``scale`` pixels per mm, reduced if it would be too large.

        :param whole: Whether the picture includes the arm's base.
        """
        return self._native.png(number("scale", scale, above=0, unit="pixels/mm"), whole)

    def save(self, path: str | os.PathLike[str], *, scale: float = SCALE, whole: bool = False) -> Path:
        """Writes the picture to a ``.svg`` or ``.png`` file and returns the path.

        :param whole: Whether the picture includes the arm's base.
        :raises InvalidInputError: The file has another extension.
        :raises OSError: The file cannot be written.
        """
        return _save(path, lambda: self._native.svg(whole), lambda: self.png(scale, whole=whole))

    def _repr_svg_(self) -> str:
        return self.svg

    def __eq__(self, other: object) -> bool:
        return self._native == other._native if isinstance(other, Drawing) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<Drawing of {len(self)} strokes>"


def _save(path: str | os.PathLike[str], svg: Callable[[], str], png: Callable[[], bytes]) -> Path:
    to = Path(path)
    end = to.suffix.lower()
    if end == ".svg":
        _magician.write_whole(to, svg().encode())
    elif end == ".png":
        _magician.write_whole(to, png())
    else:
        raise InvalidInputError(f"{to}: a picture must be a .svg or .png file")
    return to

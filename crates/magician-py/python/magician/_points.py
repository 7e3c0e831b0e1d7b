"""Numbers on their way into the native part and back: whole arrays at once, with or without NumPy."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any, Protocol

from .errors import InvalidInputError

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


class SupportsArray(Protocol):
    """What NumPy can make an array of, such as an array of its own."""

    def __array__(self) -> Any: ...


Points = Sequence[Sequence[float]] | SupportsArray
"""Points, one a row: x, y, z in mm and, in a fourth column, r in degrees. An array of shape (n, 3) or (n, 4), best of
``float64``, or rows of numbers."""


def rows(points: Points | Iterable[Sequence[float]]) -> tuple[bytes, int]:
    """The numbers of points as bytes, and how many there are in a row: 3 or 4."""
    data, shape = _numbers(points)
    if len(shape) != 2 or shape[1] not in (3, 4):
        raise InvalidInputError(
            f"points have the shape (n, 3) or (n, 4), x, y, z in mm and r in degrees; these have {shape}"
        )
    return data, shape[1]


def column(values: Sequence[float] | SupportsArray, count: int, what: str) -> bytes:
    """One number for each of ``count`` rows, as bytes."""
    data, shape = _numbers(values)
    if shape != (count,):
        raise InvalidInputError(f"{what} has the shape ({count},), one for each point; this has {shape}")
    return data


def _numbers(values: Any) -> tuple[bytes, tuple[int, ...]]:
    try:
        view = memoryview(values)
    except TypeError:
        view = None
    if view is not None and view.format in ("d", "=d", "@d"):
        return view.tobytes(), tuple(view.shape or ())
    if hasattr(values, "__array__"):
        import numpy

        made = numpy.asarray(values, dtype=numpy.float64)
        return made.tobytes(), tuple(made.shape)
    items: list[Any] = view.tolist() if view is not None else list(values)
    if not items:
        return b"", (0, 3)
    if isinstance(items[0], (int, float)):
        return array("d", items).tobytes(), (len(items),)
    lengths = set(map(len, items))
    if len(lengths) != 1:
        raise InvalidInputError(f"all points have as many numbers; these have {' or '.join(map(str, sorted(lengths)))}")
    return array("d", chain.from_iterable(items)).tobytes(), (len(items), lengths.pop())


def to_numpy(data: bytes, columns: int) -> NDArray[float64]:
    """Rows of so many numbers, as an array of its own."""
    try:
        import numpy
    except ModuleNotFoundError as error:
        error.msg = f"{error.msg}: an array needs NumPy, pip install numpy"
        raise

    return numpy.ndarray((len(data) // (8 * columns), columns), dtype=numpy.float64, buffer=bytearray(data))


def to_tuples(data: bytes, columns: int) -> list[tuple[float, ...]]:
    """Rows of so many numbers, without NumPy."""
    return list(struct.iter_unpack(f"={columns}d", data))

"""Conversion of arrays to and from the native part, with or without NumPy."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any, Protocol

from .errors import InvalidInputError

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray

    Floats = NDArray[float64]
else:
    # Lets type hints be evaluated without NumPy.
    Floats = Any


class SupportsArray(Protocol):
    """Object that NumPy can convert to an array."""

    def __array__(self) -> Any: ...


Points = Sequence[Sequence[float]] | SupportsArray
"""Points, one a row: x, y, z in mm and, in a fourth column, r in degrees. An array of shape (n, 3) or (n, 4), best of
``float64``, or rows of numbers."""


def rows(points: Points | Iterable[Sequence[float]]) -> tuple[bytes, int]:
    """Encodes points as bytes. Returns them with the row length, 3 or 4."""
    data, shape = _numbers(points, "points")
    if len(shape) != 2 or shape[1] not in (3, 4):
        raise InvalidInputError(
            f"points have the shape (n, 3) or (n, 4), x, y, z in mm and r in degrees; these have {shape}"
        )
    return data, shape[1]


def column(values: Sequence[float] | SupportsArray, count: int, what: str) -> bytes:
    """Encodes one number for each of ``count`` rows as bytes."""
    data, shape = _numbers(values, what)
    if shape != (count,):
        raise InvalidInputError(f"{what} has the shape ({count},), one for each point; this has {shape}")
    return data


def to_list(data: bytes) -> list[float]:
    """Decodes numbers of the native part."""
    values = array("d")
    values.frombytes(data)
    return values.tolist()


def table(values: Any, count: int, what: str) -> tuple[bytes, int]:
    """Encodes rows of four or five numbers as bytes. Returns them with the row length."""
    data, shape = _numbers(values, what)
    if len(shape) != 2 or shape[0] != count or shape[1] not in (4, 5):
        wanted = f"({count}, 4) or ({count}, 5)" if count > 1 else "4 or 5 numbers"
        raise InvalidInputError(f"{what} must be {wanted}, the fifth for the tool; the shape is {shape}")
    return data, shape[1]


def _numbers(values: Any, what: str) -> tuple[bytes, tuple[int, ...]]:
    if isinstance(values, (str, bytes, bytearray, Mapping)):
        raise TypeError(f"{what} are rows of numbers, not {values!r:.60}")
    _permit(values, what)
    try:
        view = memoryview(values)
    except (TypeError, ValueError, BufferError):
        view = None
    if view is not None and view.format in ("d", "=d", "@d"):
        return view.tobytes(), tuple(view.shape or ())
    if hasattr(values, "__array__"):
        import numpy

        made: Any = numpy.asarray(values)
        _permit(made, what)
        made = made.astype(numpy.float64)
        return made.tobytes(), tuple(made.shape)
    items: list[Any] = view.tolist() if view is not None else list(values)
    if not items:
        return b"", (0, 3)
    if not hasattr(items[0], "__len__"):
        return _array(items, what), (len(items),)
    lengths = {len(item) if hasattr(item, "__len__") else 1 for item in items}
    if len(lengths) != 1:
        raise InvalidInputError(f"all points have as many numbers; these have {' or '.join(map(str, sorted(lengths)))}")
    return _array(list(chain.from_iterable(items)), what, len(items[0])), (len(items), lengths.pop())


def _permit(values: Any, what: str) -> None:
    """Refuses arrays that would lose information: masked, complex, text, object and bool arrays."""
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if isinstance(kind, str) and kind not in "fiu":
        raise TypeError(f"{what} must be real numbers, not an array of {values.dtype}: convert it by astype(float)")
    mask: Any = getattr(values, "mask", None)
    if kind is not None and mask is not None and hasattr(mask, "nonzero") and mask.any():
        where = mask.nonzero()[0]
        row = f"row {where[0]} of them" if len(where) else "all of them"
        raise InvalidInputError(
            f"{what} are masked, {row} first: drop the rows, or lift the tool there with rows of NaN, filled(nan)"
        )


def _array(items: list[Any], what: str, columns: int = 1) -> bytes:
    try:
        return array("d", items).tobytes()
    except (TypeError, OverflowError) as error:
        for nth, item in enumerate(items):
            try:
                array("d", (item,))
            except (TypeError, OverflowError):
                message = f"{what}: row {nth // columns} has {item!r} ({type(item).__name__}): {error}"
                raise type(error)(message) if isinstance(error, TypeError) else InvalidInputError(message) from None
        raise


def to_numpy(data: bytes, columns: int) -> Floats:
    """Decodes rows of the given length to a new array."""
    try:
        import numpy
    except ModuleNotFoundError as error:
        error.msg = f"{error.msg}: an array needs NumPy, pip install numpy"
        raise

    return numpy.ndarray((len(data) // (8 * columns), columns), dtype=numpy.float64, buffer=bytearray(data))


def to_tuples(data: bytes, columns: int) -> list[tuple[float, ...]]:
    """Decodes rows of the given length, without NumPy."""
    return list(struct.iter_unpack(f"={columns}d", data))

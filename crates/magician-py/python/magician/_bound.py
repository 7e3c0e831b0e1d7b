"""Objects bound to a connection, and thus to one process."""

from __future__ import annotations

from typing import NoReturn

__all__ = ["Bound"]


class Bound:
    """Refuses copying and pickling."""

    __slots__ = ()

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"{type(self).__name__} is bound to its connection and to this process, and is neither copied nor pickled: "
            "connect anew where it is needed, and hand over the port, plans or readings"
        )

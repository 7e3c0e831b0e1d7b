"""Connection of dobotWrapperPy."""

from __future__ import annotations

from typing import Any

from .._line import Line

__all__ = ["DobotConnection"]


class DobotConnection:
    """Connection to the arm at a port, or at the serial port that a program has opened."""

    def __init__(self, port: str | None = None, serial_conn: Any = None) -> None:
        if port is None and serial_conn is None:
            raise TypeError("DobotConnection() takes a port or a serial connection")
        self.serial_conn = serial_conn
        """What was given."""
        self.line = Line(port or getattr(serial_conn, "port", None))
        """The connection."""

"""List of ports of dobotapi."""

from __future__ import annotations

from .._serial import comports
from .exceptions import NoComportsAvaliable

__all__ = ["get_coms_port"]


def get_coms_port() -> list[str]:
    """Returns the serial ports.

    :raises NoComportsAvaliable: There is no serial port.
    """
    if found := comports():
        return [each.device for each in found]
    raise NoComportsAvaliable

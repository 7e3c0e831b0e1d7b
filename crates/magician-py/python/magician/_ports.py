"""Where arms could be: the serial ports of this computer, and the networks around it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from . import _magician
from ._arguments import seconds
from ._magician import Call
from ._native import until, wait
from ._values import Value

__all__ = ["Found", "SerialPort", "discover", "discover_async", "ports"]


class SerialPort(Value):
    """A serial port of this computer, with the details of its USB device."""

    path: str
    """What to connect to: ``/dev/ttyUSB0``, ``COM3``."""
    vendor: int | None
    """Vendor id, if it is on USB."""
    product: int | None
    """Product id, if it is on USB."""
    name: str | None
    """Product text."""
    manufacturer: str | None
    """Manufacturer text."""
    serial_number: str | None
    """Serial number of the adapter, not of the arm."""
    location: str | None
    """The socket that it is plugged into, as the system names it: ``1-1.4`` on Linux."""
    likely_arm: bool
    """True if the adapter is one that Magicians have. Other devices have them too."""


class Found(Value):
    """An arm that answered on the network."""

    port: str
    """What to connect to: ``udp:192.168.1.5:8899``."""
    address: str
    """Where the answer came from: where the arm is reached."""
    reported: str
    """The address that its module says it has; another one behind a router."""
    mac: str
    """The module's hardware address, twelve hexadecimal digits."""
    name: str
    """What the module calls itself: ``USR-C322``."""
    version: str | None
    """Version of the module's firmware."""


def ports() -> list[SerialPort]:
    """The serial ports of this computer, likely arms first.

    Raises :class:`~magician.errors.PortError` when the system cannot list them.
    """
    return [SerialPort(*parts) for parts in _magician.ports()]


def discover(hosts: Iterable[str] = (), *, within: float = 1.0) -> list[Found]:
    """Searches the networks of this computer for arms on Wi-Fi: those that answer in ``within`` seconds.

    :param hosts: names or addresses to ask instead, which may be in other networks; then it ends when all have
        answered.

    It returns an empty list if none answers. Raises :class:`~magician.errors.InvalidInputError` for an invalid host,
    :class:`~magician.errors.PortError` when a host's name is not known or this computer has no network.
    """
    return [Found(*parts) for parts in wait(_asking(hosts, within))]


async def discover_async(hosts: Iterable[str] = (), *, within: float = 1.0) -> list[Found]:
    """As :func:`magician.discover`, for programs on asyncio."""
    return [Found(*parts) for parts in await until(_asking(hosts, within))]


def _asking(hosts: Iterable[str], within: float) -> Call[Any]:
    if isinstance(hosts, str):
        raise TypeError(f"hosts is {hosts!r}; it takes names in a list: [{hosts!r}]")
    return _magician.discover(list(hosts), seconds("within", within, most=60))

"""Discovery of arms: serial ports of this computer, and its networks."""

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
    """Port to connect to: ``/dev/ttyUSB0``, ``COM3``."""
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
    """USB location, as named by the system: ``1-1.4`` on Linux."""
    likely_arm: bool
    """True if the adapter model is used by Magicians. Other devices use it too."""


class Found(Value):
    """An arm that answered on the network."""

    port: str
    """Port to connect to: ``udp:192.168.1.5:8899``."""
    address: str
    """Address that the answer came from, at which the arm is reachable."""
    reported: str
    """Address reported by its Wi-Fi module; differs behind a router."""
    mac: str
    """MAC address of the module, twelve hexadecimal digits."""
    name: str
    """Name of the module: ``USR-C322``."""
    version: str | None
    """Version of the module's firmware."""


def ports() -> list[SerialPort]:
    """Lists the serial ports of this computer, likely arms first.

    Raises :class:`~magician.errors.PortError` when the system cannot list them.
    """
    return [SerialPort(*parts) for parts in _magician.ports()]


def discover(hosts: Iterable[str] = (), *, within: float = 1.0) -> list[Found]:
    """Searches the networks of this computer for arms on Wi-Fi, for ``within`` seconds.

    :param hosts: names or addresses to query instead, which may be in other networks; the search then ends when all
        have answered.

    Returns an empty list if no arm answers. Raises :class:`~magician.errors.InvalidInputError` for an invalid host,
    :class:`~magician.errors.PortError` when a host's name is not known or this computer has no network.
    """
    return [Found(*parts) for parts in wait(_discovery_call(hosts, within))]


async def discover_async(hosts: Iterable[str] = (), *, within: float = 1.0) -> list[Found]:
    """As :func:`magician.discover`, for programs on asyncio."""
    return [Found(*parts) for parts in await until(_discovery_call(hosts, within))]


def _discovery_call(hosts: Iterable[str], within: float) -> Call[Any]:
    if isinstance(hosts, str):
        raise TypeError(f"hosts is {hosts!r}; it takes names in a list: [{hosts!r}]")
    return _magician.discover(list(hosts), seconds("within", within, most=60))

"""Search for arms: ports with the USB adapter of an arm, or the port that ``magician.compat`` redirects to."""

from __future__ import annotations

from typing import NamedTuple

from ..._ports import ports
from .._line import redirected_port
from .._serial import comports

__all__ = [
    "KNOWN_DOBOT_USB_IDS",
    "DiscoveredDobot",
    "Discovery",
    "PortInfo",
    "ProbeFailure",
    "discover",
    "discover_with_diagnostics",
    "find_free_port",
    "is_dobot",
    "is_port_in_use",
    "list_ports",
]

KNOWN_DOBOT_USB_IDS = {(0x10C4, 0xEA60), (0x1A86, 0x7523), (0x0483, 0x5750)}


class PortInfo(NamedTuple):
    """Serial port."""

    device: str
    description: str
    vid: int | None = None
    pid: int | None = None


class DiscoveredDobot(NamedTuple):
    """Port with the USB adapter of an arm. Nothing is sent: the serial number is the adapter's."""

    port: str
    serial_number: str
    description: str


class ProbeFailure(NamedTuple):
    """Failed probe of a port. Never created, because this module probes no port."""

    port: str
    reason: str
    detail: str = ""


def list_ports(*, only_known_adapters: bool = False) -> list[PortInfo]:
    """Returns the serial ports."""
    found = [PortInfo(each.device, each.description, each.vid, each.pid) for each in comports()]
    return [each for each in found if not only_known_adapters or (each.vid, each.pid) in KNOWN_DOBOT_USB_IDS]


def discover(*, only_known_adapters: bool = False, timeout: float | None = None) -> list[DiscoveredDobot]:
    """Returns the ports at which an arm is likely."""
    if port := redirected_port():
        return [DiscoveredDobot(port, "", "by magician.compat")]
    return [
        DiscoveredDobot(each.path, each.serial_number or "", each.name or "") for each in ports() if each.likely_arm
    ]


def discover_with_diagnostics(
    *, only_known_adapters: bool = False, timeout: float | None = None
) -> tuple[list[DiscoveredDobot], list[ProbeFailure]]:
    """Same as :func:`discover`, with an empty list of failures."""
    return discover(), []


def find_free_port(*, only_known_adapters: bool = False) -> str | None:
    """Returns the first port at which an arm is likely; ``None`` if there is none."""
    return next((each.port for each in discover()), None)


def is_dobot(port: str, *, timeout: float | None = None) -> bool:
    """True if an arm is likely at a port."""
    return any(each.port == port for each in discover())


def is_port_in_use(port: str) -> bool:
    """Always false: not checked."""
    return False


class Discovery:
    """The functions of this module, as static methods."""

    list_ports = staticmethod(list_ports)
    is_dobot = staticmethod(is_dobot)
    discover = staticmethod(discover)
    discover_with_diagnostics = staticmethod(discover_with_diagnostics)
    find_free_port = staticmethod(find_free_port)
    is_port_in_use = staticmethod(is_port_in_use)

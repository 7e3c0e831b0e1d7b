"""Parts of pyserial that programs for these libraries use: the library's port, and the list of ports."""

from __future__ import annotations

import glob
import importlib
import re
import sys
import types
from collections.abc import Iterator
from typing import Any

from .._ports import SerialPort, ports
from . import _serial_port
from ._line import redirected_port

__all__ = ["PortInfo", "comports", "grep", "install"]

ADAPTER = "CP2102 USB to UART Bridge Controller (by magician.compat)"


class PortInfo:
    """Port in the list, with the attributes of pyserial."""

    def __init__(self, port: SerialPort) -> None:
        device, vid, pid = port.path, port.vendor, port.product
        self.device = device
        """What to open."""
        self.name = re.split(r"[/\\]", device)[-1]
        """The same without folders."""
        self.description = port.name or "n/a"
        """For people."""
        self.vid: int | None = vid
        """USB vendor id."""
        self.pid: int | None = pid
        """USB product id."""
        self.hwid = f"USB VID:PID={vid:04X}:{pid:04X}" if vid is not None and pid is not None else "n/a"
        """What programs look for ids in."""
        self.serial_number: str | None = port.serial_number
        """Serial number of the adapter."""
        self.location: str | None = port.location
        """The socket that it is plugged into."""
        self.manufacturer: str | None = port.manufacturer
        """Who made the adapter."""
        self.product: str | None = port.name
        """What the adapter calls itself."""
        self.interface: str | None = None
        """Not known."""

    def usb_description(self) -> str:
        """Returns the description."""
        return self.description

    def usb_info(self) -> str:
        """Returns the USB ids."""
        return self.hwid

    def __getitem__(self, index: int) -> str:
        return (self.device, self.description, self.hwid)[index]

    def __iter__(self) -> Iterator[str]:
        return iter((self.device, self.description, self.hwid))

    def __str__(self) -> str:
        return f"{self.device} - {self.description}"

    def __repr__(self) -> str:
        return f"<PortInfo {self.device}>"


class _AnyPort(str):
    """Name of the port to which all connections are redirected. It matches the usual parts of port names, by which
    programs choose theirs."""

    PARTS = re.compile(r"(/dev/)?(tty|cu)(\.|USB|ACM|AMA|S)?|COM|usb(serial|modem)?|/dev/?", re.IGNORECASE)

    def __contains__(self, part: str, /) -> bool:  # type: ignore[override]
        return super().__contains__(part) or self.PARTS.fullmatch(part) is not None

    def startswith(self, prefix: str | tuple[str, ...], *rest: Any) -> bool:
        """True if the name begins with one of these texts, or if they are usual parts of port names."""
        each = prefix if isinstance(prefix, tuple) else (prefix,)
        return super().startswith(prefix, *rest) or any(self.PARTS.fullmatch(part) for part in each)


class _Ports(list[Any]):
    """List of ports while all connections are redirected: it has the arm at every index that a program may use."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, int) and not -len(self) <= index < len(self):
            index = 0
        return super().__getitem__(index)


_real: list[Any] = []


def comports(include_links: bool = False) -> list[Any]:
    """Returns the serial ports of this computer. If all connections are redirected, that arm comes first."""
    port = redirected_port()
    found = list(_real[0](include_links)) if _real else [PortInfo(port) for port in ports()]
    if port and not port.startswith("/dev/"):
        # pyserial's own list uses glob(), and would find the arm through this one.
        found = [info for info in found if info.device != port]
    if port is None:
        return found
    first = [info for info in found if info.device == port]
    if not first:
        first = [PortInfo(SerialPort(port, 0x10C4, 0xEA60, ADAPTER, "Silicon Labs", None, None, True))]
        first[0].device = _AnyPort(port)
    return _Ports(first + [info for info in found if info.device != port])


def grep(regexp: str, include_links: bool = False) -> Iterator[Any]:
    """Returns the ports whose device, description or ids match."""
    pattern = re.compile(regexp, re.IGNORECASE)
    for info in comports(include_links):
        if any(pattern.search(text or "") for text in info):
            yield info


class _Glob:
    """``glob.glob`` that also finds the arm if a program searches for serial ports."""

    def __init__(self, real: Any) -> None:
        self.real = real

    def __call__(self, pathname: Any, *rest: Any, **named: Any) -> list[Any]:
        found = list(self.real(pathname, *rest, **named))
        port = redirected_port()
        return _Ports([port, *found]) if port and re.match(r"/dev/(tty|cu|serial)|COM", str(pathname)) else found


def install() -> None:
    """Replaces ``serial.tools.list_ports`` by the list here and, if all connections go to one arm, ``serial.Serial`` by
    that arm. The rest of pyserial, if it is installed, is unchanged."""
    if redirected_port():
        glob.glob = _Glob(glob.glob)
    try:
        serial: Any = importlib.import_module("serial")
        list_ports = importlib.import_module("serial.tools.list_ports")
    except ImportError:
        _stand_in()
        return
    if list_ports.__dict__["comports"] is not comports:
        _real[:] = [list_ports.__dict__["comports"]]
        list_ports.__dict__.update(comports=comports, grep=grep)
    if redirected_port():
        _serial_port.set_fallback(serial.Serial, serial.SerialException)
        serial.Serial = _serial_port.Serial


def _stand_in() -> None:
    serial = types.ModuleType("serial", "As much of pyserial as programs for an arm's libraries use.")
    util = types.ModuleType("serial.serialutil")
    tools = types.ModuleType("serial.tools")
    ports = types.ModuleType("serial.tools.list_ports")
    named: dict[str, object] = {
        each.__name__: each
        for each in (
            _serial_port.PortNotOpenError,
            _serial_port.Serial,
            _serial_port.SerialException,
            _serial_port.SerialTimeoutException,
        )
    }
    numbers = {"FIVEBITS": 5, "SIXBITS": 6, "SEVENBITS": 7, "EIGHTBITS": 8, "STOPBITS_ONE": 1, "STOPBITS_TWO": 2}
    named["SerialBase"] = _serial_port.Serial
    letters = {"PARITY_NONE": "N", "PARITY_EVEN": "E", "PARITY_ODD": "O"}
    serial.__dict__.update(named, **numbers, **letters, tools=tools, serialutil=util)
    util.__dict__.update(named)
    ports.__dict__.update(comports=comports, grep=grep)
    tools.__dict__["list_ports"] = ports
    serial.__dict__["__path__"] = tools.__dict__["__path__"] = []
    for module in (serial, util, tools, ports):
        sys.modules[module.__name__] = module

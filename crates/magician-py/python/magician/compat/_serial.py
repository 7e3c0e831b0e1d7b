"""What programs for these libraries ask of pyserial: the port in the library, and the list of ports."""

from __future__ import annotations

import importlib
import re
import sys
import types
from collections.abc import Iterator
from typing import Any

from .._ports import SerialPort, ports
from ._line import Line, elsewhere

__all__ = ["Port", "PortInfo", "comports", "grep", "install"]

ADAPTER = "CP2102 USB to UART Bridge Controller (by magician.compat)"


class Port:
    """The serial port of a connected arm, as far as programs look at it beside the library.

    Frames that are written to it are sent, and their answers can be read from it.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._written = bytearray()
        self._answers = bytearray()
        self.port = self.name = line.name
        """The port's name."""
        self.baudrate = 115200
        """What it was told to be; not every way to an arm has one."""
        self.timeout: float | None = None
        """Not looked at: every answer comes by its deadline."""

    @property
    def is_open(self) -> bool:
        """Whether the connection is open."""
        return not self._line.closed

    def isOpen(self) -> bool:
        """Whether the connection is open."""
        return self.is_open

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read."""
        return len(self._answers)

    def inWaiting(self) -> int:
        """Bytes that can be read."""
        return self.in_waiting

    def write(self, data: bytes | bytearray) -> int:
        """Sends the frames in these bytes, each when it is whole."""
        self._written += data
        while (start := self._written.find(b"\xaa\xaa")) >= 0 and len(self._written) > start + 2:
            end = start + 4 + self._written[start + 2]
            if len(self._written) < end:
                break
            frame = bytes(self._written[start:end])
            del self._written[:end]
            if len(frame) >= 6 and not sum(frame[3:]) & 0xFF:
                ctrl, params = self._line.exchange(frame[3], frame[4], frame[5:-1])
                body = bytes((frame[3], ctrl)) + params
                self._answers += b"\xaa\xaa" + bytes((len(body),)) + body + bytes((-sum(body) & 0xFF,))
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """So many bytes of answers, or as many as there are."""
        taken = bytes(self._answers[:size])
        del self._answers[:size]
        return taken

    def read_all(self) -> bytes:
        """All bytes of answers."""
        return self.read(len(self._answers))

    def reset_input_buffer(self) -> None:
        """Forgets answers that were not read."""
        self._answers.clear()

    flushInput = reset_input_buffer

    def reset_output_buffer(self) -> None:
        """Forgets a frame that was written in part."""
        self._written.clear()

    flushOutput = reset_output_buffer

    def flush(self) -> None:
        """Does nothing: a frame is sent when it is whole."""

    def close(self) -> None:
        """Ends the connection."""
        self._line.close()


class PortInfo:
    """A port in the list, with the attributes that pyserial gives one."""

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
        """The description."""
        return self.description

    def usb_info(self) -> str:
        """The ids."""
        return self.hwid

    def __getitem__(self, index: int) -> str:
        return (self.device, self.description, self.hwid)[index]

    def __iter__(self) -> Iterator[str]:
        return iter((self.device, self.description, self.hwid))

    def __str__(self) -> str:
        return f"{self.device} - {self.description}"

    def __repr__(self) -> str:
        return f"<PortInfo {self.device}>"


class _Ports(list[Any]):
    """The list when all connections go to one arm: it is there at every place where a program's author had theirs."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, int) and not -len(self) <= index < len(self):
            index = 0
        return super().__getitem__(index)


_real: list[Any] = []


def comports(include_links: bool = False) -> list[Any]:
    """The serial ports of this computer; the arm that all connections go to, if they do, comes first."""
    found = list(_real[0](include_links)) if _real else [PortInfo(port) for port in ports()]
    port = elsewhere()
    if port is None:
        return found
    first = [info for info in found if info.device == port]
    if not first:
        first = [PortInfo(SerialPort(port, 0x10C4, 0xEA60, ADAPTER, "Silicon Labs", None, None, True))]
    return _Ports(first + [info for info in found if info.device != port])


def grep(regexp: str, include_links: bool = False) -> Iterator[Any]:
    """The ports whose device, description or ids match."""
    pattern = re.compile(regexp, re.IGNORECASE)
    for info in comports(include_links):
        if any(pattern.search(text or "") for text in info):
            yield info


class SerialException(OSError):
    """Stands in for pyserial's where that is not installed."""


class SerialTimeoutException(SerialException):
    """Stands in for pyserial's where that is not installed."""


class Serial:
    """Stands in for pyserial's port where that is not installed."""

    def __init__(self, *_: object, **__: object) -> None:
        raise ImportError("this program opens a serial port itself, which needs pyserial: pip install pyserial")


def install() -> None:
    """Lets ``serial.tools.list_ports`` be the list here; the rest of pyserial stays what it is, if it is installed."""
    try:
        list_ports = importlib.import_module("serial.tools.list_ports")
    except ImportError:
        _stand_in()
        return
    if list_ports.__dict__["comports"] is not comports:
        _real[:] = [list_ports.__dict__["comports"]]
        list_ports.__dict__.update(comports=comports, grep=grep)


def _stand_in() -> None:
    serial = types.ModuleType("serial", "As much of pyserial as programs for an arm's libraries use.")
    util = types.ModuleType("serial.serialutil")
    tools = types.ModuleType("serial.tools")
    ports = types.ModuleType("serial.tools.list_ports")
    named: dict[str, object] = {each.__name__: each for each in (Serial, SerialException, SerialTimeoutException)}
    numbers = {"FIVEBITS": 5, "SIXBITS": 6, "SEVENBITS": 7, "EIGHTBITS": 8, "STOPBITS_ONE": 1, "STOPBITS_TWO": 2}
    letters = {"PARITY_NONE": "N", "PARITY_EVEN": "E", "PARITY_ODD": "O"}
    serial.__dict__.update(named, **numbers, **letters, tools=tools, serialutil=util)
    util.__dict__.update(named)
    ports.__dict__.update(comports=comports, grep=grep)
    tools.__dict__["list_ports"] = ports
    serial.__dict__["__path__"] = tools.__dict__["__path__"] = []
    for module in (serial, util, tools, ports):
        sys.modules[module.__name__] = module

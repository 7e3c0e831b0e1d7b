"""Replacement for the C library below ``DobotDllType``: each function sends a frame through this package.

The name of a function determines the command, and the types of its C arguments determine the bytes: by the protocol's
table, and by the prototypes of the module. Only the exceptions are listed here.
"""

from __future__ import annotations

import ctypes
import re
import sys
import threading
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

from ..._magician import command_id
from ..._ports import ports
from ...errors import (
    Error,
    InvalidInputError,
    PortError,
    QueueFullError,
    UnreachableError,
    UnsupportedError,
)
from .._line import GET, QUEUED, SET, Line, redirected_port

__all__ = ["Function", "LibraryApi"]

CURRENT_INDEX = "GetQueuedCmdCurrentIndex"
NO_ERROR, BUFFER_FULL, TIMEOUT, INVALID, NO_DEVICE = range(5)
NOT_FOUND, OCCUPIED = 1, 2
MAGICIAN = 2

# Functions with another name in the table.
COMMAND_NAMES = {
    "SetAutoLevelingCmd": "AutoLeveling",
    "GetAutoLevelingResult": "AutoLeveling",
    "SetCPRHoldEnable": "CpRHeadHoldEnable",
    "GetCPRHoldEnable": "CpRHeadHoldEnable",
    "SetInfraredSensor": "IrSwitch",
    "GetInfraredSensor": "IrSwitch",
    "UpdateFirmware": "FirmwareSwitch",
    "GetUART4PeripheralsType": "Uart4PeripheralsModel",
    "SetUART4PeripheralsEnable": "Uart4PeripheralsEnabled",
    "GetUART4PeripheralsEnable": "Uart4PeripheralsEnabled",
    "SendPluse": "PulseMode",
    "SendPluseEx": "PulseMode",
}
# Functions that obey `isQueued`. All other queueable ones are always queued.
ASKING = {
    "SetJOGCmd",
    "SetJOGLParams",
    "SetJOGCommonParams",
    "SetDeviceWithL",
    "SetColorSensor",
    "SetInfraredSensor",
    "SendPluse",
}
# Functions that read the pin's address from the memory for their result.
PINS = {"GetIOMultiplexing", "GetIODO", "GetIOPWM", "GetIODI", "GetIOADC"}
# Types that ctypes does not name: of byref(), of all pointers, and of all simple values.
_REFERENCE: Any = type(ctypes.byref(ctypes.c_int()))
_POINTER: Any = ctypes.POINTER(ctypes.c_int).__mro__[1]
_SINGLE: Any = ctypes.c_int.__mro__[1]
# Only the low byte of a C enum is sent.
ENUM = ctypes.c_int32


class LibraryApi:
    """``api`` object of a ``DobotDllType`` module: holds its arms and executes its functions."""

    def __init__(self, module: ModuleType) -> None:
        self._prototypes: dict[str, tuple[Any, ...]] = module.__dict__["_PROTOTYPES"]
        self._ids: int = module.__dict__["_IDS"]
        self._arms: dict[int, Line] = {}
        # Arms released by DisconnectDobot, each with the index of its last command.
        self._released: dict[int, int] = {}
        self._queued: dict[int, int] = {}
        self._lock = threading.Lock()
        self._timeout = 3.0
        self._allowed: list[str] = []
        self._last = threading.local()
        self._logged: set[str] = set()
        self._logged_late: set[tuple[str, int]] = set()
        self._when = "DisconnectDobot"

    def dobot_call(self, name: str, arguments: Sequence[Any]) -> int:
        """Executes the C function of this name with these arguments, and returns its code."""
        self._last.message = ""
        own: Callable[..., int] | None = getattr(self, f"_call_{name}", None)
        try:
            if own is not None:
                return own(*arguments)
            line = self._arm(arguments)
            if not isinstance(line, int) and line.closed:
                # Called from a destructor while the program ends.
                self._when = "the end of the program"
                self._call_DisconnectDobot(self._id(arguments))
                line = self._arm(arguments)
            if isinstance(line, int):
                late = self._id(arguments) in self._released and (name == CURRENT_INDEX or not name.startswith("Get"))
                return self._call_after_end(name, arguments) if late else line
            types = self._prototypes[name][self._ids :]
            self._command(name, line, list(zip(types, arguments[self._ids :], strict=False)))
            if types and _is_index(types[-1]) and name.startswith("Set") and arguments[-1].value:
                self._queued[self._id(arguments)] = int(arguments[-1].value)
        except Error as error:
            self._last.message = str(error)
            return _code(error)
        return NO_ERROR

    def dobot_last_error(self) -> str:
        """Returns the reason why the last call of this thread did not return 0."""
        message: str = getattr(self._last, "message", "")
        return message

    # Commands.

    def _command(self, name: str, line: Line, given: list[tuple[Any, Any]]) -> None:
        id = command_id(COMMAND_NAMES.get(name, name))
        if id is None:
            self._report_success(name, given)
        elif name.startswith("Get"):
            self._get(name, id, line, given)
        else:
            self._set(name, id, line, given)

    def _report_success(self, name: str, given: list[tuple[Any, Any]]) -> None:
        """Reports success for a function that this arm does not have."""
        if name not in self._logged:
            self._logged.add(name)
            print(f"magician: {name}: this arm does not support it; nothing was done", file=sys.stderr)
        for place in _output_arguments(given):
            ctypes.memset(ctypes.addressof(place), 0, ctypes.sizeof(place))

    def _get(self, name: str, id: int, line: Line, given: list[tuple[Any, Any]]) -> None:
        query = b""
        if name in PINS:
            query = bytes(given[0][1])[:1]
        elif name == "GetPTPTime":
            query, given = bytes(given[0][1]), given[1:]
        elif name == "GetInfraredSensor":
            query, given = _bytes(*given[0]), given[1:]
        _, params = line.exchange(id, GET, query)
        places = _output_arguments(given)
        if name == "GetAlarmsState":
            bits, length = places
            most = int(given[-1][1])
            ctypes.memmove(bits, params, min(len(params), most, ctypes.sizeof(bits)))
            length.value = len(params)
        elif hasattr(places[0], "raw"):
            text, size = places[0], int(given[-1][1])
            text.value = params.split(b"\0")[0][: min(size, ctypes.sizeof(text)) - 1]
        else:
            _fill(places, params)

    def _set(self, name: str, id: int, line: Line, given: list[tuple[Any, Any]]) -> None:
        ctrl, index = SET, None
        if len(given) > 1 and _is_index(given[-1][0]):
            asked, index = given[-2][1], given[-1][1]
            given = given[:-2]
            ctrl = QUEUED if name not in ASKING or int(asked) & 0xFF else SET
        if name == "SetLostStepParams":
            ctrl = SET
        elif name == "UpdateFirmware":
            # Sent like in the vendor's library: a read that carries the mode.
            ctrl = GET
        elif name in ("SetPTPPOCmd", "SetPTPPOWithLCmd"):
            move, outputs, count = (value for _, value in given)
            body = bytes(outputs)[: 4 * int(count)]
            given = [(None, bytes(move) + body)]
        elif name == "SetCircleCmd" and not given[0][1].count:
            given[0][1].count = 1
        # The module itself waits for room.
        body, allow = b"".join(_bytes(*each) for each in given), ",".join(self._allowed)
        _, params = line.exchange(id, ctrl, body, allow=allow, patient=False)
        if ctrl == QUEUED and index is not None:
            index.value = int.from_bytes(params[:8], "little")

    def _call_after_end(self, name: str, arguments: Sequence[Any]) -> int:
        """Handles a call after DisconnectDobot or after the end of the program, as by a destructor: it does nothing and
        succeeds, like a call that these interrupt. Queued commands count as done, so that loops which wait for them
        end. Other reads are refused as without a connection, because they have no value to return."""
        id = self._id(arguments)
        if (name, id) not in self._logged_late:
            self._logged_late.add((name, id))
            print(f"magician: {name} after {self._when}: nothing was done", file=sys.stderr)
        for place in map(_unwrapped, self._prototypes[name][self._ids :], arguments[self._ids :]):
            if _is_output(place):
                ctypes.memset(ctypes.addressof(place), 0, ctypes.sizeof(place))
        if name == CURRENT_INDEX:
            arguments[-1].value = self._released[id]
        return NO_ERROR

    # Arms.

    def _id(self, arguments: Sequence[Any]) -> int:
        """Returns the id of the arm: the first argument of a call, if the family has ids."""
        return int(getattr(arguments[0], "value", arguments[0])) if self._ids else 0

    def _arm(self, arguments: Sequence[Any]) -> Line | int:
        """Returns the arm of a call, or the result code if there is none."""
        line = self._arms.get(self._id(arguments))
        if line is None:
            self._last.message = "there is no connection: ConnectDobot makes one"
            return NO_DEVICE if self._ids == 2 else TIMEOUT
        return line

    def _connect(self, port: Any, baud: Any) -> tuple[int, Line] | int:
        name = bytes(getattr(port, "value", port) or b"").decode("utf-8", "replace").strip()
        try:
            line = Line(_target(name), timeout=self._timeout)
        except Error as error:
            self._last.message = str(error)
            print(f"magician: ConnectDobot: {error}", file=sys.stderr)
            return NOT_FOUND if isinstance(error, PortError) and not name else OCCUPIED
        try:
            # Programs expect a running queue, as on an arm where another program had started it.
            line.start_empty_queue()
        except Error as error:
            print(f"magician: ConnectDobot: the queue was not started: {error}", file=sys.stderr)
        with self._lock:
            id = next(id for id in range(len(self._arms) + 1) if id not in self._arms)
            self._arms[id] = line
            self._released.pop(id, None)
            self._queued.pop(id, None)
        return id, line

    def _call_SearchDobot(self, found: Any, size: int) -> int:
        port = redirected_port()
        # Programs of courses search for this name before they connect.
        named = port if port is None or re.match(r"COM|/dev/", port) else "COM1"
        paths = [named] if named else [found.path for found in ports() if found.likely_arm]
        names = [path.removeprefix("/dev/") for path in paths]
        while names and len(" ".join(names)) >= int(size):
            names.pop()
        if found is not None and int(size) > 0:
            found.value = " ".join(names).encode()
        return len(names)

    def _call_ConnectDobot(self, port: Any, baud: int, *places: Any) -> int:
        if self._ids == 0:
            self._call_DisconnectDobot()
        connected = self._connect(port, baud)
        if isinstance(connected, int):
            if self._ids == 1:
                places[-1].value = -1
            return connected
        id, line = connected
        if self._ids == 2:
            self._describe(places[0].masterDevInfo, id, line)
            return NO_ERROR
        wifi = line.name.lower().startswith("udp:")
        places[0].value, places[1].value = b"DobotWifi" if wifi else b"DobotSerial", b"0.0.0"
        if self._ids == 1:
            places[2].value = id
        return NO_ERROR

    @staticmethod
    def _describe(info: Any, id: int, line: Line) -> None:
        version = line.exchange(2, GET, b"")[1]
        milliseconds = int.from_bytes(line.exchange(4, GET, b"")[1][:4], "little")
        info.devId, info.type, info.runTime = id, MAGICIAN, milliseconds / 1000
        info.firmwareName, info.firwareVersion = b"Dobot", ".".join(map(str, version[:3])).encode()

    def _call_DisconnectDobot(self, id: Any = 0) -> int:
        id = int(getattr(id, "value", id))
        with self._lock:
            line = self._arms.pop(id, None)
            if line is not None:
                self._released[id] = self._queued.pop(id, 0)
        if line is not None:
            line.close()
        return NO_ERROR

    def _call_SetCmdTimeout(self, *given: Any) -> int:
        self._timeout = int(given[-1]) / 1000
        if self._ids:
            line = self._arms.get(int(getattr(given[0], "value", given[0])))
            lines = [line] if line else []
        else:
            lines = list(self._arms.values())
        for line in lines:
            line.set_timeout(self._timeout)
        return NO_ERROR

    def _call_DobotExec(self) -> int:
        return NO_ERROR

    def _call_PeriodicTask(self) -> int:
        return NO_ERROR

    def _call_SetDebugEnable(self, _on: Any) -> int:
        return NO_ERROR

    def _call_DobotSleep(self, milliseconds: int) -> int:
        threading.Event().wait(int(milliseconds) / 1000)
        return NO_ERROR

    def _call_MagicianAllow(self, names: bytes) -> int:
        given = [name.strip() for name in names.decode("utf-8", "replace").split(",")]
        if unknown := [name for name in given if name != "all" and command_id(COMMAND_NAMES.get(name, name)) is None]:
            self._last.message = f"unknown command {', '.join(unknown)}"
            return INVALID
        self._allowed += [COMMAND_NAMES.get(name, name) for name in given]
        return NO_ERROR

    def __getattr__(self, name: str) -> Function:
        if name.startswith("_") or name not in self._prototypes:
            raise AttributeError(f"the library has no function {name}")
        self.__dict__[name] = function = Function(self, name)
        return function

    __getitem__ = __getattr__

    @property
    def _FuncPtr(self) -> type[Function]:
        """Type of its functions, as ctypes libraries have it."""
        return Function

    def called(self, name: str, arguments: Sequence[Any]) -> int:
        """Executes a C function that a program calls directly."""
        kinds = self._prototypes[name]
        ids = len(arguments) - (len(kinds) - self._ids)
        if 0 <= ids < self._ids and name != "ConnectDobot":
            # A program for an older library, with one arm and no ids.
            arguments = (*arguments[:ids], *[0] * (self._ids - ids), *arguments[ids:])
        return self.dobot_call(name, [_unwrapped(*each) for each in zip(kinds, arguments, strict=False)])


class Function:
    """Function of the C library, for programs that call it directly. Attributes that they set on it are ignored."""

    argtypes: Any = None
    restype: Any = ctypes.c_int
    errcheck: Any = None

    def __init__(self, door: LibraryApi, name: str) -> None:
        self._api, self.__name__ = door, name

    def __call__(self, *arguments: Any) -> int:
        return self._api.called(self.__name__, arguments)


def _unwrapped(kind: Any, value: Any) -> Any:
    """Unwraps an argument for C: the object behind a reference, the number in a value."""
    if isinstance(value, _REFERENCE):
        return value._obj
    if isinstance(value, _POINTER):
        return value.contents
    if isinstance(value, ctypes.c_char_p):
        return value.value
    if isinstance(value, str):
        return value.encode()
    single = isinstance(kind, type) and issubclass(kind, _SINGLE)
    return value.value if single and isinstance(value, _SINGLE) else value


def _target(name: str) -> str | None:
    """Resolves a port name of ``SearchDobot`` or of a program."""
    if not name:
        return None
    parts = name.split(".")
    dotted = len(parts) == 4 and all(part.isdigit() and int(part) < 256 for part in parts)
    return f"udp:{name}" if dotted else name


def _code(error: Error) -> int:
    if isinstance(error, QueueFullError):
        return BUFFER_FULL
    return INVALID if isinstance(error, (InvalidInputError, UnreachableError, UnsupportedError)) else TIMEOUT


def _is_index(kind: Any) -> bool:
    return bool(kind is not None and getattr(kind, "_type_", None) is ctypes.c_uint64 and hasattr(kind, "contents"))


def _bytes(kind: Any, value: Any) -> bytes:
    """Encodes an argument for the wire."""
    if kind is ctypes.c_char_p:
        return bytes(value) + b"\0"
    if kind is ENUM:
        return bytes((int(value) & 0xFF,))
    if kind is None or _is_output(value):
        return bytes(value)
    return bytes(kind(value))


def _output_arguments(given: list[tuple[Any, Any]]) -> list[Any]:
    """Returns the arguments that receive a reply."""
    return [value for _, value in given if _is_output(value)]


def _is_output(value: Any) -> bool:
    """True for a value of ctypes."""
    return isinstance(value, (_SINGLE, ctypes.Structure, ctypes.Union, ctypes.Array))


def _fill(places: list[Any], params: bytes) -> None:
    """Writes a reply into the output arguments in order. Missing bytes are 0."""
    at = 0
    for place in places:
        size = 1 if isinstance(place, ENUM) else ctypes.sizeof(place)
        part = params[at : at + size]
        ctypes.memset(ctypes.addressof(place), 0, ctypes.sizeof(place))
        ctypes.memmove(ctypes.addressof(place), part, len(part))
        at += size

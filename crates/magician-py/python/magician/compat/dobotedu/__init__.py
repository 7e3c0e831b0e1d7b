"""Stand-in for DobotEDU and for the scripts of DobotLab.

The calls are those of the table in ``_lab``. They go to the arm directly, without DobotLink and DobotLab. The port, the
first argument, may be omitted, as after ``set_portname``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from ...errors import UnsupportedError
from .. import _lab
from .._line import Line, redirected_port
from .._serial import comports

__all__ = [
    "DobotEDU",
    "MagicianApi",
    "beta_go",
    "dobotEdu",
    "dobot_edu",
    "dobot_magician",
    "go",
    "m_lite",
    "magicbox",
    "magician",
]

_lines: dict[str | None, Line] = {}
_connect_lock = threading.Lock()
# Parameters of calls in addition to those of the table.
_COMMON = {"is_queued", "is_wait", "is_wait_for_finish", "iswait_forfinish", "time_out", "timeout", "port_name"}


def _line(port: str | None) -> Line:
    """Returns the connection to a port; the first call opens it."""
    with _connect_lock:
        line = _lines.get(port)
        if line is None or line.closed:
            line = _lines[port] = Line(port)
            line.start_empty_queue()
        return line


class _Method:
    """Method for a call of the table, under one of its names."""

    def __init__(self, arm: MagicianApi, call: _lab.Call, edu: bool) -> None:
        self._arm, self._call, self._edu = arm, call, edu
        self.__name__, *parameters = (call.edu if edu else call.lab).split()
        self._parameters = [parameter.partition("=")[::2] for parameter in parameters]

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        given, port = list(arguments), named.pop("port_name", None)
        if given and isinstance(given[0], str) and not _is_pin(given[0]):
            port = given.pop(0)
        values: list[Any] = []
        rest = given
        for name, default in self._parameters:
            other = [each for each in _names_of(self._call, len(values)) if each in named]
            if rest:
                value = rest.pop(0)
            elif other:
                value = named.pop(other[0])
            elif default:
                value = int(default)
            else:
                raise TypeError(f"{self.__name__}() needs {name}")
            if name in ("io", "port") and not self._call.sensor:
                value = _lab.io(value)
            elif name == "port":
                # DobotEDU and DobotLab use the numbers printed on the arm.
                value = int(value) - 1
            values.append(0 if value is None else value)
        if unknown := set(named) - _COMMON:
            raise TypeError(f"{self.__name__}() does not take {', '.join(sorted(unknown))}")
        queued = rest.pop(0) if rest else named.get("is_queued", not self._edu)
        waits = [named[name] for name in named if "wait" in name] + rest[:1]
        result = _lab.exchange(self._arm.connection(port), self._call, values, queued=bool(queued), wait=all(waits))
        if self._call.edu == "get_pose":
            rounded = {key: round(value, 2) for key, value in result.items() if key != "jointAngle"}
            result = _lab.Record(rounded, jointAngle=[round(value, 2) for value in result["jointAngle"]])
        return result


def _is_pin(text: str) -> bool:
    return text[:3].upper() in ("DO_", "DI_", "AD_", "AI_", "PWM", "EIO")


def _names_of(call: _lab.Call, at: int) -> list[str]:
    """Returns the names of a parameter in both libraries."""
    found = [names.split()[1:] for names in (call.lab, call.edu) if names]
    return [each[at].partition("=")[0] for each in found if at < len(each)]


class MagicianApi:
    """Arm: ``dobot_edu.magician``, ``m_lite``, and the ``magician`` of DobotLab's scripts."""

    Stepper1, Stepper2 = 0, 1
    JOG, PTP, CP, ARC = 0, 1, 2, 3

    def __init__(self, port: str | None = None) -> None:
        self._port_name = port

    def connection(self, port: str | None) -> Line:
        """Returns the connection to a port, by default to the one named last."""
        return _line(None if redirected_port() else port or self._port_name)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        for edu in (True, False):
            for call in _lab.CALLS:
                if (call.edu if edu else call.lab).partition(" ")[0] == name:
                    return _Method(self, call, edu)
        raise AttributeError(f"the arm of DobotEDU has no call {name}")

    def __setattr__(self, name: str, value: Any) -> None:
        # Rates can be set by a call or by an assignment.
        if name in ("motion_params", "jump_params"):
            getattr(self, name)(*value)
        else:
            super().__setattr__(name, value)

    def search_dobot(self) -> list[dict[str, str]]:
        """Returns the ports at which an arm may be, and to which of them this program is connected."""
        first = comports()[:1] if redirected_port() else comports()
        connected = {line.name for line in [*_lines.values()] if not line.closed}
        return [
            {
                "portName": port.device,
                "status": "connected" if port.device in connected else "unconnected",
                "description": port.description,
            }
            for port in first
        ]

    def connect_dobot(self, port_name: str | None = None, queue_start: bool = True, is_queued: bool = False) -> bool:
        """Connects. Optional, since the first call connects as well."""
        self.connection(port_name)
        return True

    def disconnect_dobot(
        self, port_name: str | None = None, queue_stop: bool = True, queue_clear: bool = True, is_queued: bool = False
    ) -> bool:
        """Ends the connection."""
        line = _lines.pop(None if redirected_port() else port_name or self._port_name, None)
        if line is not None:
            line.close()
        return True

    def queuedcmd_stop(self, port_name: str | None = None, force_stop: bool = False, is_queued: bool = False) -> bool:
        """Stops the queue; with ``force_stop`` also the motion."""
        self.connection(port_name).exchange(242 if force_stop else 241, 1, b"")
        return True

    def set_portname(self, port_name: str | None) -> None:
        """Sets the port for calls that name none."""
        self._port_name = port_name

    def set_linearrail_home(self, *_: Any, **__: Any) -> bool:
        """Does nothing: there is no such command."""
        return False


class _NotAnArm:
    """Device of DobotEDU other than the arm."""

    def __init__(self, name: str) -> None:
        self._name = name

    def set_portname(self, _: str | None) -> None:
        """Does nothing."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise UnsupportedError(f"{self._name}.{name}: no device of this kind; only the Magician arm is there")


class DobotEDU:
    """Main object of the package: its arms, and the name of the port."""

    def __init__(self, account: str | None = None, password: str | None = None) -> None:
        self.magician = self.m_lite = MagicianApi()
        self.magicbox = self.magician
        self.beta_go = self.magiciango = _NotAnArm("magiciango")
        self.face = self.ocr = self.nlp = self.speech = self.robot = self.util = self.tmt = _NotAnArm("dobot_edu")
        self.pyimageom = self.face

    def set_portname(self, port_name: str | None) -> None:
        """Sets the port for calls that name none."""
        self.magician.set_portname(port_name)

    def set_pause(self, _: Any) -> None:
        """Does nothing: there is no pause button."""


dobot_edu = dobotEdu = DobotEDU()
magician = dobot_magician = dobot_edu.magician
m_lite, magicbox = dobot_edu.m_lite, dobot_edu.magicbox
go, beta_go = dobot_edu.magiciango, dobot_edu.beta_go

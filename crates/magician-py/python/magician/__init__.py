"""Drive a Dobot Magician desktop arm, or a virtual one.

::

    import magician

    with magician.Arm("sim") as arm:  # or "/dev/ttyUSB0", "COM3", "udp:192.168.1.5"
        arm.home()
        arm.move_to(220, 60, 20)
        x, y, z, r = arm.pose()

* :class:`Arm` is a connected arm; :class:`magician.aio.Arm` the same for asyncio.
* :mod:`magician.words` builds commands for programs; :mod:`magician.commands` has every command of the protocol.
* :mod:`magician.places` keeps poses by name, and has work planes and pallets; :mod:`magician.calibrate` finds sheet,
  surface and the tool's tip from touched points.
* :func:`load` makes a :class:`Plan` from a file, :func:`write` from text, :meth:`Plan.path` from an array of points;
  ``arm.run(plan)`` runs it. :func:`frame` goes round what a file would mark, :func:`testgrid` burns a test grid.
* :func:`forward`, :func:`inverse`, :func:`is_reachable` and :func:`reach` compute without an arm, whole arrays too.
* :class:`VirtualArm` is an arm in a world of its own, for tests: :mod:`magician.testing`; :mod:`magician.simulation`
  steps many of them, for learning.
* :func:`sim` serves a virtual arm to other programs, :func:`proxy` shares an arm between them.
* :class:`Station` is a session at ``magician serve``: one arm, many programs.
* :func:`doctor` finds out what is wrong with an arm and its line, and what to do.
* :func:`conform` runs the conformance suite on an arm.
* :func:`decode` decodes the bytes of a line and reads traces; :func:`replay` replays a trace on a virtual arm.
* :mod:`magician.errors` has the exceptions, :mod:`magician.events` the events.

Lengths are mm, angles degrees, times seconds. The driver logs to the logger ``magician``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import alarms, commands, errors, events, pins, places, readings, words
from ._blocking import Arm, Check, Events, Job, Jog, Lesson, Motion, Recording, Run, StateWatch, record
from ._native import __version__
from ._pictures import Drawing, Picture, Stroke
from ._ports import Found, SerialPort, discover, ports
from .alarms import Alarm
from .commands import Output, Port, Pose
from .errors import Error
from .kinematics import forward, inverse, is_reachable, reach
from .pins import Pin
from .places import Belt, Frame, Pallet, Point, Poses
from .programs import Complaint, Plan, Rehearsal, Report, Sheet, Step, Surface, frame, load, testgrid, write
from .readings import Color, Info, Joints, Link, Position, Progress, Ran, Stats, Status
from .running import PlanProgress, RunResult

if TYPE_CHECKING:
    from . import aio, calibrate, conformance, diagnosis, replaying, serving, station, traffic
    from .conformance import conform
    from .diagnosis import Diagnosis, Finding, doctor
    from .replaying import Replay, replay
    from .serving import Served, proxy, sim
    from .station import Station
    from .traffic import decode
    from .virtual import Place, VirtualArm, WorldObject

__all__ = [
    "Alarm",
    "Arm",
    "Belt",
    "Check",
    "Color",
    "Complaint",
    "Diagnosis",
    "Drawing",
    "Error",
    "Events",
    "Finding",
    "Found",
    "Frame",
    "Info",
    "Job",
    "Jog",
    "Joints",
    "Lesson",
    "Link",
    "Motion",
    "Output",
    "Pallet",
    "Picture",
    "Pin",
    "Place",
    "Plan",
    "PlanProgress",
    "Point",
    "Port",
    "Pose",
    "Poses",
    "Position",
    "Progress",
    "Ran",
    "Recording",
    "Rehearsal",
    "Replay",
    "Report",
    "Run",
    "RunResult",
    "SerialPort",
    "Served",
    "Sheet",
    "StateWatch",
    "Station",
    "Stats",
    "Status",
    "Step",
    "Stroke",
    "Surface",
    "VirtualArm",
    "WorldObject",
    "__version__",
    "aio",
    "alarms",
    "calibrate",
    "commands",
    "conform",
    "conformance",
    "decode",
    "diagnosis",
    "discover",
    "doctor",
    "errors",
    "events",
    "forward",
    "frame",
    "inverse",
    "is_reachable",
    "load",
    "pins",
    "places",
    "ports",
    "proxy",
    "reach",
    "readings",
    "record",
    "replay",
    "replaying",
    "serving",
    "sim",
    "station",
    "testgrid",
    "traffic",
    "words",
    "write",
]


# Imported on first use, because many programs need none of it; `aio` would import asyncio.
_LATER = {
    "aio": "aio",
    "calibrate": "calibrate",
    "Place": "virtual",
    "VirtualArm": "virtual",
    "WorldObject": "virtual",
    "decode": "traffic",
    "traffic": "traffic",
    "conform": "conformance",
    "conformance": "conformance",
    "Replay": "replaying",
    "replay": "replaying",
    "replaying": "replaying",
    "Diagnosis": "diagnosis",
    "Finding": "diagnosis",
    "diagnosis": "diagnosis",
    "doctor": "diagnosis",
    "Served": "serving",
    "proxy": "serving",
    "serving": "serving",
    "sim": "serving",
    "Station": "station",
    "station": "station",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    module = importlib.import_module(f"{__name__}.{_LATER[name]}")
    found = globals()[name] = module if name == _LATER[name] else getattr(module, name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

"""Drive a Dobot Magician desktop arm, or a virtual one."""

from __future__ import annotations

from . import aio, errors
from ._blocking import Arm
from ._pictures import Drawing, Picture, Stroke
from .programs import Complaint, Plan, Rehearsal, Report, Sheet, Step, Surface, load
from .running import Progress, RunResult
from .virtual import VirtualArm, WorldObject

__all__ = [
    "Arm",
    "Complaint",
    "Drawing",
    "Picture",
    "Plan",
    "Progress",
    "Rehearsal",
    "Report",
    "RunResult",
    "Sheet",
    "Step",
    "Stroke",
    "Surface",
    "VirtualArm",
    "WorldObject",
    "aio",
    "errors",
    "load",
]

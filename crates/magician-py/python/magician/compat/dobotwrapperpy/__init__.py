"""Stand-in for dobotWrapperPy."""

from ..pydobot import Dobot
from . import dobotapi, dobotasync, dobotConnection, enums, paramsStructures
from .dobotapi import DobotApi
from .dobotasync import DobotAsync
from .dobotConnection import DobotConnection

# `Dobot` has the interface of version 1.1, which is pydobot's.
__all__ = [
    "Dobot",
    "DobotApi",
    "DobotAsync",
    "DobotConnection",
    "dobotConnection",
    "dobotapi",
    "dobotasync",
    "enums",
    "paramsStructures",
]

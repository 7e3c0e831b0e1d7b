"""Drive a Dobot Magician desktop arm, or a virtual one."""

from __future__ import annotations

from . import aio, errors
from ._blocking import Arm

__all__ = ["Arm", "aio", "errors"]

"""Stand-in for pydobot2. Programs import it as ``pydobot``."""

from . import dobot, message
from .dobot import Dobot

__all__ = ["Dobot", "dobot", "message"]

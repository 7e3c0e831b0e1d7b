"""Stand-in for pydobot 1.3."""

from . import dobot, enums, message
from .dobot import Dobot

__all__ = ["Dobot", "dobot", "enums", "message"]

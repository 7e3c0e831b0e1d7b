"""pydobot 1.3 for programs that were written for it."""

from . import dobot, enums, message
from .dobot import Dobot

__all__ = ["Dobot", "dobot", "enums", "message"]

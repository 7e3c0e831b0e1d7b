"""pydobot2 for programs that were written for it. They say ``import pydobot``."""

from . import dobot, message
from .dobot import Dobot

__all__ = ["Dobot", "dobot", "message"]

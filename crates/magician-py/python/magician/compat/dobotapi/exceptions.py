"""Exceptions of dobotapi."""

from .._pydobot2 import DobotException

__all__ = ["DobotException", "NoComportsAvaliable"]


class NoComportsAvaliable(Exception):
    """There is no serial port."""

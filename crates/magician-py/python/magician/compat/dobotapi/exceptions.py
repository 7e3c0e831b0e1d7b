"""Exceptions of dobotapi."""

from .._newer import DobotException

__all__ = ["DobotException", "NoComportsAvaliable"]


class NoComportsAvaliable(Exception):
    """There is no serial port."""

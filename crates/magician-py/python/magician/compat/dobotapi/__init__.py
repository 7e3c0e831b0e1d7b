"""Stand-in for dobotapi: the released package, with the additions of its newest source."""

from . import conveyor_belt, dobot, dobot_interfaces, dobot_message, effectors, exceptions, utils
from .dobot import Dobot

__all__ = [
    "Dobot",
    "conveyor_belt",
    "dobot",
    "dobot_interfaces",
    "dobot_message",
    "effectors",
    "exceptions",
    "run_shell",
    "utils",
]


def run_shell() -> None:
    """Raises :exc:`NotImplementedError`: there is no shell."""
    raise NotImplementedError("there is no shell of dobotapi here; `magician` is a command with one verb for each call")

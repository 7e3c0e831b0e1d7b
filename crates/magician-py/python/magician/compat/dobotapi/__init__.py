"""dobotapi for programs that were written for it: the released package, and what its newest source has beside it."""

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
    """Not here."""
    raise NotImplementedError("there is no shell of dobotapi here; `magician` is a command with one verb for each call")

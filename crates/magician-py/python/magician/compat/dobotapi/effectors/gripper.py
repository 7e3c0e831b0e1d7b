"""dobotapi's gripper."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..dobot import Dobot

__all__ = ["Gripper"]


class Gripper:
    """The gripper of an arm."""

    def __init__(self, bot: Dobot) -> None:
        self.bot = bot

    def open(self) -> None:
        """Opens it."""
        self.bot.tool(63, True, False)

    def close(self) -> None:
        """Closes it."""
        self.bot.tool(63, True, True)

    def idle(self) -> None:
        """Switches its pump off."""
        self.bot.tool(63, False, False)

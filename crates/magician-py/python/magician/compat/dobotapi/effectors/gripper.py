"""Gripper of dobotapi."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..dobot import Dobot

__all__ = ["Gripper"]


class Gripper:
    """Gripper of an arm."""

    def __init__(self, bot: Dobot) -> None:
        self.bot = bot

    def open(self) -> None:
        """Opens the gripper."""
        self.bot.tool(63, True, False)

    def close(self) -> None:
        """Closes the gripper."""
        self.bot.tool(63, True, True)

    def idle(self) -> None:
        """Switches the pump off."""
        self.bot.tool(63, False, False)

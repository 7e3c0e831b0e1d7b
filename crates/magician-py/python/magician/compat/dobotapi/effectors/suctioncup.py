"""Suction cup of dobotapi."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..dobot import Dobot

__all__ = ["SuctionCup"]


class SuctionCup:
    """Suction cup of an arm."""

    def __init__(self, bot: Dobot) -> None:
        self.bot = bot

    def suck(self) -> None:
        """Switches the suction cup on."""
        self.bot.tool(62, True, True)

    def idle(self) -> None:
        """Switches the suction cup off."""
        self.bot.tool(62, True, False)

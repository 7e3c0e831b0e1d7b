"""Belt of dobotapi."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from ..._line import QUEUED
from ..._pydobot2 import MM_PER_CIRCLE, STEP_PER_CIRCLE
from ..exceptions import DobotException

if TYPE_CHECKING:
    from ..dobot import Dobot

__all__ = ["ConveyorBelt"]


class ConveyorBelt:
    """Conveyor belt at an arm."""

    def __init__(self, bot: Dobot) -> None:
        self.bot = bot
        self.current_speed = 0.0
        """The share that it was set to."""

    def move(self, speed: float, interface: int = 0) -> None:
        """Runs the belt at a share (-1 to 1) of 70 mm/s. As in dobotapi, both signs give the same direction."""
        if not -1.0 <= speed <= 1.0:
            raise DobotException(f"the belt's speed is -1.0 to 1.0, not {speed}")
        self.current_speed = abs(speed)
        steps = int(-70 * abs(speed) * STEP_PER_CIRCLE / MM_PER_CIRCLE)
        self.bot.exchange(135, QUEUED, struct.pack("<BBi", interface == 1, 1, steps))

    def idle(self) -> None:
        """Stops the belt."""
        self.move(0)

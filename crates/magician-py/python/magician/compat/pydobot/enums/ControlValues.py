"""Values of a frame's Ctrl byte."""

from enum import Enum

__all__ = ["ControlValues"]


class ControlValues(Enum):
    """Bit 0: set; bit 1: queued."""

    ZERO = 0
    ONE = 1
    TWO = 2
    THREE = 3
    FOUR = 4
    FIVE = 5
    SIX = 6
    SEVEN = 7
    EIGHT = 8
    NINE = 9

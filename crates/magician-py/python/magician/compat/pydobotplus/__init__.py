"""Stand-in for pydobotplus."""

from . import dobotplus, message
from .dobotplus import CustomPosition, Dobot

__all__ = ["CustomPosition", "Dobot", "dobotplus", "message"]

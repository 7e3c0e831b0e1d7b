"""pydobotplus for programs that were written for it."""

from . import dobotplus, message
from .dobotplus import CustomPosition, Dobot

__all__ = ["CustomPosition", "Dobot", "dobotplus", "message"]

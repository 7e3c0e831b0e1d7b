"""What a pin does."""

from .._enums import IOFunction

__all__ = ["IOFunction"]

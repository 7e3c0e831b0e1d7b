"""Function of a pin."""

from .._enums import IOFunction

__all__ = ["IOFunction"]

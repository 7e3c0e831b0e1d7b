"""Module in which pydobot 1.3 has its frames."""

from .._message import Message

__all__ = ["Message"]

"""Module in which pydobot2 has its frames."""

from .._message import Message

__all__ = ["Message"]

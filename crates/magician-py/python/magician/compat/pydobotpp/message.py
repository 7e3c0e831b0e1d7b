"""Module in which pydobotpp has its frames."""

from .._message import Message

__all__ = ["Message"]

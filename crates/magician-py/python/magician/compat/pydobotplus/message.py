"""Module in which pydobotplus has its frames."""

from .._message import Message

__all__ = ["Message"]

"""Module in which dobotapi has its frames."""

from .._message import Message

__all__ = ["Message"]

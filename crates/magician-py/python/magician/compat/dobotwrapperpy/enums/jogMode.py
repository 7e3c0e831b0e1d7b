"""What jogging moves along."""

from .._enums import JogMode

__all__ = ["JogMode"]

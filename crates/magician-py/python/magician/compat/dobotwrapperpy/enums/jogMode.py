"""Coordinates of a jog: Cartesian axes or joints."""

from .._enums import JogMode

__all__ = ["JogMode"]

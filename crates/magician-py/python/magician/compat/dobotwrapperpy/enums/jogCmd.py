"""Axis and direction of a jog."""

from .._enums import JogCmd

__all__ = ["JogCmd"]

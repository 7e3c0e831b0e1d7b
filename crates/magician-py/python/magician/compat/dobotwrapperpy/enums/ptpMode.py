"""Kinds of point-to-point moves."""

from .._enums import PTPMode

__all__ = ["PTPMode"]

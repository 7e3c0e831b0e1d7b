"""Meaning of a path's coordinates: absolute or relative."""

from .._enums import CPMode

__all__ = ["CPMode"]

"""A pin's level."""

from .._enums import Level

__all__ = ["Level"]

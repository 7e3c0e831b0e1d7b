"""What a path's coordinates are."""

from .._enums import CPMode

__all__ = ["CPMode"]

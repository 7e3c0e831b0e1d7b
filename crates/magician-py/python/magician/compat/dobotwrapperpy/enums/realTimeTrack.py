"""Planning mode of a path."""

from .._enums import RealTimeTrack

__all__ = ["RealTimeTrack"]

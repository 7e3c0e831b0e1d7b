"""How a path is planned."""

from .._enums import RealTimeTrack

__all__ = ["RealTimeTrack"]

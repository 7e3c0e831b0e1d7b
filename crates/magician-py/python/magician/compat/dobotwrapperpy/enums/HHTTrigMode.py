"""Event at which a point taught by hand is reported."""

from .._enums import HHTTrigMode

__all__ = ["HHTTrigMode"]

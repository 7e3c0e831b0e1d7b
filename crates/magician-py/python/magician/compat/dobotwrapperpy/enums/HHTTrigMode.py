"""When teaching by hand reports a point."""

from .._enums import HHTTrigMode

__all__ = ["HHTTrigMode"]

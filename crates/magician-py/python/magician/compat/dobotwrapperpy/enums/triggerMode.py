"""Input kind of a trigger: level or analogue value."""

from .._enums import TriggerMode

__all__ = ["TriggerMode"]

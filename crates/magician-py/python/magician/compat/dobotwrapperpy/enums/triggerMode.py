"""What a trigger looks at."""

from .._enums import TriggerMode

__all__ = ["TriggerMode"]

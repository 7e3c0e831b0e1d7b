"""What a trigger waits for."""

from .._enums import TriggerCondition

__all__ = ["TriggerCondition"]

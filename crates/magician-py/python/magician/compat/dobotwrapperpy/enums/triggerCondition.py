"""Condition of a trigger."""

from .._enums import TriggerCondition

__all__ = ["TriggerCondition"]

"""The alarms."""

from ..._alarm import Alarm

__all__ = ["Alarm"]

"""The sensor's version."""

from .._enums import TagVersionColorSensorAndIR

__all__ = ["TagVersionColorSensorAndIR"]

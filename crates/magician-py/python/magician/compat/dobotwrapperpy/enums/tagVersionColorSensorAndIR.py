"""Version of the sensor."""

from .._enums import TagVersionColorSensorAndIR

__all__ = ["TagVersionColorSensorAndIR"]

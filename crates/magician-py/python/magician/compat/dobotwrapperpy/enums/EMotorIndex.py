"""Sockets of the motors."""

from .._enums import EMotorIndex

__all__ = ["EMotorIndex"]

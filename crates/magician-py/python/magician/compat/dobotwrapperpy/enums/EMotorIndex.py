"""The motors' sockets."""

from .._enums import EMotorIndex

__all__ = ["EMotorIndex"]

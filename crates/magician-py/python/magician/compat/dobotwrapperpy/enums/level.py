"""Level of a pin."""

from .._enums import Level

__all__ = ["Level"]

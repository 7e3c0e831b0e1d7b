"""The rail's version."""

from .._enums import tagVersionRail

__all__ = ["tagVersionRail"]

"""Version of the rail."""

from .._enums import tagVersionRail

__all__ = ["tagVersionRail"]

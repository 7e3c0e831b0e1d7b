"""``DobotDllType`` without the C library, a module for every family of it."""

from __future__ import annotations

__all__ = ["FAMILIES"]

FAMILIES = ("v1", "v2", "v3")

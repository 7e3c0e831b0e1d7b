"""What a virtual arm is switched on with."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from . import words
from ._arguments import numbers

__all__ = ["scenario_text", "tool_bias"]


def tool_bias(tool: words.Tool | Sequence[float] | None) -> tuple[float, float, float] | None:
    """Where the tip of a tool is from the wrist, mm."""
    if tool is None:
        return None
    if isinstance(tool, str):
        told = words.tool(tool)
        return told.x_bias, told.y_bias, told.z_bias
    x, y, z = numbers("tool", tool, 3)
    return x, y, z


def scenario_text(scenario: str | os.PathLike[str] | None) -> str | None:
    """The text of a scenario, which may be a file's name."""
    if scenario is None:
        return None
    if isinstance(scenario, str) and ("\n" in scenario or "=" in scenario):
        return scenario
    return Path(scenario).read_text(encoding="utf-8")

"""Common arguments of virtual arms."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, cast

from . import words
from ._arguments import number, numbers
from .errors import InvalidInputError

__all__ = ["clock_speed", "scenario_file", "scenario_text", "tool_bias"]


def clock_speed(speed: float | Literal["max"]) -> float:
    """Converts a speed to the factor of real time; 0 for ``"max"``."""
    if isinstance(speed, str) and speed != "max":
        raise InvalidInputError(f'speed is {speed!r}; it takes a number above 0 (1 is real time) or "max"')
    return 0.0 if speed == "max" else number("speed", speed, above=0)


def tool_bias(tool: words.Tool | Sequence[float] | None) -> tuple[float, float, float] | None:
    """Returns the offset of a tool's tip from the wrist, mm."""
    if tool is None:
        return None
    if isinstance(tool, str):
        told = words.tool(tool)
        return told.x_bias, told.y_bias, told.z_bias
    x, y, z = numbers("tool", tool, 3)
    return x, y, z


def scenario_file(scenario: str | os.PathLike[str] | None) -> str | None:
    """Returns the path of a scenario file; ``None`` for a text."""
    if scenario is None or (isinstance(scenario, str) and ("\n" in scenario or "=" in scenario)):
        return None
    return os.fspath(scenario)


def scenario_text(scenario: str | os.PathLike[str] | None) -> str | None:
    """Returns the text of a scenario, read from a file if a path is given."""
    file = scenario_file(scenario)
    if file is None:
        return cast("str | None", scenario)
    return Path(file).read_text(encoding="utf-8")

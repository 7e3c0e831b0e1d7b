"""What a program says about the library that it was written for."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

__all__ = ["which_dobotdll", "which_pydobot"]

# What only one of the libraries that are imported as `pydobot` has.
NEWER = {
    "Alarm", "DobotException", "MODE_PTP", "clear_alarms", "conveyor_belt", "conveyor_belt_distance", "engrave",
    "get_alarms", "get_pose", "go_arc", "jog_r", "jog_x", "jog_y", "jog_z", "laze", "set_home", "set_io",
    "wait_for_cmd",
}  # fmt: skip
OLDER = {"ControlValues", "CommunicationProtocolIDs", "PTPMode", "get_eio", "pose", "set_eio", "verbose"}
PLUS = {"CustomPosition", "dobotplus", "get_color", "get_ir", "move_rel", "set_color", "set_ir"}


def names(source: str) -> set[str]:
    """What a program imports, and the names after a dot and of keywords."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return set()
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, ast.keyword) and node.arg:
            found.add(node.arg)
        elif isinstance(node, ast.ImportFrom):
            found |= {*(node.module or "").split("."), *(each.name for each in node.names)}
        elif isinstance(node, ast.Import):
            found |= {part for each in node.names for part in each.name.split(".")}
    return found


def which_pydobot(*sources: str) -> str:
    """Which library ``import pydobot`` means in a program of these modules: the one that is installed, else the one
    whose names are used."""
    used = {name for source in sources for name in names(source)}
    if "dobotplus" in used:
        return "pydobotplus"
    for other in ("pydobot2", "pydobot"):
        if _installed(other):
            return other
    if used & PLUS and not used & OLDER:
        return "pydobotplus"
    return "pydobot2" if used & NEWER and not used & OLDER else "pydobot"


def _installed(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def which_dobotdll(sources: Iterable[str], folder: Path, wrappers: Iterable[Path] = ()) -> str:
    """Which family of ``DobotDllType`` a program of these modules means: that of the file that it imports, or that lies
    beside it, else of its calls."""
    for file in (*wrappers, folder / "DobotDllType.py", *folder.glob("*/DobotDllType.py")):
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        if "masterId" in text:
            return "v3"
        return "v2" if "dobotId" in text else "v1"
    return "v2" if any(map(_has_ids, sources)) else "v3"


def _has_ids(source: str) -> bool:
    """Whether moves have a number more than their own."""
    try:
        calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    except (SyntaxError, ValueError):
        return False
    named = [call for call in calls if isinstance(call.func, ast.Attribute) and call.func.attr == "SetPTPCmd"]
    return any(len(call.args) + len(call.keywords) > 7 for call in named)

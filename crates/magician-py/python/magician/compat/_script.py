"""Detection of the library that a program was written for."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

__all__ = ["expects_magician", "needs_copy", "which_dobotdll", "which_pydobot"]

# Names that identify one of the libraries imported as `pydobot`, wherever a program uses them.
NEWER = {
    "Alarm", "DobotException", "Joints", "MODE_PTP", "Position", "clear_alarms", "conveyor_belt",
    "conveyor_belt_distance", "engrave", "get_alarms", "get_pose", "go_arc", "jog_r", "jog_x", "jog_y", "jog_z", "laze",
    "set_home", "wait_for_cmd",
}  # fmt: skip
OLDER = {"ControlValues", "CommunicationProtocolIDs", "PTPMode", "get_eio", "set_eio"}
PLUS = {"CustomPosition", "dobotplus", "get_color", "get_ir", "move_rel", "set_color", "set_ir"}
# Common names: they count only as attributes of an arm.
OLDER_OF_ARMS = {"pose", "ser", "verbose", "wait"}
NEWER_OF_ARMS = {"_ser", "_extract_cmd_index", "home", "set_io"}
LIBRARIES = ("pydobot", "pydobotplus", "pydobot2", "dobotplus")
ARM = "Dobot"


class UsedNames(NamedTuple):
    """Names used in a program."""

    imported: set[str]
    anywhere: set[str]
    of_arms: set[str]


def names(*sources: str) -> UsedNames:
    """Collects a program's imports from these libraries, its attributes, and those of variables that hold an arm."""
    seen, arms = UsedNames(set(), set(), set()), {"super()"}
    trees = [tree for tree in map(_tree, sources) if tree is not None]
    for node in (node for tree in trees for node in ast.walk(tree)):
        if isinstance(node, ast.ImportFrom):
            parts = (node.module or "").split(".")
            if not node.level and parts[0] in LIBRARIES:
                seen.imported.update(parts, (each.name for each in node.names))
        elif isinstance(node, ast.Import):
            for each in node.names:
                if (parts := each.name.split("."))[0] in LIBRARIES:
                    seen.imported.update(parts)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None and _makes_arm(node.value):
            arms.update(map(_name, node.targets if isinstance(node, ast.Assign) else [node.target]))
        elif isinstance(node, ast.NamedExpr) and _makes_arm(node.value):
            arms.add(_name(node.target))
        elif isinstance(node, ast.Call) and _makes_arm(node):
            seen.of_arms.update(each.arg for each in node.keywords if each.arg)
        elif isinstance(node, ast.ClassDef) and any(_name(base) == ARM for base in node.bases):
            arms.add("self")
    for node in (node for tree in trees for node in ast.walk(tree)):
        if isinstance(node, ast.Attribute):
            seen.anywhere.add(node.attr)
            if _name(node.value) in arms:
                seen.of_arms.add(node.attr)
    return seen


def _tree(source: str) -> ast.Module | None:
    try:
        return ast.parse(source)
    except (SyntaxError, ValueError):
        return None


def _makes_arm(node: ast.AST) -> bool:
    return any(isinstance(call, ast.Call) and _name(call.func) == ARM for call in ast.walk(node))


def _name(node: ast.AST) -> str:
    """Returns the last part of a name: ``robot`` of ``self.robot``."""
    if isinstance(node, ast.Attribute):
        return node.attr
    if isinstance(node, ast.Call):
        return f"{_name(node.func)}()"
    return node.id if isinstance(node, ast.Name) else ""


def which_pydobot(*sources: str, copy: str = "") -> str:
    """Determines the library that ``import pydobot`` means in a program of these modules: the one that its imports
    name, that of its own ``copy`` (given as text), the installed one, or the one whose names are used."""
    imported, anywhere, of_arms = names(*sources)
    if "dobotplus" in imported | anywhere or imported & PLUS:
        return "pydobotplus"
    if imported & NEWER and not imported & OLDER:
        return "pydobot2"
    if imported & OLDER:
        return "pydobot"
    if copy:
        if "def get_pose" not in copy:
            return "pydobot"
        return "pydobotplus" if "def move_rel" in copy else "pydobot2"
    for other in ("pydobot2", "pydobot"):
        if _installed(other):
            return other
    older = anywhere & OLDER or of_arms & OLDER_OF_ARMS
    if anywhere & PLUS and not older:
        return "pydobotplus"
    return "pydobot2" if not older and (anywhere & NEWER or of_arms & NEWER_OF_ARMS) else "pydobot"


def needs_copy(*sources: str, copy: str, ours: Collection[str]) -> bool:
    """True if a program uses names that only its own copy of the library has. That copy then runs over the port."""
    tree = _tree(copy)
    if tree is None:
        return False
    have: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            have.add(node.name)
    imported, _, of_arms = names(*sources)
    return bool(((imported | of_arms) & have) - set(ours))


def _installed(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def expects_magician(source: str) -> bool:
    """True if a script expects the global ``magician`` that DobotLab injects."""
    tree = _tree(source)
    if tree is None:
        return False
    used = False
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id == "magician":
            if not isinstance(node.ctx, ast.Load):
                return False
            used = True
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            if any(
                each.name.partition(".")[0] in ("magician", "*") or each.asname == "magician" for each in node.names
            ):
                return False
        elif isinstance(node, ast.arg) and node.arg == "magician":
            return False
    return used


def which_dobotdll(sources: Collection[str], folder: Path, wrappers: Iterable[Path] = ()) -> str:
    """Determines the family of ``DobotDllType`` for a program of these modules: by the file that it imports or that is
    beside it, otherwise by its calls."""
    for file in (*wrappers, folder / "DobotDllType.py", *folder.glob("*/DobotDllType.py")):
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        if "masterId" in text:
            return "v3"
        return "v2" if "dobotId" in text else "v1"
    for source in sources:
        # A program that loads the C library itself reveals the family by its own structures.
        if "CDLL" in source or "LoadLibrary" in source:
            return "v3" if "masterId" in source or "masterDevInfo" in source else "v2" if "dobotId" in source else "v1"
    return "v2" if any(map(_has_ids, sources)) else "v3"


def _has_ids(source: str) -> bool:
    """True if calls of moves have an additional argument, the id of the arm."""
    tree = _tree(source)
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)] if tree else []
    named = [call for call in calls if isinstance(call.func, ast.Attribute) and call.func.attr == "SetPTPCmd"]
    return any(len(call.args) + len(call.keywords) > 7 for call in named)

"""Modules of a program, found by their imports without running them."""

from __future__ import annotations

import ast
import os
import re
import tokenize
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

__all__ = ["OTHER_WRAPPERS", "WRAPPER", "Program", "find_modules", "is_wrapper", "text"]

WRAPPER = "DobotDllType"
"""Last part of every name of the vendor's wrapper, which programs keep in packages of their own."""

OTHER_WRAPPERS = re.compile(r"dobot\d*dll\d*(type\d*)?", re.IGNORECASE)
"""Similar module names: the wrapper for a second arm, or without the last word of its name."""

LIBRARIES = {
    "pydobot", "pydobotplus", "pydobot2", "dobotplus", "pydobotpp", "pydobotlab", "dobotapi", "dobotWrapperPy",
    "DobotEDU", "DobotRPC",
}  # fmt: skip
"""Top-level modules that are replaced, wherever their files are."""

MOST = 1000
"""Largest number of modules examined, more than any known program for an arm has."""


def is_wrapper(name: str) -> bool:
    """True for the name of the vendor's wrapper, ignoring case, since some file systems do."""
    return re.fullmatch(r"dobotdlltype", name, re.IGNORECASE) is not None


class Program(NamedTuple):
    """Text of a program and of its modules."""

    sources: list[str]
    """Its modules, the one that is run first."""
    wrappers: list[Path]
    """The files of the vendor's wrapper that it imports, or that lie beside its modules."""
    packages: set[str]
    """The packages that it imports the wrapper from."""
    copies: dict[str, list[Path]]
    """The files of its own copies of libraries that are stood in for, by name."""


class _Import(NamedTuple):
    level: int
    name: str
    members: tuple[str, ...]


def find_modules(path: Path, source: str, folder: Path) -> Program:
    """Follows the imports of a program within its folder and the folders that it adds to ``sys.path``.

    :param path: File that is run.
    :param source: Text of the file.
    :param folder: Folder in which its absolute imports begin.
    """
    program = Program([], [], set(), {})
    waiting, met, roots = deque([(path, source)]), {_real(path)}, [folder]
    while waiting and len(program.sources) < MOST:
        path, source = waiting.popleft()
        program.sources.append(source)
        try:
            tree = ast.parse(source)
        except (SyntaxError, ValueError):
            continue
        roots += [root for root in _added_folders(tree, folder) if root not in roots]
        _note(path.parent / f"{WRAPPER}.py", program.wrappers)
        for found in _imports(tree):
            whole = found.name.split(".") if found.name else []
            names = [whole, *([*whole, member] for member in found.members)]
            for parts in names:
                at = next((at for at, part in enumerate(parts) if is_wrapper(part)), None)
                if at is not None:
                    parts = parts[: at + 1]
                last = max((at for at, part in enumerate(parts) if OTHER_WRAPPERS.fullmatch(part)), default=0)
                if not found.level:
                    program.packages.update(".".join(parts[:end]) for end in range(1, last + 1))
                for base in _search_folders(found, path, roots):
                    for file in _imported_files(base, parts):
                        if is_wrapper(file.stem):
                            _note(file, program.wrappers)
                        elif not found.level and parts[0] in LIBRARIES:
                            package = sorted(file.parent.glob("*.py")) if file.name == "__init__.py" else []
                            for each in (file, *package):
                                _note(each, program.copies.setdefault(parts[0], []))
                        elif _real(file) not in met:
                            met.add(_real(file))
                            waiting.append((file, text(file)))
    return program


def _imports(tree: ast.AST) -> Iterator[_Import]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for each in node.names:
                yield _Import(0, each.name, ())
        elif isinstance(node, ast.ImportFrom):
            yield _Import(node.level, node.module or "", tuple(each.name for each in node.names))


def _added_folders(tree: ast.AST, folder: Path) -> Iterator[Path]:
    """Returns the folders that a program adds to ``sys.path`` as literals."""
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args):
            continue
        of, place = node.func.value, node.args[-1]
        if (
            node.func.attr in ("append", "insert")
            and isinstance(of, ast.Attribute)
            and of.attr == "path"
            and isinstance(place, ast.Constant)
            and isinstance(place.value, str)
        ):
            yield folder / place.value
            yield Path(place.value)


def _search_folders(found: _Import, path: Path, roots: list[Path]) -> list[Path]:
    """Returns the folders in which the search for an import begins."""
    if not found.level:
        return roots
    base = path.parent
    for _ in range(found.level - 1):
        base = base.parent
    return [base]


def _imported_files(base: Path, parts: list[str]) -> Iterator[Path]:
    """Returns the files that an import of this name runs: those of its packages, and its own."""
    at = base
    candidates: list[Path] = []
    if not parts:
        candidates.append(base / "__init__.py")
    else:
        for part in parts:
            at = at / part
            candidates += [at / "__init__.py", at.with_name(f"{part}.py")]
    yield from (file for file in candidates if file.is_file())


def _note(file: Path, files: list[Path]) -> None:
    if file not in files and file.is_file():
        files.append(file)


def _real(path: Path) -> str:
    return os.path.realpath(path)


def text(file: Path) -> str:
    """Reads a module as text, in its declared encoding; empty if it cannot be read."""
    try:
        with tokenize.open(file) as opened:
            return opened.read()
    except (OSError, SyntaxError, UnicodeDecodeError):
        try:
            return file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""

"""Writes docs/reference/PYTHON-API.md of the signatures and docstrings of the package: python tools/api.py [--check].

It reads the sources, and imports nothing: the native part need not be built.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

HOME = Path(__file__).parent.parent
PACKAGE = HOME / "python" / "magician"
RESULT = HOME.parent.parent / "docs" / "reference" / "PYTHON-API.md"

HEAD = """# Python: reference

<!-- Written by crates/magician-py/tools/api.py of the package's docstrings. -->

Every public name of `magician`, with its parameters and a summary. `help(magician.Arm.move_to)` prints the full text.
[The guide](../guide/PYTHON.md) explains the package,
[How do I ..](../guide/PYTHON-TASKS.md) has examples. `magician.aio` has the same `Arm`, with `await`.
Lengths are mm, angles degrees, times seconds.
"""
# Defining file, importing module, and title of each section.
MODULES = {
    "_blocking": ("magician", "The arm"),
    "places": ("magician.places", "Places"),
    "calibrate": ("magician.calibrate", "Calibration"),
    "words": ("magician.words", "Words: command builders"),
    "pins": ("magician.pins", "Pins and connectors"),
    "programs": ("magician.programs", "Plans"),
    "running": ("magician.running", "Runs"),
    "_reports": ("magician.programs", "Checks"),
    "_pictures": ("magician", "Pictures"),
    "readings": ("magician.readings", "Readings"),
    "_meaning": ("magician.readings", "Positions"),
    "events": ("magician.events", "Events"),
    "errors": ("magician.errors", "Errors"),
    "virtual": ("magician", "Virtual arms"),
    "serving": ("magician", "Arms for other programs"),
    "station": ("magician.station", "Stations"),
    "_stations": ("magician.station", "Values of a station"),
    "simulation": ("magician.simulation", "Simulations"),
    "_ports": ("magician", "Ports"),
    "replaying": ("magician.replaying", "Replayed sessions"),
    "diagnosis": ("magician", "Diagnosis"),
    "conformance": ("magician.conformance", "Conformance"),
    "traffic": ("magician.traffic", "Bytes on a line"),
}
HIDDEN = {
    *("PoseMeaning", "ColorMeaning", "InfraredMeaning", "LevelMeaning", "AnalogMeaning"),
    *("Virtual", "clock", "endpoints", "report"),
}


def listed(tree: ast.Module) -> list[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "__all__":
            return list(ast.literal_eval(node.value))
    return []


def sentence(text: str | None) -> str:
    """The first paragraph of a docstring, as Markdown."""
    first = " ".join((text or "").strip().split("\n\n")[0].split())
    first = re.sub(r":\w+:`~?(?:[\w.]+\.)?(\w+)`", r"`\1`", first)
    return first.replace("``", "`").removesuffix("::").replace("|", "\\|").replace("<", "&lt;")


def arguments(node: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    shown = ast.unparse(node.args)
    return re.sub(r"^(self|cls)(, )?", "", shown)


def functions(body: list[ast.stmt]) -> Iterator[tuple[ast.FunctionDef, list[str]]]:
    """The public functions, each with all signatures that it has: those of its overloads, if there are some."""
    signatures: list[str] = []
    for node in body:
        if not isinstance(node, ast.FunctionDef) or (node.name.startswith("_") and node.name != "__init__"):
            continue
        marks = [ast.unparse(mark) for mark in node.decorator_list]
        if any(mark.endswith(".setter") for mark in marks):
            continue
        returns = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__init__" else ""
        signature = returns if "property" in marks else f"({arguments(node)}){returns}"
        if "overload" in marks:
            signatures.append(signature)
            continue
        yield node, signatures or [signature]
        signatures = []


def class_page(node: ast.ClassDef) -> Iterator[str]:
    yield f"### {node.name}\n"
    yield f"{sentence(ast.get_docstring(node))}\n"
    entries: list[str] = []
    for field, behind in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and field.target.id[0] != "_":
            said = behind.value.value if isinstance(behind, ast.Expr) and isinstance(behind.value, ast.Constant) else ""
            entries.append(f"* `{field.target.id}: {ast.unparse(field.annotation)}`: {sentence(str(said))}")
    for function, signatures in functions(node.body):
        name = node.name if function.name == "__init__" else function.name
        shown = "<br>".join(f"`{name}{signature}`" for signature in signatures)
        entries.append(f"* {shown}: {sentence(ast.get_docstring(function))}".removesuffix(": "))
    if entries:
        yield "\n".join(entries) + "\n"


def page() -> str:
    parts = [HEAD]
    for file, (module, title) in MODULES.items():
        tree = ast.parse((PACKAGE / f"{file}.py").read_text(encoding="utf-8"))
        names = [name for name in listed(tree) if name not in HIDDEN]
        parts.append(f"## {title}\n")
        if not file.startswith("_"):
            parts.append(f"Module `{module}`. {sentence(ast.get_docstring(tree))}\n")
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and node.name in names:
                parts.extend(class_page(node))
        entries = [
            f"* {'<br>'.join(f'`{node.name}{signature}`' for signature in signatures)}: "
            f"{sentence(ast.get_docstring(node))}"
            for node, signatures in functions(tree.body)
            if node.name in names
        ]
        if entries:
            parts.append("\n".join(entries) + "\n")
    return "\n".join(parts)


def main() -> int:
    made = page()
    if "--check" in sys.argv:
        if not RESULT.exists() or RESULT.read_text(encoding="utf-8") != made:
            print(f"docs/reference/{RESULT.name} is not what tools/api.py makes of the docstrings", file=sys.stderr)
            return 1
        return 0
    RESULT.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Runs the notebooks of docs/guide/notebooks, and stores their output: tools/notebooks.py [--check] [NAME..]

A notebook is its own source: edit it, in Jupyter or as text, and run this. With ``--check`` nothing is written: each
must run, print what is stored, and show pictures where they are stored; those of the package must be the same, those of
matplotlib need not, for they depend on its fonts.

It needs the package and what notebooks.txt lists.
"""

from __future__ import annotations

import importlib
import json
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
NOTEBOOKS = ROOT / "docs" / "guide" / "notebooks"
SAMPLES = ROOT / "crates" / "magician-program" / "samples"
SHOWN = ("image/svg+xml", "image/png", "text/html", "text/plain")
"""What is stored of a value: the first of these that it has."""


def main() -> None:
    check = "--check" in sys.argv[1:]
    wanted = [name for name in sys.argv[1:] if name != "--check"]
    stale: list[str] = []
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        if wanted and not any(name in path.name for name in wanted):
            continue
        stored = json.loads(path.read_text(encoding="utf-8"))
        ran = clean(execute(stored))
        if not check:
            path.write_text(json.dumps(ran, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        elif difference := differs(stored, ran):
            stale.append(f"{path.name}: {difference}")
        print(f"{path.name}: {len(ran['cells'])} cells, {len(json.dumps(ran)) // 1024} KiB", flush=True)
    if stale:
        sys.exit("\n".join([*stale, "tools/notebooks.py stores what they show now"]))


def execute(stored: dict[str, Any]) -> dict[str, Any]:
    """Runs a notebook from its top, in a folder of its own that has the sample files."""
    nbformat: Any = importlib.import_module("nbformat")
    client: Any = importlib.import_module("nbclient").NotebookClient
    with tempfile.TemporaryDirectory(prefix="magician-") as folder:
        for sample in SAMPLES.iterdir():
            shutil.copy(sample, folder)
        notebook = nbformat.reads(json.dumps(stored), 4)
        place = {"metadata": {"path": folder}}
        client(notebook, kernel_name="python3", timeout=300, resources=place).execute()
    ran: dict[str, Any] = json.loads(nbformat.writes(notebook))
    return ran


def clean(ran: dict[str, Any]) -> dict[str, Any]:
    """The same without what differs from run to run."""
    cells: list[dict[str, Any]] = []
    for number, cell in enumerate(ran["cells"], 1):
        kept: dict[str, Any] = {"cell_type": cell["cell_type"], "id": f"cell-{number}", "metadata": {}}
        if cell["cell_type"] == "code":
            kept |= {"execution_count": None, "outputs": outputs(cell["outputs"])}
        cells.append({**kept, "source": lines(cell["source"])})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def outputs(ran: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What a cell prints, in one piece, and shows."""
    kept: list[dict[str, Any]] = []
    for output in ran:
        if output["output_type"] == "stream":
            text = "".join(output["text"])
            if kept and kept[-1]["output_type"] == "stream":
                text = "".join(kept.pop()["text"]) + text
            kept.append({"output_type": "stream", "name": output["name"], "text": lines(text)})
        else:
            kind = next(kind for kind in SHOWN if kind in output["data"])
            value = output["data"][kind]
            data = {kind: value.rstrip("\n") if kind == "image/png" else lines(value)}
            kept.append({"output_type": "display_data", "data": data, "metadata": {}})
    return kept


def lines(text: str | list[str]) -> list[str]:
    return "".join(text).splitlines(keepends=True)


def differs(stored: dict[str, Any], ran: dict[str, Any]) -> str | None:
    """What a run shows otherwise than it is stored."""
    for number, (before, now) in enumerate(zip(stored["cells"], ran["cells"], strict=True), 1):
        shown, was = comparable(now), comparable(before)
        if shown != was:
            return f"cell {number} shows {json.dumps(shown)[:500]}, stored is {json.dumps(was)[:500]}"
    return None


def comparable(cell: dict[str, Any]) -> list[Any]:
    """The outputs of a cell, matplotlib's pictures by their kind alone."""
    return [
        "image/png" if "image/png" in output.get("data", {}) else [output.get("text"), output.get("data")]
        for output in cell.get("outputs", [])
    ]


main()

"""The pages are right: each of their Python blocks runs, and prints what stands under it.

A block marked ``python`` is a program of its own, in a folder that holds the sample files; one with a test in it is run
by pytest, one that imports another library by ``python -m magician.compat``. A block marked ``text`` right after it is
what it prints, ``…`` standing for anything; a picture there is what a notebook shows of its last line. There is a
virtual arm wherever a port is left out.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
from stationed import Server

ROOT = Path(__file__).parents[3]
PAGES = [
    ROOT / "crates" / "magician-py" / "README.md",
    ROOT / "docs" / "guide" / "PYTHON.md",
    ROOT / "docs" / "guide" / "PYTHON-TASKS.md",
    ROOT / "docs" / "guide" / "PYTHON-LEARNING.md",
    ROOT / "docs" / "guide" / "STATION-SESSION.md",
    *(ROOT / "docs" / "recipes" / f"{name}.md" for name in ("share", "queue")),
]
# Address of the station in the programs of a page.
STATION = "http://127.0.0.1:8910"
BLOCK = re.compile(
    r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n|\n!\[[^\]]*\]\((\S+)\)\n)?", re.DOTALL | re.MULTILINE
)
OTHERS = re.compile(r"^(import|from) (pydobot|DobotDllType)", re.MULTILINE)


def blocks() -> list[tuple[str, str, str | None, Path | None]]:
    """Where it stands, what it is, what it prints, what it shows."""
    found: list[tuple[str, str, str | None, Path | None]] = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in BLOCK.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            picture = page.parent / match[3] if match[3] else None
            found.append((f"{page.name}:{line}", match[1], match[2], picture))
    return found


def test_there_are_blocks() -> None:
    assert len([name for name, *_ in blocks() if name.startswith("README")]) >= 3
    assert len([name for name, *_ in blocks() if name.startswith("PYTHON.md")]) >= 10
    assert len([name for name, *_ in blocks() if name.startswith("PYTHON-TASKS")]) >= 18
    assert len([name for name, *_ in blocks() if name.startswith("PYTHON-LEARNING")]) >= 6


def test_notebooks_are_stored_with_their_outputs() -> None:
    """That they show it still, tools/notebooks.py checks."""
    notebooks = sorted((ROOT / "docs" / "guide" / "notebooks").glob("*.ipynb"))
    assert sum(path.stat().st_size for path in notebooks) < 1_500_000
    for path in notebooks:
        cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        outputs = [output for cell in cells for output in cell["outputs"]]
        assert not [output for output in outputs if output["output_type"] == "error"], path.name
        assert [output for output in outputs if {"image/svg+xml", "image/png"} & {*output.get("data", ())}], path.name


@pytest.mark.parametrize(("name", "program", "said", "picture"), [pytest.param(*each, id=each[0]) for each in blocks()])
def test_block(name: str, program: str, said: str | None, picture: Path | None, samples: Path, tmp_path: Path) -> None:
    for sample in samples.iterdir():
        if sample.is_file():
            shutil.copy(sample, tmp_path)
    shown = tmp_path / "shown.svg"
    if picture is not None:
        program, last = program.rstrip().rsplit("\n", 1)
        program += f"\nopen({str(shown)!r}, 'w', encoding='utf-8').write({last}._repr_svg_())\n"
    script = tmp_path / ("test_block.py" if "def test_" in program else "block.py")
    with ExitStack() as stack:
        if STATION in program:
            server = stack.enter_context(Server(tmp_path / "state", "--listen", "127.0.0.1:0", "--port", "sim:20"))
            program = program.replace(STATION, server.url)
        script.write_text(program, encoding="utf-8")
        done = run(script, program, tmp_path)
    assert done.returncode == 0, f"{name}\n{done.stdout}\n{done.stderr}"
    if said is not None:
        pattern = ".*".join(re.escape(part) for part in said.split("…"))
        assert re.fullmatch(pattern, done.stdout), f"{name} prints\n{done.stdout}"
    if picture is not None:
        assert shown.read_text(encoding="utf-8") == picture.read_text(encoding="utf-8"), f"{name} shows another picture"


def run(script: Path, program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Runs a program as its page says, beside its files."""
    how: list[str] = []
    if "def test_" in program:
        how = ["-m", "pytest", "-q"]
    elif OTHERS.search(program):
        how = ["-m", "magician.compat"]
    state = str(folder / "state")
    environment = {**os.environ, "MAGICIAN_PORT": "sim", "XDG_STATE_HOME": state, "MAGICIAN_CONFIG": os.devnull}
    command = [sys.executable, "-B", *how, str(script)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)

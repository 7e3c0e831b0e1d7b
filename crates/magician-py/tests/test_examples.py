"""What the documentation shows, and the numbered examples."""

from __future__ import annotations

import doctest
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import magician
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("module", [magician.words, magician.places], ids=lambda module: module.__name__)
def test_docstrings(module: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    failed, tried = doctest.testmod(module)
    assert tried and not failed


@pytest.mark.parametrize(
    "name, last", [("01_pose", "alarm 0x00"), ("02_move", "as it"), ("03_pick_and_place", "20 com")]
)
def test_examples(name: str, last: str) -> None:
    done = subprocess.run([sys.executable, EXAMPLES / f"{name}.py"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].startswith(last)


def test_drawing() -> None:
    arguments = [sys.executable, str(EXAMPLES / "05_drawing.py"), "sim", "200", "2"]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert (figures["segments"], figures["window"]) == (200, 2)


@pytest.mark.skipif(not hasattr(magician, "VirtualArm"), reason="the world is not there")
def test_sorting() -> None:
    done = subprocess.run([sys.executable, EXAMPLES / "04_sort.py"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("on the table") == 3

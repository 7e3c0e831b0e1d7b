from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

CRATES = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def samples() -> Path:
    """The sample files of the program crate."""
    return CRATES / "magician-program" / "samples"


@pytest.fixture(scope="session")
def scenarios() -> Path:
    """The example scenarios of the simulator."""
    return CRATES / "magician-sim" / "scenarios"


def in_notebook(thing: object, kind: str = "svg") -> str:
    """What a notebook shows of it."""
    shown: str = getattr(thing, f"_repr_{kind}_")()
    return shown

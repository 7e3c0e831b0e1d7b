"""What is installed carries the licences of what is in it, and says what it is."""

from __future__ import annotations

from importlib import resources
from importlib.metadata import Distribution, distribution

import pytest


@pytest.fixture
def installed() -> Distribution:
    return distribution("dobot-magician")


def text(installed: Distribution, name: str) -> str:
    said = installed.read_text(f"licenses/{name}")
    assert said is not None, f"{name} is not there"
    return said


def test_our_licences_are_there(installed: Distribution) -> None:
    assert "Permission is hereby granted" in text(installed, "LICENSE-MIT")
    assert "Apache License" in text(installed, "LICENSE-APACHE")
    assert installed.metadata["License-Expression"] == "MIT OR Apache-2.0"


@pytest.mark.parametrize(
    "who", ["\npyo3 ", "\ntokio ", "\nRoboto Regular", "\nRust's standard library", "\nwindows-sys "]
)
def test_licence_page_names_third_parties(installed: Distribution, who: str) -> None:
    assert who in text(installed, "THIRD-PARTY-LICENSES.txt")


def test_every_licence_file_that_is_announced_is_there(installed: Distribution) -> None:
    announced = installed.metadata.get_all("License-File") or []
    assert len(announced) == 3
    assert all(text(installed, name).strip() for name in announced)


def test_types_are_announced(installed: Distribution) -> None:
    assert "Typing :: Typed" in (installed.metadata.get_all("Classifier") or [])
    assert (resources.files("magician") / "py.typed").is_file()

"""What `import magician` loads, and what it leaves until somebody wants it: no times are measured here."""

from __future__ import annotations

import subprocess
import sys

import pytest

LATER = [
    "asyncio", "dataclasses", "difflib", "html", "importlib.metadata", "inspect", "json", "logging", "numpy", "socket",
    "ssl", "subprocess", "tempfile", "threading", "tokenize", "magician.aio", "magician.compat", "magician.testing",
    "magician.calibrate", "magician.conformance", "magician.diagnosis", "magician.replaying", "magician.serving",
    "magician.traffic", "magician.virtual",
]  # fmt: skip


def loaded(program: str) -> set[str]:
    # Without `site`: other packages in the environment may load anything at startup.
    show = "import sys; print(*sys.modules)"
    path = f"import sys; sys.path[:] = {sys.path!r}"
    command = [sys.executable, "-S", "-c", f"{path}\n{program}\n{show}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return set(done.stdout.split())


@pytest.mark.parametrize("program", ["import magician", "import magician; magician.Arm('sim').pose().x"])
def test_optional_modules_are_loaded_on_demand(program: str) -> None:
    found = loaded(program) - loaded("")
    assert "magician._magician" in found
    assert found.isdisjoint(LATER), sorted(found.intersection(LATER))


def test_attribute_access_loads_the_module() -> None:
    assert {"magician.aio", "magician.virtual"} <= loaded("import magician; magician.aio.Arm, magician.VirtualArm")
    assert "magician.aio" in loaded("from magician import aio")
    assert "asyncio" not in loaded("import magician.aio")


def test_unknown_attribute_raises_attribute_error() -> None:
    import magician

    assert set(magician.__all__) <= set(dir(magician))
    with pytest.raises(AttributeError, match="module 'magician' has no attribute 'arms'"):
        _ = magician.arms  # pyright: ignore[reportUnknownVariableType,reportAttributeAccessIssue]

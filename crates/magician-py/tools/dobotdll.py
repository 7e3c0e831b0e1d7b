"""Generates the DobotDllType modules of the package from the sources beside our C library."""

from __future__ import annotations

import importlib.util
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
GENERATOR = HERE.parent / "magician-capi" / "python" / "generate.py"
RESULT = HERE / "python" / "magician" / "compat" / "dobotdll"


def main() -> None:
    spec = importlib.util.spec_from_file_location("generate", GENERATOR)
    assert spec is not None and spec.loader is not None
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    for family in ("v1", "v2", "v3"):
        generate.write(RESULT / f"{family}.py", generate.module(family))


if __name__ == "__main__":
    main()

"""Generates the DobotDllType modules of the package from the sources beside our C library.

A source distribution has the modules and not their sources: it keeps what it has.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
GENERATOR = HERE.parent / "magician-capi" / "python" / "generate.py"
RESULT = HERE / "python" / "magician" / "compat" / "dobotdll"
FAMILIES = ("v1", "v2", "v3")


def main() -> int:
    results = {family: RESULT / f"{family}.py" for family in FAMILIES}
    if not GENERATOR.exists():
        missing = [str(path) for path in results.values() if not path.exists()]
        if missing:
            print("missing, and so are their sources:", *missing, file=sys.stderr)
            print("make the source distribution after `cargo xtask generate python`", file=sys.stderr)
        return len(missing)
    spec = importlib.util.spec_from_file_location("generate", GENERATOR)
    assert spec is not None and spec.loader is not None
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    for family, path in results.items():
        generate.write(path, generate.module(family))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Brings the DobotDllType modules of our C library into the package: python tools/dobotdll.py [--check]."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent.parent
SOURCE = HERE.parent / "magician-capi" / "python"
RESULT = HERE / "python" / "magician" / "compat" / "dobotdll"


def main() -> int:
    stale: list[Path] = []
    for family in ("v1", "v2", "v3"):
        text = (SOURCE / family / "DobotDllType.py").read_text(encoding="utf-8")
        result = RESULT / f"{family}.py"
        if not result.exists() or result.read_text(encoding="utf-8") != text:
            stale.append(result)
            if "--check" not in sys.argv:
                result.write_text(text, encoding="utf-8")
    if "--check" in sys.argv and stale:
        print("tools/dobotdll.py has not brought", *stale, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Makes the blocking interface of the asyncio one: python tools/blocking.py [--check]."""

from __future__ import annotations

import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "python" / "magician"
SOURCE = PACKAGE / "aio.py"
RESULT = PACKAGE / "_blocking.py"


def blocking(text: str) -> str:
    """The same program without an event loop."""
    text = text.replace("from ._native import until", "from ._native import wait")
    text = text.replace("from .running import follow_in_loop as follow\n", "")
    text = text.replace("from .running import Progress, RunResult, Watcher", "from .running import Progress, RunResult, Watcher, follow")
    text = re.sub(r"\bawait until\(", "wait(", text)
    text = re.sub(r"\bawait ", "", text)
    text = re.sub(r"\basync (def|with|for)\b", r"\1", text)
    for aio, plain in (("__aenter__", "__enter__"), ("__aexit__", "__exit__"), ("__aiter__", "__iter__"), ("__anext__", "__next__")):
        text = text.replace(aio, plain)
    head = '"""The arm for programs without asyncio: made of ``aio.py`` by ``tools/blocking.py``; change that."""\n'
    return head + text[text.index('"""', 3) + 4 :]


def main() -> int:
    made = blocking(SOURCE.read_text(encoding="utf-8"))
    if "--check" in sys.argv:
        if RESULT.read_text(encoding="utf-8") != made:
            print(f"{RESULT.name} is not what tools/blocking.py makes of {SOURCE.name}", file=sys.stderr)
            return 1
        return 0
    RESULT.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Makes the blocking interface of the asyncio one: python tools/blocking.py [--check].

What stands between ``# [aio]`` and ``# [both]`` is left out, what stands as comments between ``# [blocking]`` and ``#
[both]`` is taken in.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "python" / "magician"
SOURCE = PACKAGE / "aio.py"
RESULT = PACKAGE / "_blocking.py"

HEAD = '''"""The arm for programs without asyncio: made of ``aio.py`` by ``tools/blocking.py``; change that."""
'''
NAMES = {
    "__aenter__": "__enter__",
    "__aexit__": "__exit__",
    "__aiter__": "__iter__",
    "__anext__": "__next__",
    "StopAsyncIteration": "StopIteration",
    "AsyncIterator": "Iterator",
    '    "Connecting",\n': "",
    '    "conform",\n': "",
    '    "discover",\n': "",
    '    "doctor",\n': "",
    "Generator, ": "",
}


def sections(text: str) -> str:
    """The lines that are meant for the blocking interface."""
    lines: list[str] = []
    mode = "both"
    for line in text.splitlines():
        if mark := re.fullmatch(r"\s*# \[(aio|blocking|both)\]", line):
            mode = mark[1]
        elif mode == "both":
            lines.append(line)
        elif mode == "blocking":
            lines.append(re.sub(r"^(\s*)# ?", r"\1", line).rstrip())
    return "\n".join(lines) + "\n"


def blocking(text: str) -> str:
    """The same program without an event loop."""
    text = sections(text)
    text = re.sub(r"\bawait until(\w*)\(", r"wait\1(", text)
    text = re.sub(r"from \._native import (\([^)]*\)|.*)", lambda found: re.sub(r"\buntil", "wait", found[0]), text)
    text = re.sub(r"\bawait ", "", text)
    text = re.sub(r"\basync (def|with|for)\b", r"\1", text)
    for aio, plain in NAMES.items():
        text = text.replace(aio, plain)
    return HEAD + text[text.index('"""', 3) + 4 :]


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

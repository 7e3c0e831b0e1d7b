"""Generates the blocking interface from the asyncio one.

What stands between ``# [aio]`` and ``# [both]`` is left out, what stands as comments between ``# [blocking]`` and ``#
[both]`` is taken in.
"""

from __future__ import annotations

import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "python" / "magician"
# Generated file, its source, and its heading.
MADE = {
    "aio.py": ("_blocking.py", "The arm for programs without asyncio"),
    "_aio_station.py": ("station.py", "Stations: many programs share an arm"),
}
HEAD = '"""{about}: made of ``{source}`` by ``tools/blocking.py``; change that."""\n'
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
    '    "StateWatch",\n    "Station",\n': '    "StateWatch",\n',
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


def blocking(text: str, head: str) -> str:
    """The same program without an event loop."""
    text = sections(text)
    text = re.sub(r"\bawait until(\w*)\(", r"wait\1(", text)
    text = re.sub(r"from \._native import (\([^)]*\)|.*)", lambda found: re.sub(r"\buntil", "wait", found[0]), text)
    text = re.sub(r"\bawait ", "", text)
    text = re.sub(r"\basync (def|with|for)\b", r"\1", text)
    for aio, plain in NAMES.items():
        text = text.replace(aio, plain)
    return head + text[text.index('"""', 3) + 4 :]


def main() -> None:
    for source, (result, about) in MADE.items():
        text = (PACKAGE / source).read_text(encoding="utf-8")
        made = blocking(text, HEAD.format(about=about, source=source))
        path = PACKAGE / result
        # Leave an unchanged file alone, so that its modification time triggers no build.
        if not path.exists() or path.read_text(encoding="utf-8") != made:
            path.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()

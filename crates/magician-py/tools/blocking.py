"""Generates the blocking interface from the asyncio one.

Lines from ``# [aio]`` to the next ``# [blocking]`` or ``# [both]`` are omitted. Comment lines from
``# [blocking]`` to ``# [both]`` become code.
"""

from __future__ import annotations

import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "python" / "magician"
# Source file: the generated file and its heading.
GENERATED = {
    "aio.py": ("_blocking.py", "The arm for programs without asyncio"),
    "_aio_station.py": ("station.py", "Stations: many programs share an arm"),
}
HEAD = '"""{about}: made of ``{source}`` by ``tools/blocking.py``; change that."""\n'
REPLACEMENTS = {
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


def blocking_lines(text: str) -> str:
    """Returns the lines of the blocking interface, with its commented lines as code."""
    lines: list[str] = []
    mode = "both"
    for line in text.splitlines():
        if marker := re.fullmatch(r"\s*# \[(aio|blocking|both)\]", line):
            mode = marker[1]
        elif mode == "both":
            lines.append(line)
        elif mode == "blocking":
            lines.append(re.sub(r"^(\s*)# ?", r"\1", line).rstrip())
    return "\n".join(lines) + "\n"


def to_blocking(text: str, head: str) -> str:
    """Converts asyncio source text to blocking source text under the given heading."""
    text = blocking_lines(text)
    text = re.sub(r"\bawait until(\w*)\(", r"wait\1(", text)
    text = re.sub(r"from \._native import (\([^)]*\)|.*)", lambda imports: re.sub(r"\buntil", "wait", imports[0]), text)
    text = re.sub(r"\bawait ", "", text)
    text = re.sub(r"\basync (def|with|for)\b", r"\1", text)
    for aio, plain in REPLACEMENTS.items():
        text = text.replace(aio, plain)
    return head + text[text.index('"""', 3) + 4 :]


def main() -> None:
    for source, (result, about) in GENERATED.items():
        text = (PACKAGE / source).read_text(encoding="utf-8")
        generated = to_blocking(text, HEAD.format(about=about, source=source))
        path = PACKAGE / result
        # Leave an unchanged file alone, so that its modification time triggers no build.
        if not path.exists() or path.read_text(encoding="utf-8") != generated:
            path.write_text(generated, encoding="utf-8")


if __name__ == "__main__":
    main()

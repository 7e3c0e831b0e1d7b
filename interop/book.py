#!/usr/bin/env python3
"""The pages are right, where that takes Python or a C compiler: interop/book.py [--magician FILE] --prefix DIR

The blocks marked `bash` of a page are one session at a terminal, in a directory that looks like a checkout, with what
packaging/install-dobotdll has put into DIR as ~/.local. A line that ends with `# exit N` has to end with that status,
every other one with 0; a line that ends with `&` is a virtual arm that is served until the page ends; installing is left
out. A block marked `text` right after one is what that prints, by the rules of crates/magician-cli/tests/book.rs, which
runs the blocks marked `sh`.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ("README.md", "docs/guide/VENDOR-LIBRARY.md", "docs/recipes/vendor-programs.md")
MARK = "=== block at line "
TIME_LIMIT = 600


def blocks(page):
    """Returns each block with its line, language, text, and a flag that is true if only empty lines
    separate it from the previous block."""
    found, opened, follows = [], None, False
    for number, line in enumerate(page.splitlines(), 1):
        if line.startswith("```"):
            if opened:
                found.append(opened)
                opened, follows = None, True
            else:
                opened = (number, line[3:], [], follows)
        elif opened:
            opened[2].append(line)
        elif line.strip():
            follows = False
    return found


def script_line(line):
    """Returns a line for the shell; empty for an installation, which is tested elsewhere."""
    command, _, comment = line.partition(" #")
    command = command.strip()
    if not command or re.match(r"(cargo|packaging/install-dobotdll) ", command):
        return ""
    if command.endswith("&"):
        return f'rm -f .ready; mkfifo .ready; {command[:-1]} >.ready & pids="$pids $!"; read -r _ <.ready'
    if wanted := re.match(r"exit (\d+)", comment.strip()):
        return f"status=0; {command} || status=$?; test $status = {wanted[1]}"
    return command


def script(page):
    """Returns the shell script of a page."""
    lines = ["set -e", "pids=", "trap 'test -z \"$pids\" || kill $pids; wait' EXIT"]
    for number, language, text, _ in page:
        if language == "bash":
            lines += [f"echo '{MARK}{number}'", *map(script_line, text)]
    return "\n".join(lines) + "\n"


def plain(line):
    """Normalises a line: repeated spaces become one."""
    return " ".join(line.split())


def missing(printed, said):
    """Returns the first line of a page that is missing from the output, in order."""
    lines = iter([plain(line) for line in printed])
    for pattern in filter(str.strip, said):
        wanted = re.compile(".*".join(map(re.escape, plain(pattern).split("…"))))
        if not any(wanted.fullmatch(line) for line in lines):
            return pattern
    return None


def surroundings(place, magician, prefix):
    """Returns an environment with a home that contains the library, without the caller's
    settings."""
    home = place / "home"
    home.mkdir()
    (home / ".local").symlink_to(prefix)
    kept = {name: value for name, value in os.environ.items()
            if not name.startswith(("MAGICIAN_", "PYTHON", "XDG_", "LD_", "PKG_CONFIG"))}
    path = f"{magician.parent}{os.pathsep}{os.environ['PATH']}"
    return {**kept, "HOME": str(home), "PATH": path, "NO_COLOR": "1", "PYTHONUNBUFFERED": "1", "PYTHONDONTWRITEBYTECODE": "1"}


def try_page(name, magician, prefix):
    """Returns the number of executed blocks of a page, and its mistakes."""
    page = blocks((ROOT / name).read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="magician-book-") as folder:
        place = pathlib.Path(folder)
        work = place / "work"
        work.mkdir()
        for part in ("crates", "packaging"):
            (work / part).symlink_to(ROOT / part)
        ran = subprocess.run(
            ["bash", "-c", "exec 2>&1\n" + script(page)], cwd=work, env=surroundings(place, magician, prefix),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, timeout=TIME_LIMIT,
        )
    printed = {}
    for line in ran.stdout.splitlines():
        if line.startswith(MARK):
            here = printed[int(line[len(MARK):])] = []
        else:
            here.append(line)
    if ran.returncode:
        return len(printed), [f"{name} ends with status {ran.returncode}:\n{ran.stdout}"]
    wrong = []
    for (number, language, _, _), (_, after, said, follows) in zip(page, page[1:]):
        if language == "bash" and after == "text" and follows:
            line = missing(printed[number], said)
            if line is not None:
                wrong.append(f"{name}:{number} does not print\n{line}\nbut\n" + "\n".join(printed[number]))
    return len(printed), wrong


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    options.add_argument("--magician", type=pathlib.Path, default=target / "debug" / "magician")
    options.add_argument("--prefix", type=pathlib.Path, required=True, help="where install-dobotdll has installed")
    given = options.parse_args()
    for part in (given.magician, given.prefix / "lib" / "dobotdll" / "v1"):
        if not part.exists():
            options.error(f"there is no {part}")
    mistakes = []
    for name in PAGES:
        count, wrong = try_page(name, given.magician.resolve(), given.prefix.resolve())
        print(f"{name}: {count} blocks, {len(wrong)} wrong", flush=True)
        mistakes += wrong if count else [f"{name} has nothing that is tried"]
    print("\n\n".join(mistakes), end="\n" if mistakes else "")
    sys.exit(1 if mistakes else 0)


if __name__ == "__main__":
    main()

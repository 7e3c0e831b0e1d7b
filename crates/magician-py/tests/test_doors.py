"""One file and the same options are one plan in Python and in the command.

That station and page agree with the command is a test of the command's own.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any, cast

import magician
import pytest
from magician.errors import InvalidInputError
from test_command import run

#: Where G-code begins that depends on it: the command takes it from its virtual arm, a plan is made for no arm.
START = (220.0, 0.0, 20.0)

OPTIONS: list[tuple[list[str], dict[str, Any]]] = [
    (["run"], {}),
    (["draw", "--fit", "--page", "a4"], {"work": "draw", "fit": True, "page": "a4"}),
    (["draw", "--place"], {"work": "draw", "place": True}),
    (["draw", "--scale", "0.3", "--rotate", "20"], {"work": "draw", "scale": 0.3, "rotate": 20}),
    (["engrave", "--power", "60", "--speed", "30"], {"work": "engrave", "power": 60, "speed": 30}),
]


def single(number: float) -> float:
    """A number as the arm gets it."""
    return float(struct.unpack("f", struct.pack("f", number))[0])


def plain(value: Any) -> Any:
    """A value of a command, or of its JSON, as plain data."""
    if isinstance(value, float):
        return single(value)
    if isinstance(value, int):
        return int(value)
    if isinstance(value, dict):
        members = cast("dict[str, Any]", value)
        return {name: plain(part) for name, part in members.items()}
    if isinstance(value, (list, tuple)):
        parts = cast("list[Any]", value)
        return [plain(part) for part in parts]
    if hasattr(value, "_fields"):
        return {name: plain(getattr(value, name)) for name in value._fields}
    return value


def orders(*words: str) -> tuple[list[Any], list[Any]] | str:
    """The values of the commands of the steps, and the notes, of a dry run; or why there is none."""
    ended = run(*words, "--dry-run", "--json")
    if not ended.stdout:
        return str(json.loads(ended.stderr)["error"]["message"])
    *steps, report = [json.loads(line) for line in ended.stdout.splitlines()]
    sent = [plain(step["params"]) for step in steps if step["step"] is not None]
    return sent, [note for note in report.get("notes", []) if note["code"] not in ("doubtful", "long")]


@pytest.mark.parametrize(("words", "options"), OPTIONS, ids=[" ".join(words) for words, _ in OPTIONS])
def test_sample_is_the_same_plan_in_python_and_in_the_command(
    samples: Path, words: list[str], options: dict[str, Any]
) -> None:
    compared = 0
    for file in sorted(samples.iterdir()):
        if file.suffix == ".md":
            continue
        start: dict[str, Any] = {"start": START} if file.suffix == ".gcode" else {}
        given = [f"--start={','.join(map(str, START))}"] if start else []
        verb, *flags = words
        command = orders(verb, str(file), *flags, *given)
        try:
            plan = magician.load(file, **options, **start)
        except InvalidInputError as error:
            # The command's preview also shows drawings that do not fit.
            assert isinstance(command, str) or "fit" in str(error), (file.name, command, str(error))
            continue
        assert not isinstance(command, str), (file.name, command)
        steps, told = command
        sent = [plain(step.command) for step in plan.steps if step.command is not None]
        assert sent == steps, file.name
        assert [note["code"] for note in told] == [note.code for note in plan.notes], file.name
        assert all(note.message in of["text"] for note, of in zip(plan.notes, told, strict=True)), file.name
        compared += 1
    assert compared >= 5

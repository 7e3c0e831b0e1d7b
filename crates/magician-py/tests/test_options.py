"""Options that are refused: the table that every door reads."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import magician
import numpy
import pytest
from magician.errors import InvalidInputError
from magician.programs import SetupOptions

TABLE = Path(__file__).parents[2] / "magician-program" / "tests" / "data" / "bad_options.json"
SQUARE = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm'><path d='M1 1h20v20h-20z'/></svg>"
UNSAYABLE = 136
"""Entries that no call can say: see :func:`_is_sayable`."""


def _load(**options: Any) -> magician.Plan:
    return magician.load(io.BytesIO(SQUARE.encode()), format="svg", **options)


def _is_sayable(name: str, value: Any) -> bool:
    if value is None or name not in SetupOptions.__annotations__:
        return False  # omitted, or not a keyword
    if name in ("font", "pens") and isinstance(value, str):
        return False  # a file
    if name == "only" and isinstance(value, str):
        return False  # one part
    if name == "power" and isinstance(value, list):
        return False  # a range
    is_switch = "bool | None" in str(SetupOptions.__annotations__[name])
    return not (is_switch and not isinstance(value, bool) and value == 1)  # 1 is True


def _as_python(value: Any) -> Any:
    return float(value) if value in ("nan", "inf", "-inf") else value


def test_bad_option_has_the_sentence_of_every_door() -> None:
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    unsayable = 0
    for entry in table:
        options = {name: _as_python(value) for name, value in entry["options"].items()}
        if not all(_is_sayable(name, value) for name, value in options.items()):
            unsayable += 1
            continue
        with pytest.raises(InvalidInputError) as caught:
            _load(**options)
        assert str(caught.value) == entry["message"], entry
    assert unsayable == UNSAYABLE, len(table)


def test_values_of_python_are_taken() -> None:
    plain = _load(work="engrave", power=(5, 80), surface=-60)
    assert plain == _load(work="engrave", power=[5.0, 80.0], surface=magician.programs.Surface(-60))
    assert plain != _load(work="engrave", power=40, surface=-60)
    assert _load(scale=numpy.float32(0.5), at=numpy.array([230, 0])) == _load(scale=0.5, at=(230, 0))
    assert _load(fit=1, only="1") == _load(fit=True, only=["1"])
    assert _load(speed=None) == _load()


def test_unknown_option_is_no_keyword() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        _load(colour="red")
    with pytest.raises(TypeError, match="scale is 1j"):
        _load(scale=1j)

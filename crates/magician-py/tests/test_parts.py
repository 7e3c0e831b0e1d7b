"""Drawings with parts, and jobs that wait for a person between them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import Arm
from magician.errors import InvalidInputError

TWO = b"""<svg xmlns='http://www.w3.org/2000/svg' width='30mm' height='30mm' viewBox='0 0 30 30'>
<path d='M5 5H25' stroke='red'/><path d='M5 15H25' stroke='blue'/></svg>"""


def _load(**options: Any) -> magician.Plan:
    return magician.load(io.BytesIO(TWO), format="svg", surface=-60, **options)


def test_a_job_waits_between_its_parts_until_it_is_resumed(arm: Arm) -> None:
    plan = _load(parts="color")
    assert [text for _, text in plan.pauses] == ["mount the pen for part 2, #0000ff"]
    job = arm.start(plan)
    assert job.paused() == "mount the pen for part 2, #0000ff"
    assert (job.state, job.pause_reason) == ("paused", "part")
    assert job.pause_text == "mount the pen for part 2, #0000ff"
    job.resume()
    assert job.paused() is None
    assert job.wait().steps == len(plan)
    assert job.pause_reason is None


def test_run_with_pauses_that_nothing_resumes_is_refused(arm: Arm) -> None:
    with pytest.raises(InvalidInputError, match=r"pauses at step \d+ \(mount the pen .*no_pause=True"):
        arm.run(_load(parts="color"))
    assert arm.run(_load(parts="color", no_pause=True)).steps > 0


def test_parts_are_chosen_and_have_pens(tmp_path: Path) -> None:
    assert not _load(parts="color", only="blue").pauses
    drawn = _load(parts="color", only=["1"], passes=3).check().drawn
    assert drawn == pytest.approx(60, abs=0.1)
    pens = [{"match": "red", "passes": 2}, {"match": 2, "lift": 4}]
    assert _load(parts="color", pens=pens).check().drawn == pytest.approx(60, abs=0.1)
    file = tmp_path / "pens.toml"
    file.write_text('[[pen]]\nmatch = "red"\npasses = 2\n\n[[pen]]\nmatch = 2\nlift = 4\n')
    assert _load(parts="color", pens=file) == _load(parts="color", pens=pens)
    assert [step.action for step in _load(parts="color").steps if step.command is None] == ["part", "pause", "part"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"parts": "pen"}, 'parts is none, layer or color, not "pen"'),
        ({"only": "green", "parts": "color"}, "no part has the name, colour or number 'green'"),
        ({"passes": 0}, "passes is a whole number from 1 to 1000, not 0"),
        ({"pens": [{"match": "red", "width": 3}]}, "unknown field `width`"),
        ({"pens": [{"lift": 3}]}, "missing field `match`"),
        ({"pens": [{"match": 1, "lift": -3}]}, "lift is a number above 0 and at most 10000 mm, not -3"),
    ],
)
def test_invalid_part_options_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        _load(**options)

"""Frames, test grids and presets."""

from __future__ import annotations

import json
from pathlib import Path

import magician
import pytest
from magician.errors import InvalidInputError

SVG = (
    b"<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='20mm' viewBox='0 0 40 20'>"
    b"<path d='M2 5 L38 5 L2 15' fill='none' stroke='black'/></svg>"
)


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    path = tmp_path / "line.svg"
    path.write_bytes(SVG)
    return path


def powers(plan: magician.Plan) -> set[float]:
    segments = [step.values for step in plan.steps if step.action == "burn"]
    return {values[-1] for values in segments}


def test_a_frame_goes_round_the_marks_in_the_dark(drawing: Path, arm: magician.Arm) -> None:
    marks = magician.load(drawing, surface=-60, work="engrave").check().bounds
    assert marks is not None
    plan = magician.frame(drawing, surface=-60, tool="laser")
    targets = [step.target for step in plan.steps if step.action == "burn"]
    assert powers(plan) == {0.0}
    for axis in (0, 1):
        along = [target[axis] for target in targets if target]
        assert min(along) == pytest.approx(marks[0][axis], abs=0.02)
        assert max(along) == pytest.approx(marks[1][axis], abs=0.02)
    # It burns nothing, so no permission is needed.
    assert arm.run(plan).report.drawn == 0


def test_a_pen_goes_round_above_the_paper(drawing: Path) -> None:
    plan = magician.frame(drawing, "hull", surface=-60, tool="pen", lift=6)
    path = [step.target for step in plan.steps if step.action == "path"]
    assert path and all(target and target[2] == -54 for target in path)


def test_only_a_little_power_lights_a_frame(drawing: Path) -> None:
    plan = magician.frame(drawing, surface=-60, tool="laser", frame_power=2)
    assert powers(plan) == {2.0}
    with pytest.raises(InvalidInputError, match="at most 5"):
        magician.frame(drawing, surface=-60, tool="laser", frame_power=6)
    with pytest.raises(InvalidInputError, match="another tool"):
        magician.frame(drawing, surface=-60, tool="pen", frame_power=2)


def test_a_grid_has_the_powers_that_it_names() -> None:
    plan = magician.testgrid(power=(20, 60, 3), speed=(10, 30, 2), cell=4, surface=-60)
    assert powers(plan) == {0.0, 20.0, 40.0, 60.0}
    assert plan.check().ok
    with pytest.raises(InvalidInputError, match="at most 100"):
        magician.testgrid(power=(20, 120, 3))


def test_preset_fills_in_omitted_arguments(drawing: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MAGICIAN_CONFIG", str(tmp_path / "config.toml"))
    (tmp_path / "presets").mkdir()
    preset = {"tool": '"laser"', "power": "40", "surface": "-55.0", "note": '"birch"'}
    text = "".join(f"{key} = {value}\n" for key, value in preset.items())
    (tmp_path / "presets" / "birch.toml").write_text(text)
    plan = magician.load(drawing, preset="birch")
    assert powers(plan) == {40.0}
    assert "preset birch: birch" in [note.message for note in plan.notes]
    assert json.loads(plan.to_json())["surface"]["height"] == -55
    assert powers(magician.load(drawing, preset="birch", power=70)) == {70.0}
    for wrong in ("oak", "../birch"):
        with pytest.raises(InvalidInputError, match="preset"):
            magician.load(drawing, preset=wrong)

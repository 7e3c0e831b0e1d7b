"""Plans: loaded, checked, changed, kept, shown."""

from __future__ import annotations

import io
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import magician
import pytest
from conftest import in_notebook
from magician import Plan, Sheet, Surface, commands, words
from magician.errors import InvalidInputError, UnreachableError

SQUARE = [(200, 0, -60), (240, 0, -60), (240, 40, -60), (200, 40, -60), (200, 0, -60)]


@pytest.mark.parametrize(
    ("name", "format"),
    [
        ("arc_movl_v1412.playback", "playback"),
        ("curves.svg", "svg"),
        ("engrave_gradient.png", "image"),
        ("example_loop.blockly", "blockly"),
        ("house.svg", "svg"),
        ("jump_suction_named_v170.playback", "playback"),
        ("laser_checker.gcode", "gcode"),
        ("pen_outline.gcode", "gcode"),
        ("plate.dxf", "dxf"),
        ("rabbit.svg", "svg"),
        ("star.plt", "hpgl"),
    ],
)
def test_every_kind_of_file_becomes_a_plan_that_is_kept(samples: Path, tmp_path: Path, name: str, format: str) -> None:
    plan = magician.load(samples / name, fit=format in ("svg", "dxf", "hpgl"))
    assert (plan.source, plan.format) == (name, format)
    assert len(plan) == len(plan.steps) > 0
    assert plan.check().steps == len(plan)
    assert plan.save(tmp_path / "kept.plan.json") == []
    again = magician.load(tmp_path / "kept.plan.json")
    assert again == plan
    assert again.commands() == plan.commands()


def test_a_report_has_figures_and_a_plan_its_steps(samples: Path) -> None:
    plan = magician.load(samples / "house.svg", surface=-58.5)
    report = plan.check()
    assert report.ok and report.refused == 0 and not report.complaints
    assert report.counts["path"] == 59
    assert 20 < (report.seconds or 0) < 35 and plan.estimate == report.seconds
    assert report.drawn == pytest.approx(302.0, abs=0.1)
    assert report.bounds is not None and report.bounds[0][2] == -58.5
    assert "302 mm drawn" in str(report) and "302 mm drawn" in in_notebook(report, "html")
    step = next(step for step in plan.steps if step.action == "path" and step.name == "rect")
    assert step.target is not None and step.target[2] == -58.5
    assert step.line == 4
    assert isinstance(step.command, commands.CpCmd)
    assert plan.steps[-1].number == len(plan) and plan.steps[-2:][0].number == len(plan) - 1
    with pytest.raises(IndexError):
        plan.steps[len(plan)]
    assert plan.surface == Surface(-58.5) and not plan.surface_is_assumed
    assert plan.tool == "pen" and plan.title == "house"


def test_complaints_name_place_and_remedy(samples: Path) -> None:
    plan = magician.load(samples / "pen_outline.gcode").moved(y=250)
    report = plan.check()
    assert not report.ok and report.refused == len(report.complaints)
    first = report.complaints[0]
    assert isinstance(first.error, UnreachableError)
    assert first.line is not None and first.value is not None and first.limit is not None
    assert first.unit in ("mm", "deg")
    assert f"line {first.line}" in str(first) and f"step {first.step}" in str(first)
    assert first.value > first.limit
    nearest = "the nearest place in reach is x 247.1, y 218.6, z 0"
    assert first.message == f"x 260, y 230, z 0 is out of reach; {nearest}"
    with pytest.raises(UnreachableError, match=nearest):
        report.raise_if_refused()
    assert first.message.split(":")[0] in in_notebook(report, "html")


def test_an_unreadable_file_is_refused_with_its_place() -> None:
    with pytest.raises(InvalidInputError, match=r"bad\.gcode: line 2"):
        magician.load(_named("bad.gcode", b"G1 X200 Y0 Z0\nG1 X..\n"))
    with pytest.raises(InvalidInputError, match="one of playback, svg"):
        magician.load(_named("what.txt", b"good morning"))
    with pytest.raises(FileNotFoundError):
        magician.load("no/such/file.svg")


def test_a_recording_is_resampled_on_request() -> None:
    rows = "".join(f"{nth * 0.05:.2f},{200 + nth * 0.5:.1f},{0.1 * (-1) ** nth},10\n" for nth in range(81))
    recording = ("t,x,y,z\n" + rows).encode()
    whole = magician.load(_named("way.csv", recording))
    thinned = magician.load(_named("way.csv", recording), resample=0.3)
    assert not any("points are left out" in note.message for note in whole.notes)
    assert any("points are left out" in note.message for note in thinned.notes)
    assert thinned.check().seconds == pytest.approx(whole.check().seconds, rel=0.05)


def test_invalid_arguments_of_load_are_refused(samples: Path) -> None:
    house = samples / "house.svg"
    with pytest.raises(InvalidInputError, match="scale is a number above 0 and at most 10000, not -1"):
        magician.load(house, scale=-1)
    with pytest.raises(InvalidInputError, match="tool is none, suction"):
        magician.load(house, tool="hammer")  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="height and width contradict"):
        magician.load(samples / "engrave_gradient.png", width=10, height=10)
    with pytest.raises(InvalidInputError, match="power is percent"):
        magician.load(samples / "engrave_gradient.png", power=(50, 20))
    with pytest.raises(InvalidInputError, match="relative to the arm's position"):
        magician.load(_named("from.nc", b"G91\nG1 X10 F600\n"))
    assert len(magician.load(_named("from.nc", b"G91\nG1 X10 F600\n"), start=(200, 0, 0)))


def test_drawing_is_placed_as_requested(samples: Path) -> None:
    there = magician.load(samples / "house.svg", at=(230, 50), surface=Surface(-60, (0.01, 0.0)), scale=0.5)
    (x0, y0, _), (x1, y1, _) = _bounds(there)
    assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx((230, 50), abs=1.5)
    assert y1 - y0 == pytest.approx(25, abs=0.1)
    sheet = Sheet((180, -60), rotation=0, size=(110, 120))
    on_sheet = magician.load(samples / "house.svg", sheet=sheet, surface=-60)
    assert on_sheet.preview(sheet=sheet).svg.startswith("<svg")


def test_help_speaks_of_arguments(samples: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"reachable; fit=True shrinks it; scale=\d\.\d+ fits there"):
        magician.load(samples / "house.svg", scale=10)
    (note,) = magician.load(samples / "house.svg").notes
    assert note.help == "order=False keeps the order of the file" and note.help in str(note)
    with pytest.raises(InvalidInputError, match=r"at=\([0-9.]+, -?[0-9.]+\) fits there"):
        magician.load(samples / "house.svg", at=(0, 0), fit=True)


def test_an_image_is_engraved_or_traced(samples: Path) -> None:
    image = samples / "engrave_gradient.png"
    burnt = magician.load(image, width=20, power=(5, 60), spacing=0.5)
    assert burnt.tool == "laser" and burnt.check().counts["burn"] > 50
    powers = {step.values[3] for step in burnt.steps if step.action == "burn"} - {0}
    assert 5 <= min(powers) < 10 and 40 < max(powers) <= 60
    drawn = magician.load(image, work="draw", width=30, threshold=100)
    assert drawn.tool == "pen" and "burn" not in drawn.check().counts


JOB = b"""; LightBurn 1.4.00
G21 G90
M3
; Cut @ 600 mm/min, 20% power
G0 X220 Y0 Z0
G1 X240 S200 F600
M5
"""


def test_full_power_is_noted_and_power_scales_every_source(samples: Path) -> None:
    plan = magician.load(_named("job.gcode", JOB))
    assert plan.check().power == (20, 20) and "burns with 20 %" in str(plan.check())
    assert "full power is S1000" in str(plan.notes[0]) and "s_max=" in str(plan.notes[0])
    assert magician.load(_named("job.gcode", JOB), s_max=400).check().power == (50, 50)
    assert magician.load(_named("job.gcode", JOB), power=50).check().power == (10, 10)
    assert magician.load(_named("job.gcode", JOB), power=(10, 60)).check().power == (20, 20)
    assert magician.load(samples / "house.svg", work="engrave", power=50).check().power == (50, 50)
    assert magician.load(samples / "house.svg").check().power is None
    with pytest.raises(InvalidInputError, match=r"S2000 is above 1000.*s_max="):
        magician.load(_named("far.gcode", b"G0 X220 Y0 Z0\nM3 S2000\nG1 X240 F600\nM5\n"))


def test_a_servo_lifts_the_pen() -> None:
    program = b"M3 S40\nG0 X220 Y0\nM3 S90\nG1 X240 F600\nM3 S40\n"
    plan = magician.load(_named("servo.gcode", program), dialect="servo", surface=-50, lift=10)
    assert plan.check().power is None
    # The approach from above starts at the lift plus 50 mm.
    assert [step.values[2] for step in plan.steps if step.action in ("path", "move")] == [10, -50, -50, -40]


def test_gcode_is_placed_or_taken_as_it_stands(samples: Path) -> None:
    file = samples / "pen_outline.gcode"
    raw = magician.load(file)
    assert magician.load(file, raw=True) == raw and raw.check().bounds[0][2] == 0  # type: ignore[index]
    for placed in (magician.load(file, surface=-50), magician.load(file, surface=-50, place=True)):
        (_, _, lowest), (_, _, highest) = placed.check().travel_bounds or ((0, 0, 0), (0, 0, 0))
        assert lowest == -50 and highest > -50 and placed.surface == Surface(-50)
        assert "on the surface at z = -50.0" in str(placed.notes[0])
        help = placed.notes[0].help or ""
        assert "raw=True" in help and "pen_z=" in help
    # A pen stays above the surface unless the depths of the file are kept.
    cases: list[tuple[dict[str, Any], float]] = [
        ({"pen_z": 1}, -50),
        ({"move": (0, 0, -5)}, -50),
        ({"pen_z": 1, "depths": "keep"}, -51),
        ({"move": (0, 0, -5), "depths": "keep"}, -55),
    ]
    for options, lowest in cases:
        bounds = magician.load(file, surface=-50, **options).check().bounds
        assert bounds is not None and bounds[0][2] == pytest.approx(lowest), options
    with pytest.raises(InvalidInputError, match='depths is flatten or keep, not "deep"'):
        magician.load(file, depths="deep")  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="nothing is drawn at or below Z -2"):
        magician.load(file, surface=-50, pen_z=-2)
    assert magician.load(file, place=True).surface_is_assumed
    with pytest.raises(InvalidInputError, match="raw and place contradict"):
        magician.load(file, place=True, raw=True)
    with pytest.raises(InvalidInputError, match="raw and surface contradict"):
        magician.load(file, raw=True, surface=-50)
    with pytest.raises(InvalidInputError, match="raw and pen_z contradict"):
        magician.load(file, raw=True, pen_z=1)
    with pytest.raises(InvalidInputError, match=r"leave out raw; at=\(x, y\) sets"):
        magician.load(samples / "house.svg", raw=True)


def test_transformations_give_new_plans() -> None:
    plan = Plan.path(SQUARE, tool="pen", surface=-60)
    moved = plan.moved(10, -5, 1)
    assert moved != plan and moved.surface == Surface(-59)
    for before, after in zip(plan.targets(), moved.targets(), strict=True):
        assert after == pytest.approx([before[0] + 10, before[1] - 5, before[2] + 1], nan_ok=True)
    assert _size(plan.scaled(0.5, about=(200, 0, -60))) == pytest.approx((20, 20))
    turned = plan.rotated(90, about=(200, 0))
    (x0, y0, _), (x1, y1, _) = _bounds(turned)
    assert (x0, y0, x1, y1) == pytest.approx((160, 0, 200, 40), abs=1e-4)
    assert len(plan * 3) == 3 * len(plan) == len(plan + plan + plan)
    with pytest.raises(InvalidInputError, match="above 0"):
        plan.scaled(0)
    with pytest.raises(InvalidInputError, match="degrees is nan"):
        plan.rotated(math.nan)


def test_pallets_repeat_a_plan_at_each_place() -> None:
    drop = Plan.path([(200, 0, -20, 0)], by="jump")
    grid = drop.on_grid(2, 3, (25, 30))
    assert grid.targets() == [
        (200, 0, -20),
        (225, 0, -20),
        (250, 0, -20),
        (200, 30, -20),
        (225, 30, -20),
        (250, 30, -20),
    ]
    pallet = drop.on_pallet(2, 3, (200, 0, -20), (250, 0, -20), (200, 30, -10))
    assert pallet.targets()[-1] == (250, 30, -10)
    with pytest.raises(InvalidInputError, match="rows is 0"):
        drop.on_grid(0, 3, (25, 30))


def test_plans_of_commands_and_their_tool() -> None:
    plan = Plan.of([words.move_to(220, 0, 20, 0), words.wait(0.5)], tool="suction", title="pick")
    assert [step.action for step in plan.steps] == ["move", "wait"]
    assert (plan.steps[0].by, plan.steps[0].values) == ("joints", (220, 0, 20, 0))
    assert plan.steps[1].values == (0.5,)
    assert plan.commands() == [words.tool("suction"), words.move_to(220, 0, 20, 0), words.wait(0.5)]
    with pytest.raises(InvalidInputError, match="cannot be queued"):
        Plan.of([commands.QueuedCmdClear()])  # type: ignore[list-item]
    other = Plan.of([words.wait(0.1)], tool=(10, 0, 5))
    joined = plan + other
    assert joined.tool == "suction" and joined.steps[2].command == words.tool(x=10, z=5)


def test_playback_files_are_written_with_notes_on_losses(samples: Path, tmp_path: Path) -> None:
    plan = magician.load(samples / "jump_suction_named_v170.playback")
    plan.save(tmp_path / "again.playback")
    assert magician.load(tmp_path / "again.playback").commands() == plan.commands()
    fast = Plan.of([words.speed(50), words.move_to(220, 0, 20, 0)])
    assert any("speeds" in lost for lost in fast.save(tmp_path / "fast.playback"))
    with pytest.raises(InvalidInputError, match=r"kept as \.plan\.json"):
        plan.save(tmp_path / "plan.txt")


def test_a_plan_goes_on_at_a_step() -> None:
    plan = Plan.path(SQUARE, tool="pen")
    rest = plan.from_step(5)
    assert rest.check().ok
    assert rest.targets()[-2:] == plan.targets()[-2:]
    with pytest.raises(InvalidInputError, match=r"step is 0; .* from 1 to"):
        plan.from_step(0)
    with pytest.raises(InvalidInputError, match="step is 99"):
        plan.from_step(99)


def test_rehearsal_draws_what_the_arm_would_draw(samples: Path, tmp_path: Path) -> None:
    plan = magician.load(samples / "star.plt", fit=True)
    done = plan.rehearse(watch=0.05)
    assert done.ok and done.steps == len(plan) and not done.alarms
    assert plan.estimate is not None and done.seconds == pytest.approx(plan.estimate, rel=0.1)
    assert len(done.drawing) == 1 and done.drawing[0].burnt is False
    (least, _), (_, most) = done.drawing.bounds or ((0, 0), (0, 0))
    assert len(done.way) > 10
    stroke = done.drawing[0]
    assert min(x for x, _ in stroke.points) == least and max(y for _, y in stroke.points) == most
    assert done.drawing.save(tmp_path / "left.png").read_bytes().startswith(b"\x89PNG")
    assert in_notebook(done) == done.drawing.svg
    with pytest.raises(IndexError):
        done.drawing[1]


def test_pictures_are_files_and_shown_in_notebooks(samples: Path, tmp_path: Path) -> None:
    plan = magician.load(samples / "gripper_pick_v194.playback")
    picture = plan.preview(tmp_path / "plan.svg")
    text = (tmp_path / "plan.svg").read_text(encoding="utf-8")
    assert text == picture.svg == in_notebook(plan) and text.startswith("<svg")
    assert plan.preview(tmp_path / "plan.png", side=False).svg != picture.svg
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InvalidInputError, match=r"\.svg or \.png"):
        plan.preview(tmp_path / "plan.pdf")


def _named(name: str, data: bytes) -> io.BytesIO:
    file = io.BytesIO(data)
    file.name = name
    return file


def _bounds(plan: Plan) -> tuple[tuple[float, ...], tuple[float, ...]]:
    path = [step.target for step in plan.steps if step.action == "path" and step.target]
    return tuple(map(min, zip(*path, strict=True))), tuple(map(max, zip(*path, strict=True)))


def _size(plan: Plan) -> tuple[float, float]:
    (x0, y0, _), (x1, y1, _) = _bounds(plan)
    return x1 - x0, y1 - y0


def test_invalid_file_and_surface_raise_type_error() -> None:
    wrong: Any = b"<svg/>"
    with pytest.raises(TypeError, match="a path, or open for reading bytes, not bytes"):
        magician.load(wrong)
    low: Any = "low"
    with pytest.raises(TypeError, match="height in mm, or a Surface, not 'low'"):
        magician.Plan.path([(200, 0, 0)], surface=low)


SAVES = {
    "a.plan.json": "magician.Plan.path([(220, y, 0) for y in range(60)]).save(path)",
    "a.playback": "magician.Plan.of([magician.words.move_to(220, y, 0, 0) for y in range(60)]).save(path)",
    "a.svg": "magician.VirtualArm().picture(path)",
    "a.png": "magician.VirtualArm().picture(path)",
    "poses.json": "magician.Poses(path).__setitem__('pose ' * 200, (220, 0, 0, 0))",
}


@pytest.mark.skipif(sys.platform == "win32", reason="it has no limit of the size of files")
@pytest.mark.parametrize("name", SAVES)
def test_a_full_disk_leaves_the_file_that_was_there(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    program = f"""
import errno, resource, sys
from pathlib import Path
import magician
path = Path({str(path)!r})
{SAVES[name]}
assert path.stat().st_size > 512
path.write_bytes(b"{{}}")
resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))
try:
    {SAVES[name]}
except OSError as error:
    assert error.errno == errno.EFBIG, error
else:
    sys.exit("it was written")
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
    assert path.read_bytes() == b"{}" and list(tmp_path.iterdir()) == [path]

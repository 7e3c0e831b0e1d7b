"""Virtual arms and their worlds."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import magician
import pytest
from conftest import in_notebook
from magician import Plan, VirtualArm, words
from magician.commands import Stepper
from magician.errors import InvalidInputError

CELL = """
title = "One cube"
arm = { homed = true }
tool = { kind = "suction" }
table = { height = -60 }
object = [{ name = "red cube", size = [20, 20, 20], at = [220, 80], color = "red" }]
conveyor = { start = [200, -200], direction = 90, length = 200, width = 60, height = -40, stepper = 0 }
"""


def put_it_on_the_belt(arm: magician.Arm) -> None:
    arm.run(Plan.path([(220, 80, -40)], by="jump", tool="suction"))
    arm.run([words.suction(True), words.wait(0.5)])
    arm.run(Plan.path([(200, -100, -20)], by="jump", tool="suction"))
    arm.run([words.suction(False), words.wait(0.5)])


def test_is_the_red_cube_on_the_belt() -> None:
    cell = VirtualArm(CELL)
    put_it_on_the_belt(cell.arm())
    assert cell.object("red cube").on_belt


def test_objects_are_looked_at_as_they_are_now() -> None:
    cell = VirtualArm(CELL)
    cube = cell.object("red cube")
    assert (cube.size, cube.color, cube.position) == ((20, 20, 20), (255, 0, 0), (220, 80, -60, 0))
    assert cube.on_table and not cube.held and cell.held is None and not cube.seen_by("GP1")
    arm = cell.arm()
    arm.run(Plan.path([(220, 80, -40)], by="jump", tool="suction"))
    arm.run([words.suction(True), words.wait(0.5)])
    arm.run(Plan.path([(220, 80, 20)], by="line"))
    assert cube.held and cell.held is not None and cell.held.name == "red cube"
    assert cube.position.z == pytest.approx(0, abs=0.1)
    assert cell.suction and cell.position.z == pytest.approx(20, abs=1e-3)
    assert "the tool takes red cube" in cell.events() and cell.events() == []
    with pytest.raises(KeyError, match="known are 'red cube'"):
        cell.object("green cube")


def test_time_advances_only_on_request(scenarios: Path) -> None:
    cell = VirtualArm(scenarios / "pick_and_sort.toml")
    assert cell.time == 0 and cell.title == "Pick and sort"
    arm = cell.arm()
    arm.move_to(200, 100, 60, 0)
    at = cell.time
    assert 0.5 < at < 5 and not cell.moving
    assert cell.time == at
    cell.advance(2.5)
    assert cell.time == pytest.approx(at + 2.5, abs=1e-6)
    with pytest.raises(InvalidInputError, match="-1"):
        cell.advance(-1)


def test_every_run_is_the_same_run() -> None:
    def run() -> tuple[object, ...]:
        cell = VirtualArm(CELL)
        put_it_on_the_belt(cell.arm())
        return cell.time, cell.joints, cell.object("red cube").position

    assert run() == run()


def test_a_belt_runs_when_time_passes() -> None:
    cell = VirtualArm(CELL)
    arm = cell.arm()
    put_it_on_the_belt(arm)
    cube = cell.object("red cube")
    y = cube.position.y
    arm.conveyor(Stepper.STEPPER1, 50)
    cell.advance(1.0)
    moved = cell.belt_travel
    assert moved == pytest.approx(50, abs=0.1) and cube.position.y == pytest.approx(y + moved, abs=1e-3)
    cell.advance(10.0)
    assert not cube.on_belt


def test_hands_and_faults() -> None:
    cell = VirtualArm()
    cell.guide((20, 30, 40, 0))
    assert cell.joints == (20, 30, 40, 0)
    cell.slip(1, 5)
    assert cell.true_joints[0] == pytest.approx(25)
    cell.raise_alarm(0x20)
    assert 0x20 in cell.alarms
    cell.set_input(15, True)
    cell.set_analog(1, 4095)
    wrongs: list[Callable[[], None]] = [
        lambda: cell.set_input(21, True),
        lambda: cell.set_analog(1, 5000),
        lambda: cell.slip(5, 1),
    ]
    for wrong in wrongs:
        with pytest.raises(InvalidInputError):
            wrong()
    cell.press_key(long=True)
    cell.reset()
    assert 0 in cell.alarms
    assert any("slips" in event for event in cell.events())


def test_invalid_scenarios_are_refused_with_their_position(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="scenario: line 1, column 11"):
        VirtualArm("table = { heigth = -70 }")
    with pytest.raises(FileNotFoundError):
        VirtualArm(tmp_path / "none.toml")
    with pytest.raises(InvalidInputError, match="above 0"):
        VirtualArm(speed=0)


def test_unconstructed_objects_have_a_repr() -> None:
    """As a debugger does, with what stands in a traceback."""
    assert repr(VirtualArm.__new__(VirtualArm)) == "<VirtualArm, not made>"
    assert repr(magician.Arm.__new__(magician.Arm)) == "<Arm, not connected>"


def test_a_pen_leaves_its_drawing(scenarios: Path, samples: Path, tmp_path: Path) -> None:
    cell = VirtualArm(scenarios / "drawing.toml")
    plan = magician.load(samples / "house.svg", surface=-60, move=(0, 0, -0.5))
    cell.arm().run(plan)
    assert len(cell.drawing) == 6 and not any(stroke.burnt for stroke in cell.drawing)
    (x0, y0), (x1, y1) = cell.drawing.bounds or ((0, 0), (0, 0))
    assert (x1 - x0, y1 - y0) == pytest.approx((50, 50), abs=0.2)
    assert cell.drawing.svg.count("<path") == 6
    # Cropped to the drawing. The base is shown on demand.
    left = cell.drawing.save(tmp_path / "left.svg").read_text()
    whole = cell.drawing.save(tmp_path / "whole.svg", whole=True).read_text()
    assert left == cell.drawing.svg and "<circle" not in left and "<circle" in whole
    assert len(cell.drawing.png(1.0)) < len(cell.drawing.png(1.0, whole=True))
    picture = cell.picture(tmp_path / "cell.png")
    assert (tmp_path / "cell.png").read_bytes().startswith(b"\x89PNG")
    assert picture.svg == in_notebook(cell) and ">Drawing<" in picture.svg


def test_an_arm_shows_itself() -> None:
    cell = VirtualArm(CELL)
    arm = cell.arm()
    assert "x 259.1" in arm.picture().svg and in_notebook(arm) == arm.picture().svg
    # The picture of the world shows the tool that is really mounted.
    assert "x 259.1" in cell.picture().svg and "red cube" in cell.picture().svg


def test_a_state_shows_itself() -> None:
    arm = VirtualArm(CELL).arm()
    arm.tool("suction")
    status = arm.state(50).changed()
    shown = in_notebook(status).replace("\N{MINUS SIGN}", "-")
    assert "x 259.1  y 0  z -8.5  r 0" in shown and "32 places free" in shown


def test_asyncio_drives_the_same_arm() -> None:
    cell = VirtualArm(CELL)

    async def main() -> magician.RunResult:
        async with magician.aio.Arm.connect(cell) as arm:
            assert (await arm.check(Plan.path([(400, 0, 0)], by="line"))).refused == 1
            return await arm.run(Plan.path([(220, 0, 20)], by="line"))

    assert asyncio.run(main()).steps == 1
    assert cell.position[:3] == pytest.approx((220, 0, 20), abs=1e-3)


def test_invalid_inputs_are_refused(virtual_arm: VirtualArm) -> None:
    for address in (-1, 0, 21, 300):
        with pytest.raises(InvalidInputError, match=f"address is {address}; .* from 1 to 20"):
            virtual_arm.set_input(address, True)
        with pytest.raises(InvalidInputError, match=f"address is {address}; .* from 1 to 20"):
            virtual_arm.set_analog(address, 0)


@pytest.mark.parametrize(("tool", "x"), [(None, 259.104), ("none", 199.404), ("pen", 260.404), ((70, 0, 0), 269.404)])
def test_an_arm_has_the_tool_that_was_chosen(tool: Any, x: float) -> None:
    assert VirtualArm(tool=tool).position.x == pytest.approx(x, abs=1e-3)
    with VirtualArm(tool=tool).arm() as arm:
        assert arm.pose().x == pytest.approx(x, abs=1e-3)


def test_invalid_tool_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="hammer"):
        VirtualArm(tool="hammer")  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="2 numbers"):
        VirtualArm(tool=(1, 2))

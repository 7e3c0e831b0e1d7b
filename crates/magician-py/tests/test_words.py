from __future__ import annotations

import inspect
import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from magician import commands, errors, words
from magician.commands import Output, PtpMode, Stepper


def test_moves() -> None:
    assert words.move_to(1, 2, 3, 4) == commands.PtpCmd(PtpMode.MOVJ_XYZ, 1, 2, 3, 4)
    modes: dict[Callable[..., commands.PtpCmd], int] = {
        words.line_to: 2, words.jump_to: 0, words.jump_line_to: 9, words.move_joints: 4, words.line_joints: 5,
        words.jump_joints: 3, words.move_by: 8, words.line_by: 7, words.move_joints_by: 6,
    }  # fmt: skip
    for word, mode in modes.items():
        assert word(1, 2, 3, 4) == commands.PtpCmd(PtpMode(mode), 1, 2, 3, 4)
    assert words.move_by(dz=5) == commands.PtpCmd(PtpMode.MOVJ_XYZ_INC, 0, 0, 5, 0)
    assert words.arc_to([1, 2, 3, 4], (5, 6, 7, 8)) == commands.ArcCmd((1, 2, 3, 4), (5, 6, 7, 8))
    assert words.circle((1, 2, 3, 4), (5, 6, 7, 8)).count == 1
    with pytest.raises(errors.InvalidInputError, match="3 numbers; it takes 4"):
        words.arc_to((1, 2, 3), (5, 6, 7, 8))


def test_jogs() -> None:
    assert words.jog("x+") == commands.JogCmd(False, commands.JogCommand.AXIS1_PLUS)
    assert words.jog("r-") == commands.JogCmd(False, commands.JogCommand.AXIS4_MINUS)
    assert words.jog("j2-") == commands.JogCmd(True, commands.JogCommand.AXIS2_MINUS)
    assert words.jog("rail+") == commands.JogCmd(True, commands.JogCommand.RAIL_PLUS)
    with pytest.raises(errors.InvalidInputError, match=r"`?'up'.*x\+"):
        words.jog("up")  # type: ignore[arg-type]


def test_tools() -> None:
    assert words.tool("pen").x_bias == 61
    assert words.tool(x=10, z=-5) == commands.EndEffectorParams(10, 0, -5)
    with pytest.raises(errors.InvalidInputError, match="none, suction, gripper, pen, laser"):
        words.tool("drill")  # type: ignore[arg-type]
    with pytest.raises(errors.InvalidInputError):
        words.tool("pen", x=1)


def test_outputs_and_the_rail() -> None:
    outputs = [Output(50, 17, True)]
    on_rail = words.with_rail(words.with_outputs(words.jump_to(1, 2, 3, 4), outputs), 600)
    assert on_rail == commands.PtpPoWithLCmd(PtpMode.JUMP_XYZ, 1, 2, 3, 4, 600, (Output(50, 17, True),))
    assert words.with_outputs(words.with_rail(words.jump_to(1, 2, 3, 4), 600), outputs) == on_rail
    assert words.with_rail(words.move_to(1, 2, 3, 4), 5) == words.move_with_rail(1, 2, 3, 4, 5)
    assert words.rail_to(5, commands.Pose(0, 0, 0, 0, (1, 2, 3, 4))).ptp_mode is PtpMode.MOVJ_ANGLE
    with pytest.raises(errors.InvalidInputError, match="58 outputs on the way, limit 57"):
        words.with_outputs(words.move_to(1, 2, 3, 4), outputs * 58)
    with pytest.raises(errors.InvalidInputError, match="at most 56"):
        words.with_rail(words.with_outputs(words.move_to(1, 2, 3, 4), outputs * 57), 1)


def test_waits() -> None:
    assert words.wait(0.3) == commands.WaitCmd(300)
    for wrong in (-1, math.nan, math.inf, 1e10):
        with pytest.raises(errors.InvalidInputError):
            words.wait(wrong)
    conditions = [words.wait_below, words.wait_at_most, words.wait_at_least, words.wait_above]
    assert [word(3, 100).condition for word in conditions] == [0, 1, 2, 3]
    assert words.wait_for_level(19, True).threshold == 1


def test_belts() -> None:
    # 16,000 pulses per turn of a roller of 34 mm, as in the driver.
    assert words.conveyor(Stepper.STEPPER1, 50).speed == 7490
    assert words.conveyor(Stepper.STEPPER1, 0) == commands.EMotor(Stepper.STEPPER1, False, 0)
    back = words.conveyor_by(Stepper.STEPPER2, -100, 50)
    assert (back.speed, back.distance, back.index) == (-7490, 14979, 1)
    for wrong in (math.nan, math.inf, 121, -500):
        with pytest.raises(errors.InvalidInputError):
            words.conveyor(Stepper.STEPPER1, wrong)
    with pytest.raises(errors.InvalidInputError):
        words.conveyor_by(Stepper.STEPPER1, 1e9, 1)


def test_speeds() -> None:
    assert words.speed(40) == commands.PtpCommonParams(40, 40) == words.speed(40, 40)
    assert words.line_speed(200, 100) == commands.PtpCoordinateParams(200, 100, 100, 50)
    assert words.servo(8, 1.5) == words.pwm(8, 50, 7.5)


def test_builders_give_the_bytes_of_the_driver() -> None:
    """The driver's builders are held to the same file: ``crates/magician-host/tests/builders.rs``."""
    table = json.loads((Path(__file__).parents[2] / "magician-host/tests/data/builders.json").read_text())
    for entry in table:
        command = getattr(words, entry.get("python", entry["name"]))(*entry["args"])
        assert bytes(command).hex() == entry["params"], entry
    names = {entry.get("python", entry["name"]) for entry in table}
    functions = {name for name in words.__all__ if inspect.isfunction(getattr(words, name))}
    # Functions with other arguments than numbers are tested above.
    assert functions - names == {"bias_of", "jog", "rail_to", "with_outputs", "with_rail"}

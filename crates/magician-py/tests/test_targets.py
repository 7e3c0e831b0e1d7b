"""Poses, joints, pins and connectors as they are given to what takes them."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from magician import Arm, Joints, Output, Pin, Plan, Port, Pose, Position, VirtualArm, commands, errors, words
from magician.pins import function, pin, port, rail_version, sensor_version, stepper

POSE = Pose(220, 60, 20, 5, (15, 30, 40, -10))


def test_a_pose_is_a_row_of_four() -> None:
    x, y, z, r = POSE
    assert (x, y, z, r) == POSE.position == tuple(POSE) and len(POSE) == 4 and POSE
    numpy = pytest.importorskip("numpy")
    assert numpy.asarray(POSE).tolist() == [220, 60, 20, 5]
    assert numpy.asarray(POSE, dtype="float32").dtype == "float32"
    assert numpy.asarray([POSE, POSE]).shape == (2, 4)
    assert numpy.asarray(POSE.joints).tolist() == [15, 30, 40, -10]
    assert (220, 60, 20) in Plan.path([tuple(POSE), POSE.position]).targets()


def test_moves_reach_targets_of_every_form(arm: Arm) -> None:
    arm.move_to(220, 60, 20, 5)
    there = arm.pose()
    arm.move_to(220, -60, 20, 0)
    arm.move_to(*there)
    assert arm.pose() == there
    for to in (Position(200, 0, 10, 15), (210, 0, 10), [215, 0, 10, 20]):
        arm.line_to(to)
        assert arm.pose().position[:3] == tuple(to)[:3]
        assert arm.pose().r == (tuple(to)[3] if len(to) == 4 else 15)
    arm.jump_to(there)
    assert arm.pose() == there
    arm.move_to(there, r=9)
    assert arm.pose().position == (220, 60, 20, 9)
    arm.move_joints(Joints(0, 45, 45, 0))
    arm.move_joints(there)
    assert arm.joints() == pytest.approx(there.joints)
    arm.line_joints((0, 45, 45))
    assert arm.joints() == pytest.approx((0, 45, 45, there.j4))
    numpy = pytest.importorskip("numpy")
    arm.move_to(numpy.array([220, 0, 20]))
    assert arm.pose().y == 0


def test_invalid_targets_are_refused(arm: Arm) -> None:
    anything: Any = arm
    for wrong, message in (
        ((220, 0), "z is left out"),
        (((220, 0),), "to has 2 numbers; it takes 3"),
        (((220, 0, 0), 0, 0), r"x is \(220, 0, 0\)"),
        (("rest",), "rest"),
        ((None,), "x is left out"),
    ):
        with pytest.raises((TypeError, ValueError, KeyError), match=message):
            anything.move_to(*wrong)
    with pytest.raises(TypeError, match="j3 is left out"):
        anything.move_joints(1, 2)


def test_words_keep_r(arm: Arm) -> None:
    kept = words.line_to(220, 0, 20)
    assert kept == pickle.loads(pickle.dumps(kept)) and kept != words.line_to(220, 0, 20, 0)
    assert words.move_to(POSE) == words.move_to(220, 60, 20, 5) and words.jump_to((1, 2, 3)) == words.jump_to(1, 2, 3)
    arm.move_to(220, 60, 20, 5)
    program = [
        kept,
        words.with_rail(words.with_outputs(words.jump_to(220, 30, 20), [Output(50, 17, True)]), 0),
        words.move_by(dr=10),
        words.line_to(220, 20, 20),
    ]
    assert arm.estimate(program) > 0
    arm.perform(program)
    assert arm.pose().r == pytest.approx(15, abs=1e-4)
    arm.run([words.move_joints(10, 40, 40, 20), words.move_to(220, 0, 20)])
    assert arm.pose().r == pytest.approx(30, abs=1e-4)
    assert arm.run([words.line_to(220, 10, 20)]).steps == 1
    assert [step.values[3] for step in Plan.of([words.move_to(200, 0, 0, 7), kept]).steps] == [7, 7]


@pytest.mark.parametrize("before", [[], [words.home()], [words.move_to(200, 0, 0, 7), words.path_to(200, 10, 0)]])
def test_unknown_r_must_be_given(arm: Arm, before: list[commands.Queueable]) -> None:
    kept = words.line_to(220, 0, 20)
    with pytest.raises(errors.InvalidInputError, match="r is left out") as caught:
        Plan.of([*before, kept])
    assert caught.value.step == len(before)
    for verb in (arm.set, arm.enqueue):
        with pytest.raises(errors.InvalidInputError, match="give r"):
            verb(kept)
    with pytest.raises(TypeError, match="PTPCmd"):
        bytes(kept)


def test_pins_by_their_labels(virtual_arm: VirtualArm) -> None:
    for same in (19, Pin.E1, "EIO19", "eio 19", "E1", "e1"):
        assert pin("address", same) == 19
    assert [pin("address", f"EIO{nth}") for nth in range(1, 21)] == list(range(1, 21)) == sorted(Pin)
    assert pin("address", "GP1 PWM") == Pin.GP1_PWM.value == 11
    arm = virtual_arm.arm()
    arm.multiplex("E1", "DI")
    virtual_arm.set_input("E1", True)
    assert arm.level_at(Pin.E1) and arm.level_at("EIO19")
    assert words.output("SW1", True) == commands.IoDo(16, True)
    assert words.wait_for_level("E1", True).address == 19
    outputs = words.with_outputs(words.move_to(220, 0, 0, 0), [Output(50, "SW2", True)])  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    assert outputs.po == (Output(50, 17, True),)
    with arm.state(10, inputs=["E1"]) as watch:
        assert watch.changed().inputs == {19: True}
    with pytest.raises(errors.InvalidInputError, match=r"address is 'GP9'; it takes EIO1 to EIO20 or TEMP, SW4"):
        words.output("GP9", True)
    with pytest.raises(TypeError, match="list"):
        arm.state(10, inputs="E1")


def test_connectors_are_accepted_by_name() -> None:
    assert port("gp4") is Port.GP4 is port(2)
    assert function("DO").name == "DIGITAL_OUTPUT" and function("digital input pull-up") == 5
    assert stepper("stepper2") == 1 and sensor_version("V2") == 1 and rail_version("v2") == 1
    assert words.color_at("GP1") == words.color_at(Port.GP1)
    with pytest.raises(errors.InvalidInputError, match="port is 'GP3'; it takes GP1, GP2, GP4, GP5"):
        words.infrared_at("GP3")

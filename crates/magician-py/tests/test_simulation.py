"""Virtual arms that are stepped."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest
from magician import VirtualArm, is_reachable, words
from magician.errors import InvalidInputError
from magician.simulation import Observations, Simulation, Simulations

CELL = """
tool = { kind = "suction" }
table = { height = -60 }
object = [
    { name = "red", size = [20, 20, 20], at = [220, 80], color = "red" },
    { name = "blue", size = [20, 20, 20], at = [220, -80], color = "blue" },
    { name = "on it", size = [10, 10, 10], at = [220, -80], on = "blue" },
]
"""
NAN = float("nan")


def targets(count: int, seed: int) -> Any:
    return np.random.default_rng(seed).uniform((180, -120, -40, -20), (280, 120, 100, 20), (count, 4))


def test_step_agrees_with_a_driven_arm() -> None:
    cell = VirtualArm()
    with cell.arm() as arm:
        begun = cell.time
        arm.perform([words.line_to(220, 60, 20, 0)])
        took = cell.time - begun
        pose, joints = arm.pose().position, arm.joints()
    seen = Simulation().step((220, 60, 20, 0))
    assert seen.pose == pytest.approx(pose, abs=1e-5) and seen.joints == pytest.approx(joints, abs=1e-5)
    assert seen.time == pytest.approx(took, abs=1e-9)
    assert not (seen.moving or seen.refused or seen.alarm or seen.holding)


@pytest.mark.parametrize("dt", [None, 0.05])
def test_after_a_snapshot_everything_goes_the_same_way(dt: float | None) -> None:
    arm = Simulation(CELL, object_noise=10, joint_noise=5, seed=4)
    arm.step((220, 60, 20, 0), dt=0.3)
    before = arm.snapshot()

    def go() -> list[object]:
        steps = [arm.step(target, dt) for target in targets(20, 1)]
        return [*steps, arm.objects, arm.reset(), arm.objects]

    once = go()
    assert arm.restore(before).moving
    assert go() == once
    other = Simulation(CELL)
    other.restore(before)
    assert other.step((200, 0, 0, 0), dt) == (arm.restore(before), arm.step((200, 0, 0, 0), dt))[1]


@pytest.mark.parametrize("dt", [None, 0.1])
def test_many_at_once_are_one_after_the_other(dt: float | None) -> None:
    count = 7
    many = Simulations(count, CELL, seed=11, object_noise=20, joint_noise=10, threads=3)
    one_by_one = [Simulation(CELL, seed=11 + nth, object_noise=20, joint_noise=10) for nth in range(count)]
    assert len({repr(arm.objects) for arm in one_by_one}) == count
    for step in range(6):
        actions = np.column_stack((targets(count, step), np.full(count, step % 2)))
        seen = many.step(actions, dt)
        for nth, arm in enumerate(one_by_one):
            alone = arm.step(actions[nth], dt)
            assert tuple(alone.pose) == tuple(seen.poses[nth])
            assert tuple(alone.joints) == tuple(seen.joints[nth])
            assert (alone.time, alone.moving) == (seen.time[nth], seen.moving[nth])
            assert [*map(tuple, arm.objects.values())] == [*map(tuple, many.objects[nth])]
    assert many.object_names == ("red", "blue", "on it")
    pictures = many.images("side", (40, 30))
    assert pictures.shape == (count, 40, 30, 3)
    assert (pictures[3] == one_by_one[3].image("side", (40, 30))).all()


def test_a_seed_gives_the_same_beginning_and_the_next_another() -> None:
    arm = Simulation(CELL, object_noise=20, joint_noise=10, seed=1)
    first, next_one = (arm.objects, arm.observe()), (arm.reset(), arm.objects)
    assert (arm.reset(1), arm.objects) == first[::-1]
    assert (arm.reset(), arm.objects) == next_one and next_one[1] != first[0]
    many = Simulations(3, CELL, object_noise=20, seed=1)
    before = many.objects
    seen = many.reset(which=[False, True, False])
    assert isinstance(seen, Observations)
    assert (many.objects == before).all(axis=(1, 2)).tolist() == [True, False, True]
    moved = arm.objects
    assert abs(moved["red"].x - 220) <= 20 and moved["blue"][:2] == (220, -80) == moved["on it"][:2]


def test_unreachable_step_is_refused_and_not_sent() -> None:
    arm = Simulation()
    before = arm.observe()
    seen = arm.step((400, 0, 0, 0), dt=0.5)
    assert seen.refused and not seen.alarm and seen.pose == before.pose and seen.time == before.time + 0.5
    assert not is_reachable(400, 0, 0)
    assert arm.step((NAN, 0, 0, 0)).time == seen.time
    there = arm.step((220, 0, 20, 0))
    assert not there.refused
    # NaN means no target; an infinite value is a target.
    assert not arm.step((NAN, 0, 0, 0)).refused
    for far in (math.inf, -math.inf, 1e300):
        seen = arm.step((far, 0, 20, 0))
        assert seen.refused and seen.pose == there.pose


@pytest.mark.parametrize("what", [None, 3, "snapshot", [None]])
def test_only_a_snapshot_is_restored(what: Any) -> None:
    arm = Simulation()
    before = arm.observe()
    for restore in (arm.restore, VirtualArm().restore, Simulations(1).restore):
        with pytest.raises(TypeError, match="snapshot"):
            restore(what)
    assert arm.observe() == before


def test_the_cup_takes_a_cube_and_a_camera_sees_it() -> None:
    arm = Simulation(CELL, action="jump_to")
    before = arm.image("top", (680, 460))
    assert before.dtype == np.uint8 and (before[260, 320] == (255, 0, 0)).all()
    arm.step((220, 80, -40, 0, 0))
    assert arm.step((NAN, NAN, NAN, NAN, 1), dt=0.5).holding
    seen = arm.step((220, 0, 0, 0, 1))
    assert seen.holding and arm.objects["red"].z == pytest.approx(-20, abs=0.1)
    assert (before != arm.image("top", (680, 460))).any()


def test_restore_needs_a_disconnected_virtual_arm() -> None:
    cell = VirtualArm(CELL)
    with cell.arm() as arm:
        arm.move_to(220, 0, 20, 0)
        kept = cell.snapshot()
        with pytest.raises(InvalidInputError, match="connected"):
            cell.restore(kept)
        arm.move_to(200, 100, 20, 0)
    time, pose = cell.time, cell.position
    cell.restore(kept)
    assert cell.time < time and cell.position.x == pytest.approx(220)
    with cell.arm() as arm:
        arm.move_to(200, 100, 20, 0)
    assert cell.position == pose
    assert Simulation().restore(kept).pose.x == 220
    learner = Simulation(CELL)
    learner.step((200, -50, 20, 0))
    cell.restore(learner.snapshot())
    assert cell.position.y == pytest.approx(-50)


def test_invalid_arguments_are_refused() -> None:
    arm, many = Simulation(), Simulations(2)
    wrongs: list[Any] = [
        lambda: arm.step((1, 2, 3)),
        lambda: arm.step((220, 0, 0, 0), dt=-1),
        lambda: many.step([(220, 0, 0, 0)]),
        lambda: many.restore([arm.snapshot()]),
        lambda: many.reset(which=[True]),
        lambda: Simulations(0),
        lambda: Simulation(action="fly_to"),  # type: ignore[arg-type]
        lambda: Simulation(speed=0),
        lambda: Simulation(CELL, object_noise=-1),
        lambda: Simulation("table = { heigth = 1 }"),
        lambda: arm.image("front"),  # type: ignore[arg-type]
        lambda: arm.image(size=(0, 10)),
    ]
    for wrong in wrongs:
        with pytest.raises(InvalidInputError):
            wrong()
    for keep in (copy.deepcopy, pickle.dumps):
        for thing in (arm, many, arm.snapshot()):
            with pytest.raises(TypeError, match=r"copied|pickled"):
                keep(thing)

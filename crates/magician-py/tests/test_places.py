"""Poses by name, work planes, pallets, and what is picked and placed there."""

from __future__ import annotations

import asyncio
import math
import pickle
import random
from pathlib import Path
from typing import Any

import pytest
from magician import Arm, Frame, Pallet, Pose, Poses, Position, VirtualArm, aio, errors, words
from magician.places import picking

CELL = """
tool = { kind = "suction" }
table = { height = -60 }
object = [{ name = "red cube", size = [20, 20, 20], at = [220, 80], color = "red" }]
"""


def near(a: Position, b: tuple[float, ...]) -> bool:
    return all(abs(one - other) < 1e-6 for one, other in zip(a, b, strict=False))


def test_a_frame_goes_there_and_back() -> None:
    chance = random.Random(4)
    for _ in range(300):
        points = [tuple(chance.uniform(-200, 200) for _ in range(3)) for _ in range(3)]
        frame = Frame.from_points(*points)
        origin, on_x, on_y = points
        assert near(frame(0, 0), origin)
        assert near(frame.from_arm(*on_x), (math.dist(origin, on_x), 0, 0))
        found = frame.from_arm(*on_y)
        assert found.y > 0 and abs(found.z) < 1e-6
        place = tuple(chance.uniform(-100, 100) for _ in range(4))
        assert near(frame.from_arm(*frame(*place)), place)
        assert near(frame.to_arm(*frame.from_arm(*place)), place)
        one, other = frame(*place[:3]), frame(place[0] + 3, place[1] + 4, place[2])
        assert math.dist(one[:3], other[:3]) == pytest.approx(5)
        assert pickle.loads(pickle.dumps(frame)) == frame


def test_level_frames() -> None:
    frame = Frame.level(200, 10, -20, rotation=90)
    assert frame(10, 0, 5, 15) == Position(200, 20, -15, 105) and frame.slope == 0 and frame.rotation == 90
    assert frame(0, 0, r=170).r == -100
    assert Frame.from_points((200, 0, 0), (300, 0, 100), (200, 50, 0)).slope == pytest.approx(45)
    assert Frame.from_points(Pose(200, 0, 0, 7, (0, 0, 0, 0)), (210, 0, 0, 9), (200, 1, 0)).rotation == 0


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (((1, 2, 3), (1, 2, 3), (4, 5, 6)), "same point"),
        (((0, 0, 0), (1, 1, 1), (2, 2, 2)), "on a line"),
        (((0, 0), (1, 1, 1), (2, 2, 2)), "origin has 2 numbers; it takes 3"),
        (((0, 0, 0), (1, math.nan, 1), (2, 2, 2)), r"on_x\[1\] is nan"),
    ],
)
def test_points_that_say_no_plane(points: Any, message: str) -> None:
    with pytest.raises(errors.InvalidInputError, match=message):
        Frame.from_points(*points)


def test_pallets() -> None:
    tray = Pallet(3, 4, (200, 0, 0, 12), (200, 90, 3), (260, 0, 0))
    assert len(tray) == len(list(tray)) == 12 and tray[0] == Position(200, 0, 0, 12)
    assert tray[3] == tray[0, 3] == Position(200, 90, 3, 12) and tray[-1] == tray[2, 3] == Position(260, 90, 3, 12)
    assert tray[5] == Position(230, 30, 1, 12)
    bent = Pallet(2, 2, (0, 0, 0), (10, 0, 0), (0, 10, 0), (12, 12, 4))
    assert [place[:3] for place in bent] == [(0, 0, 0), (10, 0, 0), (0, 10, 0), (12, 12, 4)]
    assert list(Pallet(1, 1, (1, 2, 3), (1, 2, 3), (1, 2, 3))) == [Position(1, 2, 3, 0)]
    assert pickle.loads(pickle.dumps(tray)) == tray and tray != bent
    for wrong in (12, -13, (0, 4), (3, 0)):
        with pytest.raises(IndexError, match="there are"):
            tray[wrong]
    with pytest.raises(errors.InvalidInputError, match="rows is 0"):
        Pallet(0, 1, (0, 0, 0), (0, 0, 0), (0, 0, 0))


def test_poses_are_kept_by_name(arm: Arm, tmp_path: Path) -> None:
    arm.poses = Poses(tmp_path / "cell.json")
    arm.move_to(220, 60, 20, 5)
    arm.poses["über"] = arm.pose()
    arm.poses["low"] = (220, 0, 10)
    arm.move_to("low")
    assert arm.pose().position == (220, 0, 10, 0)
    again = Poses(tmp_path / "cell.json")
    assert dict(again) == {"über": (220, 60, 20, 5), "low": (220, 0, 10, 0)} and len(again) == 2
    arm.line_to("über", r=0)
    assert arm.pose().position == (220, 60, 20, 0)
    del again["low"]
    assert list(arm.poses) == ["über"] and not list(tmp_path.glob("*.new"))
    with pytest.raises(errors.InvalidInputError, match=r"no pose 'low' in .*; there are über"):
        arm.jump_to("low")
    with pytest.raises(KeyError, match="no pose"):
        del again["low"]
    for wrong in ("[1]", "{", '{"a": {"x": 1}}'):
        again.path.write_text(wrong, encoding="utf-8")
        with pytest.raises(errors.InvalidInputError, match="not a file of poses"):
            len(again)


def test_invalid_pose_is_not_stored(tmp_path: Path) -> None:
    poses: Any = Poses(tmp_path / "cell.json")
    for name, pose in (("a", (1, 2)), ("", (1, 2, 3)), ("a", (1, 2, math.nan))):
        with pytest.raises(errors.InvalidInputError):
            poses[name] = pose
    assert not poses.path.exists()
    anything: Any = Arm
    with pytest.raises(TypeError, match=r"it takes a magician\.Poses"), anything("sim") as arm:
        arm.poses = {}


@pytest.mark.scenario(CELL)
def test_picks_and_places(arm: Arm, virtual_arm: VirtualArm) -> None:
    arm.home()
    arm.tool("suction")
    cube = virtual_arm.object("red cube")
    assert arm.pick((220, 80, -40)).wait().commands == 5
    assert cube.held and arm.pose().z == 0
    tray = Frame.level(200, -80, -40)
    arm.place(tray(10, 0), approach=30, retreat=60)
    assert not cube.held and arm.pose().position == (210, -80, 20, 0)
    assert (cube.position.x, cube.position.y) == pytest.approx((210, -80), abs=0.1)
    before = arm.current_index()
    with pytest.raises(errors.UnreachableError):
        arm.pick((220, 80, -400))
    assert arm.current_index() == before, "not a byte of it was sent"
    with pytest.raises(errors.InvalidInputError, match="tool is 'hand'"):
        arm.pick((220, 80, -40), tool="hand")  # pyright: ignore[reportArgumentType]


def test_grippers_open_first() -> None:
    first, *_, up = picking((220, 0, 0), 0, "gripper", 30, 50)
    assert first == words.release() and up == words.line_to(220, 0, 50, 0)


def test_on_asyncio(tmp_path: Path) -> None:
    async def main() -> None:
        async with aio.Arm.connect("sim") as arm:
            arm.poses = Poses(tmp_path / "cell.json")
            arm.poses["there"] = await arm.pose()
            await arm.pick((220, 0, 0), tool="gripper", wait=False)
            await arm.place("there", hold=0)
            assert (await arm.pose()).z == pytest.approx(arm.poses["there"].z + 40, abs=1e-3)

    asyncio.run(main())

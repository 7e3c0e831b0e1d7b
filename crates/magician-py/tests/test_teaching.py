from __future__ import annotations

import asyncio
from pathlib import Path

import magician
import pytest
from magician import VirtualArm, aio, commands, errors

PLACES = [(0, 20, 30, 0), (30, 30, 40, 0), (-30, 45, 45, 0)]


def test_each_release_of_the_key_adds_a_point(tmp_path: Path) -> None:
    cell = VirtualArm()
    with cell.arm() as arm:
        led: list[tuple[float, ...]] = []
        with arm.teach(by="line", title="pick") as lesson:
            assert lesson.guided
            for joints in PLACES:
                cell.guide(joints)
                led.append(tuple(cell.position))
                point = lesson.wait(10)
                assert tuple(point.position) == pytest.approx(led[-1], abs=0.01)
        assert [point.name for point in lesson.points] == ["P1", "P2", "P3"]
        assert len(lesson) == 3
        plan = lesson.plan()
        assert [(step.action, step.by) for step in plan.steps] == [("move", "line")] * 3
        assert (plan.title, plan.tool) == ("pick", "suction")
        for name in ("pick.plan.json", "pick.playback"):
            lesson.save(tmp_path / name)
            arm.move_to(220, 0, 60)
            arm.run(magician.load(tmp_path / name))
            assert tuple(cell.position) == pytest.approx(led[-1], abs=0.01)


def test_a_point_comes_while_the_program_does_something_else() -> None:
    cell = VirtualArm()
    with cell.arm() as arm, arm.teach() as lesson:
        for nth, joints in enumerate(PLACES):
            cell.guide(joints)
            while len(lesson) == nth:
                pass
        # All points are returned in order, although no call was waiting.
        assert [lesson.wait(10).name for _ in PLACES] == ["P1", "P2", "P3"]


def test_it_is_iterated_until_it_is_closed() -> None:
    cell = VirtualArm()
    names: list[str] = []
    with cell.arm() as arm, arm.teach() as lesson:
        cell.guide(PLACES[0])
        for nth, point in enumerate(lesson, 1):
            names.append(point.name)
            if nth == len(PLACES):
                lesson.close()
            else:
                cell.guide(PLACES[nth])
    assert names == ["P1", "P2", "P3"]


def test_points_are_taken_by_call_with_what_the_tool_does() -> None:
    cell = VirtualArm()
    with cell.arm() as arm, arm.teach(by="jump") as lesson:
        arm.move_to(220, 40, 20)
        above = lesson.point("above")
        assert above.name == "above"
        assert tuple(above.position) == pytest.approx((220, 40, 20, 0), abs=0.01)
        arm.line_to(220, 40, 0)
        lesson.point(suction=True, pause=0.5)
        lesson.point("let go", suction=False)
        lesson.point(gripper="close")
        assert lesson.pop().name == "P4"
        assert [point.name for point in lesson.points] == ["above", "P2", "let go"]
        assert [step.action for step in lesson.plan().steps] == ["move", "move", "suction", "wait", "move", "suction"]
        assert lesson.plan().steps[3].values == (0.5,)
        with pytest.raises(errors.InvalidInputError, match=r'"close", "open" or "off"'):
            lesson.point(gripper="shut")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_the_settings_of_the_arm_are_as_before() -> None:
    cell = VirtualArm()
    with cell.arm() as arm:
        before = arm.get(commands.HhtTrigMode), arm.get(commands.HhtTrigOutputEnabled)
        with pytest.raises(KeyError), arm.teach():
            assert (arm.get(commands.HhtTrigMode), arm.get(commands.HhtTrigOutputEnabled)) != before
            raise KeyError
        assert (arm.get(commands.HhtTrigMode), arm.get(commands.HhtTrigOutputEnabled)) == before


def test_unavailable_points_raise_errors() -> None:
    cell = VirtualArm()
    with cell.arm() as arm:
        lesson = arm.teach()
        assert repr(lesson) == "<Lesson, not begun: 0 points>"
        with pytest.raises(errors.ClosedError, match=r"has not begun"):
            lesson.plan()
        with lesson:
            with pytest.raises(errors.ResponseTimeoutError, match=r"not released within 0\.05 s"):
                lesson.wait(0.05)
            with pytest.raises(IndexError):
                lesson.pop()
        assert repr(lesson) == "<Lesson, ended: 0 points>"
        assert list(lesson) == []
        for call in (lesson.wait, lesson.point, lesson.__enter__):
            with pytest.raises(errors.ClosedError):
                call()
        with pytest.raises(errors.InvalidInputError, match=r'"jump", not "fly"'), arm.teach(by="fly"):  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
            pass


def test_a_connection_that_is_closed_ends_the_wait() -> None:
    arm = VirtualArm().arm()
    with pytest.raises(errors.ClosedError), arm.teach() as lesson:
        arm.close()
        lesson.wait(10)


def test_it_is_the_same_on_asyncio() -> None:
    async def main() -> list[str]:
        cell = VirtualArm()
        names: list[str] = []
        async with aio.Arm.connect(cell) as arm, arm.teach() as lesson:
            cell.guide(PLACES[0])
            async for point in lesson:
                names.append(point.name)
                await lesson.point("here")
                await lesson.close()
        return names + [point.name for point in lesson.points]

    assert asyncio.run(main()) == ["P1", "P1", "here"]

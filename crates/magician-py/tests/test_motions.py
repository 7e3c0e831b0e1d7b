"""Motions that nobody waits for at once."""

from __future__ import annotations

import asyncio
import inspect
import itertools
import re
from collections.abc import Callable, Iterator
from threading import Thread
from typing import Any

import pytest
from magician import Arm, Motion, Plan, Ran, VirtualArm, aio, commands, errors, words

MOVES: list[Callable[[Arm], Any]] = [
    lambda arm: arm.home(wait=False),
    lambda arm: arm.move_to(220, 0, 20, wait=False),
    lambda arm: arm.line_to((220, 0, 20), wait=False),
    lambda arm: arm.jump_to(220, 0, 20, wait=False),
    lambda arm: arm.line_by(dz=1, wait=False),
    lambda arm: arm.move_joints(0, 45, 45, wait=False),
    lambda arm: arm.line_joints(0, 45, 45, wait=False),
    lambda arm: arm.jump_joints(0, 45, 45, wait=False),
    lambda arm: arm.arc_to((250, 10, -8.5, 0), (240, 20, -8.5, 0), wait=False),
    lambda arm: arm.circle((252, 6, -8.5, 0), (245, 0, -8.5, 0), wait=False),
    lambda arm: arm.path_by(dz=1, wait=False),
    lambda arm: arm.rail_by(0, wait=False),
    lambda arm: arm.rail_to(0, wait=False),
    lambda arm: arm.conveyor_by(0, 1, 50, wait=False),
    lambda arm: arm.perform([words.wait(0.1)], wait=False),
    lambda arm: arm.run(Plan.path([(220, 0, 0)]), wait=False),
]

UNSCALED = {
    "path_to": "no command of the controller scales continuous paths",
    "path_by": "no command of the controller scales continuous paths",
    "home": "its speed is set in the controller",
    "conveyor_by": "it takes mm per second",
    "perform": "its commands say their own speeds",
    "run": "its plan says its own speeds",
}
"""Motions without ``speed``, and why."""
WAITS = {
    "wait": "it waits, which is all that it does",
    "wait_for_level": "it waits, which is all that it does",
    "wait_below": "it waits, which is all that it does",
    "wait_at_most": "it waits, which is all that it does",
    "wait_at_least": "it waits, which is all that it does",
    "wait_above": "it waits, which is all that it does",
    "check_lost_steps": "nothing moves",
    "stream": "the caller's thread runs the generator",
}
"""What puts commands into the queue and returns at their end, and why it has no handle."""

LONG = [words.move_to(220, 60, 20, 0), words.wait(600)]


def test_a_motion_goes_on_by_itself(slow: Arm) -> None:
    motion = slow.move_to(220, 40, 20, wait=False)
    assert not motion.done() and repr(motion) == "<Motion, under way>"
    with pytest.raises(errors.ResponseTimeoutError, match=r"under way after 0.01 s"):
        motion.wait(0.01)
    assert motion.wait() == Ran(1, 2, 2) == motion.wait() and motion.done() and repr(motion) == "<Motion, done>"
    assert slow.pose().y == 40
    motion.cancel()
    assert motion.wait(0).commands == 1


def test_motions_go_one_after_the_other(arm: Arm) -> None:
    first = arm.move_to(220, 60, 20, 5, wait=False)
    second = arm.line_to(220, -60, 20, wait=False)
    third = arm.move_joints_by(d1=1, wait=False)
    assert arm.move_by(dz=5).done() and first.done() and second.done() and third.done()
    assert (first.wait().first, second.wait().first, third.wait().first) == (3, 4, 5)
    assert arm.pose().z == 25 and arm.pose().r == pytest.approx(6, abs=1e-3)


@pytest.mark.parametrize("move", MOVES)
def test_every_motion_has_a_handle(arm: Arm, move: Callable[[Arm], Any]) -> None:
    handle = move(arm)
    handle.wait(60)
    assert handle.done()


@pytest.mark.parametrize("interface", [Arm, aio.Arm])
def test_motions_accept_wait_and_speed_unless_excepted(interface: type) -> None:
    source = inspect.getsource(interface)
    bodies = re.findall(r"^    (?:async )?def ([a-z]\w+)\((.*?)(?=^    (?:async )?def |^    @|\Z)", source, re.M | re.S)
    moves = {name for name, body in bodies if re.search(r"self\.(_go|_move|_turn|_arc|start|_feed_from)\(", body)}
    assert {"move_to", "pick", "pick_from_belt", "rail_by", "arc_to", "home", "run", "stream"} <= moves
    parameters = {name: inspect.signature(getattr(interface, name)).parameters for name in moves}
    assert {name for name in moves if "wait" not in parameters[name]} == set(WAITS)
    assert {name for name in moves - set(WAITS) if parameters[name]["wait"].default is not True} == set()
    assert {name for name in moves - set(WAITS) if "speed" not in parameters[name]} == set(UNSCALED)


def test_a_motion_is_cancelled_and_those_behind_it(slow: Arm) -> None:
    motion = slow.perform(LONG, wait=False)
    behind = slow.move_to(200, 0, 0, wait=False)
    motion.cancel()
    for each, why in ((motion, "cancelled"), (behind, "before this one")):
        with pytest.raises(errors.ClosedError, match=why) as caught:
            each.wait()
        assert caught.value.code == "stopped" and each.done() and repr(each) == "<Motion, failed>"
    slow.wait_still()
    assert slow.left_space() == 32
    slow.move_to(slow.pose())


FAR = (220, 60, 20)
AFTER_A_CANCEL: list[Callable[[Arm], Any]] = [
    lambda arm: arm.move_to(220, -20, 20),
    lambda arm: arm.move_to(220, -20, 20, wait=False).wait(),
    lambda arm: arm.move_to(220, -20, 20, speed=50),
    lambda arm: arm.line_to(220, -20, 20),
    lambda arm: arm.line_to(220, -20, 20, wait=False).wait(),
    lambda arm: arm.line_by(dz=-1),
    lambda arm: arm.path_by(dz=-1),
    lambda arm: arm.run(Plan.path([(220, -20, 20), (220, -30, 20)])),
    lambda arm: arm.perform([words.line_to(220, -20, 20)]),
    lambda arm: arm.stream([words.line_to(220, -20, 20)]),
]


def far(y: float) -> bool:
    """Whether the arm was on its way to where a cancelled motion leads, and not there."""
    return y < FAR[1] - 1


@pytest.mark.parametrize("passed", [-60, -50, 0])
@pytest.mark.parametrize("move", AFTER_A_CANCEL)
def test_a_motion_after_a_cancel_waits_for_the_stop(slow: Arm, move: Callable[[Arm], Any], passed: float) -> None:
    slow.move_to(220, -60, 20)
    motion = slow.move_to(*FAR, wait=False)
    behind = slow.move_to(*FAR, 5, wait=False)
    while slow.pose().y <= passed:
        pass
    motion.cancel()
    move(slow)
    assert motion.done() and behind.done() and far(slow.pose().y)


def test_a_wait_for_a_cancelled_motion_ends_once_the_arm_stands(slow: Arm) -> None:
    slow.move_to(220, -60, 20)
    motion = slow.move_to(*FAR, wait=False)
    while slow.pose().y < 0:
        pass
    motion.cancel()
    assert not motion.done()
    with pytest.raises(errors.ClosedError, match="cancelled"):
        motion.wait()
    stands = slow.pose()
    slow.line_to(220, -20, 20)
    assert far(stands.y) and motion.done()


def test_a_job_that_is_cancelled_lets_the_next_motion_go(slow: Arm) -> None:
    slow.move_to(220, -60, 20)
    job = slow.run(Plan.path([FAR]), wait=False)
    while slow.pose().y < 0:
        pass
    job.cancel()
    with pytest.raises(errors.ClosedError):
        job.wait()
    slow.line_to(220, -20, 20)


@pytest.mark.parametrize("waits", [True, False])
def test_a_motion_after_a_cancel_on_asyncio(waits: bool) -> None:
    async def main() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            await arm.move_to(220, -60, 20)
            motion = await arm.move_to(*FAR, wait=False)
            while (await arm.pose()).y < 0:
                pass
            motion.cancel()
            following = await arm.line_to(220, -20, 20, wait=waits)
            await following
            assert motion.done() and far((await arm.pose()).y)
            with pytest.raises(errors.ClosedError, match="cancelled"):
                await motion

    asyncio.run(main())


def test_waiting_motion_is_cancelled_alone(slow: Arm) -> None:
    motion = slow.move_to(220, 20, 20, wait=False)
    behind = slow.move_to(200, 0, 0, wait=False)
    behind.cancel()
    assert motion.wait().commands == 1 and slow.pose().y == 20
    with pytest.raises(errors.ClosedError, match="cancelled"):
        behind.wait()


def test_a_stop_ends_all_of_them(slow: Arm) -> None:
    motions: list[Motion[Ran]] = [slow.perform(LONG, wait=False), slow.move_to(200, 0, 0, wait=False)]
    slow.stop()
    for each in motions:
        with pytest.raises(errors.ClosedError):
            each.wait()
    assert slow.move_to(slow.pose()).done(), "who stopped the arm knows that they ended"


def test_error_of_an_unawaited_motion_is_raised_once(arm: Arm) -> None:
    arm.move_to(400, 0, 0, wait=False)
    with pytest.raises(errors.UnreachableError):
        arm.move_to(220, 0, 20)
    arm.move_to(220, 0, 20)
    told = arm.move_to(400, 0, 0, wait=False)
    for _ in range(2):
        with pytest.raises(errors.UnreachableError) as caught:
            told.wait()
        assert caught.value.unit == "mm"
    assert arm.move_to(220, 0, 20).done()


def test_block_waits_for_running_motions(virtual_arm: VirtualArm) -> None:
    with virtual_arm.arm() as arm:
        arm.move_to(220, 60, 20, wait=False)
        arm.move_to(220, 0, 20, wait=False)
    assert virtual_arm.position == (220, 0, 20, 0)
    with pytest.raises(errors.UnreachableError), virtual_arm.arm() as arm:
        arm.move_to(400, 0, 0, wait=False)


def test_speed_is_for_one_move(virtual_arm: VirtualArm) -> None:
    arm = virtual_arm.arm()
    arm.speed(40, 30)

    def seconds(move: Callable[[], object]) -> float:
        before = virtual_arm.time
        move()
        return virtual_arm.time - before

    arm.line_to(220, 40, 20, 0)
    fast = seconds(lambda: arm.line_to(220, -40, 20, speed=100))
    slow = seconds(lambda: arm.line_to(220, 40, 20, speed=10))
    assert slow > 3 * fast
    assert arm.get(commands.PtpCommonParams) == commands.PtpCommonParams(40, 30)
    with pytest.raises(errors.UnreachableError) as caught:
        arm.line_to(400, 0, 0, speed=10)
    assert caught.value.step == 0
    assert arm.get(commands.PtpCommonParams) == commands.PtpCommonParams(40, 30)
    for wrong in (0, 101, float("nan")):
        with pytest.raises(errors.InvalidInputError, match="speed is"):
            arm.move_by(dz=1, speed=wrong)


def test_an_arc_has_a_speed_of_its_own(virtual_arm: VirtualArm) -> None:
    arm = virtual_arm.arm()
    arm.set(commands.ArcCommonParams(80, 70))
    arm.set(commands.PtpCommonParams(90, 60))

    def seconds(speed: float | None = None) -> float:
        arm.move_to(200, 0, 20, 0)
        before = virtual_arm.time
        arm.arc_to((240, 40, 20, 0), (280, 0, 20, 0), speed=speed)
        return virtual_arm.time - before

    assert seconds(speed=10) > 3 * seconds()
    arm.move_to(200, 0, 20, 0)
    arm.circle((220, 20, 20, 0), (240, 0, 20, 0), speed=50)
    assert arm.get(commands.ArcCommonParams) == commands.ArcCommonParams(80, 70)
    assert arm.get(commands.PtpCommonParams) == commands.PtpCommonParams(90, 60)


def test_speed_is_given_back_by_a_move_that_was_cut_short(slow: Arm) -> None:
    slow.speed(40, 30)
    motion = slow.move_to(220, 60, 20, speed=2, wait=False)
    while slow.get(commands.PtpCommonParams).velocity_ratio != 2:
        pass
    motion.cancel()
    with pytest.raises(errors.ClosedError):
        motion.wait()
    assert slow.get(commands.PtpCommonParams) == commands.PtpCommonParams(40, 30)


def test_a_generator_without_an_end_is_streamed(arm: Arm) -> None:
    taken = 0

    def endless() -> Iterator[commands.Queueable]:
        nonlocal taken
        for nth in itertools.count():
            taken += 1
            yield words.line_to(220, 20 * (nth % 2), 20)
            if arm.current_index() > 41:
                return

    ran = arm.stream(endless(), ahead=5)
    assert ran.commands == taken and 40 < taken <= 40 + 15 and (ran.last or 0) - (ran.first or 0) == taken - 1
    assert arm.stream([]) == Ran(0, None, None)
    with pytest.raises(errors.UnreachableError):
        arm.stream(itertools.repeat(words.line_to(400, 0, 0)))


def test_a_generator_that_fails_stops_the_arm(slow: Arm) -> None:
    def broken() -> Iterator[commands.Queueable]:
        yield from LONG
        raise LookupError("the camera is gone")

    with pytest.raises(LookupError):
        slow.stream(broken(), ahead=2)
    assert slow.left_space() == 32 and not slow.moving


def test_a_wait_that_is_interrupted_stops_the_arm(
    slow: Arm, meanwhile: Callable[[Callable[[], object]], Thread]
) -> None:
    import _thread

    motion = slow.perform(LONG, wait=False)

    def interrupt() -> None:
        while not motion._going._callbacks:  # type: ignore[union-attr]  # pyright: ignore[reportAttributeAccessIssue]
            pass
        _thread.interrupt_main()

    meanwhile(interrupt)
    with pytest.raises(KeyboardInterrupt):
        motion.wait()
    assert motion.done() and slow.left_space() == 32


def test_handles_of_jobs(slow: Arm) -> None:
    job = slow.run(LONG, wait=False)
    with pytest.raises(errors.ResponseTimeoutError, match="goes on"):
        job.wait(0.01)
    assert not job.done()
    job.cancel()
    with pytest.raises(errors.ClosedError, match="stopped"):
        job.wait(30)
    assert job.done()
    anything: Any = slow
    for verb in (anything.run, anything.perform):
        with pytest.raises(errors.InvalidInputError, match="during a wait"):
            verb([words.wait(0)], wait=False, progress=print)


def test_on_asyncio() -> None:
    async def main() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            motion = await arm.move_to(220, 40, 20, wait=False)
            assert not motion.done()
            with pytest.raises(errors.ResponseTimeoutError):
                await motion.wait(0.01)
            assert (await motion).commands == 1
            assert (await arm.pose()).y == 40
            motion = await arm.perform(LONG, wait=False)
            task = asyncio.ensure_future(motion.wait())
            await asyncio.sleep(0)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            assert motion.done() and await arm.left_space() == 32
            job = await arm.run([words.wait(0.01)], wait=False)
            assert (await job).steps == 1
            assert (await arm.stream(words.wait(0) for _ in range(7))).commands == 7

    asyncio.run(main())

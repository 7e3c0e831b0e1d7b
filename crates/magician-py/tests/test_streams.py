"""Generators that the arm follows while they run."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable, Iterator
from math import cos, sin
from threading import Thread
from typing import Any

import pytest
from magician import Arm, VirtualArm, aio, commands, errors, words
from magician.readings import Ran

LONG = [words.line_to(220, y, 20, 0) for y in (60, -60, 60, -60)]


def curve(pieces: int) -> list[commands.Queueable]:
    """A path in short pieces, at a speed that is to be kept."""
    start: list[commands.Queueable] = [words.path_speed(100, 100), words.move_to(255, 0, 20, 0)]
    points = ((225 + 30 * cos(nth / 50), 30 * sin(nth / 50)) for nth in range(1, pieces + 1))
    return start + [words.path_to(x, y, 20) for x, y in points]


def told(program: list[commands.Queueable]) -> Iterator[commands.Queueable]:
    yield from program


def seconds(virtual_arm: VirtualArm, run: Callable[[], object]) -> float:
    """How long it takes by the arm's clock."""
    before = virtual_arm.time
    run()
    return virtual_arm.time - before


def test_the_arm_does_not_stand_between_the_commands_of_a_generator(arm: Arm, virtual_arm: VirtualArm) -> None:
    program = curve(300)
    estimate = arm.estimate(program)
    assert seconds(virtual_arm, lambda: arm.stream(told(program), ahead=40)) == pytest.approx(estimate, abs=1e-5)
    # Sent in pieces, the arm stops at the end of each. At 30 mm/s and 100 mm/s² a ramp takes 0.3 s. Segments rounded
    # to whole periods use up to half of that.
    pieces = [program[at : at + 40] for at in range(0, len(program), 40)]
    stops = len(pieces) - 1
    in_pieces = seconds(virtual_arm, lambda: [arm.perform(piece) for piece in pieces])
    assert in_pieces > estimate + stops * 0.3 / 2


def test_a_few_commands_ahead_do_without_stops_at_the_corners(arm: Arm, virtual_arm: VirtualArm) -> None:
    """A path through many points: with a stop at each it would take thrice as long."""
    program = curve(60)
    arm.perform(program[:2])
    flowing = seconds(virtual_arm, lambda: arm.stream(told(program[2:]), ahead=4))
    arm.perform(program[1:2])
    stopping = seconds(virtual_arm, lambda: [arm.perform([piece]) for piece in program[2:]])
    assert 3 * flowing < stopping


@pytest.mark.parametrize("ahead", [1, 2, 7, 32])
def test_generator_runs_at_most_ahead_commands_ahead(arm: Arm, ahead: int) -> None:
    most = 0
    first = arm.current_index()

    def waits() -> Iterator[commands.Queueable]:
        nonlocal most
        for taken in range(1, 101):
            most = max(most, taken - (arm.current_index() - first))
            yield words.wait(0.05)

    assert arm.stream(waits(), ahead=ahead).commands == 100
    assert most == ahead


def test_a_generator_that_has_nothing_for_now_waits_for_the_arm(arm: Arm, virtual_arm: VirtualArm) -> None:
    first = arm.current_index()
    asked = 0

    def one_by_one() -> Iterator[commands.Queueable | None]:
        nonlocal asked
        for nth in range(5):
            yield words.wait(60)
            while arm.current_index() <= first + nth:
                asked += 1
                yield None

    before = virtual_arm.time
    assert arm.stream(one_by_one()).commands == 5
    assert virtual_arm.time - before == pytest.approx(300, abs=1) and asked < 500


def test_refused_command_is_raised_after_the_earlier_ones(arm: Arm, virtual_arm: VirtualArm) -> None:
    program: list[commands.Queueable] = [words.line_to(220, 40, 20)]
    program += [words.line_to(220, 0, 20), words.line_to(400, 0, 0), words.home()]
    with pytest.raises(errors.UnreachableError) as caught:
        arm.stream(told(program), ahead=2)
    assert caught.value.step == 2
    assert virtual_arm.position[:2] == pytest.approx((220, 0), abs=1e-3)
    with pytest.raises(errors.InvalidInputError, match="r is left out"):
        arm.stream([words.path_to(220, 0, 20), words.line_to(220, 40, 20)])


def test_a_stop_ends_a_stream_and_nothing_is_sent_after_it(slow: Arm) -> None:
    def stopping() -> Iterator[commands.Queueable]:
        yield from LONG
        slow.stop()
        yield from LONG

    before = slow.current_index()
    with pytest.raises(errors.ClosedError):
        slow.stream(stopping())
    assert not slow.moving and slow.left_space() == 32
    assert slow.current_index() <= before + len(LONG)


def test_ctrl_c_in_a_generator_stops_the_arm(slow: Arm) -> None:
    def interrupted() -> Iterator[commands.Queueable]:
        yield from LONG
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        slow.stream(interrupted())
    assert not slow.moving and slow.left_space() == 32


def test_ctrl_c_while_a_generator_is_waited_for_stops_the_arm(
    slow: Arm, meanwhile: Callable[[Callable[[], object]], Thread]
) -> None:
    import _thread

    taken = 0

    def endless() -> Iterator[commands.Queueable]:
        nonlocal taken
        for taken in itertools.count(1):
            yield LONG[taken % 4]

    def interrupt() -> None:
        while taken < 3:
            pass
        _thread.interrupt_main()

    meanwhile(interrupt)
    with pytest.raises(KeyboardInterrupt):
        slow.stream(endless(), ahead=3)
    assert not slow.moving and slow.left_space() == 32


def test_async_generators() -> None:
    async def program(arm: aio.Arm, many: int) -> AsyncIterator[commands.Queueable | None]:
        for nth in range(many):
            yield words.wait(0.01)
            await arm.pose()
            await asyncio.sleep(0)
            if nth % 3 == 0:
                yield None

    async def broken() -> AsyncIterator[commands.Queueable]:
        for command in LONG:
            yield command
        raise LookupError("the camera is gone")

    async def main() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            assert (await arm.stream(program(arm, 12), ahead=4)).commands == 12
            assert await arm.stream(program(arm, 0)) == Ran(0, None, None)
            with pytest.raises(LookupError):
                await arm.stream(broken(), ahead=8)
            assert await arm.left_space() == 32
            endless = (words.wait(1) for _ in itertools.count())
            task = asyncio.ensure_future(arm.stream(endless, ahead=3))
            await asyncio.sleep(0.1)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            assert await arm.left_space() == 32

    asyncio.run(main())


def test_an_async_generator_that_waits_is_ended_with_its_run() -> None:
    ended = False

    async def waits() -> AsyncIterator[commands.Queueable]:
        nonlocal ended
        yield words.wait(10)
        try:
            await asyncio.sleep(1000)
        except asyncio.CancelledError:
            ended = True
            raise

    async def main() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            task = asyncio.ensure_future(arm.stream(waits()))
            while await arm.left_space() == 32 and not arm.moving:
                await asyncio.sleep(0)
            await arm.stop()
            with pytest.raises(errors.ClosedError):
                await task
            assert ended
            # A task that is cancelled itself gets the cancellation.
            task = asyncio.ensure_future(arm.stream(waits()))
            while not arm.moving:
                await asyncio.sleep(0)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task

    asyncio.run(main())


def test_only_programs_are_streamed(arm: Arm) -> None:
    anything: Any = arm
    for wrong in (None, 3, "file.gcode", words.wait(0)):
        with pytest.raises(TypeError):
            anything.stream(wrong)
    with pytest.raises(TypeError):
        anything.stream(["wait"])
    with pytest.raises(errors.InvalidInputError, match="ahead"):
        arm.stream([], ahead=0)

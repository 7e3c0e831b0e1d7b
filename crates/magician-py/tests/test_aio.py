"""The same for asyncio, and what is its own: cancelling."""

from __future__ import annotations

import ast
import asyncio
import contextlib
import subprocess
import sys
from collections.abc import Coroutine
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import aio, commands, errors, events, words

PACKAGE = Path(magician.__file__).parent


def run(test: Coroutine[Any, Any, None]) -> None:
    asyncio.run(asyncio.wait_for(test, 60))


def test_one_interface_twice() -> None:
    tool = Path(__file__).parents[1] / "tools" / "blocking.py"
    subprocess.run([sys.executable, str(tool), "--check"], check=True)

    def names(module: str) -> set[str]:
        tree = ast.parse((PACKAGE / module).read_text(encoding="utf-8"))
        (cls,) = (node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "Arm")
        return {node.name for node in cls.body if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))}

    other = {"__aenter__": "__enter__", "__aexit__": "__exit__", "connect": "__init__"}
    assert {other.get(name, name) for name in names("aio.py")} == names("_blocking.py")


def test_everything_has_a_docstring() -> None:
    for cls in (magician.Arm, aio.Arm, aio.Jog, aio.Run, aio.StateWatch):
        for name, member in vars(cls).items():
            if not name.startswith("_"):
                assert member.__doc__, f"{cls}.{name}"


def test_connecting() -> None:
    async def test() -> None:
        arm = await aio.Arm.connect("sim")
        await arm.home()
        await arm.move_to(220, 60, 20)
        assert (await arm.pose()).position[:3] == (220, 60, 20)
        assert await arm.joints() == (await arm.get(commands.Pose)).joints
        await arm.close()
        with pytest.raises(errors.ClosedError):
            await arm.pose()
        async with aio.Arm.connect("sim") as arm:
            assert (await arm.info()).name
        assert arm.link.state == "closed"
        async with await aio.Arm.connect("sim") as arm:
            assert arm.name == "sim"
        with pytest.raises(errors.InvalidInputError):
            await aio.Arm.connect("nonsense")

    run(test())


def test_programs_and_progress() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim") as arm:
            await arm.home()
            seen: list[magician.Progress] = []
            ran = await arm.perform([words.wait(0.1)] * 3, progress=seen.append)
            assert ran.commands == 3 and seen[-1].sent == 3
            assert (await arm.begin([words.wait(0.1)]).finish()).commands == 1

            def fails(_: magician.Progress) -> None:
                raise KeyError

            with pytest.raises(KeyError):
                await arm.perform([words.wait(0.1)], progress=fails)
            poses = await asyncio.gather(*(arm.pose() for _ in range(100)))
            assert len(set(poses)) == 1

    run(test())


def test_watches() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim") as arm:
            happened = arm.events()
            count = 0
            async for status in arm.state(100):
                count += 1
                assert status.left_space == 32
                if count == 3:
                    break
            await arm.home()
            finished = await asyncio.wait_for(happened.__anext__(), 10)
            assert isinstance(finished, events.CommandFinished | events.AlarmRaised | events.AlarmCleared)
            watch = arm.state(100)
            with pytest.raises(asyncio.TimeoutError):
                await asyncio.wait_for(happened_forever(happened), 0.05)
            await arm.close()
            assert [status async for status in watch] == []

    async def happened_forever(happened: aio.Events) -> None:
        async for _ in happened:
            pass

    run(test())


def test_jog() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            before = await arm.pose()
            async with arm.jog("y-", keep=2) as jog:
                async for status in arm.state(100):
                    jog.keep()
                    if status.pose.y < before.y - 1:
                        break
            assert await arm.pose() == await arm.pose()

    run(test())


async def begun(arm: aio.Arm) -> None:
    """Waits until something is in the queue."""
    async for status in arm.state(200):
        if status.left_space < 32:
            return


def test_cancelling_a_wait_stops_the_arm() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            waiting = asyncio.create_task(arm.wait(3600))
            await begun(arm)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError) as caught:
                await waiting
            assert not getattr(caught.value, "__notes__", None)
            assert not arm.moving and await arm.left_space() == 32
            with pytest.raises(asyncio.TimeoutError):
                await asyncio.wait_for(arm.wait(3600), 0.2)
            assert not arm.moving and await arm.left_space() == 32

    run(test())


def test_a_stop_that_is_cancelled_goes_on() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            waiting = asyncio.create_task(arm.wait(3600))
            await begun(arm)
            waiting.cancel()
            await asyncio.sleep(0)
            waiting.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await waiting
            async for status in arm.state(200):
                if status.left_space == 32:
                    break

    run(test())


def test_a_block_that_fails_stops_the_arm() -> None:
    class Mine(Exception):
        pass

    async def test() -> None:
        arm = await aio.Arm.connect("sim:1")
        with pytest.raises(Mine):
            async with arm:
                await arm.clear_alarms()
                await arm.enqueue(words.wait(3600))
                await arm.start_queue()
                raise Mine
        assert arm.link.state == "closed"

    run(test())


def test_reads_that_are_cancelled_do_no_harm() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim") as arm:
            await arm.home()
            for _ in range(50):
                task = asyncio.create_task(arm.pose())
                await asyncio.sleep(0)
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await task
            assert (await arm.pose()).r == 0
            assert not arm.moving

    run(test())


def test_a_loop_that_is_closed_hears_no_more() -> None:
    async def test() -> aio.Arm:
        arm = await aio.Arm.connect("sim:1")
        await arm.clear_alarms()
        arm._core.get(commands.Pose).listen(lambda: None)  # pyright: ignore[reportPrivateUsage]
        return arm

    arm = asyncio.run(test())

    async def again() -> None:
        assert (await arm.pose()).z is not None
        await arm.close()

    run(again())


def test_cancelled_again_and_again() -> None:
    """Nobody waits for the stop then: it goes on, and the connection ends."""

    async def test() -> None:
        arms: list[aio.Arm] = []

        async def work() -> None:
            async with aio.Arm.connect("sim:1") as arm:
                arms.append(arm)
                await arm.clear_alarms()
                await arm.wait(3600)

        task = asyncio.create_task(work())
        while not arms or not arms[0].moving:
            await asyncio.sleep(0)
        while not task.done():
            task.cancel()
            await asyncio.sleep(0)
        with pytest.raises(errors.ClosedError):
            await arms[0].pose()

    run(test())


def test_a_listener_that_raises_stop_iteration() -> None:
    async def test() -> None:
        async with aio.Arm.connect("sim") as arm:
            await arm.home()
            nothing: list[Any] = []
            with pytest.raises(RuntimeError, match="StopIteration"):
                await arm.perform([words.wait(0.1)], progress=lambda _: next(iter(nothing)))
            assert not arm.moving

    run(test())


def test_a_coroutine_that_is_given_up() -> None:
    """Nobody can wait in it any more; the arm stops."""

    async def test() -> None:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            waiting = arm.wait(3600)
            waiting.send(None)
            async for status in arm.state(200):
                if status.left_space < 32:
                    break
            waiting.close()
            async for status in arm.state(200):
                if status.left_space == 32:
                    break
            await arm.wait_still()
            assert not arm.moving

    run(test())


def test_a_loop_that_is_closed_under_a_call() -> None:
    """Nobody waits for the motion any more: the arm stops."""
    loop = asyncio.new_event_loop()
    started = asyncio.Event()

    async def connect() -> aio.Arm:
        return await aio.Arm.connect("sim:1")

    async def wait(arm: aio.Arm) -> None:
        await arm.clear_alarms()
        await arm.perform([words.wait(3600)], progress=lambda _: started.set())

    arm = loop.run_until_complete(connect())
    waiting = loop.create_task(wait(arm))
    loop.run_until_complete(started.wait())
    loop.close()

    async def see() -> None:
        async for status in arm.state(200):
            if status.left_space == 32:
                break
        await arm.wait_still()
        assert not arm.moving
        await arm.close()

    run(see())
    assert not waiting.done()
    waiting.get_coro().close()


def test_kinematics_are_those_of_the_tool() -> None:
    async def main() -> None:
        async with aio.Arm.connect("sim") as arm:
            for tool in ("gripper", "none"):
                await arm.tool(tool)
                pose = await arm.pose()
                assert await arm.forward(pose.joints) == pytest.approx(pose.position, abs=1e-4)
                assert await arm.inverse(pose) == pytest.approx(pose.joints, abs=1e-4)
                assert await arm.is_reachable(pose)

    asyncio.run(main())

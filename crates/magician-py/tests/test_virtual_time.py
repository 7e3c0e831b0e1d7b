"""Virtual time: a run takes an arm the time of its check, whatever the host does meanwhile, and nothing hangs."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable
from math import cos, sin
from pathlib import Path

import magician
import pytest
from magician import Arm, Plan, VirtualArm, errors, words

Meanwhile = Callable[[Callable[[], object]], threading.Thread]

ARM = "arm = { homed = true }"


def curve(points: int) -> Plan:
    """A path in pieces so short that the arm has to know a full queue of them to keep its speed."""
    turns = (nth * 0.004 for nth in range(points))
    return Plan.path([(230 + 25 * cos(at), 40 * sin(0.77 * at), 30 + 5 * sin(3.1 * at)) for at in turns])


def takes(cell: VirtualArm, arm: Arm, plan: Plan) -> tuple[float, float]:
    """The arm's time that a run takes, and what the check of it said, s."""
    wanted = arm.check(plan).seconds
    before = cell.time
    done = arm.run(plan)
    taken = cell.time - before
    # The arm's clock has a resolution of 1 ms.
    assert done.seconds == pytest.approx(taken, abs=1.1e-3)
    assert wanted is not None
    return taken, wanted


def exactly(seconds: float) -> object:
    return pytest.approx(seconds, abs=2e-6)


def test_a_long_path_takes_the_time_of_its_check() -> None:
    cell = VirtualArm(ARM)
    arm = cell.arm()
    taken, wanted = takes(cell, arm, curve(4000))
    assert taken == exactly(wanted) and taken > 15
    for points in (1, 2, 31, 32, 33, 100):
        taken, wanted = takes(cell, arm, curve(points))
        assert taken == exactly(wanted), points


def test_so_it_does_for_asyncio() -> None:
    cell = VirtualArm(ARM)

    async def main() -> None:
        async with magician.aio.Arm.connect(cell) as arm, magician.aio.Arm.connect(cell) as other:
            wanted = (await arm.check(curve(3000))).seconds
            before = cell.time
            run = asyncio.create_task(arm.run(curve(3000)))
            while not run.done():
                await other.pose()
                await arm.joints()
            await run
            assert cell.time - before == exactly(wanted or 0)

    asyncio.run(asyncio.wait_for(main(), 60))


def test_moves_waits_and_programs_take_their_time() -> None:
    cell = VirtualArm(ARM)
    arm = cell.arm()
    arm.move_to(220, 0, 20)
    before = cell.time
    arm.wait(3600)
    assert cell.time - before == exactly(3600)
    before = cell.time
    arm.perform([words.wait(1.5)] * 100)
    assert cell.time - before == exactly(150)


def test_observers_cost_the_arm_no_time(meanwhile: Meanwhile) -> None:
    """Threads with connections of their own, and watches: each hears its own answers."""
    cell = VirtualArm(ARM)
    arm, others = cell.arm(), [cell.arm() for _ in range(3)]
    over = threading.Event()

    def look(other: Arm) -> Callable[[], None]:
        def looking() -> None:
            while not over.is_set():
                assert 190 < other.pose().x < 260
                assert other.current_index() <= cell.queue_index

        return looking

    def watch() -> None:
        for _ in arm.state(200):
            if over.is_set():
                return

    for other in others:
        meanwhile(look(other))
    meanwhile(watch)
    try:
        taken, wanted = takes(cell, arm, curve(4000))
    finally:
        over.set()
    assert taken == exactly(wanted)


def interrupt_when_it_is_under_way(cell: VirtualArm) -> None:
    while cell.queue_index < 200:
        pass
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="this system sends no signal to a thread")
def test_ctrl_c_in_the_middle_of_a_run(meanwhile: Meanwhile) -> None:
    cell = VirtualArm(ARM)
    arm = cell.arm()
    meanwhile(lambda: interrupt_when_it_is_under_way(cell))
    with pytest.raises(KeyboardInterrupt):
        arm.run(curve(30_000))
    stood = cell.time
    assert not cell.moving and cell.waiting == 0 and 200 <= cell.queue_index < 29_000
    assert arm.pose() == arm.pose() and cell.time == stood
    taken, wanted = takes(cell, arm, curve(100))
    assert taken == exactly(wanted)


def test_a_cancelled_run() -> None:
    cell = VirtualArm(ARM)

    async def main() -> None:
        async with magician.aio.Arm.connect(cell) as arm:
            run = asyncio.create_task(arm.run(curve(30_000)))
            while cell.queue_index < 200:
                await arm.pose()
            run.cancel()
            with pytest.raises(asyncio.CancelledError):
                await run
            assert not cell.moving and cell.waiting == 0

    asyncio.run(asyncio.wait_for(main(), 60))


def test_a_stop_and_an_alarm_end_a_run(meanwhile: Meanwhile) -> None:
    cell = VirtualArm(ARM)
    arm, other = cell.arm(), cell.arm()

    def then(act: Callable[[], object]) -> Callable[[], object]:
        before = cell.queue_index

        def wait() -> None:
            while cell.queue_index < before + 100:
                pass
            act()

        return wait

    for act, error in ((arm.stop, errors.ClosedError), (lambda: cell.raise_alarm(0x20), errors.AlarmError)):
        meanwhile(then(act))
        with pytest.raises(error):
            arm.run(curve(30_000))
        assert not cell.moving
        arm.clear_alarms()
    assert other.left_space() == arm.left_space()


def test_a_run_goes_on_while_its_listener_is_held() -> None:
    """As in a debugger that stops in it."""
    cell = VirtualArm(ARM)
    arm = cell.arm()
    plan = curve(6_000)
    wanted = arm.check(plan).seconds
    before = cell.time
    held: list[float] = []

    def hold(_: magician.PlanProgress) -> None:
        if not held:
            while cell.queue_index < len(plan.commands()):
                pass
            held.append(cell.time - before)

    arm.run(plan, progress=hold)
    assert cell.time - before == exactly(wanted or 0)
    assert held and held[0] == exactly(wanted or 0)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="this system cannot hold a process")
def test_a_process_that_is_held_for_a_while() -> None:
    program = """
        import sys
        sys.path.insert(0, sys.argv[1])
        from test_virtual_time import ARM, curve
        from magician import VirtualArm

        cell = VirtualArm(ARM)
        arm = cell.arm()
        plan = curve(6_000)
        wanted, before = arm.check(plan).seconds, cell.time
        arm.run(plan, progress=lambda _: print("under way", flush=True))
        print(round(cell.time - before - wanted, 5))
    """
    command = [sys.executable, "-c", textwrap.dedent(program), str(Path(__file__).parent)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "under way\n"
        child.send_signal(signal.SIGSTOP)
        os.waitpid(child.pid, os.WUNTRACED)
        child.send_signal(signal.SIGCONT)
        lines = child.stdout.read().splitlines()
    assert child.returncode == 0 and lines[-1] in {"0.0", "-0.0"}


def test_a_pulled_cable_and_late_answers_end() -> None:
    cell = VirtualArm(ARM)
    arm = cell.arm(timeout=0.2)

    def pull(_: object) -> None:
        cell.unplug()

    run = arm.begin(curve(30_000).commands(), patience=0.2)
    with pytest.raises((errors.ResponseTimeoutError, errors.UncertainError)):
        run.finish(progress=pull)
    cell.plug()
    cell.delay_answers(60)
    with pytest.raises(errors.ResponseTimeoutError):
        arm.pose()
    cell.delay_answers(0)


def test_a_jog_waits_for_time_to_pass() -> None:
    """Also after a run, whose time was the arm's alone."""
    cell = VirtualArm(ARM)
    arm = cell.arm()
    takes(cell, arm, curve(1000))
    arm.move_to(220, 0, 20)
    with arm.jog("y+", keep=2):
        y = cell.position.y
        cell.advance(0.5)
        assert cell.position.y > y + 1


@pytest.mark.parametrize(
    ("name", "kind"), [("house.svg", "pen"), ("rabbit.svg", "pen"), ("laser_checker.gcode", "laser")]
)
def test_a_drawing_is_that_of_the_rehearsal(samples: Path, name: str, kind: str) -> None:
    plan = magician.load(samples / name, surface=-60)
    rehearsed = plan.rehearse()
    cell = VirtualArm(f'{ARM}\ntool = {{ kind = "{kind}" }}\ntable = {{ height = -60 }}')
    arm = cell.arm()
    arm.tool("pen" if kind == "pen" else "laser")
    done = arm.run(plan)
    assert done.seconds == pytest.approx(rehearsed.seconds, abs=1.1e-3)
    assert list(cell.drawing) == list(rehearsed.drawing) and len(cell.drawing) > 0

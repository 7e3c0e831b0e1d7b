"""Ctrl-C, threads, forks, the log, and the end of the interpreter."""

from __future__ import annotations

import _thread
import contextlib
import logging
import os
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable, Iterator
from typing import Any

import magician
import pytest
from magician import Arm, VirtualArm, commands, errors, words


@pytest.fixture(autouse=True)
def hears_interrupts() -> Iterator[None]:
    """As in a terminal: whoever was started in the background of a shell hears none."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


Meanwhile = Callable[[Callable[[], object]], threading.Thread]


def interrupt_when_it_waits(arm: Arm) -> None:
    for status in arm.state(200):
        if status.left_space < 32:
            break
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()


def test_ctrl_c_stops_the_arm(slow: Arm, meanwhile: Meanwhile) -> None:
    meanwhile(lambda: interrupt_when_it_waits(slow))
    with pytest.raises(KeyboardInterrupt) as caught:
        slow.wait(3600)
    assert not getattr(caught.value, "__notes__", None)
    assert not slow.moving and slow.left_space() == 32


def test_ctrl_c_in_the_middle_of_a_move(slow: Arm, meanwhile: Meanwhile) -> None:
    slow.speed(5)
    meanwhile(lambda: interrupt_when_it_waits(slow))
    with pytest.raises(KeyboardInterrupt):
        slow.move_to(200, 150, 50)
    assert slow.pose() == slow.pose() and slow.pose().y < 149


def never_moves(arm: Arm) -> bool:
    """Whether the arm stands, and has nothing to do."""
    return not arm.moving and arm.left_space() == 32 and arm.pose() == arm.pose()


def test_ctrl_c_before_the_first_byte(slow: Arm) -> None:
    """An interrupt that is heard while commands are made ready: nothing begins."""
    before = slow.pose()

    class Last:
        """A command, and somebody who presses Ctrl-C while it is read."""

        ID, LAYOUT = commands.WaitCmd.ID, commands.WaitCmd.LAYOUT

        @property
        def timeout(self) -> int:
            _thread.interrupt_main()
            return 0

    program: list[Any] = [words.line_by(dy=40), words.line_by(dy=-40)] * 50
    program.append(Last())
    with pytest.raises(KeyboardInterrupt):
        slow.perform(program)
    slow.wait_still()
    assert never_moves(slow) and slow.pose() == before


def test_a_stop_during_the_check_counts(slow: Arm) -> None:
    """Whatever is asked of the arm before a stop is over with it, also while it is still being checked."""
    core = slow._core  # pyright: ignore[reportPrivateUsage]
    plan = magician.Plan.path([(210, nth, 20) for nth in range(20)])
    how: dict[str, Any] = dict.fromkeys(["check", "keep", "require_homed", "unhomed", "allow_laser", "resume"], False)
    how |= {"stay": False, "park": None, "lift": None, "overlap": 0}
    job = core.start(plan.native, how | {"first_step": 1, "restore": True})
    running, over = job.outcome(), job.over()
    for call in (core.perform([words.line_by(dy=40)], [], False, False, False), running):
        slow.stop()
        with pytest.raises(errors.ClosedError):
            call.wait()
    over.wait()
    # The check may have ended by then or not; the first point is seconds away.
    assert never_moves(slow) and slow.pose().x > 211


def test_dropped_calls_stop_the_arm(slow: Arm) -> None:
    """Before anybody in Python has done so."""
    core = slow._core  # pyright: ignore[reportPrivateUsage]
    call = core.perform([words.wait(3600)], [], False, False, False)
    assert not call.over() and slow.left_space() == 32
    call.listen(lambda: None)
    for status in slow.state(200):
        if status.left_space < 32:
            break
    del call
    for status in slow.state(200):
        if status.left_space == 32:
            break
    slow.wait_still()
    assert not slow.moving


def test_an_interrupted_farewell_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever presses Ctrl-C while a ``with`` block stops the arm has the connection end all the same."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("magician._blocking.wait_stopped", interrupted)
    arm = magician.Arm("sim:1")
    with pytest.raises(KeyboardInterrupt), arm:
        raise ValueError
    assert arm.link.state == "closed"


def test_an_interrupt_whose_stop_fails_says_so(slow: Arm, meanwhile: Meanwhile) -> None:
    """The connection goes away under the call: nobody can say that the arm stands."""

    def handler(*_: object) -> None:
        other.close()
        raise KeyboardInterrupt

    other = slow
    before = signal.signal(signal.SIGINT, handler)
    try:
        meanwhile(lambda: interrupt_when_it_waits(slow))
        with pytest.raises((KeyboardInterrupt, errors.ClosedError)) as caught:
            slow.wait(3600)
    finally:
        signal.signal(signal.SIGINT, before)
    if isinstance(caught.value, KeyboardInterrupt) and sys.version_info >= (3, 11):
        (note,) = caught.value.__notes__
        assert "has not confirmed it" in note and "closed" in note


def test_second_interrupt_still_stops_the_arm(slow: Arm, meanwhile: Meanwhile) -> None:
    """A second Ctrl-C ends the waiting for the stop, not the stop."""
    calls: list[int] = []

    def handler(number: int, _: object) -> None:
        calls.append(number)
        if len(calls) == 1:
            signal.raise_signal(signal.SIGINT)  # handled while waiting for the stop
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, handler)
    try:
        meanwhile(lambda: interrupt_when_it_waits(slow))
        with pytest.raises(KeyboardInterrupt):
            slow.wait(3600)
    finally:
        signal.signal(signal.SIGINT, before)
    assert calls
    for status in slow.state(200):
        if status.left_space == 32:
            break


def test_handlers_that_return_interrupt_nothing(slow: Arm, meanwhile: Meanwhile) -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        meanwhile(lambda: interrupt_when_it_waits(slow))
        slow.wait(0.5)
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.SIGINT]


def test_threads(arm: Arm, meanwhile: Meanwhile) -> None:
    results: list[int] = []

    def work() -> None:
        for _ in range(50):
            results.append(arm.enqueue(words.wait(0)))
            assert arm.pose().r == 0

    for thread in [meanwhile(work) for _ in range(8)]:
        thread.join(30)
    assert len(set(results)) == 400 == max(results) - min(results) + 1


def test_the_interpreter_is_free_while_a_thread_waits(slow: Arm, meanwhile: Meanwhile) -> None:
    ended = threading.Event()

    def wait() -> None:
        with pytest.raises(errors.ClosedError):
            slow.wait(3600)
        ended.set()

    meanwhile(wait)
    for status in slow.state(200):
        if status.left_space < 32:
            break
    slow.stop()
    assert ended.wait(30)


def test_the_log(caplog: pytest.LogCaptureFixture) -> None:
    heard = threading.Event()

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            heard.set()

    handler = Handler(logging.WARNING)
    logger = logging.getLogger("magician")
    logger.addHandler(handler)
    try:
        cell = VirtualArm()
        with cell.arm() as arm, caplog.at_level(logging.WARNING, "magician"):
            arm.perform([words.wait(0)])  # The warning about the missing homing does not matter here.
            cell.reset()
            with contextlib.suppress(errors.Error):
                arm.perform([words.wait(0)])
            assert heard.wait(30)
    finally:
        logger.removeHandler(handler)
    assert "home it" not in caplog.text and "off and on, or reset" in caplog.text
    assert caplog.records[0].levelno == logging.WARNING


def python(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs a program in an interpreter of its own."""
    return subprocess.run(
        [sys.executable, "-X", "faulthandler", *arguments, "-c", textwrap.dedent(program)],
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.mark.parametrize(
    "ending",
    [
        "",
        "del arm",
        "arm.close()",
        "sys.exit(0)",
        "threading.Thread(target=waiting, daemon=True).start(); next(arm.state(10))",
        "threading.Thread(target=forever, daemon=True).start(); next(arm.state(10))",
        "watch = arm.state(1000); happened = arm.events(); jog = arm.jog('x+', keep=2).__enter__()",
        "arms = [magician.Arm('sim') for _ in range(5)]",
        "asyncio.run(forgotten())",
        "arm.raw(10); import gc; gc.disable(); arm.itself = arm",
    ],
)
def test_the_end_of_the_interpreter(ending: str) -> None:
    done = python(
        f"""
        import asyncio, contextlib, sys, threading
        import magician

        async def forgotten():
            arm = await magician.aio.Arm.connect("sim:1")
            asyncio.create_task(arm.wait(3600))
            await arm.pose()

        def waiting():
            with contextlib.suppress(magician.errors.ClosedError):
                arm.wait(3600)

        def forever():
            while True:
                with contextlib.suppress(magician.errors.ClosedError):
                    arm.pose()

        arm = magician.Arm("sim:1")
        arm.clear_alarms()
        {ending}
        """
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert "Traceback" not in done.stderr or "CancelledError" in done.stderr, done.stderr


def test_an_open_arm_is_stopped_at_the_end() -> None:
    """The last thing that another program sees of a forgotten connection is its stop."""
    done = python(
        """
        import atexit, magician
        from magician import words

        def look():
            # Runs after the package's own ending: what was registered first runs last.
            print(arm.link.state)

        atexit._clear()
        atexit.register(look)
        from magician import _native
        atexit.register(_native._end)
        arm = magician.Arm("sim:1")
        arm.clear_alarms()
        arm.enqueue(words.wait(3600))
        arm.start_queue()
        """
    )
    assert (done.returncode, done.stdout) == (0, "closed\n"), done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_forks() -> None:
    done = python(
        """
        import os, sys
        import magician

        with magician.Arm("sim") as arm:
            watch = arm.state(100)
            watch.changed()
            child = os.fork()
            if child == 0:
                try:
                    arm.pose()
                except magician.errors.ClosedError as error:
                    print(error, flush=True)
                print(arm, flush=True)
                arm.close()
                with magician.Arm("sim") as own:
                    print(own.pose().r, own.link.state, flush=True)
                del arm, watch
                sys.exit(3)
            _, status = os.waitpid(child, 0)
            print(os.waitstatus_to_exitcode(status), arm.link.state)
            arm.home()
        """,
        "-W",
        "ignore::DeprecationWarning",
    )
    assert done.returncode == 0, done.stderr
    error, arm, own, parent = done.stdout.splitlines()
    assert "forked" in error and "connect again" in error
    assert (arm, own, parent) == ("<Arm of another process>", "0.0 up", "3 up")


def test_subinterpreters_are_refused() -> None:
    done = python(
        """
        try:
            import _xxsubinterpreters as interpreters
        except ImportError:
            import _interpreters as interpreters
        import magician
        other = interpreters.create()
        problem = interpreters.run_string(other, '''
        try:
            import magician
        except ImportError as error:
            print(f"refused: {error}", flush=True)
        '''.replace("        ", ""))
        assert problem is None, problem
        with magician.Arm("sim") as arm:
            print(arm.pose().r)
        """
    )
    assert done.returncode == 0, done.stderr
    refused, pose = done.stdout.splitlines()
    assert refused.startswith("refused: ") and pose == "0.0"


def test_dangling_calls_can_be_dropped(arm: Arm) -> None:
    core = arm._core  # pyright: ignore[reportPrivateUsage]
    for _ in range(100):
        core.get(commands.Pose)
    call = core.get(commands.Pose)
    assert call.wait() == arm.pose()
    with pytest.raises(RuntimeError, match="taken"):
        call.wait()
    assert call.over() and call.report() is None
    assert isinstance(magician.Arm, type)

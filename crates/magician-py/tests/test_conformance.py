from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

import magician
import pytest
from conftest import in_notebook
from magician import aio, errors
from magician._native import until_with_cleanup, wait_with_cleanup
from magician.conformance import CaseProgress, CaseResult, Conformance, Mismatch


def test_a_virtual_arm_conforms() -> None:
    found = magician.conform("sim", only=["queue", "framing"])
    assert found.ok
    assert len(found.passed) > 20 and not found.failed and not found.skipped
    assert {each.chapter for each in found.results} == {"queue", "framing"}
    assert str(found).startswith(f"0 failed, {len(found.passed)} passed")
    fewer = magician.conform("sim", only=["queue"], skip=["moves"])
    assert 0 < len(fewer.results) < len(found.results)
    assert all("moves" not in each.tags for each in fewer.results)


def test_progress_is_reported_after_each_case(capsys: pytest.CaptureFixture[str]) -> None:
    heard: list[CaseProgress] = []
    found = magician.conform("sim", only=["queue"], progress=heard.append)
    assert [each.result for each in heard] == list(found.results)
    assert [each.done for each in heard] == list(range(1, len(found.results) + 1))
    assert {(each.cases, each.failed) for each in heard} == {(len(found.results), 0)}
    assert heard[-1].share == 1 and str(heard[-1]).endswith("100 %")
    assert str(CaseProgress(1, 4, 1, found.results[0])) == "case 1 of 4, 25 %, 1 failed"
    assert magician.conform("sim", only=["framing"], progress=True).ok
    assert "Conformance: 0 failed" in capsys.readouterr().err
    with pytest.raises(TypeError, match="progress is 5"):
        magician.conform("sim", progress=5)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_exception_of_the_listener_ends_the_run() -> None:
    heard: list[CaseProgress] = []

    def refuses(progress: CaseProgress) -> None:
        heard.append(progress)
        raise ZeroDivisionError(progress.result.case)

    with magician.sim(tcp="127.0.0.1:0", speed="max") as served:
        with pytest.raises(ZeroDivisionError, match=r"queue\."):
            magician.conform(served.tcp, only=["queue"], allow_motion=True, progress=refuses)
        assert len(heard) == 1
        # The port is free and the arm is unchanged.
        assert magician.conform(served.tcp, only=["framing"], skip=["moves"]).ok


def test_on_asyncio() -> None:
    async def main() -> None:
        heard: list[CaseProgress] = []
        found = await aio.conform("sim", only=["queue"], progress=heard.append)
        assert found.ok and [each.result for each in heard] == list(found.results)
        with magician.sim(tcp="127.0.0.1:0", speed=1) as served:
            begun = asyncio.Event()
            running = asyncio.ensure_future(aio.conform(served.tcp, allow_motion=True, progress=lambda _: begun.set()))
            await begun.wait()
            running.cancel()
            with pytest.raises(asyncio.CancelledError):
                await running
            async with aio.Arm.connect(served.tcp) as arm:
                assert await arm.left_space() == 32

    asyncio.run(main())


def test_an_arm_at_a_line_is_held_against_them_too() -> None:
    with magician.sim(tcp="127.0.0.1:0", speed="max") as served:
        found = magician.conform(served.tcp, only=["framing"], skip=["moves"])
    assert found.ok
    assert found.passed


def test_an_arm_that_is_not_in_the_program_moves_only_if_it_may() -> None:
    with magician.sim(tcp="127.0.0.1:0", speed="max") as served:
        with pytest.raises(errors.InvalidInputError, match=r"would move in \d+ cases.* allow_motion=True"):
            magician.conform(served.tcp)
        with magician.Arm(served.tcp) as arm:
            # Nothing was sent: the index is that at power-up.
            assert arm.current_index() == 0
        one = magician.conform(served.tcp, only=["ptp.movl-100-mm"], allow_motion=True)
        assert len(one.results) == 1


def test_invalid_arguments_are_refused() -> None:
    with pytest.raises(errors.InvalidInputError, match='no case matches "quue"'):
        magician.conform("sim", only=["quue"])
    with pytest.raises(errors.InvalidInputError, match='give "sim"'):
        magician.conform("sim:1")
    with pytest.raises(TypeError, match="only is 'queue'"):
        magician.conform("sim", only="queue")
    with pytest.raises(errors.PortError):
        magician.conform("/dev/there-is-no-such-port", skip=["moves"])


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_ends_it() -> None:
    timer = threading.Thread(target=lambda: os.kill(os.getpid(), signal.SIGINT))
    with magician.sim(tcp="127.0.0.1:0", speed=1) as served:
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            magician.conform(served.tcp, allow_motion=True)
        timer.join()
        with magician.Arm(served.tcp) as arm:
            assert arm.left_space() == 32


class Leaving:
    """What is left in order: over when it was waited for twice, interrupted the first time."""

    waited = 0

    def over(self) -> bool:
        return self.waited == 2

    def taken(self) -> bool:
        return False

    def report(self) -> None:
        return None

    def result(self) -> None:
        return None

    def cancel(self) -> None:
        raise AssertionError

    def wait(self, listener: object = None) -> None:
        self.waited += 1
        if self.waited == 1:
            raise KeyboardInterrupt

    def listen(self, tell: Callable[[], object]) -> None:
        self.waited = 2
        tell()


class Breaking(Leaving):
    """What a listener ends."""

    def wait(self, listener: object = None) -> None:
        raise ZeroDivisionError

    def report(self) -> Any:
        return [()]

    def cancel(self) -> None:
        pass


class Telling(Leaving):
    """A run of two cases, the first of which fails."""

    def wait(self, listener: Any = None) -> None:
        about = ("a.b", "a", "t", "model 1", "M", ())
        listener([(about, "failed", None, (7, "get Pose", b"", "x=1", "x=2", b""))])
        listener([(about, "passed", None, None)])


def test_progress_counts_failed_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    def begins(*_: object) -> object:
        return Telling(), 2, Leaving()

    monkeypatch.setattr("magician.conformance._magician.conform", begins)
    heard: list[CaseProgress] = []
    found = magician.conform("sim", progress=heard.append)
    assert [(each.done, each.failed, each.result.outcome) for each in heard] == [(1, 1, "failed"), (2, 1, "passed")]
    assert not found.ok and found.failed[0].failure is not None and found.failed[0].failure.line == 7


def refuses(found: object) -> None:
    raise ZeroDivisionError


def test_early_end_is_raised_after_the_arm_was_restored() -> None:
    call: Any = Breaking()
    cleanup: Any = Leaving()
    with pytest.raises(ZeroDivisionError):
        wait_with_cleanup(call, cleanup, refuses)
    assert cleanup.waited == 2
    cleanup = Leaving()
    with pytest.raises(ZeroDivisionError):
        asyncio.run(until_with_cleanup(call, cleanup, refuses))
    assert cleanup.waited == 2


def test_a_failure_says_where() -> None:
    mismatch = Mismatch(7, "get Pose -> x=1", b"\xaa", "x=1", "x=2", b"\xbb")
    result = CaseResult("a.b", "a", "t", "model 1", "M", (), "failed", None, mismatch)
    assert str(result) == "failed: a.b: get Pose -> x=1: expected x=1, got x=2"


def test_notebook_shows_failed_cases() -> None:
    mismatch = Mismatch(7, "get Pose -> x=1", b"\xaa", "x<1", "x=2", b"\xbb")
    found = Conformance(
        (
            CaseResult("a.b", "a", "t", "model 1", "M", (), "failed", None, mismatch),
            CaseResult("a.c", "a", "t", "model 1", "M", (), "passed", None, None),
        )
    )
    assert repr(found) == "<Conformance: 1 failed, 1 passed, 0 skipped>"
    shown = in_notebook(found, "html")
    assert "<td>a.b</td>" in shown and "x&lt;1" in shown and "a.c" not in shown
    assert "table" not in in_notebook(Conformance(found.passed), "html")

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
import threading
from pathlib import Path

import magician
import pytest
from magician import aio, errors

ANY = "127.0.0.1:0"


def finding(found: magician.Diagnosis, check: str) -> magician.Finding:
    return next(each for each in found.findings if each.check == check)


def test_a_virtual_arm_is_looked_over() -> None:
    heard: list[magician.Finding] = []
    found = magician.doctor("sim", count=5, on_finding=heard.append)
    assert found.ok and found.error is None and not found.failed
    assert (found.port, found.window) == ("sim", 8)
    assert found.turnaround is not None
    assert found.turnaround * 1000 == pytest.approx(finding(found, "turnaround").value, abs=1e-3)
    assert heard == list(found.findings)
    assert finding(found, "answer").value == "3.6.14"
    identity = finding(found, "identity").value
    assert identity["firmware"] == "3.6.14"
    assert set(identity) == {"name", "serial_number", "firmware", "uptime_s"}
    homed = finding(found, "homed")
    assert homed.ok is None
    assert homed.advice is not None and homed.advice.startswith("`arm.home()` corrects")
    tried = finding(found, "index_law")
    assert tried.ok is None and "try_queue=True" in str(tried.advice)
    assert str(found).splitlines()[0] == "✓ line: it opens"


def test_nothing_moves_and_the_queue_is_tried_when_asked() -> None:
    cell = magician.VirtualArm()
    with cell.serve(tcp=ANY) as served:
        before = cell.position
        found = magician.doctor(served.tcp, count=5)
        assert finding(found, "queue").value == 0
        assert (cell.queue_index, cell.waiting) == (0, 0)
        found = magician.doctor(served.tcp, count=5, try_queue=True)
        assert found.ok
        assert finding(found, "index_law").value == 15
        assert finding(found, "left_space").ok
        window = finding(found, "window")
        assert (window.value, window.advice) == (8, "window=8 uses it")
        assert (cell.waiting, cell.position) == (0, before)


def test_active_alarm_is_a_finding_with_advice() -> None:
    cell = magician.VirtualArm()
    with cell.serve(tcp=ANY) as served:
        cell.raise_alarm(0x20)
        found = magician.doctor(served.tcp, count=2)
    alarms = [each for each in found.findings if each.check == "alarms"]
    assert 0x20 in [each.value for each in alarms]
    # Clearing alarm 0x00 would not home the arm, so homing is the advice.
    cures = {0x00: "`arm.home()`", 0x20: "`arm.clear_alarms()`"}
    assert all(cures[each.value] in str(each.advice) for each in alarms)
    assert not any("magician alarms" in str(each) for each in found.findings)


def test_no_arm_is_a_finding() -> None:
    found = magician.doctor("/dev/no-such-arm")
    assert not found.ok
    assert isinstance(found.error, errors.PortError)
    line = finding(found, "line")
    assert line.ok is False and "does not exist" in line.text
    assert "does not exist" in str(found)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        found = magician.doctor(f"tcp:127.0.0.1:{silent.getsockname()[1]}", timeout=0.1)
    assert isinstance(found.error, errors.ResponseTimeoutError)
    assert [each.check for each in found.failed] == ["answer"]
    assert found.failed[0].advice is not None
    assert str(found).count("no reply") == 1


def test_diagnosis_that_ended_early_is_not_ok() -> None:
    error = errors.PortError("the line was lost")
    found = magician.Diagnosis((), None, None, None, error)
    assert not found.ok and not found.failed and str(found) == "✗ the line was lost"
    bad = magician.Finding("line", False, None, None, "the line was lost", "look for the cable")
    unknown = magician.Finding("left_space", None, None, None, "not looked at", None)
    found = magician.Diagnosis((unknown, bad), "sim", 1, None, error)
    assert str(found) == "- left space: not looked at\n✗ line: the line was lost\n  → look for the cable"
    assert found.failed == (bad,)
    assert not magician.Diagnosis((unknown, bad), "sim", 1, None, None).ok
    assert magician.Diagnosis((unknown,), "sim", 1, None, None).ok


def test_arguments_reach_the_examination(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    class Taken(Exception):
        pass

    def takes(*what: object) -> None:
        asked.append(what)
        raise Taken

    monkeypatch.setattr("magician.diagnosis._magician.doctor", takes)
    with pytest.raises(Taken):
        magician.doctor()
    with pytest.raises(Taken):
        magician.doctor("COM3", count=7, timeout=0.25, try_queue=True)
    assert asked == [(None, 200, 3.0, False), ("COM3", 7, 0.25, True)]


def test_invalid_arguments_are_refused() -> None:
    with pytest.raises(errors.InvalidInputError):
        magician.doctor("nonsense")
    with pytest.raises(errors.InvalidInputError, match="count is 0"):
        magician.doctor("sim", count=0)
    with pytest.raises(TypeError, match="on_finding"):
        magician.doctor("sim", on_finding=5)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_on_asyncio() -> None:
    async def main() -> None:
        heard: list[magician.Finding] = []
        found = await aio.doctor("sim", count=5, on_finding=heard.append)
        assert found.ok and heard == list(found.findings) and found.window == 8

        def cancels(found: magician.Finding) -> None:
            if found.check == "identity":
                running.cancel()

        cell = magician.VirtualArm()
        with cell.serve(tcp=ANY) as served:
            running = asyncio.ensure_future(aio.doctor(served.tcp, count=100_000, try_queue=True, on_finding=cancels))
            with pytest.raises(asyncio.CancelledError):
                await running
            assert cell.waiting == 0
        with pytest.raises(errors.InvalidInputError):
            await aio.doctor("nonsense")

    asyncio.run(main())


def test_exception_of_the_listener_ends_the_diagnosis() -> None:
    def refuses(found: magician.Finding) -> None:
        raise ZeroDivisionError(found.check)

    with pytest.raises(ZeroDivisionError, match="line"):
        magician.doctor("sim", count=100_000, on_finding=refuses)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_ends_it(tmp_path: Path) -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    cell = magician.VirtualArm()
    try:
        with cell.serve(pty=tmp_path / "arm") as served:

            def interrupts(found: magician.Finding) -> None:
                if found.check == "identity":
                    threading.Thread(target=lambda: os.kill(os.getpid(), signal.SIGINT)).start()

            with pytest.raises(KeyboardInterrupt):
                magician.doctor(served.pty, count=100_000, try_queue=True, on_finding=interrupts)
            assert cell.waiting == 0
    finally:
        signal.signal(signal.SIGINT, before)

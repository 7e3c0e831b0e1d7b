"""Runs: results, progress, refusals, interruptions."""

from __future__ import annotations

import _thread
import asyncio
import io
import os
import signal
import threading
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import Plan, PlanProgress, VirtualArm, commands, words
from magician._progress import ProgressLine
from magician.errors import InvalidInputError, UnreachableError

HOUSE = Path(__file__).parents[2] / "magician-program" / "samples" / "house.svg"
BACK_AND_FORTH = [(220, y, 20) for _ in range(30) for y in (-100, 100)]


def notes(error: BaseException) -> str:
    return "\n".join(getattr(error, "__notes__", []))


def test_run_returns_steps_commands_and_indices(arm: magician.Arm, virtual_arm: VirtualArm) -> None:
    plan = magician.load(HOUSE)
    told: list[PlanProgress] = []
    result = arm.run(plan, progress=told.append)
    assert (result.steps, result.commands) == (len(plan), len(plan) + 1)
    assert (result.first_index, result.last_index) == (2, len(plan) + 2)
    assert result.report.ok and 20 < result.seconds < 60
    assert told[-1] == PlanProgress(len(plan), len(plan), 0.0) and told[-1].share == 1
    assert [each.done for each in told] == sorted(each.done for each in told)
    assert virtual_arm.queue_index == len(plan) + 2


def test_settings_are_given_back(arm: magician.Arm) -> None:
    before = arm.run([words.wait(0.001)]).report
    speeds = [arm.get(each) for each in (commands.PtpCoordinateParams, commands.CpParams)]
    arm.run(magician.load(HOUSE))
    assert [arm.get(each) for each in (commands.PtpCoordinateParams, commands.CpParams)] == speeds
    arm.run(magician.load(HOUSE), restore=False)
    assert [arm.get(each) for each in (commands.PtpCoordinateParams, commands.CpParams)] != speeds
    assert before.ok


def test_impossible_plan_is_refused_before_any_motion(arm: magician.Arm, virtual_arm: VirtualArm) -> None:
    plan = Plan.path([(220, 0, 20), (220, 50, 20), (500, 0, 20)], by="line")
    with pytest.raises(UnreachableError, match=r"row 2, step 3: .*; 1 step is refused, nothing was sent") as caught:
        arm.run(plan)
    assert caught.value.value is not None and caught.value.limit is not None
    assert virtual_arm.queue_index == 0 and virtual_arm.time == 0


def test_a_check_begins_where_the_arm_stands(arm: magician.Arm) -> None:
    plan = Plan.of([words.line_by(60, 0, 0, 0)])
    assert arm.check(plan).ok
    arm.run(Plan.path([(300, 0, 20)], by="joints"))
    assert not arm.check(plan).ok
    assert arm.preview(plan).svg.startswith("<svg")


def test_a_run_goes_on_at_a_step(arm: magician.Arm, virtual_arm: VirtualArm) -> None:
    plan = Plan.path([(220, 0, 20), (220, 50, 20), (240, 50, 20)], by="line")
    arm.run(plan, first_step=3)
    assert virtual_arm.position[:3] == pytest.approx((240, 50, 20), abs=1e-3)
    with pytest.raises(InvalidInputError, match="first_step is"):
        arm.run(plan, first_step=0)
    with pytest.raises(InvalidInputError, match="first_step is"):
        arm.run(plan, first_step=-1)
    with pytest.raises(InvalidInputError, match="first_step is 4"):
        arm.run(plan, first_step=4)


def test_a_step_that_is_refused_has_its_number_in_the_whole(arm: magician.Arm, virtual_arm: VirtualArm) -> None:
    plan = Plan.path([(220, 0, 20), (220, 50, 20), (240, 50, 20), (500, 50, 20)], by="line")
    for first in (1, 3):
        with pytest.raises(UnreachableError, match="step 4"):
            arm.run(plan, first_step=first)
    assert virtual_arm.waiting == 0


def test_ctrl_c_stops_the_arm() -> None:
    cell = VirtualArm(speed=5.0)
    arm = cell.arm()

    def interrupt(progress: PlanProgress) -> None:
        if progress.done >= 2:
            _thread.interrupt_main()

    with pytest.raises(KeyboardInterrupt) as caught:
        arm.run(Plan.path(BACK_AND_FORTH, by="line"), progress=interrupt)
    assert not cell.moving and cell.waiting == 0
    assert "of 60 steps are done; first_step=" in notes(caught.value)
    # The arm accepts the next program.
    assert arm.run(Plan.path([(220, 0, 20)], by="line")).steps == 1


def drawing(cell: VirtualArm) -> tuple[magician.Arm, Plan]:
    """An arm at its own speed, and a drawing for it."""
    arm = cell.arm()
    arm.clear_alarms()
    return arm, magician.load(HOUSE, surface=-60)


def test_ctrl_c_lifts_the_pen_of_a_drawing() -> None:
    endings: list[tuple[dict[str, Any], float]] = [({"lift": 20.0}, 20.0), ({"stay": True}, 0.0)]
    for more, up in endings:
        cell = VirtualArm(speed=5.0)
        arm, plan = drawing(cell)
        interrupted: list[float] = []

        def interrupt(progress: PlanProgress, cell: VirtualArm = cell, interrupted: list[float] = interrupted) -> None:
            if progress.done >= 6 and cell.position[2] < -59.9 and not interrupted:
                interrupted.append(cell.position[2])
                _thread.interrupt_main()

        with pytest.raises(KeyboardInterrupt) as caught:
            arm.run(plan, progress=interrupt, **more)
        assert not cell.moving and cell.waiting == 0
        assert cell.position[2] == pytest.approx(-60 + up, abs=0.1)
        assert ("the pen is up by 20.0 mm" in notes(caught.value)) == (up > 0)


def test_interrupts_in_quick_succession_lift_the_pen_and_restore_settings() -> None:
    """A shell forwards the Ctrl-C that the terminal has sent already: that is nobody who wants the lift to end."""
    cell = VirtualArm(speed=5.0)
    arm, plan = drawing(cell)
    before = arm.get(commands.CpParams)
    calls: list[int] = []

    def handler(number: int, _: object) -> None:
        calls.append(number)
        if len(calls) < 4:
            signal.raise_signal(signal.SIGINT)  # Handled while waiting for the end of the job.
        raise KeyboardInterrupt

    def interrupt(progress: PlanProgress) -> None:
        if progress.done >= 6 and cell.position[2] < -59.9 and not calls:
            signal.raise_signal(signal.SIGINT)

    known = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            arm.run(plan, progress=interrupt)
    finally:
        signal.signal(signal.SIGINT, known)
    assert len(calls) >= 2 and not cell.moving and cell.waiting == 0
    assert cell.position[2] == pytest.approx(-50, abs=0.1)
    assert "the pen is up by 10.0 mm" in notes(caught.value)
    assert arm.get(commands.CpParams) == before


def test_a_stop_by_others_moves_nothing() -> None:
    cell = VirtualArm(speed=5.0)
    arm, plan = drawing(cell)
    stopped: list[float] = []

    def stop(progress: PlanProgress) -> None:
        if progress.done >= 6 and cell.position[2] < -59.9 and not stopped:
            stopped.append(cell.position[2])
            thread = threading.Thread(target=arm.stop)
            thread.start()
            thread.join()

    with pytest.raises(magician.errors.ClosedError) as caught:
        arm.run(plan, progress=stop)
    assert cell.position[2] == pytest.approx(-60, abs=0.2) and "pen" not in notes(caught.value)


def test_a_drawing_ends_with_the_pen_up_and_may_be_parked(arm: magician.Arm, virtual_arm: VirtualArm) -> None:
    plan = magician.load(HOUSE, surface=-60)
    result = arm.run(plan)
    assert (result.pen, result.parked) == ("up", False) and virtual_arm.position[2] == pytest.approx(-50, abs=1e-3)
    result = arm.run(plan, stay=True)
    assert result.pen == "down" and virtual_arm.position[2] == pytest.approx(-60, abs=1e-3)
    result = arm.run(plan, park=(200, -80, 40))
    assert result.parked and virtual_arm.position[:3] == pytest.approx((200, -80, 40), abs=1e-3)
    with pytest.raises(UnreachableError, match="cannot be parked"):
        arm.run(plan, park=(400, 0, 0))
    with pytest.raises(InvalidInputError, match="stay"):
        arm.run(plan, park=(200, -80, 40), stay=True)
    # Without a pen a program ends at its last target: nothing is lifted.
    result = arm.run(Plan.path([(220, 0, 20), (240, 0, 20)], by="line"))
    assert result.pen is None and virtual_arm.position[2] == pytest.approx(20, abs=1e-3)


def test_an_exception_in_progress_stops_the_arm() -> None:
    cell = VirtualArm(speed=5.0)

    def fail(progress: PlanProgress) -> None:
        if progress.done >= 1:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        cell.arm().run(Plan.path(BACK_AND_FORTH, by="line"), progress=fail)
    assert not cell.moving and cell.waiting == 0


def test_a_cancelled_task_stops_the_arm() -> None:
    cell = VirtualArm(speed=5.0)

    async def main() -> None:
        arm = await magician.aio.Arm.connect(cell)
        moving = asyncio.Event()
        task = asyncio.create_task(arm.run(Plan.path(BACK_AND_FORTH, by="line"), progress=lambda _: moving.set()))
        await moving.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert not cell.moving and cell.waiting == 0

    asyncio.run(main())


def test_an_alarm_ends_a_run() -> None:
    cell = VirtualArm(speed=5.0)
    arm = cell.arm()
    with pytest.raises(magician.errors.AlarmError) as caught:
        arm.run(Plan.path(BACK_AND_FORTH, by="line"), progress=lambda _: cell.raise_alarm(0x40))
    assert caught.value.alarms is not None and 0x40 in caught.value.alarms


def test_progress_line_is_overwritten_on_a_terminal_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    clock = [0.0]
    monkeypatch.setattr("magician._progress.time.monotonic", lambda: clock[0])
    for out, wanted in (
        (Terminal(), "\r[======            ] step 1 of 4, 25 %, 0:09 left"),
        (io.StringIO(), "step 1 of 4"),
    ):
        clock[0] = 0.0
        line = ProgressLine(out)
        line(PlanProgress(0, 4, None))
        assert out.getvalue() == ""
        clock[0] = 3.1
        line(PlanProgress(1, 4, 9.0))
        assert wanted.replace("      ", "") in out.getvalue().replace("      ", "")
        if out.isatty():
            clock[0] = 3.2
            line(PlanProgress(2, 4, None))
            written = out.getvalue().split("\r")
            assert written[-1].rstrip() == "[============            ] step 2 of 4, 50 %"
            assert len(written[-1]) == len(written[-2]), "nothing of the longer line is left"
        line.end("4 of 4 steps done")
        assert out.getvalue().endswith("4 of 4 steps done in 0:03\n")


def test_a_narrow_terminal_has_a_short_line(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

        def fileno(self) -> int:
            return 2

    def size(_: int) -> os.terminal_size:
        return os.terminal_size((columns[0], 24))

    columns = [44]
    monkeypatch.setattr("magician._progress.time.monotonic", iter(range(9)).__next__)
    monkeypatch.setattr("magician._progress.os.get_terminal_size", size)
    out = Terminal()
    line = ProgressLine(out)
    for columns[0], wanted in (
        (44, "step 1 of 4, 25 %, 0:09 left"),
        (20, "step 1 of 4, 25 %, "),
        (0, "[======                  ] step 1 of 4, 25 %, 0:09 left"),
    ):
        line(PlanProgress(1, 4, 9.0))
        assert out.getvalue().split("\r")[-1] == wanted


def test_progress_true_writes_to_stderr(arm: magician.Arm, capsys: pytest.CaptureFixture[str]) -> None:
    arm.run(Plan.path([(220, 0, 20)], by="line"), progress=True)
    assert "1 of 1 steps done" in capsys.readouterr().err


def test_a_program_without_a_console(arm: magician.Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stderr", None)
    assert arm.run([words.wait(0)], progress=True).steps == 1


def test_a_refusal_tells_the_place_and_not_the_command() -> None:
    with magician.Arm("sim") as arm, pytest.raises(UnreachableError) as caught:
        arm.run(Plan.path([(210, 0, 20), (500, 0, 20)], by="line"))
    assert str(caught.value).startswith("row 1, step 2: x 500, y 0, z 20 is out of reach; ")
    assert caught.value.command == "SetPTPCmd"


def test_a_plan_and_a_lesson_need_a_homed_arm(samples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    plan = Plan.path([(220, 0, 20), (240, 0, 20)], by="line")
    # The missing homing is reported before the missing surface, which needs a homed arm to be measured.
    unmeasured = magician.load(samples / "house.svg")
    with magician.sim(tcp="127.0.0.1:0", speed="max") as served:
        with magician.Arm(served.tcp) as arm:
            for cleared in (False, True):
                if cleared:
                    arm.clear_alarms()
                for begin in (
                    lambda: arm.run(plan),
                    lambda: arm.start(plan).wait(),
                    lambda: arm.run(unmeasured),
                    lambda: arm.teach().__enter__(),
                ):
                    with pytest.raises(InvalidInputError, match="unhomed=True") as caught:
                        begin()
                    assert caught.value.code == "not-homed" and caught.value.remedies == ("home", "unhomed")
            assert arm.current_index() == 0
            with arm.teach(unhomed=True) as lesson:
                assert not lesson.points
            with pytest.raises(InvalidInputError, match="work surface height unknown: give load"):
                arm.run(unmeasured, unhomed=True)
            assert arm.run(plan, unhomed=True).steps == 2
            arm.home()
            assert arm.run(plan).steps == 2
        # This computer has recorded the homing.
        with magician.Arm(served.tcp) as arm, arm.teach():
            assert arm.run(plan).steps == 2

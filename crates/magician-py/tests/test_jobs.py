"""Plans that are started, paused, resumed and stopped."""

import asyncio
import threading

import magician
import pytest
from magician import Arm, Plan, aio, commands, errors, words

BACK_AND_FORTH = [(220, 40 * (nth % 2), 20) for nth in range(60)]


def back_and_forth() -> Plan:
    return Plan.path(BACK_AND_FORTH, by="line")


def reach(job: magician.Job, steps: int, arm: Arm) -> None:
    while job.progress.done < steps:
        arm.pose()


def test_a_job_is_paused_and_goes_on(slow: Arm) -> None:
    plan = back_and_forth()
    job = slow.start(plan)
    assert job.state in {"checking", "running"}
    reach(job, 1, slow)
    other = threading.Thread(target=job.pause)
    other.start()
    other.join()
    assert job.state == "paused" and repr(job) == "<Job, paused>"
    assert slow.left_space() == 32
    job.pause()
    done = job.progress.done
    slow.perform([words.line_by(dz=10)])
    assert job.progress.done == done
    job.resume()
    with pytest.raises(errors.InvalidInputError, match="not paused"):
        job.resume()
    reach(job, done + 1, slow)
    job.stop()
    with pytest.raises(errors.ClosedError, match="stopped"):
        job.wait()
    assert job.state == "ended"
    with pytest.raises(errors.ClosedError):
        job.pause()


def test_set_speed_applies_to_unsent_commands(slow: Arm) -> None:
    job = slow.start(back_and_forth())
    assert job.speed == 100
    job.set_speed(50)
    assert job.speed == 50
    for wrong in (9, 101):
        with pytest.raises(errors.InvalidInputError, match="percent"):
            job.set_speed(wrong)
    reach(job, 1, slow)
    assert slow.get(commands.PtpCommonParams).velocity_ratio == 25
    job.stop()
    with pytest.raises(errors.ClosedError, match="stopped"):
        job.wait()
    assert slow.get(commands.PtpCommonParams).velocity_ratio == 50
    with pytest.raises(errors.ClosedError):
        job.set_speed(60)


def test_dropped_job_is_stopped(slow: Arm) -> None:
    job = slow.start(back_and_forth())
    reach(job, 1, slow)
    del job
    slow.wait_still()
    for status in slow.state(100):
        if status.left_space == 32:
            break
    before = slow.pose()
    assert slow.pose() == before


def test_job_and_run_have_the_same_result(arm: Arm) -> None:
    plan = Plan.path([(220, 0, 20), (240, 0, 20)], by="line")
    told: list[magician.PlanProgress] = []
    job = arm.start(plan)
    result = job.wait(progress=told.append)
    assert result.steps == 2 and told[-1].done == 2
    assert arm.run(plan).steps == 2


def test_nothing_is_resumed_that_was_not_interrupted(arm: Arm) -> None:
    with pytest.raises(errors.InvalidInputError, match="nothing to resume"):
        arm.run(back_and_forth(), resume=True)


def test_a_task_pauses_a_job() -> None:
    async def main() -> int:
        async with aio.Arm.connect("sim:1") as arm:
            await arm.clear_alarms()
            job = arm.start(Plan.path(BACK_AND_FORTH[:4], by="line"))
            await job.pause()
            assert job.state == "paused" and job.progress.done == 0
            await job.resume()
            return (await job.wait()).steps

    assert asyncio.run(main()) == 4

"""Things that are picked from a belt that runs, in the virtual world."""

from __future__ import annotations

import asyncio
from math import hypot

import pytest
from magician import Arm, VirtualArm, aio, commands, errors, words
from magician.places import Belt

BELT = """
tool = { kind = "suction" }
table = { height = -60 }
conveyor = { start = [220, -220], direction = 90, length = 440, width = 40, height = -50, stepper = 0 }
object = [
    { name = "one", size = [8, 8, 20], at = [220, -200], on = "belt" },
    { name = "two", size = [8, 8, 20], at = [220, -216], on = "belt" },
]
sensor = [{ kind = "infrared", port = "GP2", belt_at = 60 }]
"""
TOP = -30.0
"""The height of the objects' tops."""
PERIOD = 0.02
"""The arm begins its motions at whole periods, s: what it meets is up to that much farther."""


def ready(cell: VirtualArm) -> Arm:
    arm = cell.arm()
    arm.clear_alarms()
    arm.tool("suction")
    arm.move_to(200, 0, 30, 0)
    return arm


def off_the_middle(cell: VirtualArm, name: str) -> float:
    """How far the middle of what was picked is from the tool's tip, mm."""
    place = cell.object(name).position
    return hypot(place.x - cell.position.x, place.y - cell.position.y)


@pytest.mark.parametrize("speed", [15, 30, 60])
def test_passing_object_is_picked_at_its_middle(speed: float) -> None:
    cell = VirtualArm(BELT)
    arm = ready(cell)
    arm.conveyor(0, speed)
    arm.pick_from_belt((220, -200, TOP), Belt(speed, 90))
    assert cell.object("one").held
    assert off_the_middle(cell, "one") < speed * PERIOD
    assert cell.position.z == pytest.approx(TOP + 40, abs=0.01)
    # The object can be carried away, and the belt still runs.
    before = cell.object("two").position.y
    arm.place((200, 0, -40))
    assert not cell.object("one").held and cell.object("two").position.y > before


def test_one_after_the_other_is_picked_where_a_sensor_sees_it() -> None:
    cell = VirtualArm(BELT.replace("220, -200", "220, -150").replace("belt_at = 60", "belt_at = 90"))
    arm = ready(cell)
    arm.infrared("GP2", True, "v2")
    arm.conveyor(0, 10)
    for name, place in (("one", -30), ("two", 30)):
        while not arm.infrared_at("GP2"):
            cell.advance(0.001)
        seen = arm.clock()
        # Simulate a slow program.
        cell.advance(0.5)
        # The sensor saw its front, 4 mm before its centre.
        arm.pick_from_belt((220, -130 - 4, TOP), Belt(10, 90), since=seen, retreat=60)
        assert cell.object(name).held
        assert off_the_middle(cell, name) < 0.2
        arm.conveyor(0, 0)
        arm.place((180, place, -40))
        arm.conveyor(0, 10)


@pytest.mark.parametrize(("lead", "held"), [(0.0, True), (0.1, True), (0.2, False), (-0.2, False)])
def test_pick_a_few_mm_early_or_late_misses_the_object(lead: float, held: bool) -> None:
    """At 30 mm/s 0.2 s are 6 mm: beside a cube of 8 mm."""
    cell = VirtualArm(BELT)
    arm = ready(cell)
    arm.conveyor(0, 30)
    arm.pick_from_belt((220, -200, TOP), Belt(30, 90), lead=lead)
    assert cell.object("one").held is held
    if held:
        assert off_the_middle(cell, "one") == pytest.approx(30 * abs(lead), abs=30 * PERIOD)


def test_impossible_interception_is_refused_before_any_motion() -> None:
    cell = VirtualArm(BELT)
    arm = ready(cell)
    before = cell.position, arm.current_index()
    for at, belt, why in (
        ((220, -200, TOP), Belt(0), "no place on its way is within reach|cannot be met"),
        ((220, 240, TOP), Belt(200, 90), "the arm needs"),
        ((600, 0, TOP), Belt(30, 90), "no place on its way is within reach"),
        ((220, -200, -500), Belt(30, 90), "no place on its way is within reach"),
    ):
        if belt == Belt(0):
            at = (500, 0, TOP)
        with pytest.raises(errors.UnreachableError, match=why):
            arm.pick_from_belt(at, belt)
    for wrong in (float("nan"), float("inf")):
        with pytest.raises(errors.InvalidInputError):
            arm.pick_from_belt((220, wrong, TOP), Belt(30))
        with pytest.raises(errors.InvalidInputError):
            Belt(wrong)
    with pytest.raises(TypeError, match="belt is"):
        arm.pick_from_belt((220, 0, TOP), 30)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    assert (cell.position, arm.current_index()) == before


def test_its_speed_is_given_back() -> None:
    cell = VirtualArm(BELT)
    arm = ready(cell)
    arm.speed(70, 80)
    arm.conveyor(0, 20)
    arm.pick_from_belt((220, -200, TOP), Belt(20, 90), speed=30)
    assert cell.object("one").held and off_the_middle(cell, "one") < 20 * PERIOD
    assert arm.get(commands.PtpCommonParams) == commands.PtpCommonParams(70, 80)


def test_a_handle_is_given_at_once() -> None:
    cell = VirtualArm(BELT)
    arm = ready(cell)
    arm.conveyor(0, 20)
    before = arm.move_to(200, 60, 30, wait=False)
    motion = arm.pick_from_belt((220, -200, TOP), Belt(20, 90), wait=False)
    after = arm.place((200, 0, -40), wait=False)
    ran = motion.wait()
    assert motion.done() and before.done()
    assert after.wait().first == (ran.last or 0) + 1
    assert not cell.object("one").held and cell.object("one").position.x == pytest.approx(200, abs=0.5)


def test_interception_counts_from_the_call_despite_earlier_motions() -> None:
    # At full speed the wait would end before the second call reads the clock.
    cell = VirtualArm(BELT, speed=5.0)
    arm = ready(cell)
    arm.conveyor(0, 10)
    arm.perform([words.wait(3)], wait=False)
    arm.pick_from_belt((220, -200, TOP), Belt(10, 90), wait=False).wait()
    assert cell.object("one").held and off_the_middle(cell, "one") < 0.2


def test_its_errors_come_out_of_the_handle(virtual_arm: VirtualArm) -> None:
    arm = virtual_arm.arm()
    motion = arm.pick_from_belt((600, 0, TOP), Belt(30, 90), wait=False)
    with pytest.raises(errors.UnreachableError, match="no place on its way"):
        motion.wait()
    arm.speed(70, 80)
    late = arm.pick_from_belt((220, -200, TOP), Belt(1, 90), lead=10, speed=50, wait=False)
    with pytest.raises(errors.ResponseTimeoutError, match="too late"):
        late.wait()
    assert arm.get(commands.PtpCommonParams) == commands.PtpCommonParams(70, 80)
    with pytest.raises(errors.InvalidInputError, match="tool is"):
        arm.pick_from_belt((220, 0, TOP), Belt(30), tool="hook", wait=False)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_it_is_cancelled(slow: Arm) -> None:
    slow.speed(40, 30)
    motion = slow.pick_from_belt((220, -200, TOP), Belt(2, 90), speed=20, wait=False)
    while slow.get(commands.PtpCommonParams).velocity_ratio != 20:
        pass
    motion.cancel()
    with pytest.raises(errors.ClosedError, match="cancelled"):
        motion.wait()
    slow.wait_still()
    assert slow.left_space() == 32
    assert slow.get(commands.PtpCommonParams) == commands.PtpCommonParams(40, 30)


def test_on_asyncio() -> None:
    async def main() -> None:
        cell = VirtualArm(BELT)
        async with aio.Arm.connect(cell) as arm:
            await arm.clear_alarms()
            await arm.tool("suction")
            await arm.conveyor(0, 30)
            motion = await arm.pick_from_belt((220, -200, TOP), Belt(30, 90), wait=False)
            await motion
            assert cell.object("one").held

    asyncio.run(main())


def test_belt_velocity_moves_objects() -> None:
    assert Belt(40).velocity == (40, 0, 0)
    assert Belt(-40, 90).after((220, 0, 0, 5), 0.5) == pytest.approx((220, -20, 0, 5))


def test_an_edge_is_waited_for() -> None:
    with Arm("sim") as arm, pytest.raises(errors.ResponseTimeoutError, match="nothing came"):
        arm.infrared_edge("GP2", timeout=0.05)


def test_belt_ends_with_a_stop_and_with_its_connection() -> None:
    def runs(cell: VirtualArm) -> bool:
        before = cell.object("two").position.y
        cell.advance(1)
        return cell.object("two").position.y != before

    cell = VirtualArm(BELT)
    with cell.arm() as arm:
        arm.conveyor(0, 30)
        assert runs(cell)
        arm.stop()
        assert not runs(cell)
        arm.conveyor(0, 30)
        assert runs(cell)
    assert not runs(cell)

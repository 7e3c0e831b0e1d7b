"""What an arm can be told, without asyncio."""

from __future__ import annotations

import functools
import gc
import inspect
import math
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import Arm, _conversion, commands, errors, words
from magician.commands import IoFunction, Port, RailVersion, SensorVersion, Stepper

FOUR = (10.0, 20.0, 30.0, 40.0)


def test_motion(arm: Arm) -> None:
    arm.move_to(220, 60, 20, 5)
    assert arm.pose().position == (220, 60, 20, 5)
    arm.move_to(220, -60, 20)
    assert arm.pose().position == (220, -60, 20, 5)
    arm.line_to(200, 0, 20)
    arm.jump_to(220, 0, 30)
    arm.move_by(dz=-10)
    arm.line_by(dx=10)
    assert arm.pose().position == (230, 0, 20, 5)
    arm.move_joints(0, 45, 45)
    arm.move_joints_by(d1=10)
    assert arm.joints() == pytest.approx((10, 45, 45, arm.pose().j4))
    arm.line_joints(0, 40, 45)
    arm.jump_joints(5, 45, 45)
    arm.move_to(200, 0, 0, 0)
    arm.arc_to((210, 20, 0, 0), (200, 40, 0, 0))
    arm.circle((210, 50, 0, 0), (190, 50, 0, 0))
    arm.path_to(200, 0, 0)
    arm.path_by(dy=10)
    pose = arm.pose()
    assert (pose.x, pose.y, pose.z) == pytest.approx((200, 10, 0), abs=1e-3)
    arm.wait(0.5)
    arm.check_lost_steps()
    arm.wait_still()
    assert not arm.moving


def test_settings(arm: Arm) -> None:
    def is_now(setting: commands.Readable) -> bool:
        return arm.get(type(setting)) == setting

    arm.speed(40, 30)
    assert is_now(words.speed(40, 30))
    arm.joint_speed(FOUR, FOUR)
    assert is_now(words.joint_speed(FOUR, FOUR))
    arm.line_speed(100, 80)
    assert is_now(words.line_speed(100, 80))
    arm.path_speed(60, 50)
    assert is_now(words.path_speed(60, 50))
    arm.arc_speed(60, 50)
    assert is_now(words.arc_speed(60, 50))
    arm.rail_speed(60, 50)
    assert is_now(words.rail_speed(60, 50))
    arm.jump_height(30, 90)
    assert is_now(words.jump_height(30, 90))
    arm.jump_heights(30, 25, 90)
    assert is_now(words.jump_heights(30, 25, 90))
    arm.jog_speed(20)
    assert is_now(words.jog_speed(20))
    arm.jog_joint_speed(FOUR, FOUR)
    assert is_now(words.jog_joint_speed(FOUR, FOUR))
    arm.jog_axis_speed(FOUR, FOUR)
    assert is_now(words.jog_axis_speed(FOUR, FOUR))
    arm.jog_rail_speed(60, 50)
    assert is_now(words.jog_rail_speed(60, 50))
    arm.home_at(200, 10, 30, 0)
    assert is_now(words.home_at(200, 10, 30, 0))
    arm.tool("pen")
    assert is_now(words.tool("pen"))
    arm.lost_step_threshold(8)
    arm.home()
    assert arm.pose().y == pytest.approx(10, abs=1e-3)


def test_tools_and_pins(arm: Arm) -> None:
    arm.suction(True)
    assert arm.get(commands.EndEffectorSuctionCup).is_sucked
    arm.suction(False)
    arm.grip()
    assert arm.get(commands.EndEffectorGripper).is_gripped
    arm.release()
    arm.pump_off()
    assert not arm.get(commands.EndEffectorGripper).is_ctrl_enabled
    arm.laser(True)
    assert arm.get(commands.EndEffectorLaser).is_on
    arm.laser(False)
    arm.multiplex(17, IoFunction.DIGITAL_OUTPUT)
    assert arm.get(commands.GetIoMultiplexing(17)).multiplex is IoFunction.DIGITAL_OUTPUT
    arm.output(17, True)
    assert arm.get(commands.GetIoDo(17)).level is True
    arm.multiplex(8, IoFunction.PWM)
    arm.pwm(8, 1000, 25)
    arm.servo(8, 1.5)
    assert arm.get(commands.GetIoPwm(8)) == commands.IoPwm(8, 50, 7.5)
    arm.multiplex(19, IoFunction.DIGITAL_INPUT)
    assert arm.level_at(19) is False
    arm.wait_for_level(19, False)
    arm.multiplex(12, IoFunction.ANALOG_INPUT)
    assert arm.analog_at(12) == 0
    arm.wait_below(12, 10)
    arm.wait_at_most(12, 10)
    arm.wait_at_least(12, 0)


def test_pin_is_driven_only_by_its_function(arm: Arm) -> None:
    way_out = (
        r"EIO 6 has no function, it has to be a digital output; "
        r'.*`arm\.multiplex\(6, "digital-output"\)` gives it'
    )
    with pytest.raises(errors.InvalidInputError, match=way_out):
        arm.output(6, True)
    arm.multiplex(6, "digital-output")
    arm.output(6, True)
    other = r"EIO 6 has another function, .* a pulse-width output"
    with pytest.raises(errors.InvalidInputError, match=other):
        arm.pwm(6, 1000, 25)
    with pytest.raises(errors.InvalidInputError, match=other):
        arm.servo(6, 1.5)


def test_belt_speed_beyond_its_limit_is_refused(arm: Arm) -> None:
    with pytest.raises(errors.InvalidInputError, match=r"mm_per_s is .* from -120 to 120"):
        arm.conveyor(Stepper.STEPPER1, 500)
    with pytest.raises(errors.InvalidInputError, match=r"mm_per_s is .* from -120 to 120"):
        arm.conveyor_by(Stepper.STEPPER1, 10, 121)


def test_belts_and_sensors(arm: Arm) -> None:
    arm.motor(Stepper.STEPPER1, 1000)
    arm.motor(Stepper.STEPPER1, 0)
    arm.motor_by(Stepper.STEPPER1, 1000, 500)
    arm.conveyor(Stepper.STEPPER2, 20)
    arm.conveyor(Stepper.STEPPER2, 0)
    arm.conveyor_by(Stepper.STEPPER2, 10, 20)
    arm.infrared(Port.GP2, True, SensorVersion.V2)
    assert arm.infrared_at(Port.GP2) is False
    arm.color_sensor(Port.GP1, True, SensorVersion.V2)
    assert arm.color_at(Port.GP1) is None


def test_rail(arm: Arm) -> None:
    arm.rail(True, RailVersion.V2)
    assert arm.info().rail
    arm.rail_to(300)
    assert arm.rail_position() == 300
    arm.rail_by(-100)
    arm.move_to(200, 50, 20, 0, rail=400)
    arm.move_with_rail(200, 0, 20, 0, 350)
    assert arm.rail_position() == 350


def test_info_identifies_the_arm(arm: Arm) -> None:
    info = arm.info()
    assert info.port == arm.name == "sim"
    assert info.firmware.count(".") == 2
    assert info.processor_id is not None and len(info.processor_id) == 3
    assert repr(arm) == "<Arm at sim, up>"
    assert arm.link and arm.link.state == "up" and arm.link.why is None
    stats = arm.stats()
    assert stats.capacity == 32 and stats.sent >= stats.frames > 0 and stats.late == 0
    arm.timeout = 1.5
    assert arm.timeout == 1.5
    with pytest.raises(errors.InvalidInputError):
        arm.timeout = math.nan


def test_by_name(arm: Arm) -> None:
    assert arm.get("Pose") == arm.pose() == arm.get("GetPose")
    assert arm.get("iodi", address=4) == commands.IoDi(4, False)
    arm.set("PTPCommonParams", velocity_ratio=20, acceleration_ratio=30)
    assert arm.get("ptp-common-params") == commands.PtpCommonParams(20, 30)
    assert arm.enqueue("WAITCmd", timeout=5) > 0
    with pytest.raises(errors.InvalidInputError, match="unknown command `Pose` to set"):
        arm.set("Pose")
    with pytest.raises(TypeError):
        arm.get("Pose", address=3)
    with pytest.raises(TypeError):
        arm.set("WAITCmd", duration=5)


def test_queue(arm: Arm) -> None:
    arm.stop_gentle()
    before = arm.current_index()
    index = arm.enqueue(words.move_to(200, 30, 20, 0))
    assert index == max(before, 1) + 1
    assert arm.left_space() == 31
    arm.start_queue()
    seen: list[magician.Progress] = []
    arm.wait_for(index, progress=seen.append)
    assert arm.current_index() == index and arm.pose().y == 30
    assert all(progress.last == index for progress in seen)
    # Starting the queue must not end a motion that is running.
    index = arm.enqueue(words.move_to(200, -30, 20, 0))
    arm.start_queue()
    arm.wait_for(index)
    assert arm.pose().y == -30
    arm.stop_gentle()
    arm.enqueue(words.wait(1))
    arm.clear_queue()
    assert arm.left_space() == 32


def test_raw(arm: Arm) -> None:
    assert commands.Pose.from_bytes(arm.raw(10)) == arm.pose()
    arm.raw(83, 1, bytes(words.speed(12)))
    assert arm.get(commands.PtpCommonParams).velocity_ratio == 12
    arm.stop_gentle()
    index = int.from_bytes(arm.raw(110, 3, bytes(words.wait(0.1))), "little")
    assert index == max(arm.current_index(), 1) + 1
    with pytest.raises(errors.InvalidInputError, match="allow_dangerous"):
        arm.raw(160, 1)


def test_programs(arm: Arm) -> None:
    program = [words.move_to(200, 50, 20, 0), words.wait(1.5), words.move_to(200, 0, 20, 0)]
    seconds = arm.estimate(program)
    assert 1.5 < seconds < 10
    assert arm.estimate([words.home()]) == math.inf
    seen: list[magician.Progress] = []
    ran = arm.perform(iter(program), progress=seen.append)
    assert ran.commands == 3 and ran.first is not None and ran.last == ran.first + 2
    assert seen[-1] == (ran.last, ran.last, 3, 3, 0.0)
    assert arm.perform([]) == (0, None, None)
    path = [words.path_to(200 + at / 100, 0, 20) for at in range(500)]
    assert arm.perform(path).commands == 500


def test_a_run(arm: Arm) -> None:
    run = arm.begin([words.wait(0.1), words.wait(0.1)], horizon=1.0)
    assert run.ran.commands == 0 and not run.is_interrupted
    assert run.finish().commands == 2 == run.ran.commands
    over = arm.begin([words.wait(0.1)])
    with pytest.raises(errors.InvalidInputError):
        arm.begin([words.wait(0.1)], horizon=-1)
    over.finish()


def test_a_listener_that_fails_ends_the_program(slow: Arm) -> None:
    class Enough(Exception):
        pass

    def enough(_: magician.Progress) -> None:
        raise Enough

    with pytest.raises(Enough):
        slow.perform([words.wait(3600)], progress=enough)
    assert slow.left_space() == 32 and not slow.moving


def test_refused(arm: Arm) -> None:
    before = arm.stats().sent
    with pytest.raises(errors.UnreachableError, match="x 500, y 0, z 0 is out of reach") as caught:
        arm.move_to(500, 0, 0, 0)
    error = caught.value
    # The wrist, 59.7 mm behind the suction cup that is set at power-up.
    assert error.value == pytest.approx(440.3, abs=1e-3)
    assert (error.limit, error.unit, error.command) == (282, "mm", "SetPTPCmd")
    assert isinstance(error, ValueError) and error.kind == "unreachable"
    with pytest.raises(errors.UnreachableError) as caught:
        arm.move_joints(0, 91.5, 45, 0)
    assert (caught.value.value, caught.value.unit) == (91.5, "deg")
    with pytest.raises(errors.InvalidInputError):
        arm.move_to(math.nan, 0, 0, 0)
    with pytest.raises(errors.InvalidInputError, match="laser"):
        arm.perform([words.laser(True), words.wait(1)])
    arm.perform([words.laser(True), words.wait(0.1), words.laser(False)], skip=["laser"])
    with pytest.raises(errors.InvalidInputError, match="unknown check `lasers`"):
        arm.perform([], skip=["lasers"])  # type: ignore[list-item]
    assert arm.stats().sent > before


def test_require_homed() -> None:
    with Arm("sim") as arm:
        with pytest.raises(errors.InvalidInputError, match="not homed since"):
            arm.perform([words.wait(0.1)], require_homed=True)
        arm.home()
        arm.perform([words.wait(0.1)], require_homed=True)


def test_verbs_refuse_invalid_commands(arm: Arm) -> None:
    untyped: Any = arm
    calls: list[tuple[Callable[[], object], type[Exception], str]] = [
        (lambda: untyped.get(commands.WaitCmd), errors.InvalidInputError, "cannot be read"),
        (lambda: untyped.get(commands.IoDi), errors.InvalidInputError, r"IoDi: read it with GetIoDi\(\.\.\.\)"),
        (lambda: untyped.get(arm.pose()), errors.InvalidInputError, "it is not a query"),
        (lambda: untyped.get(3), TypeError, "not a command"),
        (lambda: untyped.set(arm.pose()), errors.InvalidInputError, "cannot be set, only read"),
        (lambda: untyped.set(commands.GetIoDi(1)), errors.InvalidInputError, "cannot be set, only read"),
        (lambda: untyped.enqueue(commands.LostStepParams(5)), errors.InvalidInputError, "queue"),
        (lambda: untyped.perform([commands.LostStepParams(5)]), errors.InvalidInputError, "queue"),
        (lambda: untyped.perform([None]), TypeError, "not a command"),
    ]
    for call, error, message in calls:
        with pytest.raises(error, match=message):
            call()


def test_dangerous(arm: Arm) -> None:
    with pytest.raises(errors.InvalidInputError, match="allow_dangerous=True"):
        arm.set(commands.DeviceSn("123"))
    arm.set(commands.DeviceSn("123"), allow_dangerous=True)
    assert arm.info().serial_number == "123"
    arm.get(commands.WifiSsid)
    with pytest.raises(errors.InvalidInputError, match=r"flash.* allow_dangerous=True"):
        arm.set(commands.QueuedCmdStartDownload(1, 1))
    arm.set(commands.QueuedCmdStartDownload(1, 1), allow_dangerous=True)


@pytest.mark.parametrize("share", [-1, 101, float("nan"), float("inf")])
def test_a_share_of_power_out_of_range(arm: Arm, share: float) -> None:
    power, pulses = commands.CpLeCmd(commands.CpMode.ABSOLUTE, 220, 0, 20, share), commands.IoPwm(4, 100, share)
    for send in (
        lambda: arm.set(pulses),
        lambda: arm.enqueue(pulses),
        lambda: arm.enqueue(power),
        lambda: arm.perform([power]),
    ):
        with pytest.raises(errors.InvalidInputError, match=r"0 to 100 %|finite number"):
            send()


def test_full_queue(arm: Arm) -> None:
    arm.stop_gentle()
    for _ in range(32):
        arm.enqueue(words.wait(1))
    with pytest.raises(errors.QueueFullError) as caught:
        arm.enqueue(words.wait(1))
    assert caught.value.kind == "queue-full"
    arm.stop()
    assert arm.left_space() == 32


def test_a_queue_of_another_program(arm: Arm) -> None:
    """What a caller has enqueued runs with what follows; what a failed program has left behind does not."""
    arm.stop_gentle()
    arm.enqueue(words.wait(0.1))
    assert arm.perform([words.wait(0.1)]).commands == 1
    arm.stop_gentle()
    # The unreachable move raises its alarm when it is its turn; commands behind it stay queued.
    program = [words.move_to(500, 0, 0, 0), words.wait(0.1), words.wait(0.1)]
    with pytest.raises(errors.AlarmError):
        arm.begin(program).finish()
    arm.stop_gentle()
    arm.clear_alarms()
    with pytest.raises(errors.InvalidInputError, match=r"2 commands .*`arm\.stop\(\)`.*keep=True"):
        arm.wait(0.1)
    arm.perform([words.wait(0.1)], keep=True)


def test_alarms(arm: Arm) -> None:
    assert arm.alarms() == ()
    arm.set(words.move_to(500, 0, 0, 0))  # a raw verb sends what it is given
    (alarm,) = arm.alarms()
    assert int(alarm) == 0x11 and alarm is magician.Alarm.PLAN_INV_CALC
    assert alarm.cause == "the target is out of reach" and "clear the alarms" in alarm.cure and alarm.holds_queue
    assert str(alarm) == f"0x11 PLAN_INV_CALC: {alarm.cause} ({alarm.cure})"
    with pytest.raises(errors.AlarmError, match=r"`arm\.clear_alarms\(\)`") as caught:
        arm.move_to(200, 0, 20)
    assert caught.value.alarms == (magician.Alarm.PLAN_INV_CALC,)
    arm.clear_alarms()
    arm.move_to(200, 0, 20)
    assert magician.Alarm(0xEE).cause == "unknown to this package"


def test_closed(arm: Arm) -> None:
    arm.close()
    assert arm.link.state == "closed" and not arm.link
    for call in (arm.pose, arm.stop, arm.home, lambda: arm.perform([])):
        with pytest.raises(errors.ClosedError):
            call()
    with pytest.raises(errors.ClosedError):
        arm.request_stop()
    arm.close()
    assert repr(arm) == "<Arm at sim, closed>"


def test_with_lets_go() -> None:
    """What was started goes on when the block ends well, and stops when it does not."""
    with Arm("sim:1") as arm:
        arm.clear_alarms()
        arm.enqueue(words.wait(3600))
        arm.start_queue()
    assert arm.link.state == "closed"

    class Mine(Exception):
        pass

    with pytest.raises(Mine) as caught, Arm("sim:1") as arm:
        arm.laser(True)
        raise Mine
    assert not getattr(caught.value, "__notes__", None)
    assert arm.link.state == "closed"


def test_stops(slow: Arm, meanwhile: Callable[[Callable[[], object]], object]) -> None:
    def stop(how: Callable[[], None]) -> None:
        for status in slow.state(100):
            if status.left_space < 32:
                how()
                return

    for how in (slow.stop, slow.request_stop):
        meanwhile(functools.partial(stop, how))
        with pytest.raises(errors.ClosedError, match="stop"):
            slow.wait_above(12, 4000)  # never ends
        slow.wait_still()
        assert slow.left_space() == 32


def test_forgotten_connections_end() -> None:
    arm = Arm("sim")
    watch, events = arm.state(10), arm.events()
    gone = weakref.ref(arm)
    del arm
    gc.collect()
    assert gone() is None
    assert list(events) == [] or True
    with pytest.raises(errors.ClosedError):
        while True:
            watch.changed()


def test_ports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(errors.PortError, match="missing") as caught:
        Arm(tmp_path / "missing")
    assert isinstance(caught.value, OSError) and caught.value.kind == "port"
    with pytest.raises(errors.InvalidInputError, match="is not a port"):
        Arm("nonsense")
    monkeypatch.setenv("MAGICIAN_PORT", "sim:2")
    with Arm() as arm:
        assert arm.name == "sim:2"
    if not any(port.likely_arm for port in magician.ports()):
        monkeypatch.setenv("MAGICIAN_PORT", "")
        with pytest.raises(errors.PortError, match=r'no arm found .* port="sim" uses a virtual arm'):
            Arm()
    with pytest.raises(errors.InvalidInputError, match="window"):
        Arm("udp:127.0.0.1", window=4)
    for wrong in (-1, math.nan):
        with pytest.raises(errors.InvalidInputError, match=r"timeout is .* a number above 0"):
            Arm("sim", timeout=wrong)


def test_silence() -> None:
    """Nobody answers on a UDP port that somebody holds."""
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        with pytest.raises(errors.ResponseTimeoutError, match="no arm answers") as caught:
            Arm(f"udp:127.0.0.1:{silent.getsockname()[1]}", timeout=0.05)
    assert isinstance(caught.value, TimeoutError)


def test_discovery() -> None:
    assert all(isinstance(port, magician.SerialPort) for port in magician.ports())
    assert magician.discover(["127.0.0.1:9"], within=0.01) == []
    with pytest.raises(errors.InvalidInputError, match="HOST"):
        magician.discover(["arm:x"])
    with pytest.raises(errors.InvalidInputError, match="within is -1 s"):
        magician.discover(within=-1)


def test_errors_travel() -> None:
    import pickle

    error = _conversion.error("alarm", "text", alarms=[0x11], command="SetPTPCmd")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is errors.AlarmError and again.alarms == error.alarms and str(again) == "text"
    port = _conversion.error("port", "gone")
    assert str(pickle.loads(pickle.dumps(port))) == "gone"
    assert type(_conversion.error("new", "text")) is magician.Error
    away = _conversion.error("invalid-input", "text", code="not-homed", remedies=["home"], step=2)
    again = pickle.loads(pickle.dumps(away))
    assert (again.code, again.remedies, again.step) == ("not-homed", ("home",), 2)


def test_remedies_of_errors_are_worded_for_python() -> None:
    from magician._magician import every_error

    every = every_error()
    assert len({error.code for error in every}) == len(every) > 40
    assert {"stopped", "closed"} <= {error.code for error in every if error.kind == "closed"}
    for error in every:
        said = str(error)
        of_a_place = error.code in ("out-of-reach", "fenced")
        assert said.startswith("it is so" if of_a_place else "SetPTPCmd: it is so")
        assert "--" not in said, said
        if error.code != "laser-not-allowed":
            assert {"home", "keep 1"} <= set(error.remedies)
            assert "`arm.home()` mends it" in said and "keep=1 is a way" in said
    (laser,) = (str(error) for error in every if error.code == "laser-not-allowed")
    assert "goggles" in laser and "allow_laser=True" in laser


def test_a_length_that_lies(arm: Arm) -> None:
    class Endless(list[Any]):
        def __len__(self) -> int:
            return 2**62

    assert arm.perform(Endless([words.wait(0)])).commands == 1
    with pytest.raises(TypeError, match="not a command"):
        arm.perform(range(10**18))  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_the_longest_frame(arm: Arm) -> None:
    """As long as the documentation says, and no byte more."""
    assert "at most 248 bytes" in (Arm.raw.__doc__ or "")
    arm.raw(10, 0, bytes(248))
    with pytest.raises(errors.InvalidInputError, match="248"):
        arm.raw(10, 0, bytes(249))


def test_a_file_is_no_program_yet(arm: magician.Arm) -> None:
    refused: list[Callable[[Any], object]] = [arm.run, arm.perform, arm.estimate, magician.Plan.of]
    for take in refused:
        with pytest.raises(TypeError, match=r"magician\.load\('x\.svg'\)"):
            take("x.svg")


def test_a_notebook_shows_the_text_of_an_arm_that_is_not_there(arm: magician.Arm) -> None:
    assert arm._repr_svg_()
    arm.close()
    assert arm._repr_svg_() is None
    assert "closed" in repr(arm)


def test_every_parameter_has_a_line_of_its_own() -> None:
    pages = [magician.load, *vars(magician.Arm).values(), *vars(magician.Plan).values()]
    described = [inspect.getdoc(page) or "" for page in pages]
    assert sum(":param" in page for page in described) > 10
    assert not [line for page in described for line in page.splitlines() if " :param" in line]


def test_wait_in_a_stopped_queue_names_the_remedy(arm: Arm) -> None:
    arm.stop_gentle()
    index = arm.enqueue(words.wait(3600))
    with pytest.raises(
        errors.ResponseTimeoutError, match=r"its queue is stopped; `arm.start_queue\(\)` lets it continue"
    ):
        arm.wait_for(index)
    assert arm.left_space() == 31


def test_a_checked_move_is_five_frames(arm: Arm) -> None:
    def frames(move: Callable[[], object]) -> int:
        before = arm.stats().sent
        move()
        return arm.stats().sent - before

    arm.move_to(220, 60, 20, 5)
    assert frames(lambda: arm.move_to(220, 40, 20, 5)) == 5
    assert frames(lambda: arm.line_to(220, 0, 20)) == 5, "the rotation that is kept is known"
    assert frames(lambda: arm.move_by(dz=5)) == 5

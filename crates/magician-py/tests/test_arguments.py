"""Numbers that are none, and numbers out of range: refused under their names, with both values."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import Arm, Plan, VirtualArm, commands, words
from magician.errors import InvalidInputError
from magician.programs import SetupOptions

ROWS = [(200.0, 0.0, 0.0), (220.0, 10.0, 0.0)]
HUGE = 10**400
ROOT = Path(__file__).parents[3]


@pytest.fixture
def sample(samples: Path) -> Path:
    return next(samples.rglob("*.svg"))


WHOLE: list[tuple[str, Callable[[Arm, Any], object], int, int]] = [
    ("window", lambda arm, bad: Arm("sim", window=bad), 1, 8),
    ("id", lambda arm, bad: arm.raw(bad), 0, 255),
    ("ctrl", lambda arm, bad: arm.raw(10, bad), 0, 255),
    ("index", lambda arm, bad: arm.wait_for(bad), 0, 2**64 - 1),
    ("first_step", lambda arm, bad: arm.run(Plan.path(ROWS), first_step=bad), 1, 5),
    (r"inputs\[0\]", lambda arm, bad: arm.state(inputs=[bad]), 1, 20),
    ("address", lambda arm, bad: arm.level_at(bad), 1, 20),
    ("address", lambda arm, bad: arm.output(bad, True), 1, 20),
    ("threshold", lambda arm, bad: arm.wait_below(12, bad), 0, 4095),
    ("turns", lambda arm, bad: words.circle((0, 0, 0, 0), (1, 1, 1, 1), bad), 1, 2**32 - 1),
    ("index", lambda arm, bad: words.motor(bad, 1), 0, 1),
    ("index", lambda arm, bad: words.motor_by(bad, 1, 1), 0, 1),
    ("index", lambda arm, bad: arm.conveyor(bad, 1), 0, 1),
    ("speed", lambda arm, bad: words.motor(commands.Stepper.STEPPER1, bad), -(2**31), 2**31 - 1),
    ("distance", lambda arm, bad: words.motor_by(commands.Stepper.STEPPER1, 1, bad), 0, 2**32 - 1),
    ("times", lambda arm, bad: Plan.path(ROWS) * bad, 0, 2**32 - 1),
    ("rows", lambda arm, bad: Plan.path(ROWS).on_grid(bad, 1, (1, 1)), 1, 2**32 - 1),
    ("columns", lambda arm, bad: Plan.path(ROWS).on_pallet(1, bad, (0, 0, 0), (1, 0, 0), (0, 1, 0)), 1, 2**32 - 1),
    ("step", lambda arm, bad: Plan.path(ROWS).from_step(bad), 1, 5),
    ("address", lambda arm, bad: VirtualArm().set_input(bad, True), 1, 20),
    ("value", lambda arm, bad: VirtualArm().set_analog(1, bad), 0, 4095),
    ("joint", lambda arm, bad: VirtualArm().slip(bad, 1), 1, 4),
    ("code", lambda arm, bad: VirtualArm().raise_alarm(bad), 0, 255),
    ("timeout", lambda arm, bad: arm.set(commands.WaitCmd(bad)), 0, 2**32 - 1),
]


@pytest.mark.parametrize(("name", "call", "least", "most"), WHOLE, ids=[name for name, *_ in WHOLE])
def test_whole_numbers(arm: Arm, name: str, call: Callable[[Arm, Any], object], least: int, most: int) -> None:
    for bad in (least - 1, most + 1, 2**70, -(2**70)):
        with pytest.raises(InvalidInputError, match=rf"{name}.* {bad}\b.* from {least} to {most}") as caught:
            call(arm, bad)
        if caught.value.limit is not None:
            assert (caught.value.value, caught.value.limit) == (bad, least if bad < least else most)
    for wrong in (2.5, "2", True, None, [1]):
        with pytest.raises(TypeError, match=name):
            call(arm, wrong)


REAL: list[tuple[str, Callable[[Arm, Path, Any], object]]] = [
    ("timeout", lambda arm, sample, bad: Arm("sim", timeout=bad)),
    ("timeout", lambda arm, sample, bad: VirtualArm().arm(timeout=bad)),
    ("timeout", lambda arm, sample, bad: setattr(arm, "timeout", bad)),
    ("echo", lambda arm, sample, bad: Arm("sim", echo=bad)),
    ("rate", lambda arm, sample, bad: arm.state(bad)),
    ("horizon", lambda arm, sample, bad: arm.begin([], horizon=bad)),
    ("laser_horizon", lambda arm, sample, bad: arm.begin([], laser_horizon=bad)),
    ("patience", lambda arm, sample, bad: arm.begin([], patience=bad)),
    ("lift", lambda arm, sample, bad: arm.run(Plan.path(ROWS), lift=bad)),
    (r"park\[2\]", lambda arm, sample, bad: arm.run(Plan.path(ROWS), park=(200, 0, bad))),
    ("keep", lambda arm, sample, bad: arm.jog("x+", keep=bad)),
    ("x", lambda arm, sample, bad: arm.move_to(bad, 0, 0, 0)),
    ("dz", lambda arm, sample, bad: arm.move_by(dz=bad)),
    ("j2", lambda arm, sample, bad: arm.move_joints(0, bad, 0)),
    ("position", lambda arm, sample, bad: arm.rail_to(bad)),
    (r"via\[2\]", lambda arm, sample, bad: arm.arc_to((0, 0, bad, 0), (1, 1, 1, 1))),
    ("seconds", lambda arm, sample, bad: arm.wait(bad)),
    ("velocity", lambda arm, sample, bad: arm.speed(bad)),
    ("acceleration", lambda arm, sample, bad: arm.line_speed(10, bad)),
    (r"velocity\[0\]", lambda arm, sample, bad: arm.joint_speed([bad, 1, 1, 1], [1, 1, 1, 1])),
    ("height", lambda arm, sample, bad: arm.jump_height(bad, 10)),
    ("pulse_ms", lambda arm, sample, bad: arm.servo(4, bad)),
    ("frequency", lambda arm, sample, bad: arm.pwm(4, bad, 50)),
    ("mm_per_s", lambda arm, sample, bad: arm.conveyor(commands.Stepper.STEPPER1, bad)),
    ("mm", lambda arm, sample, bad: arm.conveyor_by(commands.Stepper.STEPPER1, bad, 10)),
    ("power", lambda arm, sample, bad: words.engrave_to(1, 2, 3, bad)),
    ("y", lambda arm, sample, bad: arm.tool(y=bad)),
    ("degrees", lambda arm, sample, bad: arm.lost_step_threshold(bad)),
    ("within", lambda arm, sample, bad: magician.discover(["127.0.0.1:9"], within=bad)),
    ("r", lambda arm, sample, bad: Plan.path(ROWS, r=bad)),
    ("lift", lambda arm, sample, bad: Plan.path(ROWS, lift=bad)),
    ("acceleration", lambda arm, sample, bad: Plan.path(ROWS, acceleration=bad)),
    (r"tool\[1\]", lambda arm, sample, bad: Plan.path(ROWS, tool=(0, bad, 0))),
    (r"surface\.slope\[0\]", lambda arm, sample, bad: Plan.path(ROWS, surface=magician.Surface(0, (bad, 0)))),
    ("z", lambda arm, sample, bad: Plan.path(ROWS).moved(z=bad)),
    ("factor", lambda arm, sample, bad: Plan.path(ROWS).scaled(bad)),
    (r"about\[1\]", lambda arm, sample, bad: Plan.path(ROWS).rotated(1, (0, bad))),
    (r"pitch\[0\]", lambda arm, sample, bad: Plan.path(ROWS).on_grid(2, 2, (bad, 1))),
    (
        r"sheet\.corner\[0\]",
        lambda arm, sample, bad: Plan.path(ROWS).preview(sheet=magician.Sheet((bad, 0), 0, (1, 1))),
    ),
    ("scale", lambda arm, sample, bad: Plan.path(ROWS).preview().png(bad)),
    ("speed", lambda arm, sample, bad: VirtualArm(speed=bad)),
    ("seconds", lambda arm, sample, bad: VirtualArm().advance(bad)),
    ("seconds", lambda arm, sample, bad: VirtualArm().delay_answers(bad)),
    ("degrees", lambda arm, sample, bad: VirtualArm().slip(1, bad)),
    (r"joints\[3\]", lambda arm, sample, bad: VirtualArm().guide([0, 0, 0, bad])),
]


@pytest.mark.parametrize(("name", "call"), REAL, ids=[name for name, _ in REAL])
def test_numbers(arm: Arm, sample: Path, name: str, call: Callable[[Arm, Path, Any], object]) -> None:
    for bad in (math.nan, math.inf, -math.inf, HUGE):
        with pytest.raises(InvalidInputError, match=rf"({name})\S* is (nan|inf|-inf)"):
            call(arm, sample, bad)
    for wrong in ("10", True, 1j, b"1", [1]):
        with pytest.raises((TypeError, InvalidInputError), match=rf"({name})\S* is .*; it takes|a number above 0"):
            call(arm, sample, wrong)


def test_times_have_a_least_and_a_most() -> None:
    for timeout in (0, -1, 1e6):
        with pytest.raises(InvalidInputError, match=f"timeout is {timeout:.12g} s; it takes .* above 0, at most 86400"):
            Arm("sim", timeout=timeout)
    with pytest.raises(InvalidInputError, match="timeout") as caught:
        Arm("sim", timeout=1e6)
    assert (caught.value.value, caught.value.limit, caught.value.unit) == (1e6, 86_400, "s")
    with Arm("sim", timeout=60, window=8, echo=0) as arm:
        arm.timeout = 5
        assert arm.timeout == 5


def test_numbers_of_other_kinds_are_numbers(arm: Arm) -> None:
    numpy = pytest.importorskip("numpy")
    arm.move_to(numpy.float32(210), numpy.int16(10), Decimal("20.5"), r=numpy.float64(0))  # type: ignore[call-overload]
    assert arm.pose().position == pytest.approx((210, 10, 20.5, 0), abs=1e-3)
    assert repr(words.move_by(dx=numpy.float64(1.5))).count("float64") == 0
    arm.wait_for(numpy.uint64(0))
    assert arm.state(numpy.int64(10), inputs=numpy.array([19])).changed().inputs == {19: False}
    with pytest.raises(TypeError, match="index"):
        arm.wait_for(numpy.float64(0))


def test_names_in_place_of_lists_of_names() -> None:
    with Arm("sim") as arm, pytest.raises(TypeError, match=r"\['reach'\]"):
        arm.perform([], skip="reach")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"\['arm.local'\]"):
        magician.discover("arm.local")


def test_invalid_ports_are_refused() -> None:
    for port in (5, b"sim", Arm):
        with pytest.raises(TypeError, match=r"port is .*; it takes a name, a path or a virtual arm"):
            Arm(port)  # type: ignore[arg-type]


def test_fields_of_commands_are_named(arm: Arm) -> None:
    for command, name in (
        (commands.PtpCmd(commands.PtpMode.MOVJ_XYZ, "1", 0, 0, 0), "x"),  # type: ignore[arg-type]
        (commands.PtpCmd("fast", 0, 0, 0, 0), "ptp_mode"),  # type: ignore[arg-type]
        (commands.PtpCommonParams(True, 1), "velocity_ratio"),
        (commands.HomeCmd("0"), "reserved"),  # type: ignore[arg-type]
        (commands.PtpJointParams((1, 2, "3", 4), (1, 2, 3, 4)), "velocity"),  # type: ignore[arg-type]
    ):
        with pytest.raises(TypeError, match=rf"\.{name}: "):
            arm.enqueue(command)
    with pytest.raises(InvalidInputError, match="3 values, not 4"):
        arm.set(commands.PtpJointParams((1, 2, 3), (1, 2, 3, 4)))  # type: ignore[arg-type]


def test_truth_values_texts_and_functions(arm: Arm, sample: Path) -> None:
    numpy = pytest.importorskip("numpy")
    anything: Any = arm
    plan, load = Plan.path(ROWS), magician.load
    path: Any = Plan.path
    calls: list[tuple[str, Callable[[Any], object]]] = [
        ("probe", lambda bad: Arm("sim", probe=bad)),
        ("reconnect", lambda bad: Arm("sim", reconnect=bad)),
        ("keep", lambda bad: arm.perform([], keep=bad)),
        ("trust_pose", lambda bad: arm.begin([], trust_pose=bad)),
        ("allow_laser", lambda bad: arm.run(plan, allow_laser=bad)),
        ("allow_laser", lambda bad: arm.begin([], allow_laser=bad)),
        ("unhomed", lambda bad: arm.run(plan, unhomed=bad)),
        ("stay", lambda bad: arm.run(plan, stay=bad)),
        ("allow_dangerous", lambda bad: arm.raw(10, allow_dangerous=bad)),
        ("on", arm.suction),
        ("high", lambda bad: arm.output(1, bad)),
        ("level", lambda bad: VirtualArm().set_input(1, bad)),
        ("side", lambda bad: plan.preview(side=bad)),
    ]
    none: list[Any] = ["yes", 2, 0.5, [], numpy.array([1, 0])]
    for name, call in calls:
        for bad in none:
            with pytest.raises(TypeError, match=rf"{name} is .*; it takes True or False"):
                call(bad)
    arm.suction(numpy.True_)
    from_json: Any = Plan.from_json
    calls = [
        ("by", lambda bad: path(ROWS, by=bad)),
        ("title", lambda bad: Plan.of([], title=bad)),
        ("json", from_json),
    ]
    for name, call in calls:
        with pytest.raises(TypeError, match=f"{name} is 3 .*; it takes a text"):
            call(3)
    for verb in (anything.run, anything.perform):
        with pytest.raises(TypeError, match=r"progress is 'x' \(str\); it takes a function"):
            verb([words.wait(0)], progress="x")
    for wrong in (3, [words.wait(0)]):
        with pytest.raises(TypeError, match="expected a Plan, not"):
            anything.check(wrong)
    with pytest.raises(TypeError, match=r"sheet is \(1, 2\); it takes a Sheet"):
        load(sample, sheet=(1, 2))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="params are bytes, not 'x'"):
        anything.raw(10, 0, "x")
    assert arm.raw(10, params=memoryview(b"")) == arm.raw(10)
    with pytest.raises(TypeError, match="is not a point-to-point move"):
        words.with_rail(words.home(), 5)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match=r"takes values: GetIoDi\(...\)"):
        anything.get(commands.GetIoDi)


def test_every_option_that_a_remedy_names_is_an_argument_or_a_call() -> None:
    """What to do about an error is said with these names (``voice.rs``)."""
    source = ROOT / "crates" / "magician-host" / "src" / "remedy.rs"
    options = source.read_text(encoding="utf-8").split("    Setting {", 1)[1].split("\n    }", 1)[0]
    names = set(re.findall(r'^ +[A-Z]\w+ = "(\w+)",$', options, re.MULTILINE))
    takers = (magician.load, magician.doctor, Arm, Arm.run)
    taken = {name for taker in takers for name in inspect.signature(taker).parameters}
    taken |= set(SetupOptions.__annotations__)
    calls = {"loops": Plan.repeated, "speed_ratio": Arm.speed}
    assert len(names) > 20 and names - taken == set(calls)

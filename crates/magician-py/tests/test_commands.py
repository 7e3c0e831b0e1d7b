"""Every row of the table: from Python to bytes and back."""

from __future__ import annotations

import dataclasses
import pickle
import typing
from pathlib import Path
from typing import Any

import magician
import pytest
from magician import _magician, commands, errors
from magician._protocol import Answer, Command, OpenEnum, Query, Queueable, Readable, Writable

CLASSES: list[type[Any]] = [
    each
    for each in vars(commands).values()
    if isinstance(each, type) and issubclass(each, Command) and dataclasses.is_dataclass(each)
]
VECTORS = Path(__file__).parents[2] / "magician-protocol" / "tests" / "data"


def sample(kind: Any, seed: int) -> Any:
    """A value of a field's type."""
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is tuple and args[-1] is Ellipsis:
        return tuple(sample(args[0], seed + at) for at in range(3))
    if origin is tuple:
        return tuple(sample(item, seed + at) for at, item in enumerate(args))
    if args:  # X | None
        return sample(args[0], seed)
    if kind is magician.Alarm:
        return sorted(magician.Alarm)[seed]
    if issubclass(kind, OpenEnum):
        return list(kind)[seed % len(kind)]
    if kind is commands.Output:
        return commands.Output(20 * seed, seed + 1, seed % 2 == 0)
    return {
        bool: seed % 2 == 0,
        int: 7 * seed + 1,
        float: round(-12.345 * seed + 0.1, 3),
        str: "hé",
        bytes: b"\x01\xff",
    }[kind]


def instance(cls: type[Any]) -> Any:
    hints = typing.get_type_hints(cls)
    return cls(*(sample(hints[field.name], at) for at, field in enumerate(dataclasses.fields(cls))))


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_round_trip(cls: type[Any]) -> None:
    command = instance(cls)
    params = bytes(command)
    assert cls.from_bytes(params) == command
    assert pickle.loads(pickle.dumps(command)) == command
    if issubclass(cls, Writable):
        assert _magician.command(cls.ID, params) == command
        assert type(_magician.command(cls.ID, params)) is cls


def test_every_class_is_there() -> None:
    assert len(CLASSES) == len({cls.LAYOUT for cls in CLASSES}) == 106
    assert {cls.__name__ for cls in CLASSES} <= set(commands.__all__)
    assert len({cls.ID for cls in CLASSES}) == 90


@pytest.mark.parametrize("file, name", [("vectors.toml", "vector"), ("golden.toml", "frame")])
def test_golden_bytes(file: str, name: str) -> None:
    """The frames of the protocol's own tests, decoded to the values that stand beside them."""
    tomllib = pytest.importorskip("tomllib")
    vectors = tomllib.loads((VECTORS / file).read_text(encoding="utf-8"))[name]
    checked = 0
    for vector in vectors:
        plain = vector.get("semantic", "ok") == "ok" and vector.get("frame_valid", True) and vector.get("decoded")
        if not plain or "_extra_hex" in vector["decoded"]:
            continue
        form = "set" if vector["ctrl"] & 3 else "get"
        if (form == "set") != (vector["direction"] == "host_to_device"):
            continue
        cls = commands.__dict__.get(_magician.find(vector["command"], form))
        if cls is None or issubclass(cls, Query):
            continue
        params = bytes.fromhex(vector["hex"])[5:-1]
        decoded = cls.from_bytes(params)
        assert bytes(decoded) == params, vector
        for field, expected in vector["decoded"].items():
            value = getattr(decoded, field, None)
            if isinstance(expected, (int, float)) and isinstance(value, (int, float)):
                assert value == pytest.approx(expected, rel=1e-6), (vector, field)
                checked += 1
    assert checked > 30


def test_get_after_set_returns_the_set_value(arm: magician.Arm) -> None:
    speeds = commands.PtpCommonParams(velocity_ratio=33.3, acceleration_ratio=12.7)
    arm.set(speeds)
    assert arm.get(commands.PtpCommonParams) == speeds


def test_unknown_values_pass() -> None:
    mode = commands.PtpMode(77)
    assert (mode, mode.name, repr(mode)) == (77, "UNKNOWN_77", "PtpMode(77)")
    command = commands.PtpCmd(mode, 1, 2, 3, 4)
    assert commands.PtpCmd.from_bytes(bytes(command)) == command
    assert hash(mode) == hash(commands.PtpMode(77))
    with pytest.raises(ValueError):
        commands.PtpMode(256)


def test_base_class_of_a_command_states_its_uses() -> None:
    assert issubclass(commands.Pose, Readable) and not issubclass(commands.Pose, Writable)
    assert issubclass(commands.IoDi, Answer) and not issubclass(commands.IoDi, Readable)
    assert issubclass(commands.LostStepParams, Writable) and not issubclass(commands.LostStepParams, Queueable)
    assert issubclass(commands.QueuedCmdClear, Writable) and not issubclass(commands.QueuedCmdClear, Queueable)


@pytest.mark.parametrize(
    "command, message",
    [
        (commands.WaitCmd(-1), "timeout: -1 is not from 0 to 4294967295"),
        (commands.WaitCmd(2**70), "is not from 0 to 4294967295"),
        (commands.IoDo(256, True), "address: 256 is not from 0 to 255"),
        (commands.HomeParams(1e300, 0, 0, 0), "x: 1e300 is beyond the arm's largest number"),
        (commands.PtpJointParams((1, 2), (1, 2, 3, 4)), "velocity: 2 values, not 4"),  # type: ignore[arg-type]
        (commands.DeviceName("a\0b"), "NUL"),
        (commands.DeviceName("x" * 300), "too long"),
        (commands.PtpPoCmd(commands.PtpMode(0), 0, 0, 0, 0, (commands.Output(0, 1, True),) * 58), "at most 57 fit"),
    ],
)
def test_values_that_do_not_fit(command: Command, message: str) -> None:
    with pytest.raises(errors.InvalidInputError, match=message) as caught:
        bytes(command)
    assert isinstance(caught.value, ValueError)
    assert caught.value.command


def test_values_of_the_wrong_kind() -> None:
    with pytest.raises(TypeError, match=r"HOMEParams\.x"):
        bytes(commands.HomeParams("1", 0, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="not a command"):
        _magician.encode("Pose")  # type: ignore[arg-type]
    with pytest.raises(errors.UnexpectedError):
        commands.Pose.from_bytes(b"123")


def test_optional_fields_may_be_omitted() -> None:
    assert bytes(commands.SetDeviceWithL(True)) == b"\x01"
    assert bytes(commands.SetDeviceWithL(True, commands.RailVersion.V2)) == b"\x01\x01"
    assert commands.SetDeviceWithL.from_bytes(b"\x01") == commands.SetDeviceWithL(True, None)
    assert commands.DeviceVersion.from_bytes(b"\x03\x02\x01") == commands.DeviceVersion(3, 2, 1, b"")
    assert commands.ResetPose.from_bytes(b"\x00").rear_arm_angle == 0


def test_values_are_values() -> None:
    pose = commands.Pose(200, 0, 50, 10, (1, 2, 3, 4))
    assert (pose.j1, pose.j2, pose.j3, pose.j4) == (1, 2, 3, 4) == pose.joints
    assert pose.position == (200, 0, 50, 10) and pose.position.z == 50 and pose.joints.j3 == 3
    assert {pose: 1}[commands.Pose(200, 0, 50, 10, (1, 2, 3, 4))] == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        pose.x = 3  # type: ignore[misc]
    assert commands.ColorSensor(10, 200, 12).color is magician.Color.GREEN
    assert commands.ColorSensor(0, 0, 0).color is None
    assert commands.IoAdc(12, 4095).volts == 3.3
    assert commands.IrSwitch(True) and not commands.IoDi(1, False)


def test_an_alarm_is_written_as_text_or_as_its_number() -> None:
    alarm = magician.Alarm(0x11)
    assert f"{alarm}" == str(alarm)
    assert str(alarm).startswith("0x11 PLAN")
    assert f"0x{alarm:02x}" == "0x11"


def test_unknown_names_get_suggestions(arm: magician.Arm) -> None:
    for name, meant in (("Poses", "Pose"), ("GetPoze", "Pose"), ("devicesno", "DeviceSn"), ("IO-DII", "GetIoDi")):
        with pytest.raises(errors.InvalidInputError, match=rf"`{name}` to get; did you mean [^?]*\b{meant}\b.*\?"):
            arm.get(name)
    with pytest.raises(errors.InvalidInputError, match=r"`PTPCmdd` to set; did you mean PtpCmd"):
        arm.enqueue("PTPCmdd")
    with pytest.raises(errors.InvalidInputError, match=r"`PtpComonParams` to set; did you mean PtpCommonParams"):
        arm.set("PtpComonParams", velocity_ratio=50, acceleration_ratio=50)
    with pytest.raises(errors.InvalidInputError, match=r"`qqqq` to get$"):
        arm.get("qqqq")


def test_unknown_fields_get_suggestions(arm: magician.Arm) -> None:
    with pytest.raises(TypeError, match=r"GetIoDi has no field `adress`; did you mean address\?"):
        arm.get("IODI", adress=19)
    with pytest.raises(TypeError, match=r"HomeParams has no field `velocity`; it has x, y, z, r"):
        arm.set("HomeParams", velocity=3)
    with pytest.raises(TypeError, match=r"PtpCommonParams takes acceleration_ratio as well"):
        arm.set("PTPCommonParams", velocity_ratio=50)
    with pytest.raises(TypeError, match=r"Pose is asked for without x"):
        arm.get("Pose", x=1)


def test_enums_are_shown_as_they_are_typed() -> None:
    mode = commands.PtpMode.MOVJ_XYZ
    assert (repr(mode), str(mode), f"{mode}", f"{mode:d}", f"{mode:02x}") == (
        "PtpMode.MOVJ_XYZ", "MOVJ_XYZ", "MOVJ_XYZ", "1", "01",
    )  # fmt: skip
    unknown = commands.PtpMode(200)
    assert (repr(unknown), str(unknown), f"{unknown}") == ("PtpMode(200)", "UNKNOWN_200", "UNKNOWN_200")
    command = magician.words.move_to(1, 2.5, 3, 4)
    assert repr(command) == "PtpCmd(ptp_mode=PtpMode.MOVJ_XYZ, x=1.0, y=2.5, z=3.0, r=4.0)"
    assert eval(repr(command), dict(vars(commands))) == command
    alarm = magician.Alarm(0x12)
    assert (
        repr(alarm) == f"Alarm.{alarm.name}" and str(alarm).startswith(f"0x12 {alarm.name}: ") and f"{alarm:x}" == "12"
    )


def test_commands_behave_as_dataclasses() -> None:
    pose = commands.Pose(1, 2, 3, 4, (5, 6, 7, 8))
    moved: Any = dataclasses.replace(pose, x=10)
    assert moved == commands.Pose(10, 2, 3, 4, (5, 6, 7, 8)) and type(moved) is commands.Pose
    assert dataclasses.asdict(pose)["joint_angle"] == (5, 6, 7, 8)
    rail: Any = commands.SetDeviceWithL
    assert [(each.name, each.default) for each in dataclasses.fields(rail)] == [
        ("with_l", dataclasses.MISSING), ("version", None),
    ]  # fmt: skip
    assert not dataclasses.is_dataclass(Command) and dataclasses.fields(rail(True))


def test_commands_are_made_of_their_fields() -> None:
    anything: Any = commands.PtpCommonParams
    assert anything(acceleration_ratio=2, velocity_ratio=1) == anything(1, 2) == anything(1, acceleration_ratio=2)
    for values, named, message in (
        ((1,), {}, "takes acceleration_ratio as well"),
        ((1, 2, 3), {}, "takes 2 values, and 3 were given"),
        ((1, 2), {"velocity_ratio": 1}, "multiple values for 'velocity_ratio'"),
        ((1, 2), {"ratio": 1}, "no field 'ratio'; it has velocity_ratio, acceleration_ratio"),
    ):
        with pytest.raises(TypeError, match=message):
            anything(*values, **named)
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete field 'velocity_ratio'"):
        del anything(1, 2).velocity_ratio
    assert anything(1, 2) != (1, 2) and anything(1, 2) != commands.JogCommonParams(1, 2)

"""Calls of DobotLab, as in DobotEDU and pydobotlab: one table for both.

A row has the name of a call, its parameters and its frame. The first 28 are those of DobotLab's manual (3.6.1 to
3.6.28), in its order. pydobotlab uses the manual's names, DobotEDU second names for the calls and own names for the
parameters. Only DobotEDU has the other calls.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

from ._line import GET, QUEUED, SET, Line

__all__ = ["CALLS", "Call", "Number", "Record", "exchange", "io"]


class Call(NamedTuple):
    """Call with its frame."""

    lab: str
    """Its name and parameters in DobotLab; empty where that has none."""
    edu: str
    """Its name and parameters in DobotEDU, after the port's name; ``a=1`` has a default."""
    id: int
    how: int
    """``GET``, ``SET`` or ``QUEUED``."""
    format: str
    """How the parameters travel, as :mod:`struct` writes it; of a call that gets something, how its query does."""
    order: str = ""
    """Which parameter travels where, where that is not their order."""
    answer: str = ""
    """How the answer of a call that gets something is read, and under which keys."""
    moves: bool = False
    """Whether it is waited for, and whether the arm may refuse it."""
    sensor: bool = False
    """Whether its port is one of GP1 to GP4 (5), which DobotEDU counts from 1 and the arm from 0."""


CALLS = (
    Call("ptp mode x y z r", "set_ptpcmd ptp_mode x y z r", 84, QUEUED, "B4f", moves=True),
    Call("set_device_withl enable version=0", "set_device_withl enable=1 version=1", 3, SET, "2B"),
    Call("set_ptpl_params vel accel", "set_ptpl_params velocity acceleration", 85, QUEUED, "2f"),
    Call("set_ptpwithl_cmd mode x y z r l", "set_ptpwithl_cmd mode x y z r set_l", 86, QUEUED, "B5f", moves=True),
    # A joint move to the current pose with the new angle.
    Call("set_r r", "set_rcmd r", 84, QUEUED, "", moves=True),
    Call("motion_params vel acc", "set_ptpcommon_params vel acc", 83, QUEUED, "2f"),
    Call("jump_params zlimit height", "set_ptpjump_params z_limit jump_height", 82, QUEUED, "2f", "1 0"),
    Call("set_multiplexing io multiplex", "set_iomultiplexing port multiplex", 130, QUEUED, "2B"),
    Call("set_pwm io freq cycle", "set_iopwm port frequency duty_cycle", 132, QUEUED, "B2f"),
    Call("set_do io level", "set_iodo port level", 131, QUEUED, "2B"),
    Call("get_di io", "get_iodi port", 133, GET, "B", answer="xB level"),
    Call("get_adc io", "get_ioadc port", 134, GET, "B", answer="xH value"),
    Call("set_endeffector_suctioncup enable on", "set_endeffector_suctioncup enable on", 62, QUEUED, "2B"),
    Call("set_endeffector_gripper enable on", "set_endeffector_gripper enable on", 63, QUEUED, "2B"),
    Call("set_infrared_sensor port enable version=1", "set_infrared_sensor port enable=1 version=1", 138, QUEUED, "3B",
         "1 0 2", sensor=True),
    Call("get_infrared_sensor port", "get_infrared_sensor port", 138, GET, "B", answer="B status", sensor=True),
    Call("set_color_sensor port enable version=0", "set_color_sensor port enable=1 version=1", 137, QUEUED, "3B",
         "1 0 2", sensor=True),
    Call("get_color_sensor", "get_color_sensor", 137, GET, "", answer="3B red green blue"),
    # Seconds here, milliseconds in the frame.
    Call("wait second", "wait delay", 110, QUEUED, "I", moves=True),
    Call("set_home", "set_homecmd", 31, QUEUED, "4x", moves=True),
    Call("get_pose", "get_pose", 10, GET, "", answer="8f x y z r jointAngle"),
    Call("get_posel", "get_posel", 13, GET, "", answer="f positionL"),
    Call("clear_alarm", "clear_allalarms_state", 20, SET, ""),
    # 0 for jogging, otherwise for moves. The query carries no mode.
    Call("get_arm_speed_ratio mode", "get_arm_speed_ratio mode", 83, GET, "", answer="2f value acceleration"),
    Call("set_lost_step_params value", "set_lost_step_params value", 170, SET, "f"),
    Call("set_lost_step_cmd", "set_lost_step_cmd", 171, QUEUED, "", moves=True),
    Call("get_lost_step_result", "get_lost_step_result", 20, GET, "", answer="state"),
    Call("set_converyor index enable speed", "set_converyor index enable speed", 135, QUEUED, "2Bi"),
    # DobotEDU only.
    Call("", "get_devicesn", 0, GET, "", answer="text"),
    Call("", "get_devicename", 1, GET, "", answer="text"),
    Call("", "set_waitcmd delay", 110, QUEUED, "I", moves=True),
    Call("", "get_alarms_state", 20, GET, "", answer="state"),
    Call("", "set_homeparams x y z r", 30, QUEUED, "4f"),
    Call("", "get_homeparams", 30, GET, "", answer="4f x y z r"),
    Call("", "set_hhttrig_mode mode", 40, SET, "B"),
    Call("", "get_hhttrig_mode", 40, GET, "", answer="B mode"),
    Call("", "set_hhttrig_output_enabled enable", 41, SET, "B"),
    Call("", "get_hhttrig_output_enabled", 41, GET, "", answer="B enable"),
    Call("", "get_hhttrig_output", 42, GET, "", answer="B isTriggered"),
    Call("", "set_endeffector_params x_offset y_offset z_offset", 60, QUEUED, "3f"),
    Call("", "get_endeffector_params", 60, GET, "", answer="3f xOffset yOffset zOffset"),
    Call("", "set_endeffector_laser enable on", 61, QUEUED, "2B"),
    Call("", "get_endeffector_laser", 61, GET, "", answer="2B enable on"),
    Call("", "get_endeffector_suctioncup", 62, GET, "", answer="2B enable on"),
    Call("", "get_endeffector_gripper", 63, GET, "", answer="2B enable on"),
    Call("", "set_jogcommon_params velocity_ratio acceleration_ratio", 72, QUEUED, "2f"),
    Call("", "get_jogcommon_params", 72, GET, "", answer="2f velocityRatio accelerationRatio"),
    Call("", "set_jogcmd is_joint cmd", 73, SET, "2B"),
    Call("", "get_ptpl_params", 85, GET, "", answer="2f velocity acceleration"),
    Call("", "set_ptpcoordinate_params xyz_velocity r_velocity xyz_acceleration r_acceleration", 81, QUEUED, "4f"),
    Call("", "get_ptpcoordinate_params", 81, GET, "",
         answer="4f xyzVelocity rVelocity xyzAcceleration rAcceleration"),
    Call("", "get_ptpjump_params", 82, GET, "", answer="2f jumpHeight zLimit"),
    Call("", "get_ptpcommon_params", 83, GET, "", answer="2f velocityRatio accelerationRatio"),
    Call("", "set_cpparams target_acc junction_vel isreal_timetrack=0 acc=0 period=0", 90, QUEUED, "3fB", "0 1 3 2"),
    Call("", "set_cpcmd cp_mode x y z power", 91, QUEUED, "B4f", moves=True),
    Call("", "set_cplecmd cp_mode x y z power", 92, QUEUED, "B4f", moves=True),
    Call("", "set_arcparams xyz_velocity r_velocity xyz_acceleration r_acceleration", 100, QUEUED, "4f"),
    Call("", "get_iodo port", 131, GET, "B", answer="xB level"),
    Call("", "get_iomultiplexing port", 130, GET, "B", answer="xB multiplex"),
    Call("", "set_emotor index enable speed", 135, QUEUED, "2Bi"),
    Call("", "set_emotors index enable speed distance", 136, QUEUED, "2BiI"),
    Call("", "queuedcmd_start", 240, SET, ""),
    Call("", "queuedcmd_clear", 245, SET, ""),
    Call("", "get_queuedcmd_currentindex", 246, GET, "", answer="Q currentIndex"),
    Call("", "queuedcmd_left_space", 247, GET, "", answer="I leftSpace"),
)  # fmt: skip


class Number(int):
    """Number that can also be read by its key, since programs do either."""

    key: str

    @classmethod
    def of(cls, key: str, value: int) -> Number:
        """Creates a number with its key."""
        number = cls(value)
        number.key = key
        return number

    def __getitem__(self, key: str) -> int:
        if key != self.key:
            raise KeyError(key)
        return int(self)

    def get(self, key: str, default: Any = None) -> Any:
        """Returns the value of its key."""
        return int(self) if key == self.key else default


class Record(dict[Any, Any]):
    """Values by key, by index and by iteration: ``pose["x"]``, ``pose[0]``, ``x, y, *_ = pose``."""

    def __getitem__(self, key: Any) -> Any:
        return list(self.values())[key] if isinstance(key, (int, slice)) else super().__getitem__(key)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values())


def io(pin: int | str) -> int:
    """Returns the number of a pin, given by number or label: ``DO_01``, ``DI_07``, ``AD_09``, ``AI_09``.

    :raises ValueError: There is no such pin.
    """
    number = pin
    if isinstance(pin, str):
        label = pin.upper().removeprefix("EIO").removeprefix("IO")
        for kind in ("DO_", "DI_", "AD_", "AI_", "PWM_"):
            label = label.removeprefix(kind)
        number = int(label) if label.isdigit() else 0
    if not 1 <= int(number) <= 20:
        raise ValueError(f"no pin {pin!r}: they are 1 to 20, or DO_01, DI_07, AD_09")
    return int(number)


def exchange(line: Line, call: Call, values: list[Any], *, queued: bool = True, wait: bool = True) -> Any:
    """Executes a call with these parameter values. Returns the value that it reads, or ``True`` once it is done."""
    id, ctrl = call.id, call.how
    name = call.edu.partition(" ")[0]
    if name in ("wait", "set_waitcmd"):
        values = [max(0, round(values[0] * (1000 if name == "wait" else 1)))]
    elif name == "get_arm_speed_ratio" and values.pop(0) == 0:
        id = 72
    if call.order:
        values = [values[int(at)] for at in call.order.split()]
    if name == "set_rcmd":
        body = struct.pack("<B4f", 1, *struct.unpack_from("<3f", line.exchange(10, GET, b"")[1]), values[0])
    else:
        kinds = struct.Struct(f"<{call.format}")
        letters = "".join(c * int(n or 1) for n, c in _letters(call.format))
        body = kinds.pack(*(float(v) if c == "f" else int(v) for c, v in zip(letters, values, strict=True)))
    if ctrl == QUEUED and not queued and not call.moves:
        ctrl = SET
    _, params = line.exchange(id, ctrl, body)
    if ctrl == GET:
        return _read(call.answer, bytes(params))
    if ctrl == QUEUED and wait:
        line.finish(int.from_bytes(params[:8], "little"), call.moves)
    return True


def _letters(format: str) -> list[tuple[str, str]]:
    """Returns the counts and letters of a ``struct`` format."""
    found: list[tuple[str, str]] = []
    count = ""
    for letter in format:
        if letter.isdigit():
            count += letter
        else:
            if letter != "x":
                found.append((count, letter))
            count = ""
    return found


def _read(answer: str, params: bytes) -> Any:
    format, *keys = answer.split()
    if format == "text":
        return params.split(b"\0")[0].decode("utf-8", "replace")
    if format == "state":
        return list(params)
    values: list[Any] = list(struct.unpack_from(f"<{format}", params))
    if keys[-1] == "jointAngle":
        values = [*values[:4], values[4:]]
    if len(values) == 1 and isinstance(values[0], int):
        return Number.of(keys[0], values[0])
    return Record(zip(keys, values, strict=True))

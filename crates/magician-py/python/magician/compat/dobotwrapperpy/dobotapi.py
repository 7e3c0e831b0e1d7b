"""Arm of dobotWrapperPy: a frame for each call of its table."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable, Iterator
from enum import Enum
from typing import Any, cast

from .._alarm import Alarm
from .._line import GET, QUEUED, SET
from . import _enums, paramsStructures
from .dobotConnection import DobotConnection

__all__ = ["DobotApi"]

# Calls that set a value: id, and encoding of the argument.
SETS = {
    "reset_pose": (11, "B2f"),
    "set_angle_sensor_static_error": (140, "2f"),
    "set_arc_cmd": (101, "8f"),
    "set_arc_params": (100, "4f"),
    "set_autoleveling": (32, "Bf"),
    "set_color_sensor": (137, "3B"),
    "set_cp_cmd": (91, "B4f"),
    "set_cp_le_cmd": (92, "B4f"),
    "set_cp_params": (90, "3fB"),
    "set_device_rail_capability": (3, "2B"),
    "set_e_motor": (135, "2Bi"),
    "set_e_motor_distance": (136, "2BiI"),
    "set_end_effector_laser": (61, "2B"),
    "set_end_effector_params": (60, "3f"),
    "set_hht_trig_mode": (40, "B"),
    "set_hht_trig_output_enabled": (41, "B"),
    "set_home_cmd": (31, "I"),
    "set_home_params": (30, "4f"),
    "set_io_do": (131, "2B"),
    "set_io_multiplexing": (130, "2B"),
    "set_io_pwm": (132, "B2f"),
    "set_ir_switch": (138, "3B"),
    "set_jog_cmd": (73, "2B"),
    "set_jog_common_params": (72, "2f"),
    "set_jog_coordinate_params": (71, "8f"),
    "set_jog_joint_params": (70, "8f"),
    "set_jogl_params": (74, "2f"),
    "set_lost_step_cmd": (171, ""),
    "set_lost_step_params": (170, "f"),
    "set_ptp_cmd": (84, "B4f"),
    "set_ptp_common_params": (83, "2f"),
    "set_ptp_coordinate_params": (81, "4f"),
    "set_ptp_joint_params": (80, "8f"),
    "set_ptp_jump2_params": (87, "3f"),
    "set_ptp_jump_params": (82, "2f"),
    "set_ptp_with_rail_cmd": (86, "B5f"),
    "set_ptpl_params": (85, "2f"),
    "set_queued_cmd_clear": (245, ""),
    "set_queued_cmd_force_stop_exec": (242, ""),
    "set_queued_cmd_start_download": (243, "2I"),
    "set_queued_cmd_start_exec": (240, ""),
    "set_queued_cmd_stop_download": (244, ""),
    "set_queued_cmd_stop_exec": (241, ""),
    "set_trig_cmd": (120, "3BH"),
    "set_wait_cmd": (110, "I"),
    "clear_all_alarms_state": (20, ""),
}
# Calls that read a value: id, decoding of the reply, and returned type.
GETS: dict[str, tuple[int, str, str]] = {
    "get_angle_sensor_static_error": (140, "2f", ""),
    "get_arc_params": (100, "4f", "tagARCParams"),
    "get_cp_params": (90, "3fB", "tagCPParams"),
    "get_device_id": (5, "3I", ""),
    "get_device_rail_capability": (3, "?", ""),
    "get_device_time": (4, "I", ""),
    "get_device_version": (2, "3B", ""),
    "get_end_effector_gripper": (63, "2?", ""),
    "get_end_effector_laser": (61, "2?", ""),
    "get_end_effector_params": (60, "3f", "tagEndEffectorParams"),
    "get_end_effector_suction_cup": (62, "2?", ""),
    "get_hht_trig_mode": (40, "B", "HHTTrigMode"),
    "get_hht_trig_output": (42, "?", ""),
    "get_hht_trig_output_enabled": (41, "?", ""),
    "get_home_params": (30, "4f", "tagHomeParams"),
    "get_io_adc": (134, "xH", ""),
    "get_io_di": (133, "xB", "Level"),
    "get_io_do": (131, "xB", "Level"),
    "get_io_multiplexing": (130, "xB", "IOFunction"),
    "get_io_pwm": (132, "B2f", "tagIOPWM"),
    "get_ir_switch": (138, "?", ""),
    "get_color_sensor": (137, "3B", ""),
    "get_jog_common_params": (72, "2f", "tagJOGCommonParams"),
    "get_jogl_params": (74, "2f", "tagJOGLParams"),
    "get_pose_rail": (13, "f", ""),
    "get_ptp_common_params": (83, "2f", "tagPTPCommonParams"),
    "get_ptp_coordinate_params": (81, "4f", "tagPTPCoordinateParams"),
    "get_ptp_jump2_params": (87, "3f", "tagPTPJump2Params"),
    "get_ptp_jump_params": (82, "2f", "tagPTPJumpParams"),
    "get_ptpl_params": (85, "2f", "tagPTPLParams"),
    "get_queued_cmd_current_index": (246, "Q", ""),
}
MOTIONS = {"set_ptp_cmd", "set_ptp_with_rail_cmd", "set_cp_cmd", "set_cp_le_cmd", "set_arc_cmd", "set_home_cmd"}


def _flat(value: Any) -> Iterator[Any]:
    """Returns the numbers in a value in wire order."""
    if isinstance(value, Enum):
        yield value.value
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _flat(getattr(value, field.name))
    elif isinstance(value, (list, tuple)):
        for each in cast("list[Any]", value):
            yield from _flat(each)
    else:
        yield value


class DobotApi:
    """Arm: ``set_..(params, wait=False, is_queued=False)`` returns the index if it is queued, ``get_..()`` returns the
    value.

    With ``wait``, a queued call returns when it is done.
    """

    def __init__(self, dobot_connection: DobotConnection, verbose: bool = False) -> None:
        self.conn, self.verbose = dobot_connection, verbose

    def initialize_robot(self) -> None:
        """Starts and clears the queue, and sets all speeds to 200."""
        self._send(240, SET)
        self._send(245, SET)
        for id, values in ((80, [200.0] * 8), (81, [200.0] * 4), (82, [10.0, 200.0]), (83, [100.0, 100.0])):
            self._send(id, QUEUED, struct.pack(f"<{len(values)}f", *values))
        self.get_pose()

    def close(self) -> None:
        """Ends the connection."""
        self.conn.line.close()

    def _send(self, id: int, ctrl: int, params: bytes = b"") -> bytes:
        return bytes(self.conn.line.exchange(id, ctrl, params)[1])

    def _set(self, id: int, params: bytes, wait: bool, is_queued: bool, motion: bool = False) -> int | None:
        answer = self._send(id, QUEUED if is_queued else SET, params)
        if not is_queued:
            return None
        index = int.from_bytes(answer[:8], "little")
        if wait:
            self.conn.line.finish(index, motion)
        return index

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name in SETS:
            id, format = SETS[name]

            def set_it(*given: Any, wait: bool = False, is_queued: bool = False, **named: Any) -> int | None:
                values = [*_flat([*given, *named.values()])]
                count = len(struct.unpack(f"<{format}", bytes(struct.calcsize(f"<{format}"))))
                # Optional positional arguments: wait, and isQueued.
                wait, is_queued = (
                    bool(wait or values[count:][:1] == [True]),
                    bool(is_queued or any(values[count + 1 :])),
                )
                params = struct.pack(f"<{format}", *values[:count])
                return self._set(id, params, wait, is_queued, name in MOTIONS)

            return set_it
        if name in GETS:
            id, format, kind = GETS[name]

            def get_it(*query: int, **named: int) -> Any:
                params = bytes([*query, *named.values()])
                values = struct.unpack_from(f"<{format}", self._send(id, GET, params))
                if kind.startswith("tag"):
                    return getattr(paramsStructures, kind)(*values)
                if kind:
                    return getattr(_enums, kind)(values[0])
                return values[0] if len(values) == 1 else values

            return get_it
        raise AttributeError(f"dobotWrapperPy's arm has no call {name}")

    def set_end_effector_gripper(
        self, enable: bool = True, grip: bool = False, wait: bool = False, is_queued: bool = False
    ) -> int | None:
        """Switches the gripper."""
        return self._set(63, bytes((enable, grip)), wait, is_queued)

    def set_end_effector_suction_cup(
        self, enable: bool = False, wait: bool = False, is_queued: bool = False
    ) -> int | None:
        """Switches the suction cup."""
        return self._set(62, bytes((1, enable)), wait, is_queued)

    def get_pose(self) -> Any:
        """Returns the pose of the arm."""
        values = struct.unpack_from("<8f", self._send(10, GET))
        return getattr(paramsStructures, "tagPose")(*values[:4], list(values[4:]))  # noqa: B009

    def get_active_alarms(self) -> set[Alarm]:
        """Returns the active alarms."""
        bits = int.from_bytes(self._send(20, GET), "little")
        return {Alarm(code) for code in range(bits.bit_length()) if bits >> code & 1}

    def get_device_name(self) -> str:
        """Returns the arm's name."""
        return self._send(1, GET).split(b"\0")[0].decode("utf-8", "replace")

    def set_device_name(self, device_name: str) -> None:
        """Sets the arm's name."""
        self._send(1, SET, device_name.encode() + b"\0")

    def get_device_sn(self) -> str:
        """Returns the arm's serial number."""
        return self._send(0, GET).split(b"\0")[0].decode("utf-8", "replace")

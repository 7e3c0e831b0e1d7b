"""Alarms of pydobotlab: their names, and the exception of each group."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum

from ... import errors as ours
from .errors import (
    DobotAlarmError,
    DobotConnectionError,
    DobotError,
    DobotKinematicError,
    DobotLostStepError,
    DobotOverspeedError,
    DobotProtocolError,
    DobotSystemAlarmError,
    DobotTimeoutError,
)

__all__ = ["Alarm", "AlarmSet", "alarm_error", "fault"]


class Alarm(IntEnum):
    """Alarm of the arm. A code without a name is named after its group: ``LIMIT_0x4A``."""

    PUBLIC_RESET = 0x00
    PUBLIC_UNDEFINED_INSTRUCTION = 0x01
    PUBLIC_FILE_SYSTEM = 0x02
    PUBLIC_MCU_COMM = 0x03
    PUBLIC_ANGLE_SENSOR_READ = 0x04
    PLAN_INVERSE_SINGULARITY = 0x10
    PLAN_INVERSE_CALCULATION = 0x11
    PLAN_INVERSE_LIMIT = 0x12
    PLAN_DATA_REPEAT = 0x13
    PLAN_ARC_INPUT_PARAMETER = 0x14
    PLAN_JUMP_PARAMETER = 0x15
    MOVE_INVERSE_SINGULARITY = 0x20
    MOVE_INVERSE_CALCULATION = 0x21
    MOVE_INVERSE_LIMIT = 0x22
    OVERSPEED_J1 = 0x30
    OVERSPEED_J2 = 0x31
    OVERSPEED_J3 = 0x32
    OVERSPEED_J4 = 0x33
    LIMIT_POS_J1 = 0x40
    LIMIT_NEG_J1 = 0x41
    LIMIT_POS_J2 = 0x42
    LIMIT_NEG_J2 = 0x43
    LIMIT_POS_J3 = 0x44
    LIMIT_NEG_J3 = 0x45
    LIMIT_POS_J4 = 0x46
    LIMIT_NEG_J4 = 0x47
    LIMIT_POS_PARALLELOGRAM = 0x48
    LIMIT_NEG_PARALLELOGRAM = 0x49
    LOST_STEP_J1 = 0x50
    LOST_STEP_J2 = 0x51
    LOST_STEP_J3 = 0x52
    LOST_STEP_J4 = 0x53

    @classmethod
    def _missing_(cls, value: object) -> Alarm | None:
        if not isinstance(value, int) or not 0 <= value < 256:
            return None
        member = int.__new__(cls, value)
        member._name_ = f"{_GROUPS.get(value & 0xF0, ('UNKNOWN',))[0]}_0x{value:02X}"
        member._value_ = value
        return member


_GROUPS: dict[int, tuple[str, type[DobotAlarmError]]] = {
    0x00: ("PUBLIC", DobotSystemAlarmError),
    0x10: ("PLAN", DobotKinematicError),
    0x20: ("MOVE", DobotKinematicError),
    0x30: ("OVERSPEED", DobotOverspeedError),
    0x40: ("LIMIT", DobotKinematicError),
    0x50: ("LOST_STEP", DobotLostStepError),
}


class AlarmSet:
    """Set of active alarms; true if there are any."""

    def __init__(self, raw: bytes) -> None:
        bits = int.from_bytes(raw, "little")
        self.raw = raw
        self.alarms = tuple(Alarm(code) for code in range(bits.bit_length()) if bits >> code & 1)

    def names(self) -> list[str]:
        """Names of the alarms."""
        return [alarm.name for alarm in self]

    def __bool__(self) -> bool:
        return bool(self.alarms)

    def __len__(self) -> int:
        return len(self.alarms)

    def __iter__(self) -> Iterator[Alarm]:
        return iter(self.alarms)

    def __repr__(self) -> str:
        return f"AlarmSet({', '.join(self.names())})"


def alarm_error(alarms: AlarmSet, says: str = "") -> DobotAlarmError:
    """Creates the exception for active alarms, by the group of the first.

    The alarm of a reset is skipped if there is another one, because it makes no call fail here.
    """
    first = next((alarm for alarm in alarms if alarm != Alarm.PUBLIC_RESET), Alarm.PUBLIC_RESET)
    kind = _GROUPS[first & 0xF0][1] if first & 0xF0 in _GROUPS else DobotAlarmError
    return kind(alarms.names(), says or f"the arm has an alarm: {', '.join(alarms.names())}; call clear_alarm()")


def fault(error: ours.Error) -> DobotError:
    """Converts an error to the exception that a program for pydobotlab expects."""
    if isinstance(error, ours.AlarmError):
        bits = sum(1 << int(alarm) for alarm in error.alarms or ())
        return alarm_error(AlarmSet(bits.to_bytes(32, "little")), str(error))
    if isinstance(error, ours.UnreachableError):
        return DobotKinematicError(message=str(error))
    if isinstance(error, (ours.PortError, ours.ClosedError)):
        return DobotConnectionError(str(error))
    if isinstance(error, TimeoutError):
        return DobotTimeoutError(str(error))
    return DobotProtocolError(str(error))

"""Enums of dobotWrapperPy, which has a module for each."""

from enum import Enum

from ..pydobot.enums.ptpMode import PTPMode

__all__ = [
    "CPMode",
    "EMotorIndex",
    "HHTTrigMode",
    "IOFunction",
    "JogCmd",
    "JogMode",
    "Level",
    "PTPMode",
    "RealTimeTrack",
    "TagVersionColorSensorAndIR",
    "TriggerCondition",
    "TriggerMode",
    "tagVersionRail",
]


class CPMode(Enum):
    """Meaning of a path's coordinates: absolute or relative."""

    RELATIVE = 0
    ABSOLUTE = 1


class EMotorIndex(Enum):
    """Sockets of the motors."""

    STEPPER1 = 0
    STEPPER2 = 1


class HHTTrigMode(Enum):
    """Event at which a point taught by hand is reported."""

    TriggeredOnKeyRelease = 0
    TriggeredOnPeriodicInterval = 1


class IOFunction(Enum):
    """Function of a pin."""

    DUMMY = 0
    DO = 1
    PWM = 2
    DI = 3
    ADC = 4
    DIPU = 5
    DIPD = 6


class JogCmd(Enum):
    """Axis and direction of a jog."""

    IDEL = 0
    AP_DOWN = 1
    AN_DOWN = 2
    BP_DOWN = 3
    BN_DOWN = 4
    CP_DOWN = 5
    CN_DOWN = 6
    DP_DOWN = 7
    DN_DOWN = 8


class JogMode(Enum):
    """Coordinates of a jog: Cartesian axes or joints."""

    COORDINATE = 0
    JOINT = 1


class Level(Enum):
    """Level of a pin."""

    LOW = 0
    HIGH = 1


class RealTimeTrack(Enum):
    """Planning mode of a path."""

    NONREALTIME = 0
    REALTIME = 1


class TagVersionColorSensorAndIR(Enum):
    """Version of the sensor."""

    VERSION1 = 0
    VERSION2 = 1


class tagVersionRail(Enum):
    """Version of the rail."""

    VER_V1 = 0
    VER_V2 = 1


class TriggerCondition(Enum):
    """Condition of a trigger."""

    LEVEL_EQUAL = 0
    AD_LESS = 0  # noqa: PIE796
    LEVEL_UNEQUAL = 1
    AD_LESS_EQUAL = 1  # noqa: PIE796
    AD_GREATER_EQUAL = 2
    AD_GREATER = 3


class TriggerMode(Enum):
    """Input kind of a trigger: level or analogue value."""

    LEVEL = 0
    AD = 1

"""The enums of dobotWrapperPy, all in one place; it has a module for each."""

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
    """What a path's coordinates are."""

    RELATIVE = 0
    ABSOLUTE = 1


class EMotorIndex(Enum):
    """The motors' sockets."""

    STEPPER1 = 0
    STEPPER2 = 1


class HHTTrigMode(Enum):
    """When teaching by hand reports a point."""

    TriggeredOnKeyRelease = 0
    TriggeredOnPeriodicInterval = 1


class IOFunction(Enum):
    """What a pin does."""

    DUMMY = 0
    DO = 1
    PWM = 2
    DI = 3
    ADC = 4
    DIPU = 5
    DIPD = 6


class JogCmd(Enum):
    """Which axis, up or down."""

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
    """What jogging moves along."""

    COORDINATE = 0
    JOINT = 1


class Level(Enum):
    """A pin's level."""

    LOW = 0
    HIGH = 1


class RealTimeTrack(Enum):
    """How a path is planned."""

    NONREALTIME = 0
    REALTIME = 1


class TagVersionColorSensorAndIR(Enum):
    """The sensor's version."""

    VERSION1 = 0
    VERSION2 = 1


class tagVersionRail(Enum):
    """The rail's version."""

    VER_V1 = 0
    VER_V2 = 1


class TriggerCondition(Enum):
    """What a trigger waits for."""

    LEVEL_EQUAL = 0
    AD_LESS = 0  # noqa: PIE796
    LEVEL_UNEQUAL = 1
    AD_LESS_EQUAL = 1  # noqa: PIE796
    AD_GREATER_EQUAL = 2
    AD_GREATER = 3


class TriggerMode(Enum):
    """What a trigger looks at."""

    LEVEL = 0
    AD = 1

"""Numbers of the protocol under the names of pydobotlab."""

from enum import IntEnum

from .._pydobot2 import MODE_PTP as PTPMode

__all__ = ["CommandID", "EndEffectorType", "IOFunction", "JOGCmd", "JogMode", "PTPMode"]


class JogMode(IntEnum):
    """Coordinates of a jog: Cartesian axes or joints."""

    COORDINATE = 0
    JOINT = 1


class JOGCmd(IntEnum):
    """Axis and direction of a jog."""

    IDLE = 0
    AP_DOWN = 1
    AN_DOWN = 2
    BP_DOWN = 3
    BN_DOWN = 4
    CP_DOWN = 5
    CN_DOWN = 6
    DP_DOWN = 7
    DN_DOWN = 8


class EndEffectorType(IntEnum):
    """Mounted tool."""

    LASER = 0
    SUCTION_CUP = 1
    GRIPPER = 2


class IOFunction(IntEnum):
    """Function of a pin."""

    DUMMY = 0
    DO = 1
    PWM = 2
    DI = 3
    ADC = 4
    DIPU = 5
    DIPD = 6


class CommandID(IntEnum):
    """Ids of commands."""

    GET_DEVICE_SN = 0
    GET_SET_DEVICE_NAME = 1
    GET_DEVICE_VERSION = 2
    GET_POSE = 10
    GET_POSE_L = 13
    GET_ALARMS_STATE = 20
    CLEAR_ALL_ALARMS_STATE = 20
    GET_SET_HOME_PARAMS = 30
    SET_HOME_CMD = 31
    GET_SET_JOG_COMMON_PARAMS = 72
    SET_JOG_CMD = 73
    GET_SET_PTP_COMMON_PARAMS = 83
    SET_PTP_CMD = 84
    SET_CP_CMD = 91
    SET_WAIT_CMD = 110
    SET_QUEUED_CMD_START_EXEC = 240
    SET_QUEUED_CMD_STOP_EXEC = 241
    SET_QUEUED_CMD_FORCE_STOP_EXEC = 242
    SET_QUEUED_CMD_CLEAR = 245
    GET_QUEUED_CMD_CURRENT_INDEX = 246
    GET_QUEUED_CMD_LEFT_SPACE = 247

# Made by `cargo xtask python` from the protocol's table, which the driver and the virtual arm are made of too.
"""Every command of the protocol, as values.

A value to read is a class: ``arm.get(commands.Pose)`` returns a :class:`Pose`. What is asked for with a pin, a port or
a target is a question: ``arm.get(commands.GetIoDi(address=19))`` returns an :class:`IoDi`. A value to set is an object:
``arm.set(commands.PtpCommonParams(velocity_ratio=50, acceleration_ratio=50))``, and what may be queued goes into
``arm.enqueue`` and ``arm.perform`` too.

The names are the vendor's, in Python's spelling. Lengths are mm, angles degrees. E numbers are those of the errata that
the vendor's document needs.
"""

from __future__ import annotations

from typing import NamedTuple

from . import _meaning
from ._protocol import Answer, OpenEnum, Query, Queueable, Readable, Writable
from .alarms import Alarm

__all__ = [
    "AlarmsState",
    "AngleSensorCoef",
    "AngleSensorStaticError",
    "Answer",
    "ArcCmd",
    "ArcCommonParams",
    "ArcParams",
    "ArmOrientation",
    "AutoLeveling",
    "BaseDecoderStaticError",
    "CircleCmd",
    "ClearAlarmsState",
    "ClearAllAlarmsState",
    "ColorSensor",
    "CpCmd",
    "CpCommonParams",
    "CpLeCmd",
    "CpMode",
    "CpParams",
    "CpRHeadHoldEnable",
    "DeviceId",
    "DeviceInfo",
    "DeviceName",
    "DeviceSn",
    "DeviceTime",
    "DeviceVersion",
    "DeviceWithL",
    "EMotor",
    "EMotorS",
    "EndEffectorGripper",
    "EndEffectorLaser",
    "EndEffectorParams",
    "EndEffectorSuctionCup",
    "FirmwareMode",
    "FirmwareSwitch",
    "GetColorSensor",
    "GetIoAdc",
    "GetIoDi",
    "GetIoDo",
    "GetIoMultiplexing",
    "GetIoPwm",
    "GetIrSwitch",
    "GetPtpTime",
    "Handedness",
    "HhtTrigMode",
    "HhtTrigOutput",
    "HhtTrigOutputEnabled",
    "HomeCmd",
    "HomeParams",
    "IoAdc",
    "IoDi",
    "IoDo",
    "IoFunction",
    "IoMultiplexing",
    "IoPwm",
    "IrSwitch",
    "JogCmd",
    "JogCommand",
    "JogCommonParams",
    "JogCoordinateParams",
    "JogJointParams",
    "JogLParams",
    "Kinematics",
    "LostStepCmd",
    "LostStepParams",
    "Output",
    "Port",
    "Pose",
    "PoseL",
    "PtpCmd",
    "PtpCommonParams",
    "PtpCoordinateParams",
    "PtpJointParams",
    "PtpJump2Params",
    "PtpJumpParams",
    "PtpLParams",
    "PtpMode",
    "PtpPoCmd",
    "PtpPoWithLCmd",
    "PtpTime",
    "PtpWithLCmd",
    "PulseMode",
    "Query",
    "Queueable",
    "QueuedCmdClear",
    "QueuedCmdCurrentIndex",
    "QueuedCmdForceStopExec",
    "QueuedCmdLeftSpace",
    "QueuedCmdMotionFinish",
    "QueuedCmdStartDownload",
    "QueuedCmdStartExec",
    "QueuedCmdStopDownload",
    "QueuedCmdStopExec",
    "RailVersion",
    "Readable",
    "ResetPose",
    "SensorVersion",
    "SetAutoLeveling",
    "SetColorSensor",
    "SetDeviceWithL",
    "SetEndEffectorGripper",
    "SetEndEffectorLaser",
    "SetEndEffectorSuctionCup",
    "SetIrSwitch",
    "Stepper",
    "TeachTrigger",
    "TrigCmd",
    "TriggerCondition",
    "TriggerMode",
    "Uart4PeripheralsEnabled",
    "Uart4PeripheralsModel",
    "UserParams",
    "WaitCmd",
    "WifiConfigMode",
    "WifiConnectStatus",
    "WifiDns",
    "WifiGateway",
    "WifiIpAddress",
    "WifiNetmask",
    "WifiPassword",
    "WifiSsid",
    "Writable",
    "ZdfCalibRequest",
    "ZdfCalibStatus",
]


class RailVersion(OpenEnum):
    """Generation of the sliding rail (E15)."""

    V1 = 0
    """First version."""
    V2 = 1
    """Second version."""


class TeachTrigger(OpenEnum):
    """When hand teaching reports a point (document 1.7.1)."""

    ON_RELEASE = 0
    """Once, when the unlock key is released."""
    PERIODIC = 1
    """Again and again while the key is held."""


class Handedness(OpenEnum):
    """Elbow side of a SCARA arm; without meaning on this one."""

    LEFT = 0
    """Left hand."""
    RIGHT = 1
    """Right hand."""


class JogCommand(OpenEnum):
    """Which way to jog; the axis is a joint or a coordinate (document 1.9.4, E25)."""

    STOP = 0
    """Slow down and stop."""
    AXIS1_PLUS = 1
    """J1 or x, positive."""
    AXIS1_MINUS = 2
    """J1 or x, negative."""
    AXIS2_PLUS = 3
    """J2 or y, positive."""
    AXIS2_MINUS = 4
    """J2 or y, negative."""
    AXIS3_PLUS = 5
    """J3 or z, positive."""
    AXIS3_MINUS = 6
    """J3 or z, negative."""
    AXIS4_PLUS = 7
    """J4 or r, positive."""
    AXIS4_MINUS = 8
    """J4 or r, negative."""
    RAIL_PLUS = 9
    """Rail, positive."""
    RAIL_MINUS = 10
    """Rail, negative."""


class PtpMode(OpenEnum):
    """How a point-to-point move travels and what its numbers mean (document 1.10.5, E28)."""

    JUMP_XYZ = 0
    """Lift, joint transfer, descend; absolute x y z r."""
    MOVJ_XYZ = 1
    """All joints together; absolute x y z r."""
    MOVL_XYZ = 2
    """Straight line; absolute x y z r."""
    JUMP_ANGLE = 3
    """Lift, joint transfer, descend; absolute J1 to J4."""
    MOVJ_ANGLE = 4
    """All joints together; absolute J1 to J4."""
    MOVL_ANGLE = 5
    """Straight line; absolute J1 to J4."""
    MOVJ_ANGLE_INC = 6
    """All joints together; J1 to J4 added to where the move starts."""
    MOVL_XYZ_INC = 7
    """Straight line; x y z r added to where the move starts."""
    MOVJ_XYZ_INC = 8
    """All joints together; x y z r added to where the move starts."""
    JUMP_MOVL_XYZ = 9
    """Lift, straight transfer, descend; absolute x y z r."""


class CpMode(OpenEnum):
    """What the numbers of a continuous-path segment count from (document 1.11.2)."""

    RELATIVE = 0
    """From the end of the segment before."""
    ABSOLUTE = 1
    """From the base frame."""


class TriggerMode(OpenEnum):
    """What a trigger looks at (document 1.14.1)."""

    LEVEL = 0
    """Digital level."""
    ANALOG = 1
    """Analog value."""


class TriggerCondition(OpenEnum):
    """How a trigger compares (document 1.14.1, E35)."""

    EQUAL_OR_BELOW = 0
    """Level equal to the threshold; analog below it."""
    DIFFERENT_OR_AT_MOST = 1
    """Level different from the threshold; analog at most it."""
    AT_LEAST = 2
    """Analog at least the threshold."""
    ABOVE = 3
    """Analog above the threshold."""


class IoFunction(OpenEnum):
    """What an EIO pin does (document 1.15.1, E40)."""

    NONE = 0
    """Nothing."""
    DIGITAL_OUTPUT = 1
    """Digital output."""
    PWM = 2
    """Pulse-width output."""
    DIGITAL_INPUT = 3
    """Digital input."""
    ANALOG_INPUT = 4
    """Analog input."""
    DIGITAL_INPUT_PULL_UP = 5
    """Digital input with pull-up."""
    DIGITAL_INPUT_PULL_DOWN = 6
    """Digital input with pull-down."""


class Stepper(OpenEnum):
    """External motor output (document 1.15.6)."""

    STEPPER1 = 0
    """First motor output."""
    STEPPER2 = 1
    """Second motor output."""


class Port(OpenEnum):
    """Connector that a sensor is plugged into (E42)."""

    GP1 = 0
    """GP1, at the base."""
    GP2 = 1
    """GP2, at the base."""
    GP4 = 2
    """GP4, on the forearm."""
    GP5 = 3
    """GP5, on the forearm."""


class SensorVersion(OpenEnum):
    """Generation of a colour or infrared sensor (E42, E43)."""

    V1 = 0
    """First version."""
    V2 = 1
    """Second version."""


class Output(NamedTuple):
    """An output that a move switches on its way."""

    percent: int
    """When: share of the movement that is done, percent, 0 to 100."""
    address: int
    """EIO address, 1 to 20."""
    high: bool
    """Level to set."""


class DeviceSn(Readable, Writable):
    """Serial number of the arm.

    GetDeviceSN, SetDeviceSN; id 0, document V1.1.3 section 1.3.1; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 0
    LAYOUT = "DeviceSn"

    device_sn: str
    """Serial number; at most 23 bytes."""


class DeviceName(Readable, Writable):
    """Name of the arm, free to choose.

    GetDeviceName, SetDeviceName; id 1, document V1.1.3 section 1.3.2.
    """

    ID = 1
    LAYOUT = "DeviceName"

    device_name: str
    """Name; at most 64 bytes."""


class DeviceVersion(Readable):
    """Version of the controller's firmware.

    GetDeviceVersion; id 2, document V1.1.3 section 1.3.3, errata E16.
    """

    ID = 2
    LAYOUT = "DeviceVersion"

    major_version: int
    """First number of the version."""
    minor_version: int
    """Second number of the version."""
    revision: int
    """Third number of the version."""
    extra: bytes = b""
    """Bytes added by newer firmware, among them a hardware version."""


class DeviceWithL(Readable):
    """Whether the arm stands on a sliding rail.

    GetDeviceWithL; id 3, document V1.1.3 section 1.3.4, errata E15.
    """

    ID = 3
    LAYOUT = "DeviceWithL"

    with_l: bool
    """Whether the rail is in use."""


class SetDeviceWithL(Queueable):
    """Whether the arm stands on a sliding rail.

    SetDeviceWithL; id 3, document V1.1.3 section 1.3.4, errata E15.
    """

    ID = 3
    LAYOUT = "SetDeviceWithL"

    with_l: bool
    """Whether to use the rail."""
    version: RailVersion | None = None
    """Generation of the rail; hosts before V1.1.5 leave it out."""


class DeviceTime(Readable):
    """Time since the controller was switched on.

    GetDeviceTime; id 4, document V1.1.3 section 1.3.5.
    """

    ID = 4
    LAYOUT = "DeviceTime"

    g_systick: int
    """Time since power-up; begins again at 2^32; ms."""


class DeviceId(Readable):
    """Unique id of the controller's processor.

    GetDeviceID; id 5, document V1.1.3 section 1.3.6, errata E14.
    """

    ID = 5
    LAYOUT = "DeviceId"

    device_id: tuple[int, int, int]
    """The id, least significant word first."""


class DeviceInfo(Readable):
    """Counters of the controller's life.

    GetDeviceInfo; id 6, document V1.1.5.
    """

    ID = 6
    LAYOUT = "DeviceInfo"

    run_time: int
    """Running time over its life; s (unconfirmed)."""
    power_on: int
    """Times it was switched on."""
    power_off: int
    """Times it was switched off."""


class Pose(_meaning.PoseMeaning, Readable):
    """Where the arm is: tool position and joint angles, as commanded.

    GetPose; id 10, document V1.1.3 section 1.4.1.
    """

    ID = 10
    LAYOUT = "Pose"

    x: float
    """Tool x in the base frame; mm."""
    y: float
    """Tool y in the base frame; mm."""
    z: float
    """Tool z in the base frame; mm."""
    r: float
    """Tool rotation in the base frame, J1 + J4; deg."""
    joint_angle: tuple[float, float, float, float]
    """J1 base, J2 rear arm, J3 forearm, J4 end effector; deg."""


class ResetPose(Writable):
    """Sets the angles of rear arm and forearm.

    ResetPose; id 11, document V1.1.3 section 1.4.2, errata E23; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 11
    LAYOUT = "ResetPose"

    manual: bool
    """0 takes the angles from the sensors, 1 those given here."""
    rear_arm_angle: float = 0
    """J2, used when manual is 1; deg."""
    front_arm_angle: float = 0
    """J3, used when manual is 1; deg."""


class Kinematics(Readable):
    """Speed and acceleration of the arm.

    GetKinematics; id 12, document V1.1.5.
    """

    ID = 12
    LAYOUT = "Kinematics"

    velocity: float
    """Speed; mm/s."""
    acceleration: float
    """Acceleration; mm/s^2."""


class PoseL(Readable):
    """Position of the arm on its rail.

    GetPoseL; id 13, document V1.1.3 section 1.4.3.
    """

    ID = 13
    LAYOUT = "PoseL"

    pose_l: float
    """Rail position; mm."""


class AlarmsState(Readable):
    """Active alarms, one bit each.

    GetAlarmsState; id 20, document V1.1.3 section 1.5.1, errata E18 to E20.
    """

    ID = 20
    LAYOUT = "AlarmsState"

    alarms_state: tuple[Alarm, ...]
    """Alarm n is bit n % 8 of byte n / 8; bitmap."""


class ClearAlarmsState(Writable):
    """Active alarms, one bit each.

    ClearAllAlarmsState; id 20, document V1.1.3 section 1.5.1, errata E18 to E20.
    """

    ID = 20
    LAYOUT = "ClearAlarmsState"


class ClearAllAlarmsState(Writable):
    """Clears the alarms under the document's id; hosts use 20 with rw = 1.

    ClearAllAlarmsState; id 21, document V1.1.3 section 1.5.2, errata E19.
    """

    ID = 21
    LAYOUT = "ClearAllAlarmsState"


class HomeParams(Readable, Queueable):
    """Where the arm goes when homing ends.

    GetHOMEParams, SetHOMEParams; id 30, document V1.1.3 section 1.6.1.
    """

    ID = 30
    LAYOUT = "HomeParams"

    x: float
    """Home x; mm."""
    y: float
    """Home y; mm."""
    z: float
    """Home z; mm."""
    r: float
    """Home rotation; deg."""


class HomeCmd(Queueable):
    """Homes the arm: finds the reference of J1 and goes to the home point.

    SetHOMECmd; id 31, document V1.1.3 section 1.6.2, errata E22.
    """

    ID = 31
    LAYOUT = "HomeCmd"

    reserved: int = 0
    """Reserved; 0."""


class AutoLeveling(Readable):
    """Levels the arm by its sensors.

    GetAutoLeveling; id 32, document V1.1.3 section 1.6.3, errata E21.
    """

    ID = 32
    LAYOUT = "AutoLeveling"

    result: float
    """Precision reached; deg (unconfirmed)."""


class SetAutoLeveling(Queueable):
    """Levels the arm by its sensors.

    SetAutoLeveling; id 32, document V1.1.3 section 1.6.3, errata E21.
    """

    ID = 32
    LAYOUT = "SetAutoLeveling"

    is_auto_leveling: bool
    """1 starts levelling."""
    accuracy: float
    """Precision wanted; deg (unconfirmed)."""


class HhtTrigMode(Readable, Writable):
    """When hand teaching reports a point.

    GetHHTTrigMode, SetHHTTrigMode; id 40, document V1.1.3 section 1.7.1, errata E24.
    """

    ID = 40
    LAYOUT = "HhtTrigMode"

    mode: TeachTrigger
    """When to report."""


class HhtTrigOutputEnabled(Readable, Writable):
    """Whether hand teaching reports points at all.

    GetHHTTrigOutputEnabled, SetHHTTrigOutputEnabled; id 41, document V1.1.3 section 1.7.2.
    """

    ID = 41
    LAYOUT = "HhtTrigOutputEnabled"

    is_enabled: bool
    """Whether it reports."""


class HhtTrigOutput(Readable):
    """Whether a point has been taught since the last look.

    GetHHTTrigOutput; id 42, document V1.1.3 section 1.7.3.
    """

    ID = 42
    LAYOUT = "HhtTrigOutput"

    is_triggered: bool
    """Whether there is a new point; reading clears it."""


class ArmOrientation(Readable, Queueable):
    """Elbow side of a SCARA arm; this arm stores it.

    GetArmOrientation, SetArmOrientation; id 50, document V1.1.5.
    """

    ID = 50
    LAYOUT = "ArmOrientation"

    orientation: Handedness
    """Elbow side."""


class EndEffectorParams(Readable, Queueable):
    """Tool bias: where the tool sits relative to the wrist.

    GetEndEffectorParams, SetEndEffectorParams; id 60, document V1.1.3 section 1.8.1.
    """

    ID = 60
    LAYOUT = "EndEffectorParams"

    x_bias: float
    """Offset along the forearm's direction; mm."""
    y_bias: float
    """Offset to the left; mm."""
    z_bias: float
    """Offset downwards; mm."""


class EndEffectorLaser(Readable):
    """The laser.

    GetEndEffectorLaser; id 61, document V1.1.3 section 1.8.2.
    """

    ID = 61
    LAYOUT = "EndEffectorLaser"

    is_ctrl_enabled: bool
    """Whether the host controls the tool connector."""
    is_on: bool
    """Whether the laser burns."""


class SetEndEffectorLaser(Queueable):
    """The laser.

    SetEndEffectorLaser; id 61, document V1.1.3 section 1.8.2.
    """

    ID = 61
    LAYOUT = "SetEndEffectorLaser"

    enable_ctrl: bool
    """Whether the host controls the tool connector."""
    on: bool
    """Whether the laser burns."""


class EndEffectorSuctionCup(Readable):
    """The suction cup.

    GetEndEffectorSuctionCup; id 62, document V1.1.3 section 1.8.3.
    """

    ID = 62
    LAYOUT = "EndEffectorSuctionCup"

    is_ctrl_enabled: bool
    """Whether the pump may run."""
    is_sucked: bool
    """Whether the cup sucks."""


class SetEndEffectorSuctionCup(Queueable):
    """The suction cup.

    SetEndEffectorSuctionCup; id 62, document V1.1.3 section 1.8.3.
    """

    ID = 62
    LAYOUT = "SetEndEffectorSuctionCup"

    enable_ctrl: bool
    """Whether the pump may run."""
    suck: bool
    """Whether the cup sucks."""


class EndEffectorGripper(Readable):
    """The gripper.

    GetEndEffectorGripper; id 63, document V1.1.3 section 1.8.4.
    """

    ID = 63
    LAYOUT = "EndEffectorGripper"

    is_ctrl_enabled: bool
    """Whether the pump may run."""
    is_gripped: bool
    """1 closed, 0 open."""


class SetEndEffectorGripper(Queueable):
    """The gripper.

    SetEndEffectorGripper; id 63, document V1.1.3 section 1.8.4.
    """

    ID = 63
    LAYOUT = "SetEndEffectorGripper"

    enable_ctrl: bool
    """Whether the pump may run."""
    grip: bool
    """1 closes, 0 opens."""


class JogJointParams(Readable, Queueable):
    """Speeds of jogging in joints.

    GetJOGJointParams, SetJOGJointParams; id 70, document V1.1.3 section 1.9.1.
    """

    ID = 70
    LAYOUT = "JogJointParams"

    velocity: tuple[float, float, float, float]
    """Speed of J1 to J4; deg/s; above 0."""
    acceleration: tuple[float, float, float, float]
    """Acceleration of J1 to J4; deg/s^2; above 0."""


class JogCoordinateParams(Readable, Queueable):
    """Speeds of jogging in coordinates.

    GetJOGCoordinateParams, SetJOGCoordinateParams; id 71, document V1.1.3 section 1.9.2.
    """

    ID = 71
    LAYOUT = "JogCoordinateParams"

    velocity: tuple[float, float, float, float]
    """Speed of x, y, z and r; mm/s for x, y, z; deg/s for r; above 0."""
    acceleration: tuple[float, float, float, float]
    """Acceleration of x, y, z and r; mm/s^2 for x, y, z; deg/s^2 for r; above 0."""


class JogCommonParams(Readable, Queueable):
    """Share of the jog speeds that is used.

    GetJOGCommonParams, SetJOGCommonParams; id 72, document V1.1.3 section 1.9.3.
    """

    ID = 72
    LAYOUT = "JogCommonParams"

    velocity_ratio: float
    """Share of the set speed; percent; 1 to 100, more counts as 100."""
    acceleration_ratio: float
    """Share of the set acceleration; percent; 1 to 100, more counts as 100."""


class JogCmd(Queueable):
    """Moves one axis until told to stop.

    SetJOGCmd; id 73, document V1.1.3 section 1.9.4, errata E25.
    """

    ID = 73
    LAYOUT = "JogCmd"

    is_joint: bool
    """0 jogs a coordinate, 1 a joint."""
    cmd: JogCommand
    """Axis and direction; 0 stops."""


class JogLParams(Readable, Queueable):
    """Speeds of jogging on the rail.

    GetJOGLParams, SetJOGLParams; id 74, document V1.1.3 section 1.9.5, errata E25.
    """

    ID = 74
    LAYOUT = "JogLParams"

    velocity: float
    """Speed on the rail; mm/s; above 0."""
    acceleration: float
    """Acceleration on the rail; mm/s^2; above 0."""


class PtpJointParams(Readable, Queueable):
    """Speeds of the joints in point-to-point moves.

    GetPTPJointParams, SetPTPJointParams; id 80, document V1.1.3 section 1.10.1.
    """

    ID = 80
    LAYOUT = "PtpJointParams"

    velocity: tuple[float, float, float, float]
    """Speed of J1 to J4; deg/s; above 0."""
    acceleration: tuple[float, float, float, float]
    """Acceleration of J1 to J4; deg/s^2; above 0."""


class PtpCoordinateParams(Readable, Queueable):
    """Speeds of the tool in straight point-to-point moves.

    GetPTPCoordinateParams, SetPTPCoordinateParams; id 81, document V1.1.3 section 1.10.2.
    """

    ID = 81
    LAYOUT = "PtpCoordinateParams"

    xyz_velocity: float
    """Speed of the tool point; mm/s; above 0."""
    r_velocity: float
    """Speed of rotation; deg/s; above 0."""
    xyz_acceleration: float
    """Acceleration of the tool point; mm/s^2; above 0."""
    r_acceleration: float
    """Acceleration of rotation; deg/s^2; above 0."""


class PtpJumpParams(Readable, Queueable):
    """How high a jump lifts.

    GetPTPJumpParams, SetPTPJumpParams; id 82, document V1.1.3 section 1.10.3, errata E30.
    """

    ID = 82
    LAYOUT = "PtpJumpParams"

    jump_height: float
    """Lift above the higher end; mm."""
    z_limit: float
    """Highest z of the transfer; mm."""


class PtpCommonParams(Readable, Queueable):
    """Share of the point-to-point speeds that is used.

    GetPTPCommonParams, SetPTPCommonParams; id 83, document V1.1.3 section 1.10.4.
    """

    ID = 83
    LAYOUT = "PtpCommonParams"

    velocity_ratio: float
    """Share of the set speed; percent; 1 to 100, more counts as 100."""
    acceleration_ratio: float
    """Share of the set acceleration; percent; 1 to 100, more counts as 100."""


class PtpCmd(Queueable):
    """Moves the arm to a point.

    SetPTPCmd; id 84, document V1.1.3 section 1.10.5, errata E28.
    """

    ID = 84
    LAYOUT = "PtpCmd"

    ptp_mode: PtpMode
    """How to travel, and what the numbers mean."""
    x: float
    """Target x, or J1 in the angle modes; mm, or deg for J1."""
    y: float
    """Target y, or J2 in the angle modes; mm, or deg for J2."""
    z: float
    """Target z, or J3 in the angle modes; mm, or deg for J3."""
    r: float
    """Rotation, or J4 in the angle modes; deg."""


class PtpLParams(Readable, Queueable):
    """Speeds on the rail in point-to-point moves.

    GetPTPLParams, SetPTPLParams; id 85, document V1.1.3 section 1.10.6, errata E26.
    """

    ID = 85
    LAYOUT = "PtpLParams"

    velocity: float
    """Speed on the rail; mm/s; above 0."""
    acceleration: float
    """Acceleration on the rail; mm/s^2; above 0."""


class PtpWithLCmd(Queueable):
    """Moves the arm and the rail to a point.

    SetPTPWithLCmd; id 86, document V1.1.3 section 1.10.7.
    """

    ID = 86
    LAYOUT = "PtpWithLCmd"

    ptp_mode: PtpMode
    """How to travel, and what the numbers mean."""
    x: float
    """Target x, or J1 in the angle modes; mm, or deg for J1."""
    y: float
    """Target y, or J2 in the angle modes; mm, or deg for J2."""
    z: float
    """Target z, or J3 in the angle modes; mm, or deg for J3."""
    r: float
    """Rotation, or J4 in the angle modes; deg."""
    l: float
    """Rail position, or way on the rail in the incremental modes; mm; 0 to 1000 in absolute modes."""


class PtpJump2Params(Readable, Queueable):
    """How high a jump lifts, each end for itself.

    GetPTPJump2Params, SetPTPJump2Params; id 87, document V1.1.3 section 1.10.8, errata E27.
    """

    ID = 87
    LAYOUT = "PtpJump2Params"

    start_jump_height: float
    """Lift above the start; mm."""
    end_jump_height: float
    """Lift above the end; mm."""
    z_limit: float
    """Highest z of the transfer; mm."""


class PtpPoCmd(Queueable):
    """Moves the arm to a point and switches outputs on the way.

    SetPTPPOCmd; id 88, document V1.1.3 section 1.10.9, errata E29.
    """

    ID = 88
    LAYOUT = "PtpPoCmd"

    ptp_mode: PtpMode
    """How to travel, and what the numbers mean."""
    x: float
    """Target x, or J1 in the angle modes; mm, or deg for J1."""
    y: float
    """Target y, or J2 in the angle modes; mm, or deg for J2."""
    z: float
    """Target z, or J3 in the angle modes; mm, or deg for J3."""
    r: float
    """Rotation, or J4 in the angle modes; deg."""
    po: tuple[Output, ...]
    """Outputs to switch; percent : EIO address : level; at most 57 outputs."""


class PtpPoWithLCmd(Queueable):
    """Moves the arm and the rail to a point and switches outputs on the way.

    SetPTPPOWithLCmd; id 89, document V1.1.3 section 1.10.10, errata E29.
    """

    ID = 89
    LAYOUT = "PtpPoWithLCmd"

    ptp_mode: PtpMode
    """How to travel, and what the numbers mean."""
    x: float
    """Target x, or J1 in the angle modes; mm, or deg for J1."""
    y: float
    """Target y, or J2 in the angle modes; mm, or deg for J2."""
    z: float
    """Target z, or J3 in the angle modes; mm, or deg for J3."""
    r: float
    """Rotation, or J4 in the angle modes; deg."""
    l: float
    """Rail position, or way on the rail in the incremental modes; mm; 0 to 1000 in absolute modes."""
    po: tuple[Output, ...]
    """Outputs to switch; percent : EIO address : level; at most 56 outputs."""


class CpParams(Readable, Queueable):
    """Speeds of continuous path.

    GetCPParams, SetCPParams; id 90, document V1.1.3 section 1.11.1, errata E31.
    """

    ID = 90
    LAYOUT = "CpParams"

    plan_acc: float
    """Most acceleration along the path; mm/s^2; above 0."""
    junction_vel: float
    """Most speed along the path; mm/s; above 0."""
    acc_or_period: float
    """Acceleration (unused), or the time of a segment; mm/s^2, or ms in real-time mode; above 0."""
    real_time_track: bool
    """1 when the host clocks the path."""


class CpCmd(Queueable):
    """Adds a straight segment to the continuous path.

    SetCPCmd; id 91, document V1.1.3 section 1.11.2, errata E32.
    """

    ID = 91
    LAYOUT = "CpCmd"

    cp_mode: CpMode
    """What the numbers count from."""
    x: float
    """End of the segment, x; mm."""
    y: float
    """End of the segment, y; mm."""
    z: float
    """End of the segment, z; mm."""
    velocity_or_power: float
    """Reserved."""


class CpLeCmd(Queueable):
    """Adds a straight segment with laser power to the continuous path.

    SetCPLECmd; id 92, document V1.1.3 section 1.11.3, errata E32.
    """

    ID = 92
    LAYOUT = "CpLeCmd"

    cp_mode: CpMode
    """What the numbers count from."""
    x: float
    """End of the segment, x; mm."""
    y: float
    """End of the segment, y; mm."""
    z: float
    """End of the segment, z; mm."""
    velocity_or_power: float
    """Laser power along the segment; percent; 0 to 100."""


class CpRHeadHoldEnable(Readable, Writable):
    """Whether the tool keeps its rotation on a continuous path.

    GetCPRHeadHoldEnable, SetCPRHeadHoldEnable; id 93, vendor headers.
    """

    ID = 93
    LAYOUT = "CpRHeadHoldEnable"

    enable: bool
    """Whether it keeps it."""


class CpCommonParams(Readable, Queueable):
    """Share of the continuous-path speeds that is used.

    GetCPCommonParams, SetCPCommonParams; id 94, vendor headers.
    """

    ID = 94
    LAYOUT = "CpCommonParams"

    velocity_ratio: float
    """Share of the set speed; percent; 1 to 100, more counts as 100."""
    acceleration_ratio: float
    """Share of the set acceleration; percent; 1 to 100, more counts as 100."""


class ArcParams(Readable, Queueable):
    """Speeds of arcs.

    GetARCParams, SetARCParams; id 100, document V1.1.3 section 1.12.1.
    """

    ID = 100
    LAYOUT = "ArcParams"

    xyz_velocity: float
    """Speed of the tool point; mm/s; above 0."""
    r_velocity: float
    """Speed of rotation; deg/s; above 0."""
    xyz_acceleration: float
    """Acceleration of the tool point; mm/s^2; above 0."""
    r_acceleration: float
    """Acceleration of rotation; deg/s^2; above 0."""


class ArcCmd(Queueable):
    """Moves the arm along an arc through a point to a point.

    SetARCCmd; id 101, document V1.1.3 section 1.12.2, errata E33.
    """

    ID = 101
    LAYOUT = "ArcCmd"

    cir_point: tuple[float, float, float, float]
    """A point on the arc: x, y, z, r; mm for x, y, z; deg for r."""
    to_point: tuple[float, float, float, float]
    """End of the arc: x, y, z, r; mm for x, y, z; deg for r."""


class CircleCmd(Queueable):
    """Moves the arm round a circle through two points, back to where it began.

    SetCircleCmd; id 102, vendor headers, errata E33.
    """

    ID = 102
    LAYOUT = "CircleCmd"

    cir_point: tuple[float, float, float, float]
    """A point on the circle: x, y, z, r; mm for x, y, z; deg for r."""
    to_point: tuple[float, float, float, float]
    """Another point on the circle: x, y, z, r; mm for x, y, z; deg for r."""
    count: int = 1
    """Full turns; older hosts leave it out; turns; above 0."""


class ArcCommonParams(Readable, Queueable):
    """Share of the arc speeds that is used.

    GetARCCommonParams, SetARCCommonParams; id 103, vendor headers.
    """

    ID = 103
    LAYOUT = "ArcCommonParams"

    velocity_ratio: float
    """Share of the set speed; percent; 1 to 100, more counts as 100."""
    acceleration_ratio: float
    """Share of the set acceleration; percent; 1 to 100, more counts as 100."""


class WaitCmd(Queueable):
    """Makes the queue wait.

    SetWAITCmd; id 110, document V1.1.3 section 1.13.1, errata E34.
    """

    ID = 110
    LAYOUT = "WaitCmd"

    timeout: int
    """How long to wait; ms."""


class TrigCmd(Queueable):
    """Makes the queue wait for an input.

    SetTRIGCmd; id 120, document V1.1.3 section 1.14.1, errata E35.
    """

    ID = 120
    LAYOUT = "TrigCmd"

    address: int
    """Input to look at; EIO address; 1 to 20."""
    mode: TriggerMode
    """Digital level or analog value."""
    condition: TriggerCondition
    """How to compare."""
    threshold: int
    """What to compare with; level or counts; 0 or 1 for levels, 0 to 4095 for analog values."""


class IoMultiplexing(Answer, Queueable):
    """What an EIO pin does.

    GetIOMultiplexing, SetIOMultiplexing; id 130, document V1.1.3 section 1.15.1, errata E39, E40.
    """

    ID = 130
    LAYOUT = "IoMultiplexing"

    address: int
    """Pin; EIO address; 1 to 20."""
    multiplex: IoFunction
    """What it does."""


class GetIoMultiplexing(Query[IoMultiplexing]):
    """What an EIO pin does.

    What GetIOMultiplexing is asked with, for :class:`IoMultiplexing`; id 130, document V1.1.3 section 1.15.1, errata
    E39, E40.
    """

    ID = 130
    LAYOUT = "GetIoMultiplexing"

    address: int
    """Pin; EIO address; 1 to 20."""


class IoDo(Answer, Queueable):
    """Level of a digital output.

    GetIODO, SetIODO; id 131, document V1.1.3 section 1.15.2, errata E39.
    """

    ID = 131
    LAYOUT = "IoDo"

    address: int
    """Pin; EIO address; 1 to 20."""
    level: bool
    """0 low, 1 high."""


class GetIoDo(Query[IoDo]):
    """Level of a digital output.

    What GetIODO is asked with, for :class:`IoDo`; id 131, document V1.1.3 section 1.15.2, errata E39.
    """

    ID = 131
    LAYOUT = "GetIoDo"

    address: int
    """Pin; EIO address; 1 to 20."""


class IoPwm(Answer, Queueable):
    """Signal of a pulse-width output.

    GetIOPWM, SetIOPWM; id 132, document V1.1.3 section 1.15.3, errata E39.
    """

    ID = 132
    LAYOUT = "IoPwm"

    address: int
    """Pin; EIO address; 1 to 20."""
    frequency: float
    """Frequency; Hz; 10 to 1000000."""
    duty_cycle: float
    """Share of the time that it is high, the duty cycle; percent; 0 to 100."""


class GetIoPwm(Query[IoPwm]):
    """Signal of a pulse-width output.

    What GetIOPWM is asked with, for :class:`IoPwm`; id 132, document V1.1.3 section 1.15.3, errata E39.
    """

    ID = 132
    LAYOUT = "GetIoPwm"

    address: int
    """Pin; EIO address; 1 to 20."""


class IoDi(_meaning.LevelMeaning, Answer):
    """Level of a digital input.

    GetIODI; id 133, document V1.1.3 section 1.15.4, errata E39.
    """

    ID = 133
    LAYOUT = "IoDi"

    address: int
    """Pin; EIO address; 1 to 20."""
    level: bool
    """0 low, 1 high."""


class GetIoDi(Query[IoDi]):
    """Level of a digital input.

    What GetIODI is asked with, for :class:`IoDi`; id 133, document V1.1.3 section 1.15.4, errata E39.
    """

    ID = 133
    LAYOUT = "GetIoDi"

    address: int
    """Pin; EIO address; 1 to 20."""


class IoAdc(_meaning.AnalogMeaning, Answer):
    """Value of an analog input.

    GetIOADC; id 134, document V1.1.3 section 1.15.5, errata E39.
    """

    ID = 134
    LAYOUT = "IoAdc"

    address: int
    """Pin; EIO address; 1 to 20."""
    value: int
    """Value, 4095 at 3.3 V; counts; 0 to 4095."""


class GetIoAdc(Query[IoAdc]):
    """Value of an analog input.

    What GetIOADC is asked with, for :class:`IoAdc`; id 134, document V1.1.3 section 1.15.5, errata E39.
    """

    ID = 134
    LAYOUT = "GetIoAdc"

    address: int
    """Pin; EIO address; 1 to 20."""


class EMotor(Queueable):
    """Runs an external stepper, a conveyor for one.

    SetEMotor; id 135, document V1.1.3 section 1.15.6, errata E41.
    """

    ID = 135
    LAYOUT = "EMotor"

    index: Stepper
    """Which motor."""
    is_enabled: bool
    """Whether it runs."""
    speed: int
    """Speed; the sign is the direction; pulses/s."""


class EMotorS(Queueable):
    """Runs an external stepper a number of pulses.

    SetEMotorS; id 136, vendor headers, errata E41.
    """

    ID = 136
    LAYOUT = "EMotorS"

    index: Stepper
    """Which motor."""
    is_enabled: bool
    """Whether it runs."""
    speed: int
    """Speed; the sign is the direction; pulses/s."""
    distance: int
    """How far; pulses."""


class ColorSensor(_meaning.ColorMeaning, Answer):
    """The colour sensor.

    GetColorSensor; id 137, document V1.1.3 section 1.15.7, errata E42.
    """

    ID = 137
    LAYOUT = "ColorSensor"

    r: int
    """Red; counts; 0 to 255."""
    g: int
    """Green; counts; 0 to 255."""
    b: int
    """Blue; counts; 0 to 255."""


class SetColorSensor(Queueable):
    """The colour sensor.

    SetColorSensor; id 137, document V1.1.3 section 1.15.7, errata E42.
    """

    ID = 137
    LAYOUT = "SetColorSensor"

    is_enabled: bool
    """Whether the sensor works."""
    port: Port
    """Connector of the sensor."""
    version: SensorVersion | None = None
    """Generation of the sensor; hosts before V1.1.5 leave it out."""


class GetColorSensor(Query[ColorSensor]):
    """The colour sensor.

    What GetColorSensor is asked with, for :class:`ColorSensor`; id 137, document V1.1.3 section 1.15.7, errata E42.
    """

    ID = 137
    LAYOUT = "GetColorSensor"

    port: Port | None = None
    """Connector of the sensor; most hosts leave it out."""


class IrSwitch(_meaning.InfraredMeaning, Answer):
    """The infrared sensor.

    GetIRSwitch; id 138, document V1.1.3 section 1.15.8, errata E43.
    """

    ID = 138
    LAYOUT = "IrSwitch"

    state: bool
    """Whether something is in front of it."""


class SetIrSwitch(Queueable):
    """The infrared sensor.

    SetIRSwitch; id 138, document V1.1.3 section 1.15.8, errata E43.
    """

    ID = 138
    LAYOUT = "SetIrSwitch"

    is_enabled: bool
    """Whether the sensor works."""
    port: Port
    """Connector of the sensor."""
    version: SensorVersion | None = None
    """Generation of the sensor; hosts before V1.1.5 leave it out."""


class GetIrSwitch(Query[IrSwitch]):
    """The infrared sensor.

    What GetIRSwitch is asked with, for :class:`IrSwitch`; id 138, document V1.1.3 section 1.15.8, errata E43.
    """

    ID = 138
    LAYOUT = "GetIrSwitch"

    port: Port
    """Connector of the sensor."""


class AngleSensorStaticError(Readable, Writable):
    """Corrections of the angle sensors; kept without power.

    GetAngleSensorStaticError, SetAngleSensorStaticError; id 140, document V1.1.3 section 1.16.1; dangerous: it is
    only set with ``allow_dangerous=True``.
    """

    ID = 140
    LAYOUT = "AngleSensorStaticError"

    rear_arm_angle_error: float
    """Correction of J2; deg."""
    front_arm_angle_error: float
    """Correction of J3; deg."""


class AngleSensorCoef(Readable, Writable):
    """Scale of the angle sensors; kept without power.

    GetAngleSensorCoef, SetAngleSensorCoef; id 141, vendor headers; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 141
    LAYOUT = "AngleSensorCoef"

    rear_arm_angle_coef: float
    """Scale of J2; ratio."""
    front_arm_angle_coef: float
    """Scale of J3; ratio."""


class BaseDecoderStaticError(Readable, Writable):
    """Correction of the base encoder; kept without power.

    GetBaseDecoderStaticError, SetBaseDecoderStaticError; id 142, vendor headers; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 142
    LAYOUT = "BaseDecoderStaticError"

    base_decoder_error: float
    """Correction of J1; deg."""


class WifiConfigMode(Readable, Writable):
    """Whether the Wi-Fi module takes settings.

    GetWIFIConfigMode, SetWIFIConfigMode; id 150, document V1.1.3 section 1.17.1; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 150
    LAYOUT = "WifiConfigMode"

    enable: bool
    """Whether it takes settings."""


class WifiSsid(Readable, Writable):
    """Name of the wireless network.

    GetWIFISSID, SetWIFISSID; id 151, document V1.1.3 section 1.17.2; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 151
    LAYOUT = "WifiSsid"

    ssid: str
    """Name of the network."""


class WifiPassword(Readable, Writable):
    """Password of the wireless network.

    GetWIFIPassword, SetWIFIPassword; id 152, document V1.1.3 section 1.17.3; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 152
    LAYOUT = "WifiPassword"

    password: str
    """Password."""


class WifiIpAddress(Readable, Writable):
    """Address of the arm in the wireless network.

    GetWIFIIPAddress, SetWIFIIPAddress; id 153, document V1.1.3 section 1.17.4; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 153
    LAYOUT = "WifiIpAddress"

    dhcp: bool
    """Whether the network gives the address."""
    addr: tuple[int, int, int, int]
    """Address, first octet first; IPv4 octets."""


class WifiNetmask(Readable, Writable):
    """Mask of the wireless network.

    GetWIFINetmask, SetWIFINetmask; id 154, document V1.1.3 section 1.17.5; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 154
    LAYOUT = "WifiNetmask"

    addr: tuple[int, int, int, int]
    """Mask, first octet first; IPv4 octets."""


class WifiGateway(Readable, Writable):
    """Gateway of the wireless network.

    GetWIFIGateway, SetWIFIGateway; id 155, document V1.1.3 section 1.17.6; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 155
    LAYOUT = "WifiGateway"

    addr: tuple[int, int, int, int]
    """Address, first octet first; IPv4 octets."""


class WifiDns(Readable, Writable):
    """Name server of the wireless network.

    GetWIFIDNS, SetWIFIDNS; id 156, document V1.1.3 section 1.17.7; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 156
    LAYOUT = "WifiDns"

    addr: tuple[int, int, int, int]
    """Address, first octet first; IPv4 octets."""


class WifiConnectStatus(Readable):
    """Whether the arm is in the wireless network.

    GetWIFIConnectStatus; id 157, document V1.1.3 section 1.17.8.
    """

    ID = 157
    LAYOUT = "WifiConnectStatus"

    is_connected: bool
    """Whether it is connected."""


class FirmwareSwitch(Writable):
    """Switches to another firmware, which may not speak this protocol.

    SetFirmwareSwitch; id 160, vendor headers; dangerous: it is only set with ``allow_dangerous=True``.
    """

    ID = 160
    LAYOUT = "FirmwareSwitch"


class FirmwareMode(Readable, Writable):
    """Which firmware runs.

    GetFirmwareMode, SetFirmwareMode; id 161, vendor headers; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 161
    LAYOUT = "FirmwareMode"

    mode: int
    """Firmware; code (unknown)."""
    ctl: int = 0
    """Control; may be left out; code (unknown)."""


class LostStepParams(Writable):
    """How far a joint may be off before it counts as lost.

    SetLostStepParams; id 170, document V1.1.3 section 1.18.1.
    """

    ID = 170
    LAYOUT = "LostStepParams"

    value: float
    """Threshold; deg; above 0."""


class LostStepCmd(Queueable):
    """Compares the joints with their sensors; alarms 0x50 to 0x53 tell the outcome.

    SetLostStepCmd; id 171, document V1.1.3 section 1.18.2, errata E36.
    """

    ID = 171
    LAYOUT = "LostStepCmd"


class Uart4PeripheralsModel(Readable):
    """What is plugged into the second serial connector.

    GetUART4PeripheralsModel; id 181, vendor headers.
    """

    ID = 181
    LAYOUT = "Uart4PeripheralsModel"

    type: int
    """Model; code (unknown)."""


class Uart4PeripheralsEnabled(Readable, Writable):
    """Whether the second serial connector works.

    GetUART4PeripheralsEnabled, SetUART4PeripheralsEnabled; id 182, vendor headers.
    """

    ID = 182
    LAYOUT = "Uart4PeripheralsEnabled"

    is_enabled: bool
    """Whether it works."""


class PulseMode(Readable, Queueable):
    """Counts of motor pulses; their use is unknown.

    GetPulseMode, SetPulseMode; id 191, vendor headers.
    """

    ID = 191
    LAYOUT = "PulseMode"

    j1: float
    """J1; pulses (unconfirmed)."""
    j2: float
    """J2; pulses (unconfirmed)."""
    j3: float
    """J3; pulses (unconfirmed)."""
    j4: float
    """J4; pulses (unconfirmed)."""
    e1: float
    """First external motor; pulses (unconfirmed)."""
    e2: float
    """Second external motor; pulses (unconfirmed)."""


class UserParams(Readable):
    """Eight numbers for the user.

    GetUserParams; id 220, vendor headers.
    """

    ID = 220
    LAYOUT = "UserParams"

    params: tuple[float, float, float, float, float, float, float, float]
    """The numbers; free."""


class PtpTime(Answer):
    """How long a point-to-point move would take from here.

    GetPTPTime; id 221, vendor headers.
    """

    ID = 221
    LAYOUT = "PtpTime"

    ptp_time: int
    """Duration of the move; ms."""


class GetPtpTime(Query[PtpTime]):
    """How long a point-to-point move would take from here.

    What GetPTPTime is asked with, for :class:`PtpTime`; id 221, vendor headers.
    """

    ID = 221
    LAYOUT = "GetPtpTime"

    ptp_mode: PtpMode
    """How to travel, and what the numbers mean."""
    x: float
    """Target x, or J1 in the angle modes; mm, or deg for J1."""
    y: float
    """Target y, or J2 in the angle modes; mm, or deg for J2."""
    z: float
    """Target z, or J3 in the angle modes; mm, or deg for J3."""
    r: float
    """Rotation, or J4 in the angle modes; deg."""


class ZdfCalibRequest(Writable):
    """Calibrates the Z axis of the 3-D printing kit.

    SetZDFCalibRequest; id 230, vendor headers; dangerous: it is only set with ``allow_dangerous=True``.
    """

    ID = 230
    LAYOUT = "ZdfCalibRequest"


class ZdfCalibStatus(Readable):
    """State of that calibration.

    GetZDFCalibStatus; id 231, vendor headers.
    """

    ID = 231
    LAYOUT = "ZdfCalibStatus"

    status: int
    """State; code (unknown)."""


class QueuedCmdStartExec(Writable):
    """Starts the queue.

    SetQueuedCmdStartExec; id 240, document V1.1.3 section 1.19.1.
    """

    ID = 240
    LAYOUT = "QueuedCmdStartExec"


class QueuedCmdStopExec(Writable):
    """Stops the queue when the running command has ended.

    SetQueuedCmdStopExec; id 241, document V1.1.3 section 1.19.2, errata E48.
    """

    ID = 241
    LAYOUT = "QueuedCmdStopExec"


class QueuedCmdForceStopExec(Writable):
    """Stops the queue and the running command.

    SetQueuedCmdForceStopExec; id 242, document V1.1.3 section 1.19.3, errata E48.
    """

    ID = 242
    LAYOUT = "QueuedCmdForceStopExec"


class QueuedCmdStartDownload(Writable):
    """Begins to store a program in the arm.

    SetQueuedCmdStartDownload; id 243, document V1.1.3 section 1.19.4, errata E46; dangerous: it is only set with
    ``allow_dangerous=True``.
    """

    ID = 243
    LAYOUT = "QueuedCmdStartDownload"

    total_loop: int
    """How often the program runs; loops."""
    line_per_loop: int
    """Commands of the program; commands."""


class QueuedCmdStopDownload(Writable):
    """Ends the storing of a program.

    SetQueuedCmdStopDownload; id 244, document V1.1.3 section 1.19.5.
    """

    ID = 244
    LAYOUT = "QueuedCmdStopDownload"


class QueuedCmdClear(Writable):
    """Drops the waiting commands of the queue.

    SetQueuedCmdClear; id 245, document V1.1.3 section 1.19.6, errata E48.
    """

    ID = 245
    LAYOUT = "QueuedCmdClear"


class QueuedCmdCurrentIndex(Readable):
    """Index of the queued command that was finished last.

    GetQueuedCmdCurrentIndex; id 246, document V1.1.3 section 1.19.7, errata E37.
    """

    ID = 246
    LAYOUT = "QueuedCmdCurrentIndex"

    queued_cmd_current_index: int
    """Index of the command finished last, 0 before the first; index."""


class QueuedCmdLeftSpace(Readable):
    """Free places in the queue.

    GetQueuedCmdLeftSpace; id 247, document V1.1.3 section 1.19.8, errata E38.
    """

    ID = 247
    LAYOUT = "QueuedCmdLeftSpace"

    left_space: int
    """Free places; commands."""


class QueuedCmdMotionFinish(Readable):
    """Whether nothing moves.

    GetQueuedCmdMotionFinish; id 248, document V1.1.5.
    """

    ID = 248
    LAYOUT = "QueuedCmdMotionFinish"

    is_finish: bool
    """1 when no motion is pending."""

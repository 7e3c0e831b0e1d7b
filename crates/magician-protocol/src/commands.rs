//! The command table: one row for each command. Structs, codec, help, JSON and checks are derived
//! from it.
//!
//! The rows are the 74 commands of the vendor's document (V1.1.3, four of V1.1.5) and 16 known from
//! vendor headers, corrected by the errata named in rows and comments (docs/reference/ERRATA.md). Lengths are
//! mm, angles degrees. The syntax of a row is documented at the macro in `table.rs`.
//!
//! The file is long because it is the table: every wire layout is in one place.

use crate::layout::{Field, Form, FormKind, LayoutInfo};
use crate::range::Range;
use crate::row::{Chapter, Confidence, Effect, Row, Source};
use crate::wire::{Layout, Queueable, Readable, Reader, Wire, Writable, Writer};
use crate::{
    AlarmSet, Bytes, CpMode, DecodeError, Flag, Handedness, IoFunction, JogCommand, NoArgs, PoList,
    Port, PtpMode, RailVersion, RangeError, SensorVersion, Stepper, TeachTrigger, Text,
    TriggerCondition, TriggerMode,
};

commands! {
    0 "DeviceSN" "Serial number of the arm." [Info "1.3.1" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param DeviceSn {
        device_sn: Text, "text", [at most 23 "bytes"], "Serial number.";
    }

    1 "DeviceName" "Name of the arm, free to choose." [Info "1.3.2" Document High]
    [queue no, resend yes, danger no, effect Store]
    param DeviceName {
        device_name: Text, "text", [at most 64 "bytes"], "Name.";
    }

    2 "DeviceVersion" "Version of the controller's firmware." [Info "1.3.3" Document High, errata "E16"]
    [queue no, resend yes, danger no, effect Look]
    state DeviceVersion {
        major_version: u8, "count", [], "First number of the version.";
        minor_version: u8, "count", [], "Second number of the version.";
        revision: u8, "count", [], "Third number of the version.";
        extra: Bytes, "bytes", [], "Bytes added by newer firmware, among them a hardware version.";
    }

    3 "DeviceWithL" "Whether the arm stands on a sliding rail." [Info "1.3.4" Document High, errata "E15"]
    [queue yes, resend yes, danger no, effect Setting]
    state DeviceWithL {
        with_l: Flag, "flag", [0..=1], "Whether the rail is in use.";
    }
    action SetDeviceWithL {
        with_l: Flag, "flag", [0..=1], "Whether to use the rail.";
        version: Option<RailVersion>, "enum", [0..=1], "Generation of the rail; hosts before V1.1.5 leave it out.";
    }

    4 "DeviceTime" "Time since the controller was switched on." [Info "1.3.5" Document High]
    [queue no, resend yes, danger no, effect Look]
    state DeviceTime {
        g_systick: u32, "ms", [], "Time since power-up; begins again at 2^32.";
    }

    5 "DeviceID" "Unique id of the controller's processor." [Info "1.3.6" Document High, errata "E14"]
    [queue no, resend yes, danger no, effect Look]
    state DeviceId {
        device_id: [u32; 3], "id", [], "The id, least significant word first.";
    }

    6 "DeviceInfo" "Counters of the controller's life." [Info "none" Addition Medium]
    [queue no, resend yes, danger no, effect Look]
    state DeviceInfo {
        run_time: u64, "s (unconfirmed)", [], "Running time over its life.";
        power_on: u32, "count", [], "Times it was switched on.";
        power_off: u32, "count", [], "Times it was switched off.";
    }

    10 "Pose" "Where the arm is: tool position and joint angles, as commanded." [Pose "1.4.1" Document High]
    [queue no, resend yes, danger no, effect Look]
    state Pose {
        x: f32, "mm", [], "Tool x in the base frame.";
        y: f32, "mm", [], "Tool y in the base frame.";
        z: f32, "mm", [], "Tool z in the base frame.";
        r: f32, "deg", [], "Tool rotation in the base frame, J1 + J4.";
        joint_angle: [f32; 4], "deg", [], "J1 base, J2 rear arm, J3 forearm, J4 end effector.";
    }

    11 "ResetPose" "Sets the angles of rear arm and forearm." [Pose "1.4.2" Document High, errata "E23"]
    [queue no, resend no, danger yes, effect Setting]
    action ResetPose named "ResetPose" {
        manual: Flag, "flag", [0..=1], "0 takes the angles from the sensors, 1 those given here.";
        rear_arm_angle: f32 = 0, "deg", [], "J2, used when manual is 1.";
        front_arm_angle: f32 = 0, "deg", [], "J3, used when manual is 1.";
    }

    12 "Kinematics" "Speed and acceleration of the arm." [Pose "none" Addition Medium]
    [queue no, resend yes, danger no, effect Look]
    state Kinematics {
        velocity: f32, "mm/s", [], "Speed.";
        acceleration: f32, "mm/s^2", [], "Acceleration.";
    }

    13 "PoseL" "Position of the arm on its rail." [Pose "1.4.3" Document High]
    [queue no, resend yes, danger no, effect Look]
    state PoseL {
        pose_l: f32, "mm", [], "Rail position.";
    }

    20 "AlarmsState" "Active alarms, one bit each." [Alarm "1.5.1" Document High, errata "E18 to \
        E20"]
    [queue no, resend yes, danger no, effect Queue]
    state AlarmsState {
        alarms_state: AlarmSet, "bitmap", [], "Alarm n is bit n % 8 of byte n / 8.";
    }
    action ClearAlarmsState named "ClearAllAlarmsState" {
    }

    21 "ClearAllAlarmsState" "Clears the alarms under the document's id; hosts use 20 with rw = 1." [Alarm "1.5.2" Document Medium, errata "E19"]
    [queue no, resend yes, danger no, effect Queue]
    action ClearAllAlarmsState named "ClearAllAlarmsState" {
    }

    30 "HOMEParams" "Where the arm goes when homing ends." [Home "1.6.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param HomeParams {
        x: f32, "mm", [], "Home x.";
        y: f32, "mm", [], "Home y.";
        z: f32, "mm", [], "Home z.";
        r: f32, "deg", [], "Home rotation.";
    }

    31 "HOMECmd" "Homes the arm: finds the reference of J1 and goes to the home point." [Home "1.6.2" Document High, errata "E22"]
    [queue yes, resend no, danger no, effect Motion]
    action HomeCmd {
        reserved: u32 = 0, "reserved", [0..=0], "Reserved.";
    } forms [
        1 Zeros "shortened payload (E22)",
        2 Zeros "shortened payload (E22)",
        3 Zeros "shortened payload (E22)"
    ]

    32 "AutoLeveling" "Levels the arm by its sensors." [Home "1.6.3" Document High, errata "E21"]
    [queue yes, resend no, danger no, effect Motion]
    state AutoLeveling {
        result: f32, "deg (unconfirmed)", [], "Precision reached.";
    } forms [ 5 Skip(1) "a flag before the result (E21)" ]
    action SetAutoLeveling {
        is_auto_leveling: Flag, "flag", [0..=1], "1 starts levelling.";
        accuracy: f32, "deg (unconfirmed)", [], "Precision wanted.";
    }

    40 "HHTTrigMode" "When hand teaching reports a point." [Teach "1.7.1" Document High, errata "E24"]
    [queue no, resend yes, danger no, effect Setting]
    param HhtTrigMode {
        mode: TeachTrigger, "enum", [0..=1], "When to report.";
    }

    41 "HHTTrigOutputEnabled" "Whether hand teaching reports points at all." [Teach "1.7.2" Document High]
    [queue no, resend yes, danger no, effect Setting]
    param HhtTrigOutputEnabled {
        is_enabled: Flag, "flag", [0..=1], "Whether it reports.";
    }

    42 "HHTTrigOutput" "Whether a point has been taught since the last look." [Teach "1.7.3" Document High]
    [queue no, resend yes, danger no, effect Consume]
    state HhtTrigOutput {
        is_triggered: Flag, "flag", [0..=1], "Whether there is a new point; reading clears it.";
    }

    50 "ArmOrientation" "Elbow side of a SCARA arm; this arm stores it." [Pose "none" Addition Medium]
    [queue yes, resend yes, danger no, effect Setting]
    param ArmOrientation {
        orientation: Handedness, "enum", [0..=1], "Elbow side.";
    }

    60 "EndEffectorParams" "Tool bias: where the tool sits relative to the wrist." [Tool "1.8.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param EndEffectorParams {
        x_bias: f32, "mm", [], "Offset along the forearm's direction.";
        y_bias: f32, "mm", [], "Offset to the left.";
        z_bias: f32, "mm", [], "Offset downwards.";
    }

    61 "EndEffectorLaser" "The laser." [Tool "1.8.2" Document High]
    [queue yes, resend yes, danger no, effect Laser, may burn]
    state EndEffectorLaser {
        is_ctrl_enabled: Flag, "flag", [0..=1], "Whether the host controls the tool connector.";
        is_on: Flag, "flag", [0..=1], "Whether the laser burns.";
    }
    action SetEndEffectorLaser {
        enable_ctrl: Flag, "flag", [0..=1], "Whether the host controls the tool connector.";
        on: Flag, "flag", [0..=1], "Whether the laser burns.";
    }

    62 "EndEffectorSuctionCup" "The suction cup." [Tool "1.8.3" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    state EndEffectorSuctionCup {
        is_ctrl_enabled: Flag, "flag", [0..=1], "Whether the pump may run.";
        is_sucked: Flag, "flag", [0..=1], "Whether the cup sucks.";
    }
    action SetEndEffectorSuctionCup {
        enable_ctrl: Flag, "flag", [0..=1], "Whether the pump may run.";
        suck: Flag, "flag", [0..=1], "Whether the cup sucks.";
    }

    63 "EndEffectorGripper" "The gripper." [Tool "1.8.4" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    state EndEffectorGripper {
        is_ctrl_enabled: Flag, "flag", [0..=1], "Whether the pump may run.";
        is_gripped: Flag, "flag", [0..=1], "1 closed, 0 open.";
    }
    action SetEndEffectorGripper {
        enable_ctrl: Flag, "flag", [0..=1], "Whether the pump may run.";
        grip: Flag, "flag", [0..=1], "1 closes, 0 opens.";
    }

    70 "JOGJointParams" "Speeds of jogging in joints." [Jog "1.9.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogJointParams {
        velocity: [f32; 4], "deg/s", [above 0], "Speed of J1 to J4.";
        acceleration: [f32; 4], "deg/s^2", [above 0], "Acceleration of J1 to J4.";
    }

    71 "JOGCoordinateParams" "Speeds of jogging in coordinates." [Jog "1.9.2" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogCoordinateParams {
        velocity: [f32; 4], "mm/s for x, y, z; deg/s for r", [above 0], "Speed of x, y, z and r.";
        acceleration: [f32; 4], "mm/s^2 for x, y, z; deg/s^2 for r", [above 0], "Acceleration of x, y, z and r.";
    }

    72 "JOGCommonParams" "Share of the jog speeds that is used." [Jog "1.9.3" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Share of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Share of the set acceleration.";
    }

    73 "JOGCmd" "Moves one axis until told to stop." [Jog "1.9.4" Document High, errata "E25"]
    [queue yes, resend no, danger no, effect Jog]
    action JogCmd {
        is_joint: Flag, "flag", [0..=1], "0 jogs a coordinate, 1 a joint.";
        cmd: JogCommand, "enum", [0..=10], "Axis and direction; 0 stops.";
    }

    74 "JOGLParams" "Speeds of jogging on the rail." [Jog "1.9.5" Document High, errata "E25"]
    [queue yes, resend yes, danger no, effect Setting]
    param JogLParams {
        velocity: f32, "mm/s", [above 0], "Speed on the rail.";
        acceleration: f32, "mm/s^2", [above 0], "Acceleration on the rail.";
    }

    80 "PTPJointParams" "Speeds of the joints in point-to-point moves." [Ptp "1.10.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJointParams {
        velocity: [f32; 4], "deg/s", [above 0], "Speed of J1 to J4.";
        acceleration: [f32; 4], "deg/s^2", [above 0], "Acceleration of J1 to J4.";
    }

    81 "PTPCoordinateParams" "Speeds of the tool in straight point-to-point moves." [Ptp "1.10.2" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpCoordinateParams {
        xyz_velocity: f32, "mm/s", [above 0], "Speed of the tool point.";
        r_velocity: f32, "deg/s", [above 0], "Speed of rotation.";
        xyz_acceleration: f32, "mm/s^2", [above 0], "Acceleration of the tool point.";
        r_acceleration: f32, "deg/s^2", [above 0], "Acceleration of rotation.";
    }

    82 "PTPJumpParams" "How high a jump lifts." [Ptp "1.10.3" Document High, errata "E30"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJumpParams {
        jump_height: f32, "mm", [], "Lift above the higher end.";
        z_limit: f32, "mm", [], "Highest z of the transfer.";
    }

    83 "PTPCommonParams" "Share of the point-to-point speeds that is used." [Ptp "1.10.4" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Share of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Share of the set acceleration.";
    }

    84 "PTPCmd" "Moves the arm to a point." [Ptp "1.10.5" Document High, errata "E28"]
    [queue yes, resend no, danger no, effect Motion]
    action PtpCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "How to travel, and what the numbers mean.";
        x: f32, "mm, or deg for J1", [], "Target x, or J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y, or J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z, or J3 in the angle modes.";
        r: f32, "deg", [], "Rotation, or J4 in the angle modes.";
    }

    85 "PTPLParams" "Speeds on the rail in point-to-point moves." [Ptp "1.10.6" Document High, errata "E26"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpLParams {
        velocity: f32, "mm/s", [above 0], "Speed on the rail.";
        acceleration: f32, "mm/s^2", [above 0], "Acceleration on the rail.";
    }

    86 "PTPWithLCmd" "Moves the arm and the rail to a point." [Ptp "1.10.7" Document High]
    [queue yes, resend no, danger no, effect Motion]
    action PtpWithLCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "How to travel, and what the numbers mean.";
        x: f32, "mm, or deg for J1", [], "Target x, or J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y, or J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z, or J3 in the angle modes.";
        r: f32, "deg", [], "Rotation, or J4 in the angle modes.";
        l: f32, "mm", [0..=1000 where absolute], "Rail position, or way on the rail in the incremental modes.";
    }

    87 "PTPJump2Params" "How high a jump lifts, each end for itself." [Ptp "1.10.8" Document High, errata "E27"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJump2Params {
        start_jump_height: f32, "mm", [], "Lift above the start.";
        end_jump_height: f32, "mm", [], "Lift above the end.";
        z_limit: f32, "mm", [], "Highest z of the transfer.";
    }

    88 "PTPPOCmd" "Moves the arm to a point and switches outputs on the way." [Ptp "1.10.9" Document High, errata "E29"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action PtpPoCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "How to travel, and what the numbers mean.";
        x: f32, "mm, or deg for J1", [], "Target x, or J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y, or J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z, or J3 in the angle modes.";
        r: f32, "deg", [], "Rotation, or J4 in the angle modes.";
        po: PoList, "percent : EIO address : level", [at most 57 "outputs"], "Outputs to switch.";
    }

    89 "PTPPOWithLCmd" "Moves the arm and the rail to a point and switches outputs on the way." [Ptp "1.10.10" Document High, errata "E29"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action PtpPoWithLCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "How to travel, and what the numbers mean.";
        x: f32, "mm, or deg for J1", [], "Target x, or J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y, or J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z, or J3 in the angle modes.";
        r: f32, "deg", [], "Rotation, or J4 in the angle modes.";
        l: f32, "mm", [0..=1000 where absolute], "Rail position, or way on the rail in the incremental modes.";
        po: PoList, "percent : EIO address : level", [at most 56 "outputs"], "Outputs to switch.";
    }

    90 "CPParams" "Speeds of continuous path." [Cp "1.11.1" Document High, errata "E31"]
    [queue yes, resend yes, danger no, effect Setting]
    param CpParams {
        plan_acc: f32, "mm/s^2", [above 0], "Most acceleration along the path.";
        junction_vel: f32, "mm/s", [above 0], "Most speed along the path.";
        acc_or_period: f32, "mm/s^2, or ms in real-time mode", [above 0], "Acceleration (unused), or the time of a segment.";
        real_time_track: Flag, "flag", [0..=1], "1 when the host clocks the path.";
    }

    91 "CPCmd" "Adds a straight segment to the continuous path." [Cp "1.11.2" Document High, errata "E32"]
    [queue yes, resend no, danger no, effect Motion]
    action CpCmd {
        cp_mode: CpMode, "enum", [0..=1], "What the numbers count from.";
        x: f32, "mm", [], "End of the segment, x.";
        y: f32, "mm", [], "End of the segment, y.";
        z: f32, "mm", [], "End of the segment, z.";
        velocity_or_power: f32, "reserved", [], "Reserved.";
    } forms [ 14 Zeros "one byte instead of the last number (E32)" ]

    92 "CPLECmd" "Adds a straight segment with laser power to the continuous path." [Cp "1.11.3" Document High, errata "E32"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action CpLeCmd {
        cp_mode: CpMode, "enum", [0..=1], "What the numbers count from.";
        x: f32, "mm", [], "End of the segment, x.";
        y: f32, "mm", [], "End of the segment, y.";
        z: f32, "mm", [], "End of the segment, z.";
        velocity_or_power: f32, "percent", [0..=100], "Laser power along the segment.";
    } forms [ 14 Zeros "one byte instead of the last number (E32)" ]

    93 "CPRHeadHoldEnable" "Whether the tool keeps its rotation on a continuous path." [Cp "none" Header Medium]
    [queue no, resend yes, danger no, effect Setting]
    param CpRHeadHoldEnable {
        enable: Flag, "flag", [0..=1], "Whether it keeps it.";
    }

    94 "CPCommonParams" "Share of the continuous-path speeds that is used." [Cp "none" Header Low]
    [queue yes, resend yes, danger no, effect Setting]
    param CpCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Share of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Share of the set acceleration.";
    }

    100 "ARCParams" "Speeds of arcs." [Arc "1.12.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param ArcParams {
        xyz_velocity: f32, "mm/s", [above 0], "Speed of the tool point.";
        r_velocity: f32, "deg/s", [above 0], "Speed of rotation.";
        xyz_acceleration: f32, "mm/s^2", [above 0], "Acceleration of the tool point.";
        r_acceleration: f32, "deg/s^2", [above 0], "Acceleration of rotation.";
    }

    101 "ARCCmd" "Moves the arm along an arc through a point to a point." [Arc "1.12.2" Document High, errata "E33"]
    [queue yes, resend no, danger no, effect Motion]
    action ArcCmd {
        cir_point: [f32; 4], "mm for x, y, z; deg for r", [], "A point on the arc: x, y, z, r.";
        to_point: [f32; 4], "mm for x, y, z; deg for r", [], "End of the arc: x, y, z, r.";
    }

    102 "CircleCmd" "Moves the arm round a circle through two points, back to where it began." [Arc "none" Header Medium, errata "E33"]
    [queue yes, resend no, danger no, effect Motion]
    action CircleCmd {
        cir_point: [f32; 4], "mm for x, y, z; deg for r", [], "A point on the circle: x, y, z, r.";
        to_point: [f32; 4], "mm for x, y, z; deg for r", [], "Another point on the circle: x, y, z, r.";
        count: u32 = 1, "turns", [above 0], "Full turns; older hosts leave it out.";
    }

    103 "ARCCommonParams" "Share of the arc speeds that is used." [Arc "none" Header Low]
    [queue yes, resend yes, danger no, effect Setting]
    param ArcCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Share of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Share of the set acceleration.";
    }

    110 "WAITCmd" "Makes the queue wait." [Wait "1.13.1" Document High, errata "E34"]
    [queue yes, resend yes, danger no, effect Wait]
    action WaitCmd {
        timeout: u32, "ms", [], "How long to wait.";
    }

    120 "TRIGCmd" "Makes the queue wait for an input." [Trigger "1.14.1" Document High, errata "E35"]
    [queue yes, resend no, danger no, effect Wait]
    action TrigCmd {
        address: u8, "EIO address", [1..=20], "Input to look at.";
        mode: TriggerMode, "enum", [0..=1], "Digital level or analog value.";
        condition: TriggerCondition, "enum", [mode 0 "level mode" 0..=1, mode 1 "analog mode" 0..=3], "How to compare.";
        threshold: u16, "level or counts", [mode 0 "level mode" 0..=1, mode 1 "analog mode" 0..=4095 "counts"], "What to compare with.";
    }

    130 "IOMultiplexing" "What an EIO pin does." [Io "1.15.1" Document High, errata "E39, E40"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetIoMultiplexing {
        address: Option<u8> | required, "EIO address", [1..=20], "Pin.";
    }
    param IoMultiplexing {
        address: u8, "EIO address", [1..=20], "Pin.";
        multiplex: IoFunction, "enum", [0..=6], "What it does.";
    }

    131 "IODO" "Level of a digital output." [Io "1.15.2" Document High, errata "E39"]
    [queue yes, resend yes, danger no, effect Setting, may burn]
    query GetIoDo {
        address: Option<u8> | required, "EIO address", [1..=20], "Pin.";
    }
    param IoDo {
        address: u8, "EIO address", [1..=20], "Pin.";
        level: Flag, "flag", [0..=1], "0 low, 1 high.";
    }

    132 "IOPWM" "Signal of a pulse-width output." [Io "1.15.3" Document High, errata "E39"]
    [queue yes, resend yes, danger no, effect Setting, may burn]
    query GetIoPwm {
        address: Option<u8> | required, "EIO address", [1..=20], "Pin.";
    }
    param IoPwm {
        address: u8, "EIO address", [1..=20], "Pin.";
        frequency: f32, "Hz", [10..=1000000], "Frequency.";
        duty_cycle: f32, "percent", [0..=100], "Share of the time that it is high, the duty cycle.";
    }

    133 "IODI" "Level of a digital input." [Io "1.15.4" Document High, errata "E39"]
    [queue no, resend yes, danger no, effect Look]
    query GetIoDi {
        address: Option<u8> | required, "EIO address", [1..=20], "Pin.";
    }
    state IoDi {
        address: u8, "EIO address", [1..=20], "Pin.";
        level: Flag, "flag", [0..=1], "0 low, 1 high.";
    }

    134 "IOADC" "Value of an analog input." [Io "1.15.5" Document High, errata "E39"]
    [queue no, resend yes, danger no, effect Look]
    query GetIoAdc {
        address: Option<u8> | required, "EIO address", [1..=20], "Pin.";
    }
    state IoAdc {
        address: u8, "EIO address", [1..=20], "Pin.";
        value: u16, "counts", [0..=4095], "Value, 4095 at 3.3 V.";
    }

    135 "EMotor" "Runs an external stepper, a conveyor for one." [Io "1.15.6" Document High, errata "E41"]
    [queue yes, resend no, danger no, effect Motor]
    action EMotor {
        index: Stepper, "enum", [0..=1], "Which motor.";
        is_enabled: Flag, "flag", [0..=1], "Whether it runs.";
        speed: i32, "pulses/s", [], "Speed; the sign is the direction.";
    } forms [ 4 Zeros "shortened speed (E11)" ]

    136 "EMotorS" "Runs an external stepper a number of pulses." [Io "none" Header Medium, errata "E41"]
    [queue yes, resend no, danger no, effect Motor]
    action EMotorS {
        index: Stepper, "enum", [0..=1], "Which motor.";
        is_enabled: Flag, "flag", [0..=1], "Whether it runs.";
        speed: i32, "pulses/s", [], "Speed; the sign is the direction.";
        distance: u32, "pulses", [], "How far.";
    }

    137 "ColorSensor" "The colour sensor." [Io "1.15.7" Document Medium, errata "E42"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetColorSensor {
        port: Option<Port>, "enum", [0..=3], "Connector of the sensor; most hosts leave it out.";
    }
    state ColorSensor {
        r: u8, "counts", [0..=255], "Red.";
        g: u8, "counts", [0..=255], "Green.";
        b: u8, "counts", [0..=255], "Blue.";
    }
    action SetColorSensor {
        is_enabled: Flag, "flag", [0..=1], "Whether the sensor works.";
        port: Port, "enum", [0..=3], "Connector of the sensor.";
        version: Option<SensorVersion>, "enum", [0..=1], "Generation of the sensor; hosts before V1.1.5 leave it out.";
    }

    138 "IRSwitch" "The infrared sensor." [Io "1.15.8" Document Medium, errata "E43"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetIrSwitch {
        port: Option<Port> | required, "enum", [0..=3], "Connector of the sensor.";
    }
    state IrSwitch {
        state: Flag, "flag", [0..=1], "Whether something is in front of it.";
    }
    action SetIrSwitch {
        is_enabled: Flag, "flag", [0..=1], "Whether the sensor works.";
        port: Port, "enum", [0..=3], "Connector of the sensor.";
        version: Option<SensorVersion>, "enum", [0..=1], "Generation of the sensor; hosts before V1.1.5 leave it out.";
    }

    140 "AngleSensorStaticError" "Corrections of the angle sensors; kept without power." [Calibration "1.16.1" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param AngleSensorStaticError {
        rear_arm_angle_error: f32, "deg", [], "Correction of J2.";
        front_arm_angle_error: f32, "deg", [], "Correction of J3.";
    }

    141 "AngleSensorCoef" "Scale of the angle sensors; kept without power." [Calibration "none" Header Medium]
    [queue no, resend yes, danger yes, effect Store]
    param AngleSensorCoef {
        rear_arm_angle_coef: f32, "ratio", [], "Scale of J2.";
        front_arm_angle_coef: f32, "ratio", [], "Scale of J3.";
    }

    142 "BaseDecoderStaticError" "Correction of the base encoder; kept without power." [Calibration "none" Header Medium]
    [queue no, resend yes, danger yes, effect Store]
    param BaseDecoderStaticError {
        base_decoder_error: f32, "deg", [], "Correction of J1.";
    }

    150 "WIFIConfigMode" "Whether the Wi-Fi module takes settings." [Wifi "1.17.1" Document High]
    [queue no, resend yes, danger yes, effect Setting]
    param WifiConfigMode {
        enable: Flag, "flag", [0..=1], "Whether it takes settings.";
    }

    151 "WIFISSID" "Name of the wireless network." [Wifi "1.17.2" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiSsid {
        ssid: Text, "text", [], "Name of the network.";
    }

    152 "WIFIPassword" "Password of the wireless network." [Wifi "1.17.3" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiPassword {
        password: Text, "text", [], "Password.";
    }

    153 "WIFIIPAddress" "Address of the arm in the wireless network." [Wifi "1.17.4" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiIpAddress {
        dhcp: Flag, "flag", [0..=1], "Whether the network gives the address.";
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    154 "WIFINetmask" "Mask of the wireless network." [Wifi "1.17.5" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiNetmask {
        addr: [u8; 4], "IPv4 octets", [], "Mask, first octet first.";
    }

    155 "WIFIGateway" "Gateway of the wireless network." [Wifi "1.17.6" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiGateway {
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    156 "WIFIDNS" "Name server of the wireless network." [Wifi "1.17.7" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiDns {
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    157 "WIFIConnectStatus" "Whether the arm is in the wireless network." [Wifi "1.17.8" Document High]
    [queue no, resend yes, danger no, effect Look]
    state WifiConnectStatus {
        is_connected: Flag, "flag", [0..=1], "Whether it is connected.";
    }

    160 "FirmwareSwitch" "Switches to another firmware, which may not speak this protocol." [Info "none" Header Low]
    [queue no, resend no, danger yes, effect Store]
    action FirmwareSwitch {
    }

    161 "FirmwareMode" "Which firmware runs." [Info "none" Header Low]
    [queue no, resend no, danger yes, effect Store]
    param FirmwareMode {
        mode: u8, "code (unknown)", [], "Firmware.";
        ctl: u8 = 0, "code (unknown)", [], "Control; may be left out.";
    }

    170 "LostStepParams" "How far a joint may be off before it counts as lost." [LostStep "1.18.1" Document High]
    [queue no, resend yes, danger no, effect Setting]
    action LostStepParams {
        value: f32, "deg", [above 0], "Threshold.";
    }

    171 "LostStepCmd" "Compares the joints with their sensors; alarms 0x50 to 0x53 tell the outcome." [LostStep "1.18.2" Document High, errata "E36"]
    [queue yes, resend no, danger no, effect Setting]
    action LostStepCmd {
    }

    181 "UART4PeripheralsModel" "What is plugged into the second serial connector." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state Uart4PeripheralsModel {
        type_: u8, "code (unknown)", [], "Model.";
    }

    182 "UART4PeripheralsEnabled" "Whether the second serial connector works." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Setting]
    param Uart4PeripheralsEnabled {
        is_enabled: Flag, "flag", [0..=1], "Whether it works.";
    }

    191 "PulseMode" "Counts of motor pulses; their use is unknown." [Calibration "none" Header Low]
    [queue yes, resend no, danger no, effect Setting]
    param PulseMode {
        j1: f32, "pulses (unconfirmed)", [], "J1.";
        j2: f32, "pulses (unconfirmed)", [], "J2.";
        j3: f32, "pulses (unconfirmed)", [], "J3.";
        j4: f32, "pulses (unconfirmed)", [], "J4.";
        e1: f32, "pulses (unconfirmed)", [], "First external motor.";
        e2: f32, "pulses (unconfirmed)", [], "Second external motor.";
    } forms [ 0 Zeros "empty payload" ]

    220 "UserParams" "Eight numbers for the user." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state UserParams {
        params: [f32; 8], "free", [], "The numbers.";
    }

    221 "PTPTime" "How long a point-to-point move would take from here." [Ptp "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    query GetPtpTime {
        ptp_mode: PtpMode, "enum", [0..=9], "How to travel, and what the numbers mean.";
        x: f32, "mm, or deg for J1", [], "Target x, or J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y, or J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z, or J3 in the angle modes.";
        r: f32, "deg", [], "Rotation, or J4 in the angle modes.";
    }
    state PtpTime {
        ptp_time: u32, "ms", [], "Duration of the move.";
    }

    230 "ZDFCalibRequest" "Calibrates the Z axis of the 3-D printing kit." [Calibration "none" Header Low]
    [queue no, resend no, danger yes, effect Motion]
    action ZdfCalibRequest {
    }

    231 "ZDFCalibStatus" "State of that calibration." [Calibration "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state ZdfCalibStatus {
        status: u8, "code (unknown)", [], "State.";
    }

    240 "QueuedCmdStartExec" "Starts the queue." [Queue "1.19.1" Document High]
    [queue ignored, resend no, danger no, effect Queue]
    action QueuedCmdStartExec {
    }

    241 "QueuedCmdStopExec" "Stops the queue when the running command has ended." [Queue "1.19.2" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdStopExec {
    }

    242 "QueuedCmdForceStopExec" "Stops the queue and the running command." [Queue "1.19.3" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdForceStopExec {
    }

    243 "QueuedCmdStartDownload" "Begins to store a program in the arm." [Queue "1.19.4" Document High, errata "E46"]
    [queue ignored, resend no, danger yes, effect Queue]
    action QueuedCmdStartDownload {
        total_loop: u32, "loops", [], "How often the program runs.";
        line_per_loop: u32, "commands", [], "Commands of the program.";
    } forms [ 2 Bytes "two single bytes (E46)" ]

    244 "QueuedCmdStopDownload" "Ends the storing of a program." [Queue "1.19.5" Document High]
    [queue ignored, resend no, danger no, effect Queue]
    action QueuedCmdStopDownload {
    }

    245 "QueuedCmdClear" "Drops the waiting commands of the queue." [Queue "1.19.6" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdClear {
    }

    246 "QueuedCmdCurrentIndex" "Index of the queued command that was finished last." [Queue "1.19.7" Document High, errata "E37"]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdCurrentIndex {
        queued_cmd_current_index: u64, "index", [], "Index of the command finished last, 0 before the first.";
    }

    247 "QueuedCmdLeftSpace" "Free places in the queue." [Queue "1.19.8" Document High, errata "E38"]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdLeftSpace {
        left_space: u32, "commands", [], "Free places.";
    } forms [ 8 Skip(0) "64-bit count, its low half taken (E38)" ]

    248 "QueuedCmdMotionFinish" "Whether nothing moves." [Queue "none" Addition Medium]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdMotionFinish {
        is_finish: Flag, "flag", [0..=1], "1 when no motion is pending.";
    }
}

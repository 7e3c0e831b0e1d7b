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

    1 "DeviceName" "Name of the arm, chosen by its owner." [Info "1.3.2" Document High]
    [queue no, resend yes, danger no, effect Store]
    param DeviceName {
        device_name: Text, "text", [at most 64 "bytes"], "Name.";
    }

    2 "DeviceVersion" "Firmware version of the controller." [Info "1.3.3" Document High, errata "E16"]
    [queue no, resend yes, danger no, effect Look]
    state DeviceVersion {
        major_version: u8, "count", [], "Major version.";
        minor_version: u8, "count", [], "Minor version.";
        revision: u8, "count", [], "Revision.";
        extra: Bytes, "bytes", [], "Bytes appended by newer firmware, including a hardware version.";
    }

    3 "DeviceWithL" "Use of the sliding rail." [Info "1.3.4" Document High, errata "E15"]
    [queue yes, resend yes, danger no, effect Setting]
    state DeviceWithL {
        with_l: Flag, "flag", [0..=1], "True if the rail is in use.";
    }
    action SetDeviceWithL {
        with_l: Flag, "flag", [0..=1], "True to use the rail.";
        version: Option<RailVersion>, "enum", [0..=1], "Generation of the rail; hosts before V1.1.5 omit it.";
    }

    4 "DeviceTime" "Time since the controller was switched on." [Info "1.3.5" Document High]
    [queue no, resend yes, danger no, effect Look]
    state DeviceTime {
        g_systick: u32, "ms", [], "Time since power-up; wraps at 2^32.";
    }

    5 "DeviceID" "Unique id of the controller's processor." [Info "1.3.6" Document High, errata "E14"]
    [queue no, resend yes, danger no, effect Look]
    state DeviceId {
        device_id: [u32; 3], "id", [], "Id, least significant word first.";
    }

    6 "DeviceInfo" "Lifetime counters of the controller." [Info "none" Addition Medium]
    [queue no, resend yes, danger no, effect Look]
    state DeviceInfo {
        run_time: u64, "s (unconfirmed)", [], "Total running time.";
        power_on: u32, "count", [], "Number of power-ups.";
        power_off: u32, "count", [], "Number of power-downs.";
    }

    10 "Pose" "Pose of the arm: tool position and joint angles, as commanded." [Pose "1.4.1" Document High]
    [queue no, resend yes, danger no, effect Look]
    state Pose {
        x: f32, "mm", [], "Tool x in the base frame.";
        y: f32, "mm", [], "Tool y in the base frame.";
        z: f32, "mm", [], "Tool z in the base frame.";
        r: f32, "deg", [], "Tool rotation in the base frame, J1 + J4.";
        joint_angle: [f32; 4], "deg", [], "J1 base, J2 rear arm, J3 forearm, J4 end effector.";
    }

    11 "ResetPose" "Sets the controller's angles of the rear arm and the forearm." [Pose "1.4.2" Document High, errata "E23"]
    [queue no, resend no, danger yes, effect Setting]
    action ResetPose named "ResetPose" {
        manual: Flag, "flag", [0..=1], "True to take the angles given here, false to read them from the sensors.";
        rear_arm_angle: f32 = 0, "deg", [], "J2; used if manual is true.";
        front_arm_angle: f32 = 0, "deg", [], "J3; used if manual is true.";
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

    21 "ClearAllAlarmsState" "Clears the alarms, under the id of the document; hosts use id 20 with rw = 1." [Alarm "1.5.2" Document Medium, errata "E19"]
    [queue no, resend yes, danger no, effect Queue]
    action ClearAllAlarmsState named "ClearAllAlarmsState" {
    }

    30 "HOMEParams" "Home point, to which the arm moves at the end of homing." [Home "1.6.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param HomeParams {
        x: f32, "mm", [], "Home x.";
        y: f32, "mm", [], "Home y.";
        z: f32, "mm", [], "Home z.";
        r: f32, "deg", [], "Home rotation.";
    }

    31 "HOMECmd" "Homes the arm: finds the reference of J1, then moves to the home point." [Home "1.6.2" Document High, errata "E22"]
    [queue yes, resend no, danger no, effect Motion]
    action HomeCmd {
        reserved: u32 = 0, "reserved", [0..=0], "Reserved.";
    } forms [
        1 Zeros "shortened payload (E22)",
        2 Zeros "shortened payload (E22)",
        3 Zeros "shortened payload (E22)"
    ]

    32 "AutoLeveling" "Levels the arm with its sensors." [Home "1.6.3" Document High, errata "E21"]
    [queue yes, resend no, danger no, effect Motion]
    state AutoLeveling {
        result: f32, "deg (unconfirmed)", [], "Accuracy reached.";
    } forms [ 5 Skip(1) "a flag before the result (E21)" ]
    action SetAutoLeveling {
        is_auto_leveling: Flag, "flag", [0..=1], "True to start levelling.";
        accuracy: f32, "deg (unconfirmed)", [], "Accuracy requested.";
    }

    40 "HHTTrigMode" "Trigger mode of hand teaching: when it reports a point." [Teach "1.7.1" Document High, errata "E24"]
    [queue no, resend yes, danger no, effect Setting]
    param HhtTrigMode {
        mode: TeachTrigger, "enum", [0..=1], "Trigger mode.";
    }

    41 "HHTTrigOutputEnabled" "Output of points during hand teaching." [Teach "1.7.2" Document High]
    [queue no, resend yes, danger no, effect Setting]
    param HhtTrigOutputEnabled {
        is_enabled: Flag, "flag", [0..=1], "True if points are reported.";
    }

    42 "HHTTrigOutput" "Flag of a new taught point; reading clears it." [Teach "1.7.3" Document High]
    [queue no, resend yes, danger no, effect Consume]
    state HhtTrigOutput {
        is_triggered: Flag, "flag", [0..=1], "True if a point has been taught since the last get; reading clears it.";
    }

    50 "ArmOrientation" "Elbow side of a SCARA arm; stored by the Magician, without effect." [Pose "none" Addition Medium]
    [queue yes, resend yes, danger no, effect Setting]
    param ArmOrientation {
        orientation: Handedness, "enum", [0..=1], "Elbow side.";
    }

    60 "EndEffectorParams" "Tool bias: offset of the tool from the wrist." [Tool "1.8.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param EndEffectorParams {
        x_bias: f32, "mm", [], "Offset along the forearm's direction.";
        y_bias: f32, "mm", [], "Offset to the left.";
        z_bias: f32, "mm", [], "Offset downwards.";
    }

    61 "EndEffectorLaser" "State of the laser." [Tool "1.8.2" Document High]
    [queue yes, resend yes, danger no, effect Laser, may burn]
    state EndEffectorLaser {
        is_ctrl_enabled: Flag, "flag", [0..=1], "True if the host controls the tool connector.";
        is_on: Flag, "flag", [0..=1], "True if the laser is on.";
    }
    action SetEndEffectorLaser {
        enable_ctrl: Flag, "flag", [0..=1], "True to let the host control the tool connector.";
        on: Flag, "flag", [0..=1], "True to switch the laser on.";
    }

    62 "EndEffectorSuctionCup" "State of the suction cup." [Tool "1.8.3" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    state EndEffectorSuctionCup {
        is_ctrl_enabled: Flag, "flag", [0..=1], "True if the pump may run.";
        is_sucked: Flag, "flag", [0..=1], "True if suction is on.";
    }
    action SetEndEffectorSuctionCup {
        enable_ctrl: Flag, "flag", [0..=1], "True to let the pump run.";
        suck: Flag, "flag", [0..=1], "True to switch suction on.";
    }

    63 "EndEffectorGripper" "State of the gripper." [Tool "1.8.4" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    state EndEffectorGripper {
        is_ctrl_enabled: Flag, "flag", [0..=1], "True if the pump may run.";
        is_gripped: Flag, "flag", [0..=1], "True if closed, false if open.";
    }
    action SetEndEffectorGripper {
        enable_ctrl: Flag, "flag", [0..=1], "True to let the pump run.";
        grip: Flag, "flag", [0..=1], "True to close, false to open.";
    }

    70 "JOGJointParams" "Speeds and accelerations of joint jogs." [Jog "1.9.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogJointParams {
        velocity: [f32; 4], "deg/s", [above 0], "Speed of J1 to J4.";
        acceleration: [f32; 4], "deg/s^2", [above 0], "Acceleration of J1 to J4.";
    }

    71 "JOGCoordinateParams" "Speeds and accelerations of coordinate jogs." [Jog "1.9.2" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogCoordinateParams {
        velocity: [f32; 4], "mm/s for x, y, z; deg/s for r", [above 0], "Speed of x, y, z and r.";
        acceleration: [f32; 4], "mm/s^2 for x, y, z; deg/s^2 for r", [above 0], "Acceleration of x, y, z and r.";
    }

    72 "JOGCommonParams" "Speed and acceleration ratios of jogs." [Jog "1.9.3" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param JogCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Percentage of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Percentage of the set acceleration.";
    }

    73 "JOGCmd" "Moves one axis until a stop is sent." [Jog "1.9.4" Document High, errata "E25"]
    [queue yes, resend no, danger no, effect Jog]
    action JogCmd {
        is_joint: Flag, "flag", [0..=1], "True to jog a joint, false to jog a coordinate.";
        cmd: JogCommand, "enum", [0..=10], "Axis and direction; 0 stops.";
    }

    74 "JOGLParams" "Speed and acceleration of jogs on the rail." [Jog "1.9.5" Document High, errata "E25"]
    [queue yes, resend yes, danger no, effect Setting]
    param JogLParams {
        velocity: f32, "mm/s", [above 0], "Speed on the rail.";
        acceleration: f32, "mm/s^2", [above 0], "Acceleration on the rail.";
    }

    80 "PTPJointParams" "Joint speeds and accelerations of point-to-point moves." [Ptp "1.10.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJointParams {
        velocity: [f32; 4], "deg/s", [above 0], "Speed of J1 to J4.";
        acceleration: [f32; 4], "deg/s^2", [above 0], "Acceleration of J1 to J4.";
    }

    81 "PTPCoordinateParams" "Tool speeds and accelerations of straight point-to-point moves." [Ptp "1.10.2" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpCoordinateParams {
        xyz_velocity: f32, "mm/s", [above 0], "Speed of the tool point.";
        r_velocity: f32, "deg/s", [above 0], "Speed of rotation.";
        xyz_acceleration: f32, "mm/s^2", [above 0], "Acceleration of the tool point.";
        r_acceleration: f32, "deg/s^2", [above 0], "Acceleration of rotation.";
    }

    82 "PTPJumpParams" "Lift height and height limit of jumps." [Ptp "1.10.3" Document High, errata "E30"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJumpParams {
        jump_height: f32, "mm", [], "Lift above the higher of start and end.";
        z_limit: f32, "mm", [], "Largest z of the transfer.";
    }

    83 "PTPCommonParams" "Speed and acceleration ratios of point-to-point moves." [Ptp "1.10.4" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Percentage of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Percentage of the set acceleration.";
    }

    84 "PTPCmd" "Moves the arm to a point." [Ptp "1.10.5" Document High, errata "E28"]
    [queue yes, resend no, danger no, effect Motion]
    action PtpCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "Kind of travel, and meaning of the four numbers.";
        x: f32, "mm, or deg for J1", [], "Target x; J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y; J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z; J3 in the angle modes.";
        r: f32, "deg", [], "Target rotation; J4 in the angle modes.";
    }

    85 "PTPLParams" "Speed and acceleration of the rail in point-to-point moves." [Ptp "1.10.6" Document High, errata "E26"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpLParams {
        velocity: f32, "mm/s", [above 0], "Speed on the rail.";
        acceleration: f32, "mm/s^2", [above 0], "Acceleration on the rail.";
    }

    86 "PTPWithLCmd" "Moves the arm and the rail to a point." [Ptp "1.10.7" Document High]
    [queue yes, resend no, danger no, effect Motion]
    action PtpWithLCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "Kind of travel, and meaning of the four numbers.";
        x: f32, "mm, or deg for J1", [], "Target x; J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y; J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z; J3 in the angle modes.";
        r: f32, "deg", [], "Target rotation; J4 in the angle modes.";
        l: f32, "mm", [0..=1000 where absolute], "Rail position; displacement along the rail in the incremental modes.";
    }

    87 "PTPJump2Params" "Lift heights of jumps, for start and end separately." [Ptp "1.10.8" Document High, errata "E27"]
    [queue yes, resend yes, danger no, effect Setting]
    param PtpJump2Params {
        start_jump_height: f32, "mm", [], "Lift above the start.";
        end_jump_height: f32, "mm", [], "Lift above the end.";
        z_limit: f32, "mm", [], "Largest z of the transfer.";
    }

    88 "PTPPOCmd" "Moves the arm to a point and switches outputs on the way." [Ptp "1.10.9" Document High, errata "E29"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action PtpPoCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "Kind of travel, and meaning of the four numbers.";
        x: f32, "mm, or deg for J1", [], "Target x; J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y; J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z; J3 in the angle modes.";
        r: f32, "deg", [], "Target rotation; J4 in the angle modes.";
        po: PoList, "percent : EIO address : level", [at most 57 "outputs"], "Outputs to switch, each at a percentage of the path.";
    }

    89 "PTPPOWithLCmd" "Moves the arm and the rail to a point and switches outputs on the way." [Ptp "1.10.10" Document High, errata "E29"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action PtpPoWithLCmd {
        ptp_mode: PtpMode, "enum", [0..=9], "Kind of travel, and meaning of the four numbers.";
        x: f32, "mm, or deg for J1", [], "Target x; J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y; J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z; J3 in the angle modes.";
        r: f32, "deg", [], "Target rotation; J4 in the angle modes.";
        l: f32, "mm", [0..=1000 where absolute], "Rail position; displacement along the rail in the incremental modes.";
        po: PoList, "percent : EIO address : level", [at most 56 "outputs"], "Outputs to switch, each at a percentage of the path.";
    }

    90 "CPParams" "Speeds and accelerations of continuous paths." [Cp "1.11.1" Document High, errata "E31"]
    [queue yes, resend yes, danger no, effect Setting]
    param CpParams {
        plan_acc: f32, "mm/s^2", [above 0], "Largest acceleration along the path.";
        junction_vel: f32, "mm/s", [above 0], "Largest speed along the path.";
        acc_or_period: f32, "mm/s^2, or ms in real-time mode", [above 0], "Acceleration (unused); duration of a segment in real-time mode.";
        real_time_track: Flag, "flag", [0..=1], "True if the host clocks the path (real-time mode).";
    }

    91 "CPCmd" "Adds a straight segment to the continuous path." [Cp "1.11.2" Document High, errata "E32"]
    [queue yes, resend no, danger no, effect Motion]
    action CpCmd {
        cp_mode: CpMode, "enum", [0..=1], "Reference of the coordinates.";
        x: f32, "mm", [], "End of the segment, x.";
        y: f32, "mm", [], "End of the segment, y.";
        z: f32, "mm", [], "End of the segment, z.";
        velocity_or_power: f32, "reserved", [], "Reserved.";
    } forms [ 14 Zeros "one byte instead of the last number (E32)" ]

    92 "CPLECmd" "Adds a straight segment with laser power to the continuous path." [Cp "1.11.3" Document High, errata "E32"]
    [queue yes, resend no, danger no, effect Motion, may burn]
    action CpLeCmd {
        cp_mode: CpMode, "enum", [0..=1], "Reference of the coordinates.";
        x: f32, "mm", [], "End of the segment, x.";
        y: f32, "mm", [], "End of the segment, y.";
        z: f32, "mm", [], "End of the segment, z.";
        velocity_or_power: f32, "percent", [0..=100], "Laser power along the segment.";
    } forms [ 14 Zeros "one byte instead of the last number (E32)" ]

    93 "CPRHeadHoldEnable" "Constant rotation of the tool along a continuous path." [Cp "none" Header Medium]
    [queue no, resend yes, danger no, effect Setting]
    param CpRHeadHoldEnable {
        enable: Flag, "flag", [0..=1], "True if the rotation is held.";
    }

    94 "CPCommonParams" "Speed and acceleration ratios of continuous paths." [Cp "none" Header Low]
    [queue yes, resend yes, danger no, effect Setting]
    param CpCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Percentage of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Percentage of the set acceleration.";
    }

    100 "ARCParams" "Speeds and accelerations of arcs." [Arc "1.12.1" Document High]
    [queue yes, resend yes, danger no, effect Setting]
    param ArcParams {
        xyz_velocity: f32, "mm/s", [above 0], "Speed of the tool point.";
        r_velocity: f32, "deg/s", [above 0], "Speed of rotation.";
        xyz_acceleration: f32, "mm/s^2", [above 0], "Acceleration of the tool point.";
        r_acceleration: f32, "deg/s^2", [above 0], "Acceleration of rotation.";
    }

    101 "ARCCmd" "Moves the arm along an arc, through one point to another." [Arc "1.12.2" Document High, errata "E33"]
    [queue yes, resend no, danger no, effect Motion]
    action ArcCmd {
        cir_point: [f32; 4], "mm for x, y, z; deg for r", [], "A point on the arc: x, y, z, r.";
        to_point: [f32; 4], "mm for x, y, z; deg for r", [], "End of the arc: x, y, z, r.";
    }

    102 "CircleCmd" "Moves the arm along a full circle through two points, back to its start." [Arc "none" Header Medium, errata "E33"]
    [queue yes, resend no, danger no, effect Motion]
    action CircleCmd {
        cir_point: [f32; 4], "mm for x, y, z; deg for r", [], "A point on the circle: x, y, z, r.";
        to_point: [f32; 4], "mm for x, y, z; deg for r", [], "Another point on the circle: x, y, z, r.";
        count: u32 = 1, "turns", [above 0], "Number of full turns; older hosts omit it.";
    }

    103 "ARCCommonParams" "Speed and acceleration ratios of arcs." [Arc "none" Header Low]
    [queue yes, resend yes, danger no, effect Setting]
    param ArcCommonParams {
        velocity_ratio: f32, "percent", [1..=100 capped], "Percentage of the set speed.";
        acceleration_ratio: f32, "percent", [1..=100 capped], "Percentage of the set acceleration.";
    }

    110 "WAITCmd" "Makes the queue wait for a time." [Wait "1.13.1" Document High, errata "E34"]
    [queue yes, resend yes, danger no, effect Wait]
    action WaitCmd {
        timeout: u32, "ms", [], "Duration of the wait.";
    }

    120 "TRIGCmd" "Makes the queue wait for a condition on an input." [Trigger "1.14.1" Document High, errata "E35"]
    [queue yes, resend no, danger no, effect Wait]
    action TrigCmd {
        address: u8, "EIO address", [1..=20], "Address of the input.";
        mode: TriggerMode, "enum", [0..=1], "Digital level or analog value.";
        condition: TriggerCondition, "enum", [mode 0 "level mode" 0..=1, mode 1 "analog mode" 0..=3], "Comparison with the threshold.";
        threshold: u16, "level or counts", [mode 0 "level mode" 0..=1, mode 1 "analog mode" 0..=4095 "counts"], "Threshold.";
    }

    130 "IOMultiplexing" "Function of an EIO pin." [Io "1.15.1" Document High, errata "E39, E40"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetIoMultiplexing {
        address: Option<u8> | required, "EIO address", [1..=20], "Address of the pin.";
    }
    param IoMultiplexing {
        address: u8, "EIO address", [1..=20], "Address of the pin.";
        multiplex: IoFunction, "enum", [0..=6], "Function of the pin.";
    }

    131 "IODO" "Level of a digital output." [Io "1.15.2" Document High, errata "E39"]
    [queue yes, resend yes, danger no, effect Setting, may burn]
    query GetIoDo {
        address: Option<u8> | required, "EIO address", [1..=20], "Address of the pin.";
    }
    param IoDo {
        address: u8, "EIO address", [1..=20], "Address of the pin.";
        level: Flag, "flag", [0..=1], "True if high, false if low.";
    }

    132 "IOPWM" "Frequency and duty cycle of a PWM output." [Io "1.15.3" Document High, errata "E39"]
    [queue yes, resend yes, danger no, effect Setting, may burn]
    query GetIoPwm {
        address: Option<u8> | required, "EIO address", [1..=20], "Address of the pin.";
    }
    param IoPwm {
        address: u8, "EIO address", [1..=20], "Address of the pin.";
        frequency: f32, "Hz", [10..=1000000], "Frequency.";
        duty_cycle: f32, "percent", [0..=100], "Duty cycle: percentage of the period at high level.";
    }

    133 "IODI" "Level of a digital input." [Io "1.15.4" Document High, errata "E39"]
    [queue no, resend yes, danger no, effect Look]
    query GetIoDi {
        address: Option<u8> | required, "EIO address", [1..=20], "Address of the pin.";
    }
    state IoDi {
        address: u8, "EIO address", [1..=20], "Address of the pin.";
        level: Flag, "flag", [0..=1], "True if high, false if low.";
    }

    134 "IOADC" "Value of an analog input." [Io "1.15.5" Document High, errata "E39"]
    [queue no, resend yes, danger no, effect Look]
    query GetIoAdc {
        address: Option<u8> | required, "EIO address", [1..=20], "Address of the pin.";
    }
    state IoAdc {
        address: u8, "EIO address", [1..=20], "Address of the pin.";
        value: u16, "counts", [0..=4095], "Value, 4095 at 3.3 V.";
    }

    135 "EMotor" "Runs an external stepper motor, such as a conveyor's." [Io "1.15.6" Document High, errata "E41"]
    [queue yes, resend no, danger no, effect Motor]
    action EMotor {
        index: Stepper, "enum", [0..=1], "Motor output.";
        is_enabled: Flag, "flag", [0..=1], "True to run the motor, false to stop it.";
        speed: i32, "pulses/s", [], "Speed; the sign gives the direction.";
    } forms [ 4 Zeros "shortened speed (E11)" ]

    136 "EMotorS" "Runs an external stepper motor for a number of pulses." [Io "none" Header Medium, errata "E41"]
    [queue yes, resend no, danger no, effect Motor]
    action EMotorS {
        index: Stepper, "enum", [0..=1], "Motor output.";
        is_enabled: Flag, "flag", [0..=1], "True to run the motor, false to stop it.";
        speed: i32, "pulses/s", [], "Speed; the sign gives the direction.";
        distance: u32, "pulses", [], "Distance to run.";
    }

    137 "ColorSensor" "Colour sensor: reading and set-up." [Io "1.15.7" Document Medium, errata "E42"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetColorSensor {
        port: Option<Port>, "enum", [0..=3], "Connector of the sensor; most hosts omit it.";
    }
    state ColorSensor {
        r: u8, "counts", [0..=255], "Red.";
        g: u8, "counts", [0..=255], "Green.";
        b: u8, "counts", [0..=255], "Blue.";
    }
    action SetColorSensor {
        is_enabled: Flag, "flag", [0..=1], "True to enable the sensor.";
        port: Port, "enum", [0..=3], "Connector of the sensor.";
        version: Option<SensorVersion>, "enum", [0..=1], "Generation of the sensor; hosts before V1.1.5 omit it.";
    }

    138 "IRSwitch" "Infrared sensor: reading and set-up." [Io "1.15.8" Document Medium, errata "E43"]
    [queue yes, resend yes, danger no, effect Setting]
    query GetIrSwitch {
        port: Option<Port> | required, "enum", [0..=3], "Connector of the sensor.";
    }
    state IrSwitch {
        state: Flag, "flag", [0..=1], "True if an object is in front of the sensor.";
    }
    action SetIrSwitch {
        is_enabled: Flag, "flag", [0..=1], "True to enable the sensor.";
        port: Port, "enum", [0..=3], "Connector of the sensor.";
        version: Option<SensorVersion>, "enum", [0..=1], "Generation of the sensor; hosts before V1.1.5 omit it.";
    }

    140 "AngleSensorStaticError" "Offset corrections of the angle sensors; kept without power." [Calibration "1.16.1" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param AngleSensorStaticError {
        rear_arm_angle_error: f32, "deg", [], "Correction of J2.";
        front_arm_angle_error: f32, "deg", [], "Correction of J3.";
    }

    141 "AngleSensorCoef" "Scale factors of the angle sensors; kept without power." [Calibration "none" Header Medium]
    [queue no, resend yes, danger yes, effect Store]
    param AngleSensorCoef {
        rear_arm_angle_coef: f32, "ratio", [], "Scale factor of J2.";
        front_arm_angle_coef: f32, "ratio", [], "Scale factor of J3.";
    }

    142 "BaseDecoderStaticError" "Offset correction of the base encoder; kept without power." [Calibration "none" Header Medium]
    [queue no, resend yes, danger yes, effect Store]
    param BaseDecoderStaticError {
        base_decoder_error: f32, "deg", [], "Correction of J1.";
    }

    150 "WIFIConfigMode" "Configuration mode of the Wi-Fi module." [Wifi "1.17.1" Document High]
    [queue no, resend yes, danger yes, effect Setting]
    param WifiConfigMode {
        enable: Flag, "flag", [0..=1], "True if the module accepts settings.";
    }

    151 "WIFISSID" "Name (SSID) of the wireless network." [Wifi "1.17.2" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiSsid {
        ssid: Text, "text", [], "Name (SSID) of the network.";
    }

    152 "WIFIPassword" "Password of the wireless network." [Wifi "1.17.3" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiPassword {
        password: Text, "text", [], "Password.";
    }

    153 "WIFIIPAddress" "IP address of the arm in the wireless network." [Wifi "1.17.4" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiIpAddress {
        dhcp: Flag, "flag", [0..=1], "True if DHCP assigns the address.";
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    154 "WIFINetmask" "Netmask of the wireless network." [Wifi "1.17.5" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiNetmask {
        addr: [u8; 4], "IPv4 octets", [], "Netmask, first octet first.";
    }

    155 "WIFIGateway" "Gateway of the wireless network." [Wifi "1.17.6" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiGateway {
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    156 "WIFIDNS" "DNS server of the wireless network." [Wifi "1.17.7" Document High]
    [queue no, resend yes, danger yes, effect Store]
    param WifiDns {
        addr: [u8; 4], "IPv4 octets", [], "Address, first octet first.";
    }

    157 "WIFIConnectStatus" "Connection of the arm to the wireless network." [Wifi "1.17.8" Document High]
    [queue no, resend yes, danger no, effect Look]
    state WifiConnectStatus {
        is_connected: Flag, "flag", [0..=1], "True if connected.";
    }

    160 "FirmwareSwitch" "Switches to another firmware, which may not speak this protocol." [Info "none" Header Low]
    [queue no, resend no, danger yes, effect Store]
    action FirmwareSwitch {
    }

    161 "FirmwareMode" "Firmware that runs." [Info "none" Header Low]
    [queue no, resend no, danger yes, effect Store]
    param FirmwareMode {
        mode: u8, "code (unknown)", [], "Code of the firmware.";
        ctl: u8 = 0, "code (unknown)", [], "Control code; may be omitted.";
    }

    170 "LostStepParams" "Threshold of lost-step detection." [LostStep "1.18.1" Document High]
    [queue no, resend yes, danger no, effect Setting]
    action LostStepParams {
        value: f32, "deg", [above 0], "Deviation from which a joint counts as having lost steps.";
    }

    171 "LostStepCmd" "Checks the joints for lost steps against their sensors; alarms 0x50 to 0x53 report the result." [LostStep "1.18.2" Document High, errata "E36"]
    [queue yes, resend no, danger no, effect Setting]
    action LostStepCmd {
    }

    181 "UART4PeripheralsModel" "Model of the peripheral at the second serial connector (UART4)." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state Uart4PeripheralsModel {
        type_: u8, "code (unknown)", [], "Code of the model.";
    }

    182 "UART4PeripheralsEnabled" "Enable flag of the second serial connector (UART4)." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Setting]
    param Uart4PeripheralsEnabled {
        is_enabled: Flag, "flag", [0..=1], "True if the connector is enabled.";
    }

    191 "PulseMode" "Motor pulse counts; their use is unknown." [Calibration "none" Header Low]
    [queue yes, resend no, danger no, effect Setting]
    param PulseMode {
        j1: f32, "pulses (unconfirmed)", [], "Pulses of J1.";
        j2: f32, "pulses (unconfirmed)", [], "Pulses of J2.";
        j3: f32, "pulses (unconfirmed)", [], "Pulses of J3.";
        j4: f32, "pulses (unconfirmed)", [], "Pulses of J4.";
        e1: f32, "pulses (unconfirmed)", [], "Pulses of the first external motor.";
        e2: f32, "pulses (unconfirmed)", [], "Pulses of the second external motor.";
    } forms [ 0 Zeros "empty payload" ]

    220 "UserParams" "Eight numbers for use by programs." [Info "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state UserParams {
        params: [f32; 8], "free", [], "Numbers, without a fixed meaning.";
    }

    221 "PTPTime" "Duration of a point-to-point move from the current pose." [Ptp "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    query GetPtpTime {
        ptp_mode: PtpMode, "enum", [0..=9], "Kind of travel, and meaning of the four numbers.";
        x: f32, "mm, or deg for J1", [], "Target x; J1 in the angle modes.";
        y: f32, "mm, or deg for J2", [], "Target y; J2 in the angle modes.";
        z: f32, "mm, or deg for J3", [], "Target z; J3 in the angle modes.";
        r: f32, "deg", [], "Target rotation; J4 in the angle modes.";
    }
    state PtpTime {
        ptp_time: u32, "ms", [], "Duration of the move.";
    }

    230 "ZDFCalibRequest" "Calibrates the Z axis of the 3-D printing kit." [Calibration "none" Header Low]
    [queue no, resend no, danger yes, effect Motion]
    action ZdfCalibRequest {
    }

    231 "ZDFCalibStatus" "State of the Z calibration of the 3-D printing kit." [Calibration "none" Header Low]
    [queue no, resend yes, danger no, effect Look]
    state ZdfCalibStatus {
        status: u8, "code (unknown)", [], "Code of the state.";
    }

    240 "QueuedCmdStartExec" "Starts execution of the queue." [Queue "1.19.1" Document High]
    [queue ignored, resend no, danger no, effect Queue]
    action QueuedCmdStartExec {
    }

    241 "QueuedCmdStopExec" "Stops the queue after the running command has finished." [Queue "1.19.2" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdStopExec {
    }

    242 "QueuedCmdForceStopExec" "Stops the queue and the running command at once." [Queue "1.19.3" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdForceStopExec {
    }

    243 "QueuedCmdStartDownload" "Begins the download of a program to the arm's flash." [Queue "1.19.4" Document High, errata "E46"]
    [queue ignored, resend no, danger yes, effect Queue]
    action QueuedCmdStartDownload {
        total_loop: u32, "loops", [], "Number of times the program runs.";
        line_per_loop: u32, "commands", [], "Number of commands in the program.";
    } forms [ 2 Bytes "two single bytes (E46)" ]

    244 "QueuedCmdStopDownload" "Ends the download of a program." [Queue "1.19.5" Document High]
    [queue ignored, resend no, danger no, effect Queue]
    action QueuedCmdStopDownload {
    }

    245 "QueuedCmdClear" "Discards the pending commands of the queue." [Queue "1.19.6" Document High, errata "E48"]
    [queue ignored, resend yes, danger no, effect Queue]
    action QueuedCmdClear {
    }

    246 "QueuedCmdCurrentIndex" "Index of the queued command that finished last." [Queue "1.19.7" Document High, errata "E37"]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdCurrentIndex {
        queued_cmd_current_index: u64, "index", [], "Index of the command that finished last; 0 before the first.";
    }

    247 "QueuedCmdLeftSpace" "Free slots in the queue." [Queue "1.19.8" Document High, errata "E38"]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdLeftSpace {
        left_space: u32, "commands", [], "Number of free slots.";
    } forms [ 8 Skip(0) "64-bit count, of which the low half is read (E38)" ]

    248 "QueuedCmdMotionFinish" "Completion of all motion." [Queue "none" Addition Medium]
    [queue no, resend yes, danger no, effect Look]
    state QueuedCmdMotionFinish {
        is_finish: Flag, "flag", [0..=1], "True if no motion is pending.";
    }
}

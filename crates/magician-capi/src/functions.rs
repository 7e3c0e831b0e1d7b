//! The function table: every function of the vendor's headers and export tables
//! (docs/reference/VENDOR-FUNCTIONS.md).
//!
//! A row consists of its class ([`Kind`](crate::Kind)), leading ids ([`Ids`](crate::Ids)), name,
//! arguments after the ids, families, and body. Its doc comment is the description on generated
//! pages.
//!
//! The file is long because the table is.

use std::ffi::c_int;

use crate::Function;

/// Names used by the bodies and arguments of the rows.
pub mod names {
    pub use std::ffi::c_int;

    pub use magician::commands;
    pub use magician::protocol::Flag;

    pub use crate::call::Queued::{Always, Argument};
    pub use crate::call::{
        self, get, get_by_query, get_text, neutral, number, parts, parts_for, put, queue, queue_as,
        queue_in, set, set_text, to_flag, to_protocol_enum,
    };
    pub use crate::pointer::{Buffer, In, Out, Text};
    pub use crate::session;
    pub use crate::structure::*;

    /// C's `bool`. Only the low byte counts, because callers without prototypes pass an `int`.
    pub type Bool = u8;
    /// Trigger of hand teaching: a C enum.
    pub type HHTTrigMode = c_int;
    /// Elbow side: a C enum.
    pub type ArmOrientation = c_int;
    /// Connector of the colour sensor: a C enum.
    pub type ColorPort = c_int;
    /// Connector of the infrared sensor: a C enum.
    pub type InfraredPort = c_int;
}

/// Every function of the interface.
pub const FUNCTIONS: &[Function] = crate::functions!(crate list_rows list);

/// Returns the first id, which selects the arm. In `v1`, without ids, it is 0.
#[doc(hidden)]
#[must_use]
pub fn first(given: &[c_int]) -> c_int {
    given.first().copied().unwrap_or_default()
}

/// Hands the table to another macro of this crate.
#[doc(hidden)]
#[macro_export]
macro_rules! functions {
    ($home:tt $then:ident $($first:tt)*) => {
        $home::$then! { $($first)*

    // Session

    /// Lists the ports where arms may be, separated by spaces, and returns their number.
    Host None SearchDobot(list: Buffer, size: u32) in [v1 v2 v3] = |_, list, size| session::search(list, size);
    /// Connects to the arm at a port, or to the first arm found if the name is empty.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer) in [v1]
        = |_, port, baud, firmware, version| session::connect_v1(port, baud, firmware, version);
    /// Connects to the arm at a port, or to the first arm found if the name is empty.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer, id: Out<i32>) in [v2]
        = |_, port, baud, firmware, version, id| session::connect_v2(port, baud, firmware, version, id);
    /// Connects to the arm at a port, or to the first arm found if the name is empty.
    Host None ConnectDobot(port: Text, baud: u32, info: Out<ConnectInfo>) in [v3]
        = |_, port, baud, info| session::connect_v3(port, baud, info);
    /// Closes the connection. The arm continues with the commands in its queue.
    Host Master DisconnectDobot() in [v1 v2 v3] = session::disconnect;
    /// Sets the timeout of calls, ms; the default is 3000. May be called before a connection exists.
    Host Master SetCmdTimeout(milliseconds: u32) in [v1 v2 v3] = session::set_timeout;
    /// Does nothing: no event loop is needed.
    Host None DobotExec() in [v1 v2 v3] = |_| 0;
    /// Does nothing: no periodic call is needed.
    Host None PeriodicTask() in [v1 v2 v3] = |_| 0;
    /// Copies the calling thread's last error message, truncated to the buffer, and returns its full length; 0 if
    /// there is no error. The buffer may be null.
    Host None MagicianLastError(text: Buffer, size: u32) in [v1 v2 v3] = |_, text, size| session::last_error(text, size);
    /// Allows guarded (dangerous) commands: names separated by commas, or `all`.
    Host None MagicianAllow(names: Text) in [v1 v2 v3] = |_, names| session::allow(names);

    // Device

    /// Sets the serial number of the arm.
    Guarded Arm SetDeviceSN(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |device_sn| commands::DeviceSn { device_sn });
    /// Serial number of the arm.
    Command Arm GetDeviceSN(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::DeviceSn| row.device_sn);
    /// Sets the name of the arm.
    Command Arm SetDeviceName(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |device_name| commands::DeviceName { device_name });
    /// Name of the arm.
    Command Arm GetDeviceName(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::DeviceName| row.device_name);
    /// Firmware version. Newer headers add a fourth argument for the hardware version, which is never written.
    Command Arm GetDeviceVersion(major: Out<u8>, minor: Out<u8>, revision: Out<u8>) in [v1 v2]
        = |arm, major, minor, revision| parts(arm, (major, minor, revision), |row: commands::DeviceVersion| {
            (row.major_version, row.minor_version, row.revision)
        });
    /// Versions of firmware and hardware. The arm reports three firmware numbers; all other fields are 0.
    Command Arm GetDeviceVersion(version: Out<DeviceVersion>) in [v3]
        = |arm, version| parts(arm, version, |row: commands::DeviceVersion| DeviceVersion::of(&row));
    /// Sets whether the arm is mounted on the sliding rail.
    Command Arm SetDeviceWithL(on: Bool, queued: Bool, index: Out<u64>) in [v1]
        = |arm, on, queued, index| queue(arm, &commands::SetDeviceWithL { with_l: Flag(on), version: None }, Argument(queued), index);
    /// Sets whether the arm is mounted on the sliding rail.
    Command Arm SetDeviceWithL(on: Bool) in [v2]
        = |arm, on| set(arm, &commands::SetDeviceWithL { with_l: Flag(on), version: None });
    /// Sets whether the arm is mounted on the sliding rail, and the rail's version.
    Command Arm SetDeviceWithL(on: Bool, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, version, queued, index| {
            let row = commands::SetDeviceWithL { with_l: Flag(on), version: Some(version.into()) };
            queue(arm, &row, Argument(queued), index)
        };
    /// True if the arm is set up for the sliding rail.
    Command Arm GetDeviceWithL(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::DeviceWithL| to_flag(row.with_l));
    /// Time since power-up, ms.
    Command Arm GetDeviceTime(time: Out<u32>) in [v1 v2 v3]
        = |arm, time| parts(arm, time, |row: commands::DeviceTime| row.g_systick);
    /// Unique id of the controller's processor.
    Command Arm GetDeviceID(value: Out<DeviceID>) in [v3] = |arm, value| get(arm, value);
    /// Lifetime counters: running time and power cycles.
    Command Arm GetDeviceInfo(value: Out<DeviceCountInfo>) in [v1 v3] = |arm, value| get(arm, value);
    /// Version of the 3D-printing firmware.
    Neutral Arm GetMarlinVersion() in [v1 v3] = |_| neutral("GetMarlinVersion", ());

    // Pose

    /// Current pose: tool position, mm and degrees, and joint angles, degrees.
    Command Arm GetPose(value: Out<Pose>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Alias of `GetPose` in the oldest headers.
    Command Arm GetPoseEx(value: Out<Pose>) in [v1 v2] = |arm, value| get(arm, value);
    /// Overwrites the angles of rear arm and forearm, degrees.
    Guarded Arm ResetPose(manual: Bool, rear_arm_angle: f32, front_arm_angle: f32) in [v1 v2 v3]
        = |arm, manual, rear_arm_angle, front_arm_angle| {
            set(arm, &commands::ResetPose { manual: Flag(manual), rear_arm_angle, front_arm_angle })
        };
    /// Speed, mm/s, and acceleration, mm/s², of the arm.
    Command Arm GetKinematics(value: Out<Kinematics>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Position on the sliding rail, mm.
    Command Arm GetPoseL(l: Out<f32>) in [v1 v2 v3] = |arm, l| parts(arm, l, |row: commands::PoseL| row.pose_l);

    // Alarms

    /// Active alarms, one bit each, and their length in bytes. Writes as many bytes as fit.
    Command Arm GetAlarmsState(state: Out<u8>, length: Out<u32>, size: u32) in [v1 v2 v3]
        = |arm, state, length, size| call::alarms(arm, state, length, size);
    /// Clears all alarms.
    Command Arm ClearAllAlarmsState() in [v1 v2 v3] = |arm| set(arm, &commands::ClearAlarmsState {});

    // Homing

    /// Sets the home pose, where homing ends.
    Command Arm SetHOMEParams(value: In<HOMEParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Home pose, where homing ends.
    Command Arm GetHOMEParams(value: Out<HOMEParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Homes the arm.
    Command Arm SetHOMECmd(value: In<HOMECmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Levels the arm with its sensors.
    Command Arm SetAutoLevelingCmd(value: In<AutoLevelingCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Precision reached by automatic levelling.
    Command Arm GetAutoLevelingResult(precision: Out<f32>) in [v1 v2 v3]
        = |arm, precision| parts(arm, precision, |row: commands::AutoLeveling| row.result);

    // Teaching by hand

    /// Sets the trigger of hand teaching: key release, or a periodic interval.
    Command Arm SetHHTTrigMode(mode: HHTTrigMode) in [v1 v2 v3]
        = |arm, mode| set(arm, &commands::HhtTrigMode { mode: to_protocol_enum(mode) });
    /// Trigger of hand teaching.
    Command Arm GetHHTTrigMode(mode: Out<HHTTrigMode>) in [v1 v2 v3]
        = |arm, mode| parts(arm, mode, |row: commands::HhtTrigMode| number(row.mode));
    /// Enables or disables the reports of hand teaching.
    Command Arm SetHHTTrigOutputEnabled(on: Bool) in [v1 v2 v3]
        = |arm, on| set(arm, &commands::HhtTrigOutputEnabled { is_enabled: Flag(on) });
    /// True if hand teaching reports points.
    Command Arm GetHHTTrigOutputEnabled(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::HhtTrigOutputEnabled| to_flag(row.is_enabled));
    /// True if a point was taught since the last call.
    Command Arm GetHHTTrigOutput(triggered: Out<Bool>) in [v1 v2 v3]
        = |arm, triggered| parts(arm, triggered, |row: commands::HhtTrigOutput| to_flag(row.is_triggered));

    // Tool

    /// Sets the offset of the tool tip from the end of the arm, mm.
    Command Arm SetEndEffectorParams(value: In<EndEffectorParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Offset of the tool tip from the end of the arm, mm.
    Command Arm GetEndEffectorParams(value: Out<EndEffectorParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Switches the laser. The power that Python modules pass is sent unchanged.
    Command Arm SetEndEffectorLaser(enable: Bool, on: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, on, _, index| {
            queue(arm, &commands::SetEndEffectorLaser { enable_ctrl: Flag(enable), on: Flag(on) }, Always, index)
        };
    /// State of the laser: enabled, and on.
    Command Arm GetEndEffectorLaser(enabled: Out<Bool>, on: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, on| parts(arm, (enabled, on), |row: commands::EndEffectorLaser| {
            (to_flag(row.is_ctrl_enabled), to_flag(row.is_on))
        });
    /// Switches the suction cup.
    Command Arm SetEndEffectorSuctionCup(enable: Bool, suck: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, suck, _, index| {
            queue(arm, &commands::SetEndEffectorSuctionCup { enable_ctrl: Flag(enable), suck: Flag(suck) }, Always, index)
        };
    /// State of the suction cup: enabled, and sucking.
    Command Arm GetEndEffectorSuctionCup(enabled: Out<Bool>, sucked: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, sucked| parts(arm, (enabled, sucked), |row: commands::EndEffectorSuctionCup| {
            (to_flag(row.is_ctrl_enabled), to_flag(row.is_sucked))
        });
    /// Opens or closes the gripper.
    Command Arm SetEndEffectorGripper(enable: Bool, grip: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, grip, _, index| {
            queue(arm, &commands::SetEndEffectorGripper { enable_ctrl: Flag(enable), grip: Flag(grip) }, Always, index)
        };
    /// State of the gripper: enabled, and closed.
    Command Arm GetEndEffectorGripper(enabled: Out<Bool>, gripped: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, gripped| parts(arm, (enabled, gripped), |row: commands::EndEffectorGripper| {
            (to_flag(row.is_ctrl_enabled), to_flag(row.is_gripped))
        });
    /// Sets the tool type of another arm model.
    Neutral Arm SetEndEffectorType(queued: Bool, kind: u8, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetEndEffectorType", index);
    /// Tool type of another arm model.
    Neutral Arm GetEndEffectorType(kind: Out<u8>) in [v3] = |_, kind| neutral("GetEndEffectorType", kind);

    // Arm orientation

    /// Sets the elbow side. This arm stores it without effect.
    Command Arm SetArmOrientation(side: ArmOrientation, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, side, _, index| queue(arm, &commands::ArmOrientation { orientation: to_protocol_enum(side) }, Always, index);
    /// Stored elbow side.
    Command Arm GetArmOrientation(side: Out<ArmOrientation>) in [v1 v2 v3]
        = |arm, side| parts(arm, side, |row: commands::ArmOrientation| number(row.orientation));

    // Jog

    /// Sets speeds and accelerations of joint jogs.
    Command Arm SetJOGJointParams(value: In<JOGJointParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds and accelerations of joint jogs.
    Command Arm GetJOGJointParams(value: Out<JOGJointParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets speeds and accelerations of Cartesian jogs.
    Command Arm SetJOGCoordinateParams(value: In<JOGCoordinateParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds and accelerations of Cartesian jogs.
    Command Arm GetJOGCoordinateParams(value: Out<JOGCoordinateParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets speed and acceleration of rail jogs.
    Command Arm SetJOGLParams(value: In<JOGLParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Argument(queued), index);
    /// Speed and acceleration of rail jogs.
    Command Arm GetJOGLParams(value: Out<JOGLParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the jog speed ratio, percent.
    Command Arm SetJOGCommonParams(value: In<JOGCommonParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Argument(queued), index);
    /// Jog speed ratio, percent.
    Command Arm GetJOGCommonParams(value: Out<JOGCommonParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Starts a jog, which lasts until command 0 ends it.
    Command Arm SetJOGCmd(value: In<JOGCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Argument(queued), index);

    // Point to point

    /// Sets joint speeds and accelerations of point-to-point moves.
    Command Arm SetPTPJointParams(value: In<PTPJointParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Joint speeds and accelerations of point-to-point moves.
    Command Arm GetPTPJointParams(value: Out<PTPJointParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets Cartesian speeds and accelerations of point-to-point moves.
    Command Arm SetPTPCoordinateParams(value: In<PTPCoordinateParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Cartesian speeds and accelerations of point-to-point moves.
    Command Arm GetPTPCoordinateParams(value: Out<PTPCoordinateParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets speed and acceleration of the rail in point-to-point moves.
    Command Arm SetPTPLParams(value: In<PTPLParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speed and acceleration of the rail in point-to-point moves.
    Command Arm GetPTPLParams(value: Out<PTPLParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the lift height of jumps and the z limit, mm.
    Command Arm SetPTPJumpParams(value: In<PTPJumpParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Lift height of jumps and the z limit, mm.
    Command Arm GetPTPJumpParams(value: Out<PTPJumpParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the speed and acceleration ratio, percent.
    Command Arm SetPTPCommonParams(value: In<PTPCommonParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speed and acceleration ratio, percent.
    Command Arm GetPTPCommonParams(value: Out<PTPCommonParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves the arm to a target (point-to-point).
    Command Arm SetPTPCmd(value: In<PTPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves arm and rail to a target (point-to-point).
    Command Arm SetPTPWithLCmd(value: In<PTPWithLCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Sets separate lift heights at the start and end of jumps, mm.
    Command Arm SetPTPJump2Params(value: In<PTPJump2Params>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Lift heights at the start and end of jumps, mm.
    Command Arm GetPTPJump2Params(value: Out<PTPJump2Params>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves the arm to a target and switches outputs on the way.
    Command Arm SetPTPPOCmd(value: In<PTPCmd>, outputs: In<ParallelOutputCmd>, count: c_int, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, outputs, count, _, index| call::queue_switching(arm, value, outputs, count, index);
    /// Moves arm and rail to a target and switches outputs on the way.
    Command Arm SetPTPPOWithLCmd(value: In<PTPWithLCmd>, outputs: In<ParallelOutputCmd>, count: c_int, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, outputs, count, _, index| call::queue_switching(arm, value, outputs, count, index);
    /// Sets the speed ratio of another arm model.
    Neutral Arm SetArmSpeedRatio(queued: Bool, mode: u8, ratio: u8, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetArmSpeedRatio", index);
    /// Speed ratio of another arm model.
    Neutral Arm GetArmSpeedRatio(mode: u8, ratio: Out<u8>) in [v3] = |_, _, ratio| neutral("GetArmSpeedRatio", ratio);
    /// Sets the speed ratio of a controller box's rail.
    Neutral Arm SetLSpeedRatio(queued: Bool, mode: u8, ratio: u8, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetLSpeedRatio", index);
    /// Speed ratio of a controller box's rail.
    Neutral Arm GetLSpeedRatio(mode: u8, ratio: Out<u8>) in [v3] = |_, _, ratio| neutral("GetLSpeedRatio", ratio);

    // Continuous path

    /// Sets speed and acceleration of continuous paths.
    Command Arm SetCPParams(value: In<CPParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speed and acceleration of continuous paths.
    Command Arm GetCPParams(value: Out<CPParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Appends a straight segment to the continuous path.
    Command Arm SetCPCmd(value: In<CPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Appends a straight segment with laser power to the continuous path.
    Command Arm SetCPLECmd(value: In<CPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_as(arm, value, call::with_laser_power, Always, index);
    /// Appends a segment to the path of another arm model.
    Neutral Arm SetCP2Cmd(value: In<CP2Cmd>, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetCP2Cmd", index);
    /// Sets whether the tool keeps its rotation along the path.
    Command Arm SetCPRHoldEnable(on: Bool) in [v1 v3]
        = |arm, on| set(arm, &commands::CpRHeadHoldEnable { enable: Flag(on) });
    /// True if the tool keeps its rotation along the path.
    Command Arm GetCPRHoldEnable(on: Out<Bool>) in [v1 v3]
        = |arm, on| parts(arm, on, |row: commands::CpRHeadHoldEnable| to_flag(row.enable));
    /// Sets the speed and acceleration ratio, percent.
    Command Arm SetCPCommonParams(value: In<CPCommonParams>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speed and acceleration ratio, percent.
    Command Arm GetCPCommonParams(value: Out<CPCommonParams>) in [v1 v3] = |arm, value| get(arm, value);

    // Arcs

    /// Sets speeds and accelerations of arcs and circles.
    Command Arm SetARCParams(value: In<ARCParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds and accelerations of arcs and circles.
    Command Arm GetARCParams(value: Out<ARCParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves along an arc.
    Command Arm SetARCCmd(value: In<ARCCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves along full circles.
    Command Arm SetCircleCmd(value: In<CircleCmd>, queued: Bool, index: Out<u64>) in [v1]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves along one full circle: every Python module of these families passes two points and no count.
    Command Arm SetCircleCmd(value: In<ARCCmd>, queued: Bool, index: Out<u64>) in [v2 v3]
        = |arm, value, _, index| queue_as(arm, value, call::as_circle, Always, index);
    /// Sets the speed ratio of arcs, percent.
    Command Arm SetARCCommonParams(value: In<ARCCommonParams>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speed ratio of arcs, percent.
    Command Arm GetARCCommonParams(value: Out<ARCCommonParams>) in [v1 v3] = |arm, value| get(arm, value);

    // Waiting and triggers

    /// Holds the queue for a time, ms.
    Command Arm SetWAITCmd(value: In<WAITCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Holds the queue until an input meets a condition.
    Command Arm SetTRIGCmd(value: In<TRIGCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);

    // Inputs, outputs, motors and sensors

    /// Sets the function of an EIO pin.
    Command Arm SetIOMultiplexing(value: In<IOMultiplexing>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Function of an EIO pin. The caller sets the address in the result structure.
    Command Arm GetIOMultiplexing(value: Out<IOMultiplexing>) in [v1 v2 v3]
        = |arm, value| get_by_query(arm, value, |pin| commands::GetIoMultiplexing { address: Some(pin.address) });
    /// Sets the level of a digital output.
    Command Arm SetIODO(value: In<IODO>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Level of a digital output. The caller sets the address in the result structure.
    Command Arm GetIODO(value: Out<IODO>) in [v1 v2 v3]
        = |arm, value| get_by_query(arm, value, |pin| commands::GetIoDo { address: Some(pin.address) });
    /// Sets frequency and duty cycle of a PWM output.
    Command Arm SetIOPWM(value: In<IOPWM>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Frequency and duty cycle of a PWM output. The caller sets the address in the result structure.
    Command Arm GetIOPWM(value: Out<IOPWM>) in [v1 v2 v3]
        = |arm, value| get_by_query(arm, value, |pin| commands::GetIoPwm { address: Some(pin.address) });
    /// Level of a digital input. The caller sets the address in the result structure.
    Command Arm GetIODI(value: Out<IODI>) in [v1 v2 v3]
        = |arm, value| get_by_query(arm, value, |pin| commands::GetIoDi { address: Some(pin.address) });
    /// Value of an analog input. The caller sets the address in the result structure.
    Command Arm GetIOADC(value: Out<IOADC>) in [v1 v2 v3]
        = |arm, value| get_by_query(arm, value, |pin| commands::GetIoAdc { address: Some(pin.address) });
    /// Runs an external stepper motor at a speed.
    Command Arm SetEMotor(value: In<EMotor>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Runs an external stepper motor for a number of pulses.
    Command Arm SetEMotorS(value: In<EMotorS>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Enables or disables the colour sensor at a port.
    Command Arm SetColorSensor(on: Bool, port: ColorPort) in [v1 v2]
        = |arm, on, port| {
            set(arm, &commands::SetColorSensor { is_enabled: Flag(on), port: to_protocol_enum(port), version: None })
        };
    /// Enables or disables the colour sensor at a port, and sets its version.
    Command Arm SetColorSensor(on: Bool, port: u8, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, port, version, queued, index| {
            let (port, version) = (port.into(), Some(version.into()));
            queue(arm, &commands::SetColorSensor { is_enabled: Flag(on), port, version }, Argument(queued), index)
        };
    /// Reading of the colour sensor: red, green and blue.
    Command Arm GetColorSensor(r: Out<u8>, g: Out<u8>, b: Out<u8>) in [v1 v2 v3]
        = |arm, r, g, b| parts_for(arm, &commands::GetColorSensor { port: None }, (r, g, b), |row: commands::ColorSensor| {
            (row.r, row.g, row.b)
        });
    /// Enables or disables the infrared sensor at a port.
    Command Arm SetInfraredSensor(on: Bool, port: InfraredPort) in [v1 v2]
        = |arm, on, port| {
            set(arm, &commands::SetIrSwitch { is_enabled: Flag(on), port: to_protocol_enum(port), version: None })
        };
    /// Enables or disables the infrared sensor at a port, and sets its version.
    Command Arm SetInfraredSensor(on: Bool, port: u8, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, port, version, queued, index| {
            let (port, version) = (port.into(), Some(version.into()));
            queue(arm, &commands::SetIrSwitch { is_enabled: Flag(on), port, version }, Argument(queued), index)
        };
    /// True if the infrared sensor detects an object.
    Command Arm GetInfraredSensor(port: InfraredPort, value: Out<u8>) in [v1 v2 v3]
        = |arm, port, value| {
            let query = commands::GetIrSwitch { port: Some(to_protocol_enum(port)) };
            parts_for(arm, &query, value, |row: commands::IrSwitch| to_flag(row.state))
        };
    /// Enables or disables a Grove colour sensor of a controller box.
    Neutral Arm SetSeeedColorSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedColorSensor", index);
    /// Reading of a Grove colour sensor of a controller box.
    Neutral Arm GetSeeedColorSensor(r: Out<u16>, g: Out<u16>, b: Out<u16>, cct: Out<u16>) in [v3]
        = |_, r, g, b, cct| neutral("GetSeeedColorSensor", (r, g, b, cct));
    /// Enables or disables a Grove temperature sensor of a controller box.
    Neutral Arm SetSeeedTempSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedTempSensor", index);
    /// Reading of a Grove temperature sensor of a controller box.
    Neutral Arm GetSeeedTempSensor(temperature: Out<u16>, humidity: Out<u16>) in [v3]
        = |_, temperature, humidity| neutral("GetSeeedTempSensor", (temperature, humidity));
    /// Enables or disables a Grove light sensor of a controller box.
    Neutral Arm SetSeeedLightSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedLightSensor", index);
    /// Reading of a Grove light sensor of a controller box.
    Neutral Arm GetSeeedLightSensor(lux: Out<u16>) in [v3] = |_, lux| neutral("GetSeeedLightSensor", lux);
    /// Reading of a Grove distance sensor of a controller box.
    Neutral Arm GetSeeedDistanceSensor(port: u8, distance: Out<u8>) in [v3]
        = |_, _, distance| neutral("GetSeeedDistanceSensor", distance);
    /// Sets a Grove LED of a controller box.
    Neutral Arm SetSeeedRgb(port: u8, rgb: f32, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetSeeedRgb", index);

    // Calibration

    /// Sets the static errors (offsets) of the angle sensors.
    Guarded Arm SetAngleSensorStaticError(rear: f32, front: f32) in [v1 v2 v3]
        = |arm, rear_arm_angle_error, front_arm_angle_error| {
            set(arm, &commands::AngleSensorStaticError { rear_arm_angle_error, front_arm_angle_error })
        };
    /// Static errors (offsets) of the angle sensors.
    Command Arm GetAngleSensorStaticError(rear: Out<f32>, front: Out<f32>) in [v1 v2 v3]
        = |arm, rear, front| parts(arm, (rear, front), |row: commands::AngleSensorStaticError| {
            (row.rear_arm_angle_error, row.front_arm_angle_error)
        });
    /// Sets the linear coefficients of the angle sensors.
    Guarded Arm SetAngleSensorCoef(rear: f32, front: f32) in [v1 v2 v3]
        = |arm, rear_arm_angle_coef, front_arm_angle_coef| {
            set(arm, &commands::AngleSensorCoef { rear_arm_angle_coef, front_arm_angle_coef })
        };
    /// Linear coefficients of the angle sensors.
    Command Arm GetAngleSensorCoef(rear: Out<f32>, front: Out<f32>) in [v1 v2 v3]
        = |arm, rear, front| parts(arm, (rear, front), |row: commands::AngleSensorCoef| {
            (row.rear_arm_angle_coef, row.front_arm_angle_coef)
        });
    /// Sets the static error (offset) of the base encoder.
    Guarded Arm SetBaseDecoderStaticError(error: f32) in [v1 v2 v3]
        = |arm, base_decoder_error| set(arm, &commands::BaseDecoderStaticError { base_decoder_error });
    /// Static error (offset) of the base encoder.
    Command Arm GetBaseDecoderStaticError(error: Out<f32>) in [v1 v2 v3]
        = |arm, error| parts(arm, error, |row: commands::BaseDecoderStaticError| row.base_decoder_error);
    /// Calibrates the elbow sides of another arm model.
    Neutral Arm SetLRHandCalibrateValue(value: f32) in [v1 v2 v3] = |_, _| neutral("SetLRHandCalibrateValue", ());
    /// Elbow-side calibration of another arm model.
    Neutral Arm GetLRHandCalibrateValue(value: Out<f32>) in [v1 v2 v3]
        = |_, value| neutral("GetLRHandCalibrateValue", value);

    // Wi-Fi

    /// Enables or disables configuration of the Wi-Fi module.
    Guarded Arm SetWIFIConfigMode(on: Bool) in [v1 v2 v3]
        = |arm, on| set(arm, &commands::WifiConfigMode { enable: Flag(on) });
    /// True if the Wi-Fi module accepts configuration.
    Command Arm GetWIFIConfigMode(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::WifiConfigMode| to_flag(row.enable));
    /// Sets the name (SSID) of the Wi-Fi network.
    Guarded Arm SetWIFISSID(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |ssid| commands::WifiSsid { ssid });
    /// Name (SSID) of the Wi-Fi network.
    Command Arm GetWIFISSID(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::WifiSsid| row.ssid);
    /// Sets the password of the Wi-Fi network.
    Guarded Arm SetWIFIPassword(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |password| commands::WifiPassword { password });
    /// Password of the Wi-Fi network.
    Command Arm GetWIFIPassword(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::WifiPassword| row.password);
    /// Sets the IP address, or DHCP.
    Guarded Arm SetWIFIIPAddress(value: In<WIFIIPAddress>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// IP address, and use of DHCP.
    Command Arm GetWIFIIPAddress(value: Out<WIFIIPAddress>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the network mask.
    Guarded Arm SetWIFINetmask(value: In<WIFINetmask>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// Network mask.
    Command Arm GetWIFINetmask(value: Out<WIFINetmask>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the gateway.
    Guarded Arm SetWIFIGateway(value: In<WIFIGateway>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// Gateway.
    Command Arm GetWIFIGateway(value: Out<WIFIGateway>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the DNS server.
    Guarded Arm SetWIFIDNS(value: In<WIFIDNS>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// DNS server.
    Command Arm GetWIFIDNS(value: Out<WIFIDNS>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// True if the Wi-Fi module is connected to the network.
    Command Arm GetWIFIConnectStatus(connected: Out<Bool>) in [v1 v2 v3]
        = |arm, connected| parts(arm, connected, |row: commands::WifiConnectStatus| to_flag(row.is_connected));

    // Firmware

    /// Switches to another firmware, which may use a different protocol.
    Guarded Arm UpdateFirmware(value: In<FirmwareParams>) in [v1 v2 v3]
        = |arm, value| call::switch_firmware(arm, value);
    /// Sets the firmware mode.
    Guarded Arm SetFirmwareMode(value: In<FirmwareMode>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// Current firmware mode.
    Command Arm GetFirmwareMode(value: Out<FirmwareMode>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Announces a firmware upgrade to a controller box.
    Neutral Arm SetUpgradeFWReadyCmd(value: In<UpgradeFWReadyCmd>) in [v3] = |_, _| neutral("SetUpgradeFWReadyCmd", ());
    /// True if a controller box is ready for a firmware upgrade.
    Neutral Arm GetUpgradeFWReadyCmd(value: In<UpgradeFWReadyCmd>, ready: Out<u8>) in [v3]
        = |_, _, ready| neutral("GetUpgradeFWReadyCmd", ready);

    // Lost steps

    /// Sets the lost-step threshold of the joints, degrees. Older headers end here, so later arguments are ignored.
    Command Arm SetLostStepParams(threshold: f32, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, _| set(arm, &commands::LostStepParams { value });
    /// Sets the lost-step threshold of the joints, degrees.
    Command Arm SetLostStepParams(threshold: f32) in [v2] = |arm, value| set(arm, &commands::LostStepParams { value });
    /// Checks for lost steps: compares the joints with their sensors.
    Command Arm SetLostStepCmd(queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, _, index| queue(arm, &commands::LostStepCmd {}, Always, index);
    /// Sets the collision detection of another arm model.
    Neutral Arm SetLostStepEnableAndParamsCmd(enable: u8, threshold: f32, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetLostStepEnableAndParamsCmd", index);
    /// Collision-detection setting of another arm model.
    Neutral Arm GetLostStepEnableAndParamsCmd(enable: Out<u8>, threshold: Out<f32>) in [v3]
        = |_, enable, threshold| neutral("GetLostStepEnableAndParamsCmd", (enable, threshold));

    // Second serial connector

    /// Device type at the second serial connector.
    Command Arm GetUART4PeripheralsType(kind: Out<u8>) in [v1 v3]
        = |arm, kind| parts(arm, kind, |row: commands::Uart4PeripheralsModel| row.type_);
    /// Enables or disables the second serial connector.
    Command Arm SetUART4PeripheralsEnable(on: Bool) in [v1 v3]
        = |arm, on| set(arm, &commands::Uart4PeripheralsEnabled { is_enabled: Flag(on) });
    /// True if the second serial connector is enabled.
    Command Arm GetUART4PeripheralsEnable(on: Out<Bool>) in [v1 v3]
        = |arm, on| parts(arm, on, |row: commands::Uart4PeripheralsEnabled| to_flag(row.is_enabled));

    // Pulses

    /// Moves the motors by pulse counts, queued.
    Command Arm SendPluse(value: In<PluseCmd>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, queued, index| queue_in(arm, value, Argument(queued), index);
    /// Moves the motors by pulse counts, at once.
    Command Arm SendPluseEx(value: In<PluseCmd>) in [v1 v3] = |arm, value| put(arm, value);

    // Tuning and tests

    /// Eight user-defined numbers.
    Command Arm GetUserParams(value: Out<UserParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Duration of a move from the current pose, ms.
    Command Arm GetPTPTime(value: In<PTPCmd>, time: Out<u32>) in [v1 v2 v3]
        = |arm, value, time| call::ptp_time(arm, value, time);
    /// PID parameters of a servo.
    Neutral Arm GetServoPIDParams(value: Out<PID>) in [v1 v2] = |_, value| neutral("GetServoPIDParams", value);
    /// Sets the PID parameters of a servo.
    Neutral Arm SetServoPIDParams(value: In<PID>, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, index| neutral("SetServoPIDParams", index);
    /// Control loop of a servo.
    Neutral Arm GetServoControlLoop(servo: u8, control_loop: Out<u8>) in [v1 v2]
        = |_, _, control_loop| neutral("GetServoControlLoop", control_loop);
    /// Sets the control loop of a servo.
    Neutral Arm SetServoControlLoop(servo: u8, control_loop: u8, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, _, index| neutral("SetServoControlLoop", index);
    /// Saves the PID parameters of a servo.
    Neutral Arm SaveServoPIDParams(servo: u8, control_loop: u8, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, _, index| neutral("SaveServoPIDParams", index);
    /// Sets the angle of a servo of a controller box.
    Neutral Arm SetServoAngle(queued: Bool, servo: u8, angle: f32, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetServoAngle", index);
    /// Angle of a servo of a controller box.
    Neutral Arm GetServoAngle(servo: u8, angle: Out<f32>) in [v3] = |_, _, angle| neutral("GetServoAngle", angle);
    /// Sets the motor mode of another arm model.
    Neutral Arm SetMotorMode(mode: c_int) in [v3] = |_, _| neutral("SetMotorMode", ());
    /// Motor mode of another arm model.
    Neutral Arm GetMotorMode(mode: Out<i32>) in [v3] = |_, mode| neutral("GetMotorMode", mode);
    /// Geometry of another arm model. No public program calls it; its arguments are unknown, so nothing is written.
    Neutral Arm GetDobotDHParams() in [v3] = |_| neutral("GetDobotDHParams", ());

    // Controller box

    /// Shows progress on the display of a controller box.
    Neutral Arm SetProgbar(value: u8) in [v3] = |_, _| neutral("SetProgbar", ());
    /// Shows text on the display of a controller box.
    Neutral Arm PrintInfo(text: Text) in [v3] = |_, _| neutral("PrintInfo", ());
    /// Restarts a controller box.
    Neutral Arm RestartMagicBox() in [v3] = |_| neutral("RestartMagicBox", ());

    // Queue

    /// Starts the queue.
    Command Arm SetQueuedCmdStartExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStartExec {});
    /// Stops the queue after the running command.
    Command Arm SetQueuedCmdStopExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStopExec {});
    /// Stops the queue and aborts the running command.
    Command Arm SetQueuedCmdForceStopExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdForceStopExec {});
    /// Begins the download of a program into the arm.
    Guarded Arm SetQueuedCmdStartDownload(loops: u32, lines: u32) in [v1 v2 v3]
        = |arm, total_loop, line_per_loop| {
            set(arm, &commands::QueuedCmdStartDownload { total_loop, line_per_loop })
        };
    /// Ends the download of a program.
    Command Arm SetQueuedCmdStopDownload() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStopDownload {});
    /// Clears the queue: drops waiting commands.
    Command Arm SetQueuedCmdClear() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdClear {});
    /// Index of the last finished command. The log says why a program waits in vain while the queue is stopped.
    Command Arm GetQueuedCmdCurrentIndex(index: Out<u64>) in [v1 v2 v3]
        = |arm, index| call::current_index(arm, index);
    /// True if no motion is under way.
    Command Arm GetQueuedCmdMotionFinish(finished: Out<Bool>) in [v1 v3]
        = |arm, finished| parts(arm, finished, |row: commands::QueuedCmdMotionFinish| to_flag(row.is_finish));

    // Library

    /// Accepts the vendor's debug switch without effect; `MAGICIAN_LOG` controls the log.
    Host None SetDebugEnable(on: Bool) in [v1 v3] = |_, on| call::debug(on);
    /// Sleeps. No public program calls it; the argument is assumed to be milliseconds.
    Host None DobotSleep(milliseconds: u32) in [v3] = |_, milliseconds| call::sleep(milliseconds);

        }
    };
}

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

    pub use crate::call::Queued::{Always, Said};
    pub use crate::call::{
        self, ask, choice, get, get_text, neutral, number, parts, parts_for, put, queue, queue_as,
        queue_in, set, set_text, truth,
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

    /// Lists where arms could be, separated by blanks, and returns how many there are.
    Host None SearchDobot(list: Buffer, size: u32) in [v1 v2 v3] = |_, list, size| session::search(list, size);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer) in [v1]
        = |_, port, baud, firmware, version| session::connect_v1(port, baud, firmware, version);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer, id: Out<i32>) in [v2]
        = |_, port, baud, firmware, version, id| session::connect_v2(port, baud, firmware, version, id);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, info: Out<ConnectInfo>) in [v3]
        = |_, port, baud, info| session::connect_v3(port, baud, info);
    /// Ends the connection. The arm goes on with what is in its queue.
    Host Master DisconnectDobot() in [v1 v2 v3] = session::disconnect;
    /// How long calls may take, in milliseconds: 3000 unless set. It may be set before there is a connection.
    Host Master SetCmdTimeout(milliseconds: u32) in [v1 v2 v3] = session::set_timeout;
    /// Returns at once: no event loop is needed.
    Host None DobotExec() in [v1 v2 v3] = |_| 0;
    /// Returns at once: nothing needs to be called again and again.
    Host None PeriodicTask() in [v1 v2 v3] = |_| 0;
    /// Puts the sentence of the calling thread's last fault into a text, as much as fits, and returns its length; 0 if
    /// there was none. The text may be null.
    Host None MagicianLastError(text: Buffer, size: u32) in [v1 v2 v3] = |_, text, size| session::last_error(text, size);
    /// Allows dangerous commands by their names, with commas between them, or `all`.
    Host None MagicianAllow(names: Text) in [v1 v2 v3] = |_, names| session::allow(names);

    // Device

    /// Gives the arm another serial number.
    Guarded Arm SetDeviceSN(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |device_sn| commands::DeviceSn { device_sn });
    /// Serial number of the arm.
    Command Arm GetDeviceSN(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::DeviceSn| row.device_sn);
    /// Gives the arm a name.
    Command Arm SetDeviceName(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |device_name| commands::DeviceName { device_name });
    /// Name of the arm.
    Command Arm GetDeviceName(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::DeviceName| row.device_name);
    /// Version of the firmware. Newer headers have a fourth place, for the hardware: it is never touched.
    Command Arm GetDeviceVersion(major: Out<u8>, minor: Out<u8>, revision: Out<u8>) in [v1 v2]
        = |arm, major, minor, revision| parts(arm, (major, minor, revision), |row: commands::DeviceVersion| {
            (row.major_version, row.minor_version, row.revision)
        });
    /// Versions of firmware and hardware; the arm tells three numbers of the firmware's, all else is 0.
    Command Arm GetDeviceVersion(version: Out<DeviceVersion>) in [v3]
        = |arm, version| parts(arm, version, |row: commands::DeviceVersion| DeviceVersion::of(&row));
    /// Says whether the arm stands on a rail.
    Command Arm SetDeviceWithL(on: Bool, queued: Bool, index: Out<u64>) in [v1]
        = |arm, on, queued, index| queue(arm, &commands::SetDeviceWithL { with_l: Flag(on), version: None }, Said(queued), index);
    /// Says whether the arm stands on a rail.
    Command Arm SetDeviceWithL(on: Bool) in [v2]
        = |arm, on| set(arm, &commands::SetDeviceWithL { with_l: Flag(on), version: None });
    /// Says whether the arm stands on a rail, and on which generation of it.
    Command Arm SetDeviceWithL(on: Bool, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, version, queued, index| {
            let row = commands::SetDeviceWithL { with_l: Flag(on), version: Some(version.into()) };
            queue(arm, &row, Said(queued), index)
        };
    /// Whether the arm stands on a rail.
    Command Arm GetDeviceWithL(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::DeviceWithL| truth(row.with_l));
    /// Milliseconds since the arm was switched on.
    Command Arm GetDeviceTime(time: Out<u32>) in [v1 v2 v3]
        = |arm, time| parts(arm, time, |row: commands::DeviceTime| row.g_systick);
    /// Id of the arm's processor.
    Command Arm GetDeviceID(value: Out<DeviceID>) in [v3] = |arm, value| get(arm, value);
    /// Counters of the arm's life.
    Command Arm GetDeviceInfo(value: Out<DeviceCountInfo>) in [v1 v3] = |arm, value| get(arm, value);
    /// Version of a 3-D printing firmware.
    Neutral Arm GetMarlinVersion() in [v1 v3] = |_| neutral("GetMarlinVersion", ());

    // Pose

    /// Where the arm is.
    Command Arm GetPose(value: Out<Pose>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Where the arm is, as the oldest headers also call it.
    Command Arm GetPoseEx(value: Out<Pose>) in [v1 v2] = |arm, value| get(arm, value);
    /// Sets the angles of rear arm and forearm anew.
    Guarded Arm ResetPose(manual: Bool, rear_arm_angle: f32, front_arm_angle: f32) in [v1 v2 v3]
        = |arm, manual, rear_arm_angle, front_arm_angle| {
            set(arm, &commands::ResetPose { manual: Flag(manual), rear_arm_angle, front_arm_angle })
        };
    /// Speed and acceleration of the arm.
    Command Arm GetKinematics(value: Out<Kinematics>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Where the arm is on its rail.
    Command Arm GetPoseL(l: Out<f32>) in [v1 v2 v3] = |arm, l| parts(arm, l, |row: commands::PoseL| row.pose_l);

    // Alarms

    /// The alarms that stand, a bit each, and how many bytes they are: as many as fit are written.
    Command Arm GetAlarmsState(state: Out<u8>, length: Out<u32>, size: u32) in [v1 v2 v3]
        = |arm, state, length, size| call::alarms(arm, state, length, size);
    /// Clears the alarms.
    Command Arm ClearAllAlarmsState() in [v1 v2 v3] = |arm| set(arm, &commands::ClearAlarmsState {});

    // Homing

    /// Sets where homing ends.
    Command Arm SetHOMEParams(value: In<HOMEParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Where homing ends.
    Command Arm GetHOMEParams(value: Out<HOMEParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Homes the arm.
    Command Arm SetHOMECmd(value: In<HOMECmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Levels the arm by its sensors.
    Command Arm SetAutoLevelingCmd(value: In<AutoLevelingCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// How precisely the arm was levelled.
    Command Arm GetAutoLevelingResult(precision: Out<f32>) in [v1 v2 v3]
        = |arm, precision| parts(arm, precision, |row: commands::AutoLeveling| row.result);

    // Teaching by hand

    /// Sets when hand teaching reports a point.
    Command Arm SetHHTTrigMode(mode: HHTTrigMode) in [v1 v2 v3]
        = |arm, mode| set(arm, &commands::HhtTrigMode { mode: choice(mode) });
    /// When hand teaching reports a point.
    Command Arm GetHHTTrigMode(mode: Out<HHTTrigMode>) in [v1 v2 v3]
        = |arm, mode| parts(arm, mode, |row: commands::HhtTrigMode| number(row.mode));
    /// Sets whether hand teaching reports points.
    Command Arm SetHHTTrigOutputEnabled(on: Bool) in [v1 v2 v3]
        = |arm, on| set(arm, &commands::HhtTrigOutputEnabled { is_enabled: Flag(on) });
    /// Whether hand teaching reports points.
    Command Arm GetHHTTrigOutputEnabled(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::HhtTrigOutputEnabled| truth(row.is_enabled));
    /// Whether a point was taught since the last look.
    Command Arm GetHHTTrigOutput(triggered: Out<Bool>) in [v1 v2 v3]
        = |arm, triggered| parts(arm, triggered, |row: commands::HhtTrigOutput| truth(row.is_triggered));

    // Tool

    /// Sets where the tool sits.
    Command Arm SetEndEffectorParams(value: In<EndEffectorParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Where the tool sits.
    Command Arm GetEndEffectorParams(value: Out<EndEffectorParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Switches the laser; what Python modules pass as its power goes out as it is.
    Command Arm SetEndEffectorLaser(enable: Bool, on: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, on, _, index| {
            queue(arm, &commands::SetEndEffectorLaser { enable_ctrl: Flag(enable), on: Flag(on) }, Always, index)
        };
    /// Whether the laser is in use, and on.
    Command Arm GetEndEffectorLaser(enabled: Out<Bool>, on: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, on| parts(arm, (enabled, on), |row: commands::EndEffectorLaser| {
            (truth(row.is_ctrl_enabled), truth(row.is_on))
        });
    /// Switches the suction cup.
    Command Arm SetEndEffectorSuctionCup(enable: Bool, suck: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, suck, _, index| {
            queue(arm, &commands::SetEndEffectorSuctionCup { enable_ctrl: Flag(enable), suck: Flag(suck) }, Always, index)
        };
    /// Whether the suction cup is in use, and sucks.
    Command Arm GetEndEffectorSuctionCup(enabled: Out<Bool>, sucked: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, sucked| parts(arm, (enabled, sucked), |row: commands::EndEffectorSuctionCup| {
            (truth(row.is_ctrl_enabled), truth(row.is_sucked))
        });
    /// Opens or closes the gripper.
    Command Arm SetEndEffectorGripper(enable: Bool, grip: Bool, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, enable, grip, _, index| {
            queue(arm, &commands::SetEndEffectorGripper { enable_ctrl: Flag(enable), grip: Flag(grip) }, Always, index)
        };
    /// Whether the gripper is in use, and closed.
    Command Arm GetEndEffectorGripper(enabled: Out<Bool>, gripped: Out<Bool>) in [v1 v2 v3]
        = |arm, enabled, gripped| parts(arm, (enabled, gripped), |row: commands::EndEffectorGripper| {
            (truth(row.is_ctrl_enabled), truth(row.is_gripped))
        });
    /// Names the tool of another arm.
    Neutral Arm SetEndEffectorType(queued: Bool, kind: u8, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetEndEffectorType", index);
    /// The tool of another arm.
    Neutral Arm GetEndEffectorType(kind: Out<u8>) in [v3] = |_, kind| neutral("GetEndEffectorType", kind);

    // Arm orientation

    /// Sets the elbow side, which this arm only stores.
    Command Arm SetArmOrientation(side: ArmOrientation, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, side, _, index| queue(arm, &commands::ArmOrientation { orientation: choice(side) }, Always, index);
    /// The elbow side.
    Command Arm GetArmOrientation(side: Out<ArmOrientation>) in [v1 v2 v3]
        = |arm, side| parts(arm, side, |row: commands::ArmOrientation| number(row.orientation));

    // Jog

    /// Sets the speeds of jogging in joints.
    Command Arm SetJOGJointParams(value: In<JOGJointParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of jogging in joints.
    Command Arm GetJOGJointParams(value: Out<JOGJointParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the speeds of jogging in coordinates.
    Command Arm SetJOGCoordinateParams(value: In<JOGCoordinateParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of jogging in coordinates.
    Command Arm GetJOGCoordinateParams(value: Out<JOGCoordinateParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the speeds of jogging on the rail.
    Command Arm SetJOGLParams(value: In<JOGLParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Said(queued), index);
    /// Speeds of jogging on the rail.
    Command Arm GetJOGLParams(value: Out<JOGLParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the share of the jog speeds that is used.
    Command Arm SetJOGCommonParams(value: In<JOGCommonParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Said(queued), index);
    /// Share of the jog speeds that is used.
    Command Arm GetJOGCommonParams(value: Out<JOGCommonParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves while a key is held; command 0 ends it.
    Command Arm SetJOGCmd(value: In<JOGCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, queued, index| queue_in(arm, value, Said(queued), index);

    // Point to point

    /// Sets the speeds of the joints.
    Command Arm SetPTPJointParams(value: In<PTPJointParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of the joints.
    Command Arm GetPTPJointParams(value: Out<PTPJointParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the speeds of the tool.
    Command Arm SetPTPCoordinateParams(value: In<PTPCoordinateParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of the tool.
    Command Arm GetPTPCoordinateParams(value: Out<PTPCoordinateParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the speeds on the rail.
    Command Arm SetPTPLParams(value: In<PTPLParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds on the rail.
    Command Arm GetPTPLParams(value: Out<PTPLParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets how high a jump lifts.
    Command Arm SetPTPJumpParams(value: In<PTPJumpParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// How high a jump lifts.
    Command Arm GetPTPJumpParams(value: Out<PTPJumpParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the share of the speeds that is used.
    Command Arm SetPTPCommonParams(value: In<PTPCommonParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Share of the speeds that is used.
    Command Arm GetPTPCommonParams(value: Out<PTPCommonParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves the arm to a point.
    Command Arm SetPTPCmd(value: In<PTPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves the arm and the rail to a point.
    Command Arm SetPTPWithLCmd(value: In<PTPWithLCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Sets how high a jump lifts, each end for itself.
    Command Arm SetPTPJump2Params(value: In<PTPJump2Params>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// How high a jump lifts, each end for itself.
    Command Arm GetPTPJump2Params(value: Out<PTPJump2Params>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves the arm to a point and switches outputs on the way.
    Command Arm SetPTPPOCmd(value: In<PTPCmd>, outputs: In<ParallelOutputCmd>, count: c_int, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, outputs, count, _, index| call::queue_switching(arm, value, outputs, count, index);
    /// Moves the arm and the rail to a point and switches outputs on the way.
    Command Arm SetPTPPOWithLCmd(value: In<PTPWithLCmd>, outputs: In<ParallelOutputCmd>, count: c_int, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, outputs, count, _, index| call::queue_switching(arm, value, outputs, count, index);
    /// Sets the share of the speeds of another arm.
    Neutral Arm SetArmSpeedRatio(queued: Bool, mode: u8, ratio: u8, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetArmSpeedRatio", index);
    /// Share of the speeds of another arm.
    Neutral Arm GetArmSpeedRatio(mode: u8, ratio: Out<u8>) in [v3] = |_, _, ratio| neutral("GetArmSpeedRatio", ratio);
    /// Sets the share of the speeds of a controller box's rail.
    Neutral Arm SetLSpeedRatio(queued: Bool, mode: u8, ratio: u8, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetLSpeedRatio", index);
    /// Share of the speeds of a controller box's rail.
    Neutral Arm GetLSpeedRatio(mode: u8, ratio: Out<u8>) in [v3] = |_, _, ratio| neutral("GetLSpeedRatio", ratio);

    // Continuous path

    /// Sets the speeds of the path.
    Command Arm SetCPParams(value: In<CPParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of the path.
    Command Arm GetCPParams(value: Out<CPParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Adds a straight segment to the path.
    Command Arm SetCPCmd(value: In<CPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Adds a straight segment with laser power to the path.
    Command Arm SetCPLECmd(value: In<CPCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_as(arm, value, call::burning, Always, index);
    /// Adds a segment to the path of another arm.
    Neutral Arm SetCP2Cmd(value: In<CP2Cmd>, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetCP2Cmd", index);
    /// Sets whether the tool keeps its rotation on the path.
    Command Arm SetCPRHoldEnable(on: Bool) in [v1 v3]
        = |arm, on| set(arm, &commands::CpRHeadHoldEnable { enable: Flag(on) });
    /// Whether the tool keeps its rotation on the path.
    Command Arm GetCPRHoldEnable(on: Out<Bool>) in [v1 v3]
        = |arm, on| parts(arm, on, |row: commands::CpRHeadHoldEnable| truth(row.enable));
    /// Sets the share of the speeds that is used.
    Command Arm SetCPCommonParams(value: In<CPCommonParams>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Share of the speeds that is used.
    Command Arm GetCPCommonParams(value: Out<CPCommonParams>) in [v1 v3] = |arm, value| get(arm, value);

    // Arcs

    /// Sets the speeds of arcs.
    Command Arm SetARCParams(value: In<ARCParams>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Speeds of arcs.
    Command Arm GetARCParams(value: Out<ARCParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Moves along an arc.
    Command Arm SetARCCmd(value: In<ARCCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves round a circle.
    Command Arm SetCircleCmd(value: In<CircleCmd>, queued: Bool, index: Out<u64>) in [v1]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Moves round a circle, once: every Python module of these families hands in two points and no count.
    Command Arm SetCircleCmd(value: In<ARCCmd>, queued: Bool, index: Out<u64>) in [v2 v3]
        = |arm, value, _, index| queue_as(arm, value, call::once_round, Always, index);
    /// Sets the share of the arc speeds that is used.
    Command Arm SetARCCommonParams(value: In<ARCCommonParams>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Share of the arc speeds that is used.
    Command Arm GetARCCommonParams(value: Out<ARCCommonParams>) in [v1 v3] = |arm, value| get(arm, value);

    // Waiting and triggers

    /// Makes the queue wait, milliseconds.
    Command Arm SetWAITCmd(value: In<WAITCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Makes the queue wait for an input.
    Command Arm SetTRIGCmd(value: In<TRIGCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);

    // Inputs, outputs, motors and sensors

    /// Sets what a pin does.
    Command Arm SetIOMultiplexing(value: In<IOMultiplexing>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// What a pin does; which pin is said in the place for the answer.
    Command Arm GetIOMultiplexing(value: Out<IOMultiplexing>) in [v1 v2 v3]
        = |arm, value| ask(arm, value, |pin| commands::GetIoMultiplexing { address: Some(pin.address) });
    /// Sets the level of an output.
    Command Arm SetIODO(value: In<IODO>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Level of an output; which one is said in the place for the answer.
    Command Arm GetIODO(value: Out<IODO>) in [v1 v2 v3]
        = |arm, value| ask(arm, value, |pin| commands::GetIoDo { address: Some(pin.address) });
    /// Sets the signal of an output.
    Command Arm SetIOPWM(value: In<IOPWM>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Signal of an output; which one is said in the place for the answer.
    Command Arm GetIOPWM(value: Out<IOPWM>) in [v1 v2 v3]
        = |arm, value| ask(arm, value, |pin| commands::GetIoPwm { address: Some(pin.address) });
    /// Level of an input; which one is said in the place for the answer.
    Command Arm GetIODI(value: Out<IODI>) in [v1 v2 v3]
        = |arm, value| ask(arm, value, |pin| commands::GetIoDi { address: Some(pin.address) });
    /// Value of an analog input; which one is said in the place for the answer.
    Command Arm GetIOADC(value: Out<IOADC>) in [v1 v2 v3]
        = |arm, value| ask(arm, value, |pin| commands::GetIoAdc { address: Some(pin.address) });
    /// Runs an external motor.
    Command Arm SetEMotor(value: In<EMotor>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Runs an external motor a number of pulses.
    Command Arm SetEMotorS(value: In<EMotorS>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, value, _, index| queue_in(arm, value, Always, index);
    /// Switches the colour sensor.
    Command Arm SetColorSensor(on: Bool, port: ColorPort) in [v1 v2]
        = |arm, on, port| {
            set(arm, &commands::SetColorSensor { is_enabled: Flag(on), port: choice(port), version: None })
        };
    /// Switches the colour sensor, and says its generation.
    Command Arm SetColorSensor(on: Bool, port: u8, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, port, version, queued, index| {
            let (port, version) = (port.into(), Some(version.into()));
            queue(arm, &commands::SetColorSensor { is_enabled: Flag(on), port, version }, Said(queued), index)
        };
    /// What the colour sensor sees.
    Command Arm GetColorSensor(r: Out<u8>, g: Out<u8>, b: Out<u8>) in [v1 v2 v3]
        = |arm, r, g, b| parts_for(arm, &commands::GetColorSensor { port: None }, (r, g, b), |row: commands::ColorSensor| {
            (row.r, row.g, row.b)
        });
    /// Switches the infrared sensor.
    Command Arm SetInfraredSensor(on: Bool, port: InfraredPort) in [v1 v2]
        = |arm, on, port| {
            set(arm, &commands::SetIrSwitch { is_enabled: Flag(on), port: choice(port), version: None })
        };
    /// Switches the infrared sensor, and says its generation.
    Command Arm SetInfraredSensor(on: Bool, port: u8, version: u8, queued: Bool, index: Out<u64>) in [v3]
        = |arm, on, port, version, queued, index| {
            let (port, version) = (port.into(), Some(version.into()));
            queue(arm, &commands::SetIrSwitch { is_enabled: Flag(on), port, version }, Said(queued), index)
        };
    /// Whether something is in front of the infrared sensor.
    Command Arm GetInfraredSensor(port: InfraredPort, value: Out<u8>) in [v1 v2 v3]
        = |arm, port, value| {
            let query = commands::GetIrSwitch { port: Some(choice(port)) };
            parts_for(arm, &query, value, |row: commands::IrSwitch| truth(row.state))
        };
    /// Switches a Grove colour sensor of a controller box.
    Neutral Arm SetSeeedColorSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedColorSensor", index);
    /// What a Grove colour sensor of a controller box sees.
    Neutral Arm GetSeeedColorSensor(r: Out<u16>, g: Out<u16>, b: Out<u16>, cct: Out<u16>) in [v3]
        = |_, r, g, b, cct| neutral("GetSeeedColorSensor", (r, g, b, cct));
    /// Switches a Grove temperature sensor of a controller box.
    Neutral Arm SetSeeedTempSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedTempSensor", index);
    /// What a Grove temperature sensor of a controller box sees.
    Neutral Arm GetSeeedTempSensor(temperature: Out<u16>, humidity: Out<u16>) in [v3]
        = |_, temperature, humidity| neutral("GetSeeedTempSensor", (temperature, humidity));
    /// Switches a Grove light sensor of a controller box.
    Neutral Arm SetSeeedLightSensor(port: u8, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, index| neutral("SetSeeedLightSensor", index);
    /// What a Grove light sensor of a controller box sees.
    Neutral Arm GetSeeedLightSensor(lux: Out<u16>) in [v3] = |_, lux| neutral("GetSeeedLightSensor", lux);
    /// What a Grove distance sensor of a controller box sees.
    Neutral Arm GetSeeedDistanceSensor(port: u8, distance: Out<u8>) in [v3]
        = |_, _, distance| neutral("GetSeeedDistanceSensor", distance);
    /// Lights a Grove lamp of a controller box.
    Neutral Arm SetSeeedRgb(port: u8, rgb: f32, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetSeeedRgb", index);

    // Calibration

    /// Sets the corrections of the angle sensors.
    Guarded Arm SetAngleSensorStaticError(rear: f32, front: f32) in [v1 v2 v3]
        = |arm, rear_arm_angle_error, front_arm_angle_error| {
            set(arm, &commands::AngleSensorStaticError { rear_arm_angle_error, front_arm_angle_error })
        };
    /// Corrections of the angle sensors.
    Command Arm GetAngleSensorStaticError(rear: Out<f32>, front: Out<f32>) in [v1 v2 v3]
        = |arm, rear, front| parts(arm, (rear, front), |row: commands::AngleSensorStaticError| {
            (row.rear_arm_angle_error, row.front_arm_angle_error)
        });
    /// Sets the scales of the angle sensors.
    Guarded Arm SetAngleSensorCoef(rear: f32, front: f32) in [v1 v2 v3]
        = |arm, rear_arm_angle_coef, front_arm_angle_coef| {
            set(arm, &commands::AngleSensorCoef { rear_arm_angle_coef, front_arm_angle_coef })
        };
    /// Scales of the angle sensors.
    Command Arm GetAngleSensorCoef(rear: Out<f32>, front: Out<f32>) in [v1 v2 v3]
        = |arm, rear, front| parts(arm, (rear, front), |row: commands::AngleSensorCoef| {
            (row.rear_arm_angle_coef, row.front_arm_angle_coef)
        });
    /// Sets the correction of the base encoder.
    Guarded Arm SetBaseDecoderStaticError(error: f32) in [v1 v2 v3]
        = |arm, base_decoder_error| set(arm, &commands::BaseDecoderStaticError { base_decoder_error });
    /// Correction of the base encoder.
    Command Arm GetBaseDecoderStaticError(error: Out<f32>) in [v1 v2 v3]
        = |arm, error| parts(arm, error, |row: commands::BaseDecoderStaticError| row.base_decoder_error);
    /// Calibrates the elbow sides of another arm.
    Neutral Arm SetLRHandCalibrateValue(value: f32) in [v1 v2 v3] = |_, _| neutral("SetLRHandCalibrateValue", ());
    /// Calibration of the elbow sides of another arm.
    Neutral Arm GetLRHandCalibrateValue(value: Out<f32>) in [v1 v2 v3]
        = |_, value| neutral("GetLRHandCalibrateValue", value);

    // Wi-Fi

    /// Sets whether the Wi-Fi module takes settings.
    Guarded Arm SetWIFIConfigMode(on: Bool) in [v1 v2 v3]
        = |arm, on| set(arm, &commands::WifiConfigMode { enable: Flag(on) });
    /// Whether the Wi-Fi module takes settings.
    Command Arm GetWIFIConfigMode(on: Out<Bool>) in [v1 v2 v3]
        = |arm, on| parts(arm, on, |row: commands::WifiConfigMode| truth(row.enable));
    /// Sets the name of the network.
    Guarded Arm SetWIFISSID(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |ssid| commands::WifiSsid { ssid });
    /// Name of the network.
    Command Arm GetWIFISSID(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::WifiSsid| row.ssid);
    /// Sets the password of the network.
    Guarded Arm SetWIFIPassword(text: Text) in [v1 v2 v3]
        = |arm, text| set_text(arm, text, |password| commands::WifiPassword { password });
    /// Password of the network.
    Command Arm GetWIFIPassword(text: Buffer, size: u32) in [v1 v2 v3]
        = |arm, text, size| get_text(arm, text, size, |row: commands::WifiPassword| row.password);
    /// Sets the address.
    Guarded Arm SetWIFIIPAddress(value: In<WIFIIPAddress>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// The address.
    Command Arm GetWIFIIPAddress(value: Out<WIFIIPAddress>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the network mask.
    Guarded Arm SetWIFINetmask(value: In<WIFINetmask>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// The network mask.
    Command Arm GetWIFINetmask(value: Out<WIFINetmask>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the gateway.
    Guarded Arm SetWIFIGateway(value: In<WIFIGateway>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// The gateway.
    Command Arm GetWIFIGateway(value: Out<WIFIGateway>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Sets the name server.
    Guarded Arm SetWIFIDNS(value: In<WIFIDNS>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// The name server.
    Command Arm GetWIFIDNS(value: Out<WIFIDNS>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Whether the arm is in the network.
    Command Arm GetWIFIConnectStatus(connected: Out<Bool>) in [v1 v2 v3]
        = |arm, connected| parts(arm, connected, |row: commands::WifiConnectStatus| truth(row.is_connected));

    // Firmware

    /// Switches to another firmware, which may not speak this protocol.
    Guarded Arm UpdateFirmware(value: In<FirmwareParams>) in [v1 v2 v3]
        = |arm, value| call::switch_firmware(arm, value);
    /// Says which firmware is to run.
    Guarded Arm SetFirmwareMode(value: In<FirmwareMode>) in [v1 v2 v3] = |arm, value| put(arm, value);
    /// Which firmware runs.
    Command Arm GetFirmwareMode(value: Out<FirmwareMode>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Announces a firmware to a controller box.
    Neutral Arm SetUpgradeFWReadyCmd(value: In<UpgradeFWReadyCmd>) in [v3] = |_, _| neutral("SetUpgradeFWReadyCmd", ());
    /// Whether a controller box takes a firmware.
    Neutral Arm GetUpgradeFWReadyCmd(value: In<UpgradeFWReadyCmd>, ready: Out<u8>) in [v3]
        = |_, _, ready| neutral("GetUpgradeFWReadyCmd", ready);

    // Lost steps

    /// Sets how far a joint may be off. Older headers end after the threshold, so what follows is never looked at.
    Command Arm SetLostStepParams(threshold: f32, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, _, _| set(arm, &commands::LostStepParams { value });
    /// Sets how far a joint may be off.
    Command Arm SetLostStepParams(threshold: f32) in [v2] = |arm, value| set(arm, &commands::LostStepParams { value });
    /// Compares the joints with their sensors.
    Command Arm SetLostStepCmd(queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, _, index| queue(arm, &commands::LostStepCmd {}, Always, index);
    /// Watches for collisions of another arm.
    Neutral Arm SetLostStepEnableAndParamsCmd(enable: u8, threshold: f32, queued: Bool, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetLostStepEnableAndParamsCmd", index);
    /// Whether another arm watches for collisions.
    Neutral Arm GetLostStepEnableAndParamsCmd(enable: Out<u8>, threshold: Out<f32>) in [v3]
        = |_, enable, threshold| neutral("GetLostStepEnableAndParamsCmd", (enable, threshold));

    // Second serial connector

    /// What is plugged into the second serial connector.
    Command Arm GetUART4PeripheralsType(kind: Out<u8>) in [v1 v3]
        = |arm, kind| parts(arm, kind, |row: commands::Uart4PeripheralsModel| row.type_);
    /// Sets whether the second serial connector works.
    Command Arm SetUART4PeripheralsEnable(on: Bool) in [v1 v3]
        = |arm, on| set(arm, &commands::Uart4PeripheralsEnabled { is_enabled: Flag(on) });
    /// Whether the second serial connector works.
    Command Arm GetUART4PeripheralsEnable(on: Out<Bool>) in [v1 v3]
        = |arm, on| parts(arm, on, |row: commands::Uart4PeripheralsEnabled| truth(row.is_enabled));

    // Pulses

    /// Moves motors by pulses.
    Command Arm SendPluse(value: In<PluseCmd>, queued: Bool, index: Out<u64>) in [v1 v3]
        = |arm, value, queued, index| queue_in(arm, value, Said(queued), index);
    /// Moves motors by pulses, at once.
    Command Arm SendPluseEx(value: In<PluseCmd>) in [v1 v3] = |arm, value| put(arm, value);

    // Tuning and tests

    /// Eight numbers for the user.
    Command Arm GetUserParams(value: Out<UserParams>) in [v1 v2 v3] = |arm, value| get(arm, value);
    /// Milliseconds that a move would take from here.
    Command Arm GetPTPTime(value: In<PTPCmd>, time: Out<u32>) in [v1 v2 v3]
        = |arm, value, time| call::ptp_time(arm, value, time);
    /// Controller of a servo.
    Neutral Arm GetServoPIDParams(value: Out<PID>) in [v1 v2] = |_, value| neutral("GetServoPIDParams", value);
    /// Sets the controller of a servo.
    Neutral Arm SetServoPIDParams(value: In<PID>, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, index| neutral("SetServoPIDParams", index);
    /// Control loop of a servo.
    Neutral Arm GetServoControlLoop(servo: u8, control_loop: Out<u8>) in [v1 v2]
        = |_, _, control_loop| neutral("GetServoControlLoop", control_loop);
    /// Sets the control loop of a servo.
    Neutral Arm SetServoControlLoop(servo: u8, control_loop: u8, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, _, index| neutral("SetServoControlLoop", index);
    /// Keeps the controller of a servo.
    Neutral Arm SaveServoPIDParams(servo: u8, control_loop: u8, queued: Bool, index: Out<u64>) in [v1 v2]
        = |_, _, _, _, index| neutral("SaveServoPIDParams", index);
    /// Turns a servo of a controller box.
    Neutral Arm SetServoAngle(queued: Bool, servo: u8, angle: f32, index: Out<u64>) in [v3]
        = |_, _, _, _, index| neutral("SetServoAngle", index);
    /// Angle of a servo of a controller box.
    Neutral Arm GetServoAngle(servo: u8, angle: Out<f32>) in [v3] = |_, _, angle| neutral("GetServoAngle", angle);
    /// Sets how the motors of another arm work.
    Neutral Arm SetMotorMode(mode: c_int) in [v3] = |_, _| neutral("SetMotorMode", ());
    /// How the motors of another arm work.
    Neutral Arm GetMotorMode(mode: Out<i32>) in [v3] = |_, mode| neutral("GetMotorMode", mode);
    /// Geometry of another arm. No public program calls it and its places are unknown, so none is touched.
    Neutral Arm GetDobotDHParams() in [v3] = |_| neutral("GetDobotDHParams", ());

    // Controller box

    /// Shows progress on a controller box.
    Neutral Arm SetProgbar(value: u8) in [v3] = |_, _| neutral("SetProgbar", ());
    /// Shows text on a controller box.
    Neutral Arm PrintInfo(text: Text) in [v3] = |_, _| neutral("PrintInfo", ());
    /// Restarts a controller box.
    Neutral Arm RestartMagicBox() in [v3] = |_| neutral("RestartMagicBox", ());

    // Queue

    /// Lets the queue run.
    Command Arm SetQueuedCmdStartExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStartExec {});
    /// Stops the queue when the running command has ended.
    Command Arm SetQueuedCmdStopExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStopExec {});
    /// Stops the queue and the running command.
    Command Arm SetQueuedCmdForceStopExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdForceStopExec {});
    /// Begins to store a program in the arm.
    Guarded Arm SetQueuedCmdStartDownload(loops: u32, lines: u32) in [v1 v2 v3]
        = |arm, total_loop, line_per_loop| {
            set(arm, &commands::QueuedCmdStartDownload { total_loop, line_per_loop })
        };
    /// Ends the storing of a program.
    Command Arm SetQueuedCmdStopDownload() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStopDownload {});
    /// Drops what waits in the queue.
    Command Arm SetQueuedCmdClear() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdClear {});
    /// Index of the command that ended last. A program that waits for more while the queue stands finds out why in the log.
    Command Arm GetQueuedCmdCurrentIndex(index: Out<u64>) in [v1 v2 v3]
        = |arm, index| call::current_index(arm, index);
    /// Whether nothing moves.
    Command Arm GetQueuedCmdMotionFinish(finished: Out<Bool>) in [v1 v3]
        = |arm, finished| parts(arm, finished, |row: commands::QueuedCmdMotionFinish| truth(row.is_finish));

    // Library

    /// Asks for the vendor's messages; `MAGICIAN_LOG` asks for ours.
    Host None SetDebugEnable(on: Bool) in [v1 v3] = |_, on| call::debug(on);
    /// Waits. No public program calls it, and its argument is what its name suggests.
    Host None DobotSleep(milliseconds: u32) in [v3] = |_, milliseconds| call::sleep(milliseconds);

        }
    };
}

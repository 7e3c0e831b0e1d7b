//! What people say to a robot arm, as commands.
//!
//! A word returns a command as a value and does nothing else: [`Arm::perform`](crate::Arm::perform)
//! checks and runs them, [`Arm::run`](crate::Arm::run) runs them,
//! [`Arm::enqueue_set`](crate::Arm::enqueue_set) takes them one at a time, and programs may keep them
//! in lists. Lengths are mm, angles degrees; the frame is the arm's: origin where the base axis meets the
//! shoulder axis, X forward, Y to the arm's left, Z up. The table is below z = 0.
//!
//! ```
//! use magician::words;
//!
//! let pick = [
//!     words::jump_to(220.0, 40.0, -30.0, 0.0),
//!     words::suction(true),
//!     words::wait(std::time::Duration::from_millis(300)),
//!     words::jump_to(220.0, -40.0, -30.0, 0.0),
//!     words::suction(false),
//! ];
//! assert_eq!(pick.len(), 5);
//! ```

use std::time::Duration;

use magician_motion::ToolBias;
use magician_protocol::commands::{
    ArcCmd, ArcParams, CircleCmd, CpCmd, CpLeCmd, CpParams, EMotor, EMotorS, EndEffectorParams,
    HomeCmd, HomeParams, IoDo, IoMultiplexing, IoPwm, JogCmd, JogCommonParams, LostStepCmd, PtpCmd,
    PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpJump2Params, PtpJumpParams,
    PtpWithLCmd, SetColorSensor, SetDeviceWithL, SetEndEffectorGripper, SetEndEffectorLaser,
    SetEndEffectorSuctionCup, SetIrSwitch, TrigCmd, WaitCmd,
};
use magician_protocol::{
    CpMode, Flag, IoFunction, JogCommand, Port, PtpMode, RailVersion, SensorVersion, Set, Stepper,
    TriggerCondition, TriggerMode,
};

pub use crate::preflight::Preflight;
use crate::{Error, Result};

fn ptp(ptp_mode: PtpMode, [x, y, z, r]: [f32; 4]) -> Set {
    PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
    .into()
}

/// Goes to a pose, all joints together; the tool's way is a curve.
#[must_use]
pub fn move_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::MovjXyz, [x, y, z, r])
}

/// Goes to a pose on a straight line.
#[must_use]
pub fn line_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::MovlXyz, [x, y, z, r])
}

/// Goes to a pose over obstacles: up, across with all joints together, down. [`jump_height`] says
/// how high.
#[must_use]
pub fn jump_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::JumpXyz, [x, y, z, r])
}

/// As [`jump_to`], across on a straight line (errata E28: seen to do nothing on some firmware).
#[must_use]
pub fn jump_line_to(x: f32, y: f32, z: f32, r: f32) -> Set {
    ptp(PtpMode::JumpMovlXyz, [x, y, z, r])
}

/// Goes to joint angles.
#[must_use]
pub fn move_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::MovjAngle, [j1, j2, j3, j4])
}

/// Goes to joint angles with the tool on a straight line.
#[must_use]
pub fn line_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::MovlAngle, [j1, j2, j3, j4])
}

/// Goes to joint angles over obstacles.
#[must_use]
pub fn jump_joints(j1: f32, j2: f32, j3: f32, j4: f32) -> Set {
    ptp(PtpMode::JumpAngle, [j1, j2, j3, j4])
}

/// Moves by so much from where the arm then is, all joints together.
#[must_use]
pub fn move_by(dx: f32, dy: f32, dz: f32, dr: f32) -> Set {
    ptp(PtpMode::MovjXyzInc, [dx, dy, dz, dr])
}

/// Moves by so much from where the arm then is, on a straight line.
#[must_use]
pub fn line_by(dx: f32, dy: f32, dz: f32, dr: f32) -> Set {
    ptp(PtpMode::MovlXyzInc, [dx, dy, dz, dr])
}

/// Turns the joints by so much from where they then are.
#[must_use]
pub fn move_joints_by(d1: f32, d2: f32, d3: f32, d4: f32) -> Set {
    ptp(PtpMode::MovjAngleInc, [d1, d2, d3, d4])
}

/// Goes to a pose and to `l` mm on the rail (0 to 1000) at the same time.
#[must_use]
pub fn move_with_rail(x: f32, y: f32, z: f32, r: f32, l: f32) -> Set {
    let ptp_mode = PtpMode::MovjXyz;
    PtpWithLCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
        l,
    }
    .into()
}

/// Goes to `to` along the arc through `via`; both are x, y, z, r, and the r of `via` is ignored.
#[must_use]
pub fn arc_to(via: [f32; 4], to: [f32; 4]) -> Set {
    ArcCmd {
        cir_point: via,
        to_point: to,
    }
    .into()
}

/// Goes round the circle through here, `via` and `over`, so many turns.
#[must_use]
pub fn circle(via: [f32; 4], over: [f32; 4], turns: u32) -> Set {
    CircleCmd {
        cir_point: via,
        to_point: over,
        count: turns,
    }
    .into()
}

/// Adds a segment to a continuous path, to a point; the tool does not stop between segments that
/// follow each other, and J4 does not turn.
#[must_use]
pub fn path_to(x: f32, y: f32, z: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Absolute, 0.0);
    CpCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    }
    .into()
}

/// Adds a segment to a continuous path, by so much from the end of the one before.
#[must_use]
pub fn path_by(dx: f32, dy: f32, dz: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Relative, 0.0);
    CpCmd {
        cp_mode,
        x: dx,
        y: dy,
        z: dz,
        velocity_or_power,
    }
    .into()
}

/// As [`path_to`], with the laser at so many percent on the way.
#[must_use]
pub fn engrave_to(x: f32, y: f32, z: f32, power: f32) -> Set {
    let (cp_mode, velocity_or_power) = (CpMode::Absolute, power);
    CpLeCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    }
    .into()
}

/// Finds the reference of J1 and goes to the home point. [`Arm::home`](crate::Arm::home) also waits
/// and clears the alarm that the arm raises when it is switched on.
#[must_use]
pub fn home() -> Set {
    HomeCmd { reserved: 0 }.into()
}

/// Sets the home point.
#[must_use]
pub fn home_at(x: f32, y: f32, z: f32, r: f32) -> Set {
    HomeParams { x, y, z, r }.into()
}

/// Tells the arm where the tool sits; poses count from there on.
#[must_use]
pub fn tool(bias: ToolBias) -> Set {
    EndEffectorParams {
        x_bias: bias.x as f32,
        y_bias: bias.y as f32,
        z_bias: bias.z as f32,
    }
    .into()
}

/// As [`tool`], by name: `none`, `suction`, `gripper`, `pen`, `laser`.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) for another name; it lists these.
pub fn tool_named(name: &str) -> Result<Set> {
    ToolBias::named(name).map(tool).ok_or_else(|| {
        let names: Vec<_> = ToolBias::NAMED.iter().map(|(name, _)| *name).collect();
        Error::invalid(format!(
            "there is no tool `{name}`; there are {}",
            names.join(", ")
        ))
    })
}

/// Share of the set speeds and accelerations that point-to-point moves use, percent.
#[must_use]
pub fn speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    PtpCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}

/// Speeds (deg/s) and accelerations (deg/s2) of J1 to J4 in point-to-point moves.
#[must_use]
pub fn joint_speed(velocity: [f32; 4], acceleration: [f32; 4]) -> Set {
    PtpJointParams {
        velocity,
        acceleration,
    }
    .into()
}

/// Speed (mm/s) and acceleration (mm/s2) of the tool on straight lines; its rotation has half of
/// each in degrees, as at power-up.
#[must_use]
pub fn line_speed(velocity: f32, acceleration: f32) -> Set {
    PtpCoordinateParams {
        xyz_velocity: velocity,
        r_velocity: velocity / 2.0,
        xyz_acceleration: acceleration,
        r_acceleration: acceleration / 2.0,
    }
    .into()
}

/// Most speed (mm/s) and acceleration (mm/s2) on a continuous path.
#[must_use]
pub fn path_speed(velocity: f32, acceleration: f32) -> Set {
    CpParams {
        plan_acc: acceleration,
        junction_vel: velocity,
        acc_or_period: acceleration,
        real_time_track: Flag::OFF,
    }
    .into()
}

/// Speed (mm/s) and acceleration (mm/s2) on arcs and circles, and of the rotation (deg/s, deg/s2).
#[must_use]
pub fn arc_speed(velocity: f32, acceleration: f32) -> Set {
    ArcParams {
        xyz_velocity: velocity,
        r_velocity: velocity,
        xyz_acceleration: acceleration,
        r_acceleration: acceleration,
    }
    .into()
}

/// How far a jump lifts above the higher of its ends, and the z it stays below.
#[must_use]
pub fn jump_height(height: f32, z_limit: f32) -> Set {
    PtpJumpParams {
        jump_height: height,
        z_limit,
    }
    .into()
}

/// How far a jump lifts above its start and above its end, and the z it stays below.
#[must_use]
pub fn jump_heights(start: f32, end: f32, z_limit: f32) -> Set {
    PtpJump2Params {
        start_jump_height: start,
        end_jump_height: end,
        z_limit,
    }
    .into()
}

/// Share of the set jog speeds and accelerations, percent.
#[must_use]
pub fn jog_speed(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
    JogCommonParams {
        velocity_ratio,
        acceleration_ratio,
    }
    .into()
}

/// Moves a joint until told to stop: send it at once, not through the queue, and end it with
/// [`Arm::stop_jog`](crate::Arm::stop_jog).
#[must_use]
pub fn jog_joint(direction: JogCommand) -> Set {
    JogCmd {
        is_joint: Flag::ON,
        cmd: direction,
    }
    .into()
}

/// As [`jog_joint`], along a coordinate.
#[must_use]
pub fn jog_axis(direction: JogCommand) -> Set {
    JogCmd {
        is_joint: Flag::OFF,
        cmd: direction,
    }
    .into()
}

/// Makes the queue wait, to the millisecond and for at most 49 days.
#[must_use]
pub fn wait(time: Duration) -> Set {
    let timeout = u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
    WaitCmd { timeout }.into()
}

/// Makes the queue wait until a digital input has this level, for ever if need be.
#[must_use]
pub fn wait_for_level(address: u8, level: bool) -> Set {
    TrigCmd {
        address,
        mode: TriggerMode::Level,
        condition: TriggerCondition::EqualOrBelow,
        threshold: level.into(),
    }
    .into()
}

/// Makes the queue wait until an analog input (0 to 4095) compares so, for ever if need be.
#[must_use]
pub fn wait_for_analog(address: u8, condition: TriggerCondition, threshold: u16) -> Set {
    let mode = TriggerMode::Analog;
    TrigCmd {
        address,
        mode,
        condition,
        threshold,
    }
    .into()
}

/// Sucks, or lets go.
#[must_use]
pub fn suction(on: bool) -> Set {
    SetEndEffectorSuctionCup {
        enable_ctrl: Flag::ON,
        suck: on.into(),
    }
    .into()
}

/// Closes the gripper.
#[must_use]
pub fn grip() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::ON,
        grip: Flag::ON,
    }
    .into()
}

/// Opens the gripper.
#[must_use]
pub fn release() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::ON,
        grip: Flag::OFF,
    }
    .into()
}

/// Switches the air pump off; suction cup and gripper go limp (model section 13).
#[must_use]
pub fn pump_off() -> Set {
    SetEndEffectorGripper {
        enable_ctrl: Flag::OFF,
        grip: Flag::OFF,
    }
    .into()
}

/// Switches the laser.
#[must_use]
pub fn laser(on: bool) -> Set {
    SetEndEffectorLaser {
        enable_ctrl: on.into(),
        on: on.into(),
    }
    .into()
}

/// Says what an EIO pin (1 to 20) does; a pin must be told before it is used.
#[must_use]
pub fn multiplex(address: u8, function: IoFunction) -> Set {
    IoMultiplexing {
        address,
        multiplex: function,
    }
    .into()
}

/// Sets the level of a digital output.
#[must_use]
pub fn output(address: u8, high: bool) -> Set {
    IoDo {
        address,
        level: high.into(),
    }
    .into()
}

/// Sets a pulse-width output: Hz (10 to 1000000), and percent of the time that it is high.
#[must_use]
pub fn pwm(address: u8, frequency: f32, duty_cycle: f32) -> Set {
    IoPwm {
        address,
        frequency,
        duty_cycle,
    }
    .into()
}

/// Runs an external motor at so many pulses a second; 0 stops it. The sign is the direction.
#[must_use]
pub fn motor(index: Stepper, speed: i32) -> Set {
    EMotor {
        index,
        is_enabled: (speed != 0).into(),
        speed,
    }
    .into()
}

/// Runs an external motor so many pulses far.
#[must_use]
pub fn motor_by(index: Stepper, speed: i32, distance: u32) -> Set {
    EMotorS {
        index,
        is_enabled: Flag::ON,
        speed,
        distance,
    }
    .into()
}

/// Switches the colour sensor on a port.
#[must_use]
pub fn color_sensor(port: Port, on: bool, version: SensorVersion) -> Set {
    SetColorSensor {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Switches the infrared sensor on a port.
#[must_use]
pub fn infrared(port: Port, on: bool, version: SensorVersion) -> Set {
    SetIrSwitch {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Says whether the arm stands on a rail.
#[must_use]
pub fn rail(on: bool, version: RailVersion) -> Set {
    SetDeviceWithL {
        with_l: on.into(),
        version: Some(version),
    }
    .into()
}

/// Compares the joints with their sensors; a lost step raises an alarm (errata E36).
#[must_use]
pub fn check_lost_steps() -> Set {
    LostStepCmd {}.into()
}

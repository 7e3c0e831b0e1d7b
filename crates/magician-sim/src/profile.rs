//! The firmware profile: what the controller knows at power-up and how it decides where nothing is documented.
//!
//! A profile is a data file; the one of firmware 3.6.14 is built in. Each of its values carries its source.

use std::sync::LazyLock;

use magician_motion::{JointAngles, Limits, Range, ToolBias};
use serde::Deserialize;

mod check;
mod tool;

const MAGICIAN_3_6_14: &str = include_str!("../profiles/magician-3.6.14.toml");

/// Longest name that the arm keeps, bytes (model section 15).
pub(crate) const MAX_NAME: usize = 64;
/// Longest serial number that the arm keeps, bytes (model section 15).
pub(crate) const MAX_SERIAL: usize = 23;
/// Longest program that a flash may hold, whatever its profile says.
pub(crate) const MAX_LINES: usize = 65_536;
/// EIO addresses run from 1 to this (model section 13).
pub(crate) const PINS: usize = 20;

/// Why a firmware profile cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ProfileError {
    /// It is not TOML, lacks a value or has one that is not known.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// The line, from 1.
        line: usize,
        /// The column in characters, from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// A value makes no sense.
    #[error("{name} is {value}, it must be {rule}")]
    Value {
        /// Which value, as in the file: `queue.depth`.
        name: &'static str,
        /// What it is.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
}

/// Everything that makes one firmware differ from another, and every choice that a scenario may want to change.
///
/// [`Profile::default`] is firmware 3.6.14; [`Profile::from_toml`] reads another. The built-in file, with the source
/// of each value, is [`Profile::BUILT_IN`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Who the arm says it is.
    pub identity: Identity,
    /// How it wakes.
    pub power_up: PowerUp,
    /// The command queue.
    pub queue: QueueRules,
    /// The joint limits.
    pub limits: LimitSets,
    /// The fastest that a motion is planned.
    pub ceilings: Ceilings,
    /// Homing.
    pub home: Homing,
    /// Continuous paths.
    pub path: Paths,
    /// Stopping.
    pub stop: Stopping,
    /// The sliding rail.
    pub rail: Sliding,
    /// Hand teaching.
    pub teach: HandTeaching,
    /// Programs in the flash.
    pub offline: Offline,
    /// The Wi-Fi module.
    pub wifi: Wifi,
    /// Suction cup and gripper.
    pub tools: Tools,
    /// The connectors' pins.
    pub io: Pins,
    /// What to do where only a choice exists.
    pub fidelity: FidelityRules,
    /// What a host reads before it has set anything.
    pub defaults: Defaults,
}

/// What to do where nobody knows what the real arm does ([`fidelity`](crate::fidelity)).
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FidelityRules {
    /// Whether what rests on a choice alone is refused: answered, and not carried out.
    pub strict: bool,
}

/// Who the arm says it is (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Firmware version.
    pub version: [u8; 3],
    /// Name, at most 64 bytes.
    pub name: String,
    /// Serial number, at most 23 bytes.
    pub serial: String,
    /// The three words of GetDeviceID are drawn from it.
    pub device_id_seed: u64,
}

/// How the controller wakes (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerUp {
    /// The joints it reports before homing, deg.
    pub joints: [f64; 4],
    /// The tool bias that was chosen before and is kept, mm; in the file, the name of a tool or `[x, y, z]`. A scenario
    /// that says what tool is on the arm goes before it.
    #[serde(deserialize_with = "tool::read")]
    pub tool: ToolBias,
    /// Whether alarm 0x00 stands.
    pub reset_alarm: bool,
    /// Whether the queue runs without a start.
    pub queue_started: bool,
}

/// How the command queue behaves (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QueueRules {
    /// Places, the running command's included; 1 to 1024.
    pub depth: usize,
    /// The index of the first command, at least 1.
    pub first_index: u64,
    /// Whether an alarm above 0x07 holds the queue.
    pub alarms_hold: bool,
    /// Whether Clear ends the running motion on the spot.
    pub clear_ends_motion: bool,
}

/// Which joint limits are in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LimitChoice {
    /// The controller's soft limits.
    Controller,
    /// The range that the vendor guarantees.
    Guaranteed,
}

/// The joint limits (model section 4).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitSets {
    /// Which set is in force.
    #[serde(rename = "use")]
    pub in_force: LimitChoice,
    /// The controller's soft limits.
    pub controller: LimitSet,
    /// The range that the vendor guarantees.
    pub guaranteed: LimitSet,
}

/// Ten bounds: least and greatest of each, deg.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitSet {
    /// Base.
    pub j1: [f64; 2],
    /// Rear arm.
    pub j2: [f64; 2],
    /// Forearm.
    pub j3: [f64; 2],
    /// End servo.
    pub j4: [f64; 2],
    /// The coupling of rear arm and forearm.
    pub j2_minus_j3: [f64; 2],
}

/// More than this counts as this when a motion is planned (model section 6). The values of the built-in profile are the
/// planner's own; a profile can only lower them: one that raises them is refused.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ceilings {
    /// Of J1 to J4, deg/s.
    pub joint_velocity: [f64; 4],
    /// Of every joint, deg/s2.
    pub joint_acceleration: f64,
    /// Along a path, mm/s.
    pub linear_velocity: f64,
    /// Along a path, mm/s2.
    pub linear_acceleration: f64,
    /// Of r along a path, deg/s.
    pub rotation_velocity: f64,
    /// Of r along a path, deg/s2.
    pub rotation_acceleration: f64,
}

/// Homing (model section 11).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Homing {
    /// The home point until a host sets one, deg.
    pub joints: [f64; 4],
    /// Speed of the joint move to the home point, deg/s; no ratio scales it.
    pub velocity: [f64; 4],
    /// Its acceleration, deg/s2.
    pub acceleration: [f64; 4],
    /// Where the base stands when the switch of J1 closes, deg.
    pub switch: f64,
    /// Speed of the base towards the switch and off it again, deg/s. Its acceleration is that of J1 above.
    pub search: f64,
    /// How far the base backs off from the switch, deg.
    pub back_off: f64,
    /// Speeds at which it creeps on, each for half of the way back, deg/s.
    pub creep: [f64; 2],
}

/// Continuous paths (model section 8).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paths {
    /// The interpolation period that limits the speed at corners, s.
    pub period: f64,
    /// Whether a segment takes whole periods, so that a short one is slow.
    pub whole_periods: bool,
}

/// Stopping (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// ForceStop brakes with this many times the acceleration in force; above 0.
    pub force_factor: f64,
}

/// The sliding rail (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sliding {
    /// How far the carriage can go, mm; above 0.
    pub length: f64,
    /// How fast it homes, mm/s; no ratio scales it.
    pub home_velocity: f64,
    /// Its acceleration when it homes, mm/s2.
    pub home_acceleration: f64,
}

/// Hand teaching (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandTeaching {
    /// From point to point while the unlock key is held and points are taught periodically, s; above 0.
    pub period: f64,
}

/// The Wi-Fi module (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wifi {
    /// From power-up, or from when it leaves its command mode, until it has joined its network, s.
    pub association: f64,
}

/// Programs in the flash, which the arm runs without a host (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Offline {
    /// Commands that a program may have, 1 to 65536.
    pub capacity: usize,
}

/// Suction cup and gripper (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tools {
    /// From the command until the suction cup holds or lets go, s.
    pub vacuum_delay: f64,
    /// From the command until the gripper is closed or open, s.
    pub gripper_delay: f64,
}

/// The pins of the connectors (model section 13).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pins {
    /// Whether a function that the pin lacks is refused; else it is stored and has no effect.
    pub strict: bool,
    /// What each of the 20 addresses can do.
    pub pins: Vec<PinFunctions>,
}

/// What one pin can do: in the file, words out of `DO`, `PWM`, `DI` and `ADC`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct PinFunctions {
    /// Digital output.
    pub digital_output: bool,
    /// Pulse-width output.
    pub pwm: bool,
    /// Digital input.
    pub digital_input: bool,
    /// Analog input.
    pub analog_input: bool,
}

impl TryFrom<String> for PinFunctions {
    type Error = String;

    fn try_from(words: String) -> Result<Self, String> {
        let mut pin = Self::default();
        for word in words.split_whitespace() {
            match word {
                "DO" => pin.digital_output = true,
                "PWM" => pin.pwm = true,
                "DI" => pin.digital_input = true,
                "ADC" => pin.analog_input = true,
                other => return Err(format!("a pin is DO, PWM, DI or ADC, not {other}")),
            }
        }
        Ok(pin)
    }
}

/// What a host reads before it has set anything (model section 6). Kept as the wire has it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Defaults {
    /// Jogging.
    pub jog: JogDefaults,
    /// Point to point.
    pub ptp: PtpDefaults,
    /// Continuous path.
    pub cp: CpDefaults,
    /// Arcs.
    pub arc: ArcDefaults,
    /// Lost steps.
    pub lost_step: LostStepDefaults,
    /// The Wi-Fi module.
    pub wifi: WifiDefaults,
}

/// Jog speeds: deg/s, mm/s, percent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct JogDefaults {
    pub joint_velocity: [f32; 4],
    pub joint_acceleration: [f32; 4],
    pub coordinate_velocity: [f32; 4],
    pub coordinate_acceleration: [f32; 4],
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub rail_velocity: f32,
    pub rail_acceleration: f32,
}

/// Point-to-point speeds and jump heights: deg/s, mm/s, percent, mm.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PtpDefaults {
    pub joint_velocity: [f32; 4],
    pub joint_acceleration: [f32; 4],
    pub linear_velocity: f32,
    pub linear_acceleration: f32,
    pub rotation_velocity: f32,
    pub rotation_acceleration: f32,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub jump_height: f32,
    pub z_limit: f32,
    pub rail_velocity: f32,
    pub rail_acceleration: f32,
}

/// Continuous-path speeds: mm/s, mm/s2, percent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct CpDefaults {
    pub plan_acceleration: f32,
    pub junction_velocity: f32,
    pub acceleration: f32,
    pub real_time_track: bool,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub hold_rotation: bool,
}

/// Arc speeds: mm/s, deg/s, percent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ArcDefaults {
    pub linear_velocity: f32,
    pub linear_acceleration: f32,
    pub rotation_velocity: f32,
    pub rotation_acceleration: f32,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
}

/// The lost-step threshold, deg.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct LostStepDefaults {
    pub threshold: f32,
}

/// The settings of the Wi-Fi module.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct WifiDefaults {
    pub ssid: String,
    pub password: String,
    pub dhcp: bool,
    pub address: [u8; 4],
    pub netmask: [u8; 4],
    pub gateway: [u8; 4],
    pub dns: [u8; 4],
}

impl Default for Profile {
    /// Firmware 3.6.14.
    fn default() -> Self {
        static PARSED: LazyLock<Profile> = LazyLock::new(|| {
            Profile::from_toml(MAGICIAN_3_6_14).expect("the built-in profile is tested")
        });
        PARSED.clone()
    }
}

impl Profile {
    /// The text of the built-in profile, the pattern for another.
    pub const BUILT_IN: &str = MAGICIAN_3_6_14;

    /// Reads a profile. Every value must be there, and none that is not known.
    ///
    /// # Errors
    /// [`ProfileError`] for text that is no profile, or values that make no sense.
    pub fn from_toml(text: &str) -> Result<Self, ProfileError> {
        let syntax = |error: toml::de::Error| {
            let (line, column, message) = crate::document::flaw(text, &error);
            ProfileError::Syntax {
                line,
                column,
                message,
            }
        };
        let profile: Self = toml::from_str(text).map_err(syntax)?;
        profile.check()?;
        Ok(profile)
    }

    /// The joint limits in force.
    #[must_use]
    pub fn limits_in_force(&self) -> Limits {
        match self.limits.in_force {
            LimitChoice::Controller => self.limits.controller.limits(),
            LimitChoice::Guaranteed => self.limits.guaranteed.limits(),
        }
    }

    /// The home point until a host sets one.
    pub(crate) fn home_joints(&self) -> JointAngles {
        JointAngles::from(self.home.joints)
    }
}

impl LimitSet {
    /// The bounds as the motion planner takes them.
    #[must_use]
    pub fn limits(&self) -> Limits {
        let range = |[min, max]: [f64; 2]| Range::new(min, max);
        Limits {
            j1: range(self.j1),
            j2: range(self.j2),
            j3: range(self.j3),
            j4: range(self.j4),
            j2_minus_j3: range(self.j2_minus_j3),
        }
    }
}

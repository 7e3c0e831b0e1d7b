//! The firmware profile: what the controller knows at power-up and how it decides where nothing is documented.
//!
//! A profile is a data file; the one of firmware 3.6.14 is built in. Each of its values carries its source.

use std::sync::LazyLock;

use magician_motion::{JointAngles, Limits, Range};
use serde::Deserialize;

const MAGICIAN_3_6_14: &str = include_str!("../profiles/magician-3.6.14.toml");

/// Longest name that the arm keeps, bytes (model section 15).
pub(crate) const MAX_NAME: usize = 64;
/// Longest serial number that the arm keeps, bytes (model section 15).
pub(crate) const MAX_SERIAL: usize = 23;
/// EIO addresses run from 1 to this (model section 13).
pub(crate) const PINS: usize = 20;
/// The planner brakes with no more than this many times the acceleration.
const MAX_FORCE_FACTOR: f64 = 2.0;
/// Deepest queue that a profile may ask for; it bounds the controller's memory.
const MAX_DEPTH: usize = 1024;

/// Why a firmware profile cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ProfileError {
    /// It is not TOML, lacks a value or has one that is not known; the message names the line.
    #[error("{0}")]
    Syntax(#[from] toml::de::Error),
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
    /// Stopping.
    pub stop: Stopping,
    /// Suction cup and gripper.
    pub tools: Tools,
    /// The connectors' pins.
    pub io: Pins,
    /// What a host reads before it has set anything.
    pub defaults: Defaults,
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
/// planner's own; a profile can only lower them.
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
    /// How long the search for J1's switch takes before that move, s.
    pub search: f64,
}

/// Stopping (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// ForceStop brakes with this many times the acceleration that is set; above 0, at most 2.
    pub force_factor: f64,
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
    /// The tool.
    pub tool: ToolDefaults,
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

/// The tool bias, mm.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ToolDefaults {
    pub bias: [f32; 3],
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
    pub connected: bool,
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
        let profile: Self = toml::from_str(text)?;
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

    /// Whether the values make sense: no NaN, nothing negative that must not be, lists of the right length. Needed
    /// only for a profile that was changed by hand; [`from_toml`](Self::from_toml) has done it.
    ///
    /// # Errors
    /// [`ProfileError::Value`] for the first that does not.
    pub fn check(&self) -> Result<(), ProfileError> {
        self.check_text()?;
        self.check_queue()?;
        self.limits.controller.check("limits.controller")?;
        self.limits.guaranteed.check("limits.guaranteed")?;
        finite("power_up.joints", &self.power_up.joints)?;
        finite("home.joints", &self.home.joints)?;
        self.check_speeds()?;
        self.check_numbers()?;
        duration("home.search", self.home.search)?;
        duration("tools.vacuum_delay", self.tools.vacuum_delay)?;
        duration("tools.gripper_delay", self.tools.gripper_delay)?;
        let pins = self.io.pins.len();
        rule(pins == PINS, "io.pins", pins, "a list of 20 pins")
    }

    fn check_text(&self) -> Result<(), ProfileError> {
        let texts: [(_, &str, usize, _); 4] = [
            (
                "identity.name",
                &self.identity.name,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
            (
                "identity.serial",
                &self.identity.serial,
                MAX_SERIAL,
                "text of at most 23 bytes without NUL",
            ),
            (
                "defaults.wifi.ssid",
                &self.defaults.wifi.ssid,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
            (
                "defaults.wifi.password",
                &self.defaults.wifi.password,
                MAX_NAME,
                "text of at most 64 bytes without NUL",
            ),
        ];
        for (name, text, max, wanted) in texts {
            let good = text.len() <= max && !text.contains('\0');
            rule(good, name, format!("{text:?}"), wanted)?;
        }
        Ok(())
    }

    fn check_queue(&self) -> Result<(), ProfileError> {
        let QueueRules {
            depth, first_index, ..
        } = self.queue;
        rule(
            (1..=MAX_DEPTH).contains(&depth),
            "queue.depth",
            depth,
            "1 to 1024",
        )?;
        rule(
            first_index >= 1,
            "queue.first_index",
            first_index,
            "at least 1",
        )
    }

    fn check_speeds(&self) -> Result<(), ProfileError> {
        let Ceilings {
            joint_velocity,
            joint_acceleration,
            linear_velocity,
            linear_acceleration,
            rotation_velocity,
            rotation_acceleration,
        } = self.ceilings;
        positive("ceilings.joint_velocity", &joint_velocity)?;
        positive("ceilings.joint_acceleration", &[joint_acceleration])?;
        positive("ceilings.linear_velocity", &[linear_velocity])?;
        positive("ceilings.linear_acceleration", &[linear_acceleration])?;
        positive("ceilings.rotation_velocity", &[rotation_velocity])?;
        positive("ceilings.rotation_acceleration", &[rotation_acceleration])?;
        positive("home.velocity", &self.home.velocity)?;
        positive("home.acceleration", &self.home.acceleration)?;
        let factor = self.stop.force_factor;
        rule(
            factor > 0.0 && factor <= MAX_FORCE_FACTOR,
            "stop.force_factor",
            factor,
            "above 0 and at most 2",
        )?;
        let Defaults { jog, ptp, .. } = &self.defaults;
        positive32("defaults.jog.joint_velocity", &jog.joint_velocity)?;
        positive32("defaults.jog.joint_acceleration", &jog.joint_acceleration)?;
        positive32("defaults.jog.coordinate_velocity", &jog.coordinate_velocity)?;
        positive32(
            "defaults.jog.coordinate_acceleration",
            &jog.coordinate_acceleration,
        )?;
        positive32("defaults.ptp.joint_velocity", &ptp.joint_velocity)?;
        positive32("defaults.ptp.joint_acceleration", &ptp.joint_acceleration)?;
        for (name, value) in self.scalar_speeds() {
            positive32(name, &[value])?;
        }
        Ok(())
    }

    /// Numbers that may have any sign.
    fn check_numbers(&self) -> Result<(), ProfileError> {
        let Defaults {
            ptp,
            cp,
            tool,
            lost_step,
            ..
        } = &self.defaults;
        let numbers: [(_, &[f32]); 7] = [
            ("defaults.ptp.jump_height", &[ptp.jump_height]),
            ("defaults.ptp.z_limit", &[ptp.z_limit]),
            ("defaults.cp.acceleration", &[cp.acceleration]),
            ("defaults.cp.velocity_ratio", &[cp.velocity_ratio]),
            ("defaults.cp.acceleration_ratio", &[cp.acceleration_ratio]),
            ("defaults.tool.bias", &tool.bias),
            ("defaults.lost_step.threshold", &[lost_step.threshold]),
        ];
        for (name, values) in numbers {
            let good = values.iter().all(|value| value.is_finite());
            rule(good, name, format!("{values:?}"), "finite")?;
        }
        Ok(())
    }

    fn scalar_speeds(&self) -> [(&'static str, f32); 20] {
        let Defaults {
            jog, ptp, cp, arc, ..
        } = &self.defaults;
        [
            ("defaults.jog.velocity_ratio", jog.velocity_ratio),
            ("defaults.jog.acceleration_ratio", jog.acceleration_ratio),
            ("defaults.jog.rail_velocity", jog.rail_velocity),
            ("defaults.jog.rail_acceleration", jog.rail_acceleration),
            ("defaults.ptp.linear_velocity", ptp.linear_velocity),
            ("defaults.ptp.linear_acceleration", ptp.linear_acceleration),
            ("defaults.ptp.rotation_velocity", ptp.rotation_velocity),
            (
                "defaults.ptp.rotation_acceleration",
                ptp.rotation_acceleration,
            ),
            ("defaults.ptp.velocity_ratio", ptp.velocity_ratio),
            ("defaults.ptp.acceleration_ratio", ptp.acceleration_ratio),
            ("defaults.ptp.rail_velocity", ptp.rail_velocity),
            ("defaults.ptp.rail_acceleration", ptp.rail_acceleration),
            ("defaults.cp.plan_acceleration", cp.plan_acceleration),
            ("defaults.cp.junction_velocity", cp.junction_velocity),
            ("defaults.arc.linear_velocity", arc.linear_velocity),
            ("defaults.arc.linear_acceleration", arc.linear_acceleration),
            ("defaults.arc.rotation_velocity", arc.rotation_velocity),
            (
                "defaults.arc.rotation_acceleration",
                arc.rotation_acceleration,
            ),
            ("defaults.arc.velocity_ratio", arc.velocity_ratio),
            ("defaults.arc.acceleration_ratio", arc.acceleration_ratio),
        ]
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

    fn check(&self, name: &'static str) -> Result<(), ProfileError> {
        for [min, max] in [self.j1, self.j2, self.j3, self.j4, self.j2_minus_j3] {
            let good = min.is_finite() && max.is_finite() && min < max;
            rule(
                good,
                name,
                format!("[{min}, {max}]"),
                "pairs of numbers, the smaller first",
            )?;
        }
        Ok(())
    }
}

fn rule(
    good: bool,
    name: &'static str,
    value: impl ToString,
    rule: &'static str,
) -> Result<(), ProfileError> {
    if good {
        return Ok(());
    }
    let value = value.to_string();
    Err(ProfileError::Value { name, value, rule })
}

fn finite(name: &'static str, values: &[f64]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite());
    rule(good, name, format!("{values:?}"), "finite numbers")
}

fn positive(name: &'static str, values: &[f64]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite() && *value > 0.0);
    rule(good, name, format!("{values:?}"), "above 0")
}

fn positive32(name: &'static str, values: &[f32]) -> Result<(), ProfileError> {
    let good = values.iter().all(|value| value.is_finite() && *value > 0.0);
    rule(good, name, format!("{values:?}"), "above 0")
}

fn duration(name: &'static str, seconds: f64) -> Result<(), ProfileError> {
    rule(
        (0.0..=3600.0).contains(&seconds),
        name,
        seconds,
        "0 to 3600 seconds",
    )
}

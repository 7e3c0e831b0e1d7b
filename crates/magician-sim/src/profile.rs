//! The firmware profile: all values at power-up, and every choice made where no document describes
//! the behaviour.
//!
//! Firmware 3.6.14 is built in. A profile file is a patch: it gives only the values that differ.
//! The planning numbers become an [`ArmModel`](magician_motion::ArmModel), which the host's checks
//! use too; `pattern.txt` rates each value by its source.

use magician_motion::{Ceilings, Homing, Paths, Rail};
use serde::{Deserialize, Serialize};

mod arm;
mod check;
mod numbered;
mod pattern;
mod sections;
mod tool;

pub(crate) use numbered::serial_at;

pub use arm::{Defaults, JogAxisChange, LimitChoice, LimitSets, MotionRules};
pub use sections::{
    FidelityRules, HandTeaching, Identity, LostStepDefaults, Offline, PinFunctions, Pins, PowerUp,
    QueueRules, Stopping, Tools, Wifi, WifiDefaults,
};

/// Longest name, bytes (model section 15).
pub(crate) const MAX_NAME: usize = 64;
/// Longest serial number, bytes (model section 15).
pub(crate) const MAX_SERIAL: usize = 23;
/// Longest stored program, in commands, whatever the profile says. Choice: bounds the memory of an
/// arm to a few megabytes, and is far above the length of any known program.
pub(crate) const MAX_STORED_COMMANDS: usize = 65_536;
/// Number of EIO addresses; they run from 1 to this (model section 13).
pub(crate) const PINS: usize = 20;

/// Index of an EIO address in the list of pins; `None` if there is no such pin.
pub(crate) fn pin_index(address: u8) -> Option<usize> {
    usize::from(address).checked_sub(1).filter(|at| *at < PINS)
}

/// Reason why a firmware profile is invalid.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// Not valid TOML, or an unknown key.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Description of the error.
        message: String,
    },
    /// A value is out of range.
    #[error("{name} is {value}, it must be {rule}")]
    Value {
        /// Key in the file: `queue.depth`.
        name: &'static str,
        /// Value found.
        value: String,
        /// Rule that the value breaks.
        rule: &'static str,
    },
}

/// Values in which firmwares differ, and every choice that a scenario may want to change.
///
/// [`Profile::default`] is firmware 3.6.14; [`Profile::from_toml`] reads the values that differ.
/// [`Profile::pattern`] is a complete file with the source of each value.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Profile {
    /// Identity of the arm.
    pub identity: Identity,
    /// State at power-up.
    pub power_up: PowerUp,
    /// Command queue.
    pub queue: QueueRules,
    /// Joint limits.
    pub limits: LimitSets,
    /// Ceilings of speeds and accelerations.
    pub ceilings: Ceilings,
    /// Homing.
    pub home: Homing,
    /// Law of motion.
    pub motion: MotionRules,
    /// Continuous paths.
    pub path: Paths,
    /// Stops.
    pub stop: Stopping,
    /// Sliding rail.
    pub rail: Rail,
    /// Hand teaching.
    pub teach: HandTeaching,
    /// Programs stored in the flash.
    pub offline: Offline,
    /// Wi-Fi module.
    pub wifi: Wifi,
    /// Suction cup and gripper.
    pub tools: Tools,
    /// Pins of the connectors.
    pub io: Pins,
    /// Handling of assumptions without a source.
    pub fidelity: FidelityRules,
    /// Settings that a host reads before it has set any.
    pub defaults: Defaults,
}

impl Profile {
    /// Firmware 3.6.14 in continuous time, where a jog comes to rest before another axis is jogged.
    ///
    /// Simpler than recorded real arms; for comparison with closed-form functions of time.
    #[must_use]
    pub fn continuous() -> Self {
        Self {
            motion: MotionRules {
                period: 0.0,
                jog_axis_change: JogAxisChange::Stops,
                ..MotionRules::default()
            },
            ..Self::default()
        }
    }

    /// Names of the built-in profiles, each with a description.
    pub const NAMED: [(&str, &str); 4] = [
        ("3.6.14", "firmware of the vendor's documents (default)"),
        (
            "3.7.0",
            "firmware found in the field; only its version number is known to differ",
        ),
        (
            "4.0.3",
            "firmware found in the field; only its version number is known to differ",
        ),
        (
            "continuous",
            "3.6.14 in continuous time, where a jog stops before another axis is jogged; for comparison",
        ),
    ];

    /// Returns a built-in profile; `None` if the name is unknown.
    ///
    /// ```
    /// use magician_sim::Profile;
    ///
    /// let newer = Profile::named("4.0.3").expect("built in");
    /// assert_eq!(newer.identity.version, [4, 0, 3]);
    /// assert!(Profile::NAMED.iter().all(|(name, _)| Profile::named(name).is_some()));
    /// assert_eq!(Profile::named("5.0.0"), None);
    /// ```
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let version = |version| {
            let mut profile = Self::default();
            profile.identity.version = version;
            profile
        };
        Some(match name {
            "3.6.14" => Self::default(),
            "3.7.0" => version([3, 7, 0]),
            "4.0.3" => version([4, 0, 3]),
            "continuous" => Self::continuous(),
            // Names come from users: an unknown one is an error for the caller to report.
            _ => return None,
        })
    }

    /// Parses a profile: firmware 3.6.14 except for the values in the text.
    ///
    /// ```
    /// use magician_sim::Profile;
    ///
    /// let profile = Profile::from_toml("[queue]\ndepth = 16\n")?;
    /// assert_eq!(profile.queue.depth, 16);
    /// assert_eq!(profile.limits, Profile::default().limits);
    /// # Ok::<(), magician_sim::ProfileError>(())
    /// ```
    ///
    /// # Errors
    /// [`ProfileError`] for invalid TOML, unknown keys, and values out of range.
    pub fn from_toml(text: &str) -> Result<Self, ProfileError> {
        let syntax = |error: toml::de::Error| {
            let (line, column, message) = crate::document::locate(text, &error);
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
}

//! The firmware profile: what the controller knows at power-up and how it decides where nothing is documented.
//!
//! Firmware 3.6.14 is built in. A file is a patch over it: it gives the values that differ.

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

/// Longest name that the arm keeps, bytes (model section 15).
pub(crate) const MAX_NAME: usize = 64;
/// Longest serial number that the arm keeps, bytes (model section 15).
pub(crate) const MAX_SERIAL: usize = 23;
/// Longest program that a flash may hold, whatever its profile says.
pub(crate) const MAX_LINES: usize = 65_536;
/// EIO addresses run from 1 to this (model section 13).
pub(crate) const PINS: usize = 20;

/// Where an EIO address is among the pins, `None` when there is no such pin.
pub(crate) fn pin_index(address: u8) -> Option<usize> {
    usize::from(address).checked_sub(1).filter(|at| *at < PINS)
}

/// Why a firmware profile cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// It is not TOML, or has a value that is not known.
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
/// [`Profile::default`] is firmware 3.6.14; [`Profile::from_toml`] reads what differs from it. [`Profile::pattern`] is a
/// whole file, with the source of each value.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Profile {
    /// The identity that the arm reports.
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
    /// How motions are computed.
    pub motion: MotionRules,
    /// Continuous paths.
    pub path: Paths,
    /// Stopping.
    pub stop: Stopping,
    /// The sliding rail.
    pub rail: Rail,
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

impl Profile {
    /// Firmware 3.6.14 in continuous time, where a jog stops before another axis is jogged: simpler than recordings show
    /// real arms to be, for what closed forms of time are compared with.
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

    /// Names of the built-in profiles, each with what it is.
    pub const NAMED: [(&str, &str); 4] = [
        (
            "3.6.14",
            "the firmware of the vendor's documents; the default",
        ),
        (
            "3.7.0",
            "firmware in the field; nothing but its version is known to differ",
        ),
        (
            "4.0.3",
            "firmware in the field; nothing but its version is known to differ",
        ),
        (
            "continuous",
            "3.6.14 without periods, where a jog stops before another axis: for comparison",
        ),
    ];

    /// A built-in profile; `None` for a name that none of them has.
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
            _ => return None,
        })
    }

    /// Reads a profile: firmware 3.6.14 but for the values that the text gives.
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
    /// [`ProfileError`] for text that is no profile, names that are not known, or values that make no sense.
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

//! Configuration with which a station is opened.
//!
//! ```json
//! {"arms": [{"name": "arm", "sim": {"speed": 1, "scenario": "table = { height = -60 }"}}],
//!  "epoch": "k3x9", "unix_zero": 1763932800.25, "role": "teacher"}
//! ```
//!
//! | member | meaning |
//! |---|---|
//! | `arms` | one or more: `name`, and either `sim` or `line: true` |
//! | `sim` | a virtual arm: `speed` (above 0, at most 100; default 1), `scenario` (TOML text) |
//! | `line` | the real arm at the other end of the line; at most one |
//! | `epoch` | prefix of ids; a different text for each opening keeps ids from being reused |
//! | `unix_zero` | Unix seconds at which `now` is 0; default 0 |
//! | `role` | role of all sessions: `viewer`, `student` or `teacher` (default) |

use magician::sim::Scenario;
use magician::{SimSpeed, VirtualArm};
use magician_station::Role;
use serde::Deserialize;

/// Largest speed of a virtual arm's clock, relative to a real arm.
const MAX_SPEED: f64 = 100.0;
/// Largest number of arms.
const MAX_ARMS: usize = 64;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawConfig {
    arms: Vec<RawArm>,
    #[serde(default)]
    epoch: String,
    #[serde(default)]
    unix_zero: f64,
    role: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawArm {
    name: String,
    sim: Option<RawSim>,
    #[serde(default)]
    line: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSim {
    speed: Option<f64>,
    scenario: Option<String>,
}

/// Validated configuration.
#[derive(Debug)]
pub(crate) struct Config {
    pub(crate) arms: Vec<(String, ArmLocation)>,
    pub(crate) epoch: String,
    pub(crate) unix_zero: f64,
    pub(crate) role: Role,
}

/// Virtual arm of this process, or real arm on the line.
#[derive(Debug)]
pub(crate) enum ArmLocation {
    /// A virtual arm in this process.
    Virtual(VirtualArm),
    /// A real arm at the other end of the line.
    Line,
}

impl Config {
    /// Parses and validates the JSON. The error is a sentence.
    pub(crate) fn read(json: &[u8]) -> Result<Self, String> {
        let raw: RawConfig =
            serde_json::from_slice(json).map_err(|error| format!("configuration: {error}"))?;
        let role = match raw.role.as_deref() {
            None => Role::Teacher,
            Some(name) => Role::named(name).ok_or("`role` must be viewer, student or teacher")?,
        };
        if !(raw.unix_zero.is_finite() && raw.unix_zero.abs() < 1e12) {
            return Err("`unix_zero` must be Unix seconds".to_owned());
        }
        if raw.epoch.len() > 64 {
            return Err("`epoch` must have at most 64 bytes".to_owned());
        }
        if raw.arms.is_empty() || raw.arms.len() > MAX_ARMS {
            return Err(format!("`arms` must have 1 to {MAX_ARMS} arms"));
        }
        let mut arms: Vec<(String, ArmLocation)> = Vec::new();
        for arm in raw.arms {
            if !is_name(&arm.name) {
                return Err(
                    "`name` of an arm must be 1 to 32 of a-z, 0-9, _ and -, the first of a-z, 0-9"
                        .to_owned(),
                );
            }
            if arms.iter().any(|(name, _)| *name == arm.name) {
                return Err(format!("two arms have the name {}", arm.name));
            }
            let has_line = arms
                .iter()
                .any(|(_, location)| matches!(location, ArmLocation::Line));
            let location = match (arm.sim, arm.line) {
                (Some(sim), false) => sim
                    .location()
                    .map_err(|why| format!("{}: {why}", arm.name))?,
                (None, true) if !has_line => ArmLocation::Line,
                (None, true) => return Err("only one arm can be at the line".to_owned()),
                _ => return Err(format!("{}: either `sim` or `line: true`", arm.name)),
            };
            arms.push((arm.name, location));
        }
        Ok(Self {
            arms,
            epoch: raw.epoch,
            unix_zero: raw.unix_zero,
            role,
        })
    }
}

impl RawSim {
    fn location(self) -> Result<ArmLocation, String> {
        let speed = self.speed.unwrap_or(1.0);
        if !(speed > 0.0 && speed <= MAX_SPEED) {
            return Err(format!(
                "`speed` must be more than 0 and at most {MAX_SPEED}, not {speed}"
            ));
        }
        let scenario = match self.scenario {
            None => Scenario::default(),
            Some(text) => {
                Scenario::from_toml(&text).map_err(|error| format!("`scenario`: {error}"))?
            }
        };
        let arm = VirtualArm::in_scenario_at(&scenario, SimSpeed::Times(speed));
        Ok(ArmLocation::Virtual(arm.with_breaking_lines()))
    }
}

fn is_name(name: &str) -> bool {
    let is_letter_or_digit = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    (1..=32).contains(&name.len())
        && name
            .bytes()
            .all(|byte| is_letter_or_digit(byte) || b"_-".contains(&byte))
        && name.bytes().next().is_some_and(is_letter_or_digit)
}

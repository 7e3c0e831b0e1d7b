//! The roster: the arms that a site is expected to have.
//!
//! An arm that cannot be reached does not answer, so its absence would go unnoticed. Every request
//! to all arms therefore compares its answers with the roster and names the arms that are missing.

use std::collections::BTreeMap;

use magician::{Message, message};
use magician_protocol::visible;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::names::is_name;

/// Most arms in a roster. A roster may come from strangers on the site's bus, so its size is
/// bounded; further arms are ignored.
const MAX_ARMS: usize = 10_000;
/// Most characters kept of a machine's name.
const MAX_MACHINE_NAME: usize = 64;

/// Expected arms of a site, each with the name of its machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roster(BTreeMap<String, String>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    arms: Vec<Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    arm: String,
    #[serde(default)]
    machine: String,
}

impl Roster {
    /// Parses a roster from JSON: `{"arms": [{"arm", "machine"}]}`.
    ///
    /// # Errors
    /// The reason why the text is no roster: it is not JSON of this form, or contains an invalid
    /// name of an arm.
    pub fn parse(text: &str) -> Result<Self, Message> {
        let content: Content = serde_json::from_str(text).map_err(|error| error.to_string())?;
        Self::of(&content.arms)
    }

    /// Builds a roster from values of the form `{"arm", "machine"}`.
    ///
    /// # Errors
    /// The fault of the first invalid value.
    pub fn of(arms: &[Value]) -> Result<Self, Message> {
        let mut roster = Self::default();
        for arm in arms {
            let Expected { arm, machine } =
                Expected::deserialize(arm).map_err(|error| error.to_string())?;
            if !is_name(&arm) {
                return Err(message!(
                    "`{name}` is no name of an arm",
                    name = visible(&arm).to_string()
                ));
            }
            roster.expect(arm, &machine);
        }
        Ok(roster)
    }

    /// Returns the roster as JSON, as read by [`parse`](Self::parse).
    #[must_use]
    pub fn to_value(&self) -> Value {
        let arms = self.arms();
        let arms = arms.map(|(arm, machine)| json!({"arm": arm, "machine": machine}));
        json!({"arms": arms.collect::<Vec<_>>()})
    }

    /// Adds an arm at this machine, unless the arm is in the roster already. No effect above 10,000
    /// arms.
    pub fn expect(&mut self, arm: String, machine: &str) {
        if self.0.len() < MAX_ARMS {
            let machine = machine.chars().take(MAX_MACHINE_NAME).collect();
            // A known arm keeps its machine, so a stranger's roster cannot move it.
            self.0.entry(arm).or_insert(machine);
        }
    }

    /// Adds all arms of another roster. Nothing is removed or changed, so a stranger's roster
    /// cannot hide an arm.
    pub fn add(&mut self, other: &Self) {
        for (arm, machine) in other.arms() {
            self.expect(arm.to_owned(), machine);
        }
    }

    /// Returns the arms and their machines, sorted by name.
    pub fn arms(&self) -> impl Iterator<Item = (&str, &str)> {
        let arms = self.0.iter();
        arms.map(|(arm, machine)| (arm.as_str(), machine.as_str()))
    }

    /// True if no arm is expected.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if the arm is expected.
    #[must_use]
    pub fn has(&self, arm: &str) -> bool {
        self.0.contains_key(arm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roster(arms: &[(&str, &str)]) -> Roster {
        let mut roster = Roster::default();
        for (arm, machine) in arms {
            roster.expect((*arm).to_owned(), machine);
        }
        roster
    }

    #[test]
    fn roster_round_trips_through_json() {
        let known = roster(&[("a1", "bench-1"), ("b1", "")]);
        assert_eq!(Roster::parse(&known.to_value().to_string()), Ok(known));
        for wrong in [
            "",
            "[]",
            r#"{"arms": [{"machine": "m"}]}"#,
            r#"{"arms": [{"arm": "*"}]}"#,
            r#"{"arms": [{"arm": "a1", "gone": true}]}"#,
        ] {
            assert!(Roster::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn merged_roster_adds_arms_without_changing_any() {
        let mut own = roster(&[("a1", "bench-1"), ("a2", "bench-1")]);
        own.add(&roster(&[("a1", "elsewhere"), ("a3", "bench-3")]));
        let all = roster(&[("a1", "bench-1"), ("a2", "bench-1"), ("a3", "bench-3")]);
        assert_eq!(own, all);
        own.add(&Roster::default());
        assert_eq!(own, all);
    }

    #[test]
    fn roster_size_is_bounded() {
        let mut own = Roster::default();
        for at in 0..=MAX_ARMS {
            own.expect(format!("a{at}"), &"m".repeat(MAX_MACHINE_NAME + 1));
        }
        assert_eq!(own.arms().count(), MAX_ARMS);
        assert!(
            own.arms()
                .all(|(_, machine)| machine.len() == MAX_MACHINE_NAME)
        );
    }
}

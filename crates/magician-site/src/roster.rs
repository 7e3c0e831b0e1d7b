//! The roster of a site: the arms that are expected there. Whatever is asked of all arms compares itself with it, because an arm that
//! cannot be reached says nothing.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use magician::files::replace_private;
use magician_protocol::visible;
use serde::{Deserialize, Serialize};

use crate::keys::is_name;

/// Arms that are expected, at most: what more are told of, by a stranger as well, is left out.
const MOST: usize = 10_000;
/// Characters of a machine's name that are kept.
const MACHINE: usize = 64;

/// Arms that a site is expected to have, each with the name of its machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roster(BTreeMap<String, String>);

/// As files and messages have it.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Content {
    arms: Vec<Expected>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    arm: String,
    #[serde(default)]
    machine: String,
}

impl Roster {
    /// Parses a roster.
    ///
    /// # Errors
    /// What is wrong with the text: no JSON of this form, or a name that no arm can have.
    pub fn parse(text: &str) -> Result<Self, String> {
        let content: Content = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let mut roster = Self::default();
        for Expected { arm, machine } in content.arms {
            if !is_name(&arm) {
                return Err(format!("`{}` is no name of an arm", visible(&arm)));
            }
            roster.expect(arm, &machine);
        }
        Ok(roster)
    }

    /// The roster as JSON, which [`parse`](Self::parse) reads.
    #[must_use]
    pub fn to_text(&self) -> String {
        let arms = self.arms().map(|(arm, machine)| Expected {
            arm: arm.to_owned(),
            machine: machine.to_owned(),
        });
        let content = Content {
            arms: arms.collect(),
        };
        // Names are text always.
        serde_json::to_string(&content).unwrap_or_default()
    }

    /// Expects an arm, at this machine unless it is expected already. No effect at 10,000 arms.
    pub fn expect(&mut self, arm: String, machine: &str) {
        if self.0.len() < MOST {
            let machine = machine.chars().take(MACHINE).collect();
            self.0.entry(arm).or_insert(machine);
        }
    }

    /// Expects all arms of another roster as well. Nothing is removed, so a stranger's roster cannot hide an arm.
    pub fn add(&mut self, other: &Self) {
        for (arm, machine) in other.arms() {
            self.expect(arm.to_owned(), machine);
        }
    }

    /// The arms and their machines, by name.
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

/// The roster of a station, in a file.
#[derive(Debug)]
pub struct KeptRoster {
    path: Option<PathBuf>,
    roster: Mutex<Roster>,
}

impl KeptRoster {
    /// Reads the file, if there is one; without a path the roster lasts as long as the station. A file that is damaged counts as
    /// none, with a warning: a station has to come up.
    #[must_use]
    pub fn open(path: Option<PathBuf>) -> Self {
        let read = path.as_deref().map_or(Ok(Roster::default()), read);
        let roster = read.unwrap_or_else(|error| {
            tracing::warn!(%error, ?path, "the roster of the site cannot be read");
            Roster::default()
        });
        Self {
            path,
            roster: Mutex::new(roster),
        }
    }

    /// The roster as it is kept.
    #[must_use]
    pub fn roster(&self) -> Roster {
        self.lock().clone()
    }

    /// Replaces the roster: it is on disk when this returns.
    ///
    /// # Errors
    /// If the file cannot be written; the roster stays as it was.
    pub fn set(&self, roster: Roster) -> io::Result<()> {
        let mut kept = self.lock();
        if let Some(path) = &self.path {
            replace_private(path, &roster.to_text())?;
        }
        *kept = roster;
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Roster> {
        self.roster.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read(path: &Path) -> Result<Roster, String> {
    match fs::read_to_string(path) {
        Ok(text) => Roster::parse(&text),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Roster::default()),
        Err(error) => Err(error.to_string()),
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
    fn roster_is_read_as_it_is_written() {
        let known = roster(&[("a1", "bench-1"), ("b1", "")]);
        assert_eq!(Roster::parse(&known.to_text()), Ok(known));
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
    fn roster_of_another_adds_arms_and_changes_none() {
        let mut own = roster(&[("a1", "bench-1"), ("a2", "bench-1")]);
        own.add(&roster(&[("a1", "elsewhere"), ("a3", "bench-3")]));
        let all = roster(&[("a1", "bench-1"), ("a2", "bench-1"), ("a3", "bench-3")]);
        assert_eq!(own, all);
        own.add(&Roster::default());
        assert_eq!(own, all);
    }

    #[test]
    fn roster_of_a_flood_is_bounded() {
        let mut own = Roster::default();
        for at in 0..=MOST {
            own.expect(format!("a{at}"), &"m".repeat(MACHINE + 1));
        }
        assert_eq!(own.arms().count(), MOST);
        assert!(own.arms().all(|(_, machine)| machine.len() == MACHINE));
    }

    #[test]
    fn roster_in_a_file_outlives_its_station() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("station/site-lab.json");
        let kept = KeptRoster::open(Some(path.clone()));
        assert!(kept.roster().is_empty());
        let known = roster(&[("a1", "bench-1")]);
        kept.set(known.clone()).unwrap();
        assert_eq!(KeptRoster::open(Some(path.clone())).roster(), known);
        fs::write(&path, "{").unwrap();
        assert!(KeptRoster::open(Some(path)).roster().is_empty());
        // A place that cannot be written.
        let kept = KeptRoster::open(Some(folder.path().join("station/site-lab.json/none")));
        assert!(kept.set(known).is_err());
        assert!(kept.roster().is_empty());
    }
}

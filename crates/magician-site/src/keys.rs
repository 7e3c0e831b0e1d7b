//! Keys of a site on its bus: `/`-separated paths, `magician/SITE/MACHINE/...`.

use std::fmt;
use std::str::FromStr;

use crate::{ArmAt, StationId};

use magician_station::MAX_NAME_LENGTH;
pub use magician_station::is_name;

/// Derives a valid name from a text such as a host name. Returns `None` if no valid character is
/// left.
#[must_use]
pub fn derive_name(text: &str) -> Option<String> {
    let signs = text.chars().map(|c| match c.to_ascii_lowercase() {
        c if c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' => c,
        _ => '-',
    });
    let name: String = signs.skip_while(|c| "_-".contains(*c)).collect();
    let name: String = name
        .trim_end_matches('-')
        .chars()
        .take(MAX_NAME_LENGTH)
        .collect();
    is_name(&name).then_some(name)
}

/// The name of a site.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SiteName(String);

impl SiteName {
    /// Returns the name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for SiteName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for SiteName {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let rule =
            "a name is of a-z, 0-9, _ and -, 32 at most, and begins with a letter or a digit";
        is_name(text).then(|| Self(text.to_owned())).ok_or(rule)
    }
}

/// Builds and parses the keys of a site. Each key contains the machine of its station, so that an
/// access list can bind it to the certificate of that machine.
#[derive(Clone, Debug)]
pub struct Keys {
    /// Name of the site.
    pub site: SiteName,
}

impl Keys {
    /// Key of the state of an arm: its station publishes it there and answers queries. `*` matches
    /// any machine or arm.
    #[must_use]
    pub fn state(&self, machine: &str, arm: &str) -> String {
        self.key(machine, &format!("state/{arm}"))
    }

    /// Key of the liveliness token of an arm.
    #[must_use]
    pub fn alive(&self, machine: &str, at: &ArmAt) -> String {
        self.key(machine, &format!("alive/{}/{}", at.arm, at.station))
    }

    /// Key expression for the liveliness tokens of all arms called `arm`, or of all arms with `*`.
    #[must_use]
    pub fn all_alive(&self, arm: &str) -> String {
        self.key("*", &format!("alive/{arm}/*"))
    }

    /// Key at which a station answers with its roster. `*` matches all machines.
    #[must_use]
    pub fn roster(&self, machine: &str) -> String {
        self.key(machine, "roster")
    }

    /// Key of the list of revoked certificates: a machine publishes it there and answers queries.
    /// `*` matches all machines.
    #[must_use]
    pub fn revoked(&self, machine: &str) -> String {
        self.key(machine, "revoked")
    }

    /// Parses the key of a liveliness token into machine and arm. Returns `None` for any other key.
    #[must_use]
    pub fn parse_alive<'a>(&self, key: &'a str) -> Option<(&'a str, ArmAt)> {
        let [machine, "alive", arm, station] = self.parts(key)? else {
            return None;
        };
        let at = ArmAt {
            arm: arm.to_owned(),
            station: StationId::named(station)?,
        };
        is_name(arm).then_some((machine, at))
    }

    /// Parses the key of a state into machine and arm. Returns `None` for any other key.
    #[must_use]
    pub fn parse_state<'a>(&self, key: &'a str) -> Option<(&'a str, &'a str)> {
        let [machine, "state", arm] = self.parts(key)? else {
            return None;
        };
        is_name(arm).then_some((machine, arm))
    }

    fn key(&self, machine: &str, rest: &str) -> String {
        format!("magician/{}/{machine}/{rest}", self.site)
    }

    /// Splits the part of a key after the site. Returns `None` unless it has exactly `N` parts and
    /// the first is a valid name.
    fn parts<'a, const N: usize>(&self, key: &'a str) -> Option<[&'a str; N]> {
        let rest = key.strip_prefix("magician/")?;
        let rest = rest.strip_prefix(self.site.as_str())?.strip_prefix('/')?;
        let mut parts = rest.split('/');
        let mut found = [""; N];
        for part in &mut found {
            *part = parts.next()?;
        }
        (parts.next().is_none() && is_name(found.first()?)).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Keys {
        Keys {
            site: "lab".parse().unwrap(),
        }
    }

    #[test]
    fn site_name_follows_the_rules_of_arm_names() {
        assert!("lab-2".parse::<SiteName>().is_ok());
        for wrong in ["", "A", "a/b", "*"] {
            assert!(wrong.parse::<SiteName>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn name_is_derived_from_a_host_name() {
        for (machine, name) in [
            ("bench-3", Some("bench-3")),
            ("Bench 3.local", Some("bench-3-local")),
            ("_pi_", Some("pi_")),
            ("--", None),
            ("ä", None),
            ("", None),
            ("Zoë's", Some("zo--s")),
        ] {
            assert_eq!(derive_name(machine).as_deref(), name, "{machine}");
        }
        assert_eq!(derive_name(&"X".repeat(80)), Some("x".repeat(32)));
    }

    #[test]
    fn keys_round_trip() {
        let keys = keys();
        let at = ArmAt {
            arm: "left".to_owned(),
            station: StationId(7),
        };
        let alive = keys.alive("bench-1", &at);
        assert_eq!(alive, "magician/lab/bench-1/alive/left/0000000000000007");
        assert_eq!(keys.parse_alive(&alive), Some(("bench-1", at)));
        assert_eq!(keys.parse_state(&alive), None);
        let state = keys.state("bench-1", "left");
        assert_eq!(state, "magician/lab/bench-1/state/left");
        assert_eq!(keys.parse_state(&state), Some(("bench-1", "left")));
        for other in [state, keys.roster("bench-1"), keys.revoked("bench-1")] {
            assert_eq!(keys.parse_alive(&other), None, "{other}");
        }
    }

    #[test]
    fn foreign_keys_are_ignored() {
        let keys = keys();
        for wrong in [
            "",
            "magician",
            "magician/lab",
            "magician/lab/bench/alive/left",
            "magician/lab/bench/alive/left/7",
            "magician/lab/bench/alive/left/0000000000000007/more",
            "magician/lab/Bench/alive/left/0000000000000007",
            "magician/lab/bench/alive/Left/0000000000000007",
            "magician/lab/*/alive/left/0000000000000007",
            "magician/labor/bench/alive/left/0000000000000007",
            "elsewhere/lab/bench/alive/left/0000000000000007",
        ] {
            assert_eq!(keys.parse_alive(wrong), None, "{wrong}");
        }
        for wrong in [
            "magician/lab/bench/stat/left",
            "magician/lab//state/left",
            "magician/lab/bench/state/*",
            "state",
        ] {
            assert_eq!(keys.parse_state(wrong), None, "{wrong}");
        }
    }
}

//! Where the messages of a site go: keys of `/`-separated parts, `magician/SITE/ARM/...`.

use std::fmt;
use std::str::FromStr;

use crate::{ArmAt, StationId};

/// Characters of a name, at most.
const LONGEST: usize = 32;

/// Whether a text is a name, of a site as of an arm: `[a-z0-9][a-z0-9_-]{0,31}`.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let sign = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    !text.is_empty()
        && text.len() <= LONGEST
        && !text.starts_with(['_', '-'])
        && text.chars().all(sign)
}

/// The name that is nearest to a text, such as that of a machine; none where nothing of it can stay.
#[must_use]
pub fn name_like(text: &str) -> Option<String> {
    let signs = text.chars().map(|c| match c.to_ascii_lowercase() {
        c if c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' => c,
        _ => '-',
    });
    let name: String = signs.skip_while(|c| "_-".contains(*c)).collect();
    let name: String = name.trim_end_matches('-').chars().take(LONGEST).collect();
    is_name(&name).then_some(name)
}

/// The name of a site.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SiteName(String);

impl SiteName {
    /// As text.
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

/// What an arm's station publishes or answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// Its state; also answered to whoever asks.
    State,
    /// Its events.
    Event,
    /// Its jobs.
    Job,
    /// Requests to its station.
    Rpc,
}

impl Topic {
    const ALL: [Self; 4] = [Self::State, Self::Event, Self::Job, Self::Rpc];

    const fn name(self) -> &'static str {
        match self {
            Self::State => "state",
            Self::Event => "event",
            Self::Job => "job",
            Self::Rpc => "rpc",
        }
    }
}

/// The keys of a site.
#[derive(Clone, Debug)]
pub struct Keys {
    /// The site.
    pub site: SiteName,
}

/// The two directions of a session's channel, as seen from the station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelKeys<'a> {
    site: &'a SiteName,
    arm: &'a str,
    channel: u128,
}

impl Keys {
    /// A topic of one arm; of all with `*`.
    #[must_use]
    pub fn topic(&self, arm: &str, topic: Topic) -> String {
        format!("magician/{}/{arm}/{}", self.site, topic.name())
    }

    /// The token by which a station says that an arm is there.
    #[must_use]
    pub fn alive(&self, at: &ArmAt) -> String {
        format!("magician/{}/{}/alive/{}", self.site, at.arm, at.station)
    }

    /// All such tokens of one name; of all with `*`.
    #[must_use]
    pub fn all_alive(&self, arm: &str) -> String {
        format!("magician/{}/{arm}/alive/*", self.site)
    }

    /// Where a station answers with its roster. No arm is called so, and `*` does not mean it: parts that begin with `@` are meant
    /// by themselves alone.
    #[must_use]
    pub fn roster(&self, station: StationId) -> String {
        format!("magician/{}/@roster/{station}", self.site)
    }

    /// All rosters.
    #[must_use]
    pub fn all_rosters(&self) -> String {
        format!("magician/{}/@roster/*", self.site)
    }

    /// The keys of a session's channel.
    #[must_use]
    pub fn channel<'a>(&'a self, arm: &'a str, channel: u128) -> ChannelKeys<'a> {
        ChannelKeys {
            site: &self.site,
            arm,
            channel,
        }
    }

    /// The arm whose token a key is; none for any other key.
    #[must_use]
    pub fn read_alive(&self, key: &str) -> Option<ArmAt> {
        let [arm, "alive", station] = self.parts(key)? else {
            return None;
        };
        Some(ArmAt {
            arm: arm.to_owned(),
            station: StationId::named(station)?,
        })
    }

    /// The arm and the topic of a key; none for any other key.
    #[must_use]
    pub fn read_topic<'a>(&self, key: &'a str) -> Option<(&'a str, Topic)> {
        let [arm, topic] = self.parts(key)?;
        let topic = Topic::ALL.into_iter().find(|one| one.name() == topic)?;
        Some((arm, topic))
    }

    /// What follows the site, if there are so many parts and the first is a name.
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

impl ChannelKeys<'_> {
    fn key(&self, last: &str) -> String {
        let Self { site, arm, channel } = self;
        format!("magician/{site}/{arm}/session/{channel:032x}/{last}")
    }

    /// To the station.
    #[must_use]
    pub fn up(&self) -> String {
        self.key("up")
    }

    /// From the station.
    #[must_use]
    pub fn down(&self) -> String {
        self.key("down")
    }

    /// The token of the client.
    #[must_use]
    pub fn hub(&self) -> String {
        self.key("hub")
    }

    /// The token of the station.
    #[must_use]
    pub fn station(&self) -> String {
        self.key("station")
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
    fn a_name_is_a_part_of_a_key_and_nothing_else() {
        for name in ["a", "0", "a1_-", &"x".repeat(32)] {
            assert!(is_name(name), "{name}");
        }
        for wrong in [
            "",
            "A",
            "_a",
            "-a",
            "a/b",
            "*",
            "a*",
            "ä",
            "a b",
            "$*",
            &"x".repeat(33),
        ] {
            assert!(!is_name(wrong), "{wrong}");
            assert!(wrong.parse::<SiteName>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_machine_lends_its_name() {
        for (machine, name) in [
            ("bench-3", Some("bench-3")),
            ("Bench 3.local", Some("bench-3-local")),
            ("_pi_", Some("pi_")),
            ("--", None),
            ("ä", None),
            ("", None),
            ("Zoë's", Some("zo--s")),
        ] {
            assert_eq!(name_like(machine).as_deref(), name, "{machine}");
        }
        assert_eq!(name_like(&"X".repeat(80)), Some("x".repeat(32)));
    }

    #[test]
    fn keys_are_read_as_they_are_written() {
        let keys = keys();
        let at = ArmAt {
            arm: "left".to_owned(),
            station: StationId(7),
        };
        let alive = keys.alive(&at);
        assert_eq!(alive, "magician/lab/left/alive/0000000000000007");
        assert_eq!(keys.read_alive(&alive), Some(at));
        for topic in Topic::ALL {
            let key = keys.topic("left", topic);
            assert_eq!(keys.read_topic(&key), Some(("left", topic)), "{key}");
            assert_eq!(keys.read_alive(&key), None);
        }
        let channel = keys.channel("left", 1);
        let up = "magician/lab/left/session/00000000000000000000000000000001/up";
        assert_eq!(channel.up(), up);
        let all = [
            channel.up(),
            channel.down(),
            channel.hub(),
            channel.station(),
        ];
        assert!(all.iter().all(|key| keys.read_alive(key).is_none()));
    }

    #[test]
    fn keys_of_others_are_none() {
        let keys = keys();
        for wrong in [
            "",
            "magician",
            "magician/lab",
            "magician/lab/left",
            "magician/lab/left/alive",
            "magician/lab/left/alive/7",
            "magician/lab/left/alive/0000000000000007/more",
            "magician/lab/Left/alive/0000000000000007",
            "magician/lab/*/alive/0000000000000007",
            "magician/labor/left/alive/0000000000000007",
            "magician/other/left/alive/0000000000000007",
            "elsewhere/lab/left/alive/0000000000000007",
        ] {
            assert_eq!(keys.read_alive(wrong), None, "{wrong}");
        }
        for wrong in ["magician/lab/left/stat", "magician/lab//state", "state"] {
            assert_eq!(keys.read_topic(wrong), None, "{wrong}");
        }
    }
}

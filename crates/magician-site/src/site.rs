//! A site: which arms are there, what they do, and commands to any of them.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use magician_station::Roster;
use serde_json::Value;
use tokio::sync::Notify;

use crate::channel::Channel;

/// A station of a site: another one at each start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StationId(pub u64);

impl fmt::Display for StationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl StationId {
    /// One as text: 16 digits of hex, in lower case.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        let id = Self(u64::from_str_radix(text, 16).ok()?);
        (id.to_string() == text).then_some(id)
    }
}

/// An arm of a site. A name is one arm; where two stations have the same name (they came together after both had started), it is
/// two, and whoever shows them says so.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArmAt {
    /// Its name.
    pub arm: String,
    /// The station that has it.
    pub station: StationId,
}

/// What a station says of one of its arms.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmNews {
    /// The machine that the station runs on.
    pub machine: String,
    /// Where the arm is, as a person wrote it there.
    pub port: String,
    /// Whether it is a virtual one.
    pub is_virtual: bool,
    /// The state as `arm.state` answers it. While the line to the arm is lost it is the last that was read, with `link` `lost`; null
    /// where it was never read.
    pub state: Value,
}

/// What happens on a site.
#[derive(Clone, Debug, PartialEq)]
pub enum SiteEvent {
    /// An arm is there. Its news comes within a second, and then again and again.
    Arrived(ArmAt),
    /// An arm is gone: its station ended, or cannot be reached.
    Left(ArmAt),
    /// What its station says of it now: when something has changed, ten times a second at most, and every second.
    News(ArmAt, ArmNews),
    /// Too much waited to be read and is lost, arms that came and went as well: ask [`Site::arms`] again.
    Missed,
}

/// In whose name a request is made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Caller {
    /// The token of the station. Without one nothing is answered, but each station has its own say.
    pub token: Option<String>,
}

/// Why a site does not do something.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SiteError {
    /// The arm or station is not on the site.
    Gone,
    /// It did not answer in time. What was asked may be done or not.
    NoAnswer,
    /// It has not proved that it is a station of the site, so that it was sent nothing.
    Unproved(String),
    /// The station refuses it, before it looks at the request: no token, a wrong one, too many sessions.
    Refused(String),
    /// The network refuses it.
    Network(String),
}

impl fmt::Display for SiteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gone => f.write_str("the station is not on the site any more"),
            Self::NoAnswer => {
                f.write_str("the station does not answer: what was asked may be done or not")
            }
            Self::Unproved(why) => f.write_str(why),
            Self::Refused(why) => write!(f, "the station refuses it: {why}"),
            Self::Network(why) => write!(f, "the network of the site fails: {why}"),
        }
    }
}

impl std::error::Error for SiteError {}

/// What comes in time.
pub type Later<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// A site as a program sees it, whatever carries it.
pub trait Site: Send + Sync + 'static {
    /// Its name.
    fn name(&self) -> &str;

    /// The arms that are there now, with the last that was heard of each.
    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmNews>>;

    /// What happens from now on. Begins with [`SiteEvent::Arrived`] for each arm that is there, and the last news of each.
    fn watch(&self) -> SiteEvents;

    /// One request of JSON-RPC to a station, as POST `/api/v1/rpc` takes it: the arm is named in its text. The answer's text,
    /// which may be an error of the station; none for a notification. It is carried out by this station once or not at all:
    /// nothing is asked twice.
    fn call<'a>(
        &'a self,
        at: &'a ArmAt,
        caller: &'a Caller,
        request: String,
    ) -> Later<'a, Result<Option<String>, SiteError>>;

    /// The arms that are expected, by the rosters of all stations that answer in time. Anybody on the network may answer as well, so it
    /// can have names that nobody has written.
    fn roster(&self) -> Later<'_, Roster> {
        Box::pin(async { Roster::default() })
    }

    /// Opens a session with a station: the equal of a WebSocket to it. Its first message is `session.hello`, with the token.
    fn open(&self, station: StationId) -> Later<'_, Result<Channel, SiteError>>;
}

/// Events that wait beside states, at most.
const WAITING: usize = 4096;

#[derive(Debug, Default)]
struct Inbox {
    waiting: VecDeque<Entry>,
    /// The newest of each arm that waits to be read.
    news: BTreeMap<ArmAt, ArmNews>,
    missed: bool,
}

#[derive(Debug)]
enum Entry {
    News(ArmAt),
    Other(SiteEvent),
}

impl Inbox {
    fn push(&mut self, event: SiteEvent) {
        match event {
            SiteEvent::News(at, news) => {
                if self.news.insert(at.clone(), news).is_none() {
                    self.waiting.push_back(Entry::News(at));
                }
            }
            other => {
                if let SiteEvent::Left(at) = &other {
                    // What waits of it is no news any more.
                    self.news.remove(at);
                    self.waiting
                        .retain(|entry| !matches!(entry, Entry::News(news) if news == at));
                }
                self.waiting.push_back(Entry::Other(other));
            }
        }
        if self.waiting.len() - self.news.len() > WAITING {
            self.waiting.clear();
            self.news.clear();
            self.missed = true;
        }
    }

    fn pop(&mut self) -> Option<SiteEvent> {
        if std::mem::take(&mut self.missed) {
            return Some(SiteEvent::Missed);
        }
        loop {
            match self.waiting.pop_front()? {
                Entry::Other(event) => return Some(event),
                Entry::News(at) => {
                    if let Some(news) = self.news.remove(&at) {
                        return Some(SiteEvent::News(at, news));
                    }
                }
            }
        }
    }
}

#[derive(Debug, Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    awake: Notify,
}

impl Shared {
    fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What happens on a site, in order; of states that were not read in time the newest alone.
#[derive(Debug)]
pub struct SiteEvents(Arc<Shared>);

/// Whoever makes a site tells one of its watchers by this.
#[derive(Clone, Debug)]
pub struct SiteTeller(Weak<Shared>);

/// A watcher of a site, and what tells it.
#[must_use]
pub fn watcher() -> (SiteTeller, SiteEvents) {
    let shared = Arc::new(Shared::default());
    (SiteTeller(Arc::downgrade(&shared)), SiteEvents(shared))
}

impl SiteTeller {
    /// Tells it; never waits. Whether anybody listens still.
    pub fn tell(&self, event: SiteEvent) -> bool {
        let Some(shared) = self.0.upgrade() else {
            return false;
        };
        shared.inbox().push(event);
        shared.awake.notify_one();
        true
    }
}

impl SiteEvents {
    /// What happens next; waits for it. Dropping the future loses nothing.
    pub async fn next(&mut self) -> SiteEvent {
        loop {
            if let Some(event) = self.try_next() {
                return event;
            }
            self.0.awake.notified().await;
        }
    }

    /// What has happened and was not read yet.
    pub fn try_next(&mut self) -> Option<SiteEvent> {
        self.0.inbox().pop()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn at(arm: &str) -> ArmAt {
        ArmAt {
            arm: arm.to_owned(),
            station: StationId(1),
        }
    }

    fn news(arm: &str, x: u32) -> SiteEvent {
        let news = ArmNews {
            machine: "here".to_owned(),
            port: "sim".to_owned(),
            is_virtual: true,
            state: json!({"x": x}),
        };
        SiteEvent::News(at(arm), news)
    }

    fn read(events: &mut SiteEvents) -> Vec<SiteEvent> {
        std::iter::from_fn(|| events.try_next()).collect()
    }

    #[test]
    fn a_station_has_one_form_as_text() {
        assert_eq!(StationId(0xab).to_string(), "00000000000000ab");
        assert_eq!(StationId::named("00000000000000ab"), Some(StationId(0xab)));
        for wrong in ["ab", "00000000000000AB", "+0000000000000ab", "", "é"] {
            assert_eq!(StationId::named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn of_states_that_wait_the_newest_is_read() {
        let (teller, mut events) = watcher();
        for event in [
            SiteEvent::Arrived(at("a")),
            news("a", 1),
            news("b", 1),
            SiteEvent::Left(at("c")),
            news("a", 2),
        ] {
            assert!(teller.tell(event));
        }
        let expected = [
            SiteEvent::Arrived(at("a")),
            news("a", 2),
            news("b", 1),
            SiteEvent::Left(at("c")),
        ];
        assert_eq!(read(&mut events), expected);
        teller.tell(news("a", 3));
        assert_eq!(read(&mut events), [news("a", 3)]);
        drop(events);
        assert!(!teller.tell(news("a", 4)));
    }

    #[test]
    fn nothing_is_told_of_an_arm_behind_its_end() {
        let (teller, mut events) = watcher();
        teller.tell(news("a", 1));
        teller.tell(SiteEvent::Left(at("a")));
        teller.tell(SiteEvent::Arrived(at("a")));
        teller.tell(news("a", 2));
        let expected = [
            SiteEvent::Left(at("a")),
            SiteEvent::Arrived(at("a")),
            news("a", 2),
        ];
        assert_eq!(read(&mut events), expected);
    }

    #[test]
    fn whoever_does_not_read_hears_that_something_is_lost() {
        let (teller, mut events) = watcher();
        for _ in 0..=WAITING {
            teller.tell(SiteEvent::Left(at("b")));
        }
        teller.tell(news("a", 1));
        assert_eq!(read(&mut events), [SiteEvent::Missed, news("a", 1)]);
    }
}

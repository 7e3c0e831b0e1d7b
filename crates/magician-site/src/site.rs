//! The [`Site`] trait: the arms of a site, their states and events, and commands to any of them.
//!
//! Events reach a watcher through a bounded inbox. States are coalesced, so that a slow watcher
//! reads the newest state of each arm and never a backlog of old ones; arrivals and departures are
//! kept in order. If too many of those wait, the inbox is emptied and the watcher gets
//! [`SiteEvent::Missed`].

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use magician_station::Roster;
use serde_json::Value;
use tokio::sync::Notify;

use crate::channel::Channel;

/// Id of a running station of a site. A station gets a new one at each start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StationId(pub u64);

impl fmt::Display for StationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl StationId {
    /// Parses an id of 16 lower-case hex digits, the form that `Display` writes. Returns `None` for
    /// any other text.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        let id = Self(u64::from_str_radix(text, 16).ok()?);
        (id.to_string() == text).then_some(id)
    }
}

/// An arm at one station of a site.
///
/// Normally a name belongs to one arm. Two stations that started before they could see each other
/// may use the same name; then there are two entries, and front ends have to show both.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArmAt {
    /// Name of the arm.
    pub arm: String,
    /// Station that owns the arm.
    pub station: StationId,
}

/// State report of a station about one of its arms.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmNews {
    /// Name of the machine that runs the station.
    pub machine: String,
    /// Port of the arm as configured at the station.
    pub port: String,
    /// True for a virtual arm.
    pub is_virtual: bool,
    /// State in the form of the API method `arm.state`. While the link to the arm is lost this is
    /// the last state read, with `link` set to `lost`. Null if the state was never read.
    pub state: Value,
}

/// Event on a site.
#[derive(Clone, Debug, PartialEq)]
pub enum SiteEvent {
    /// An arm appeared. Its first state follows within a second.
    Arrived(ArmAt),
    /// An arm disappeared: its station ended or is unreachable.
    Left(ArmAt),
    /// State of an arm: sent on change, at most ten times a second, and at least once a second.
    News(ArmAt, ArmNews),
    /// The inbox overflowed and its events are lost, arrivals and departures included. Read
    /// [`Site::arms`] again.
    Missed,
}

/// Identity under which a request is made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Caller {
    /// Token for the station. Whether a station answers requests without one is its own decision;
    /// by default it does not.
    pub token: Option<String>,
}

/// Reason why a request to a site failed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SiteError {
    /// The arm or station is not on the site.
    Gone,
    /// The station did not answer in time. The request may or may not have been carried out.
    NoAnswer,
    /// The station did not prove that it belongs to the site. Nothing was sent to it.
    Unproved(String),
    /// The station refused the caller before it read the request: token missing or wrong, or too
    /// many sessions.
    Refused(String),
    /// The network failed.
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

/// Boxed future, which keeps [`Site`] usable as a trait object.
pub type Later<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// A site as seen by a program, independent of the transport.
pub trait Site: Send + Sync + 'static {
    /// Name of the site.
    fn name(&self) -> &str;

    /// Arms present now, each with its last state report. `None` until the first report.
    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmNews>>;

    /// Subscribes to events. The stream starts with [`SiteEvent::Arrived`] and the last report for
    /// each arm that is present.
    fn watch(&self) -> SiteEvents;

    /// Sends one JSON-RPC request to the station of `at`, as POST `/api/v1/rpc` would.
    ///
    /// The text of the request names the arm. Returns the text of the reply, which may be an error
    /// of the station, or `None` for a notification. The request is never retransmitted, so the
    /// station executes it at most once.
    fn call<'a>(
        &'a self,
        at: &'a ArmAt,
        caller: &'a Caller,
        request: String,
    ) -> Later<'a, Result<Option<String>, SiteError>>;

    /// Expected arms: the union of the rosters of all stations that answer in time.
    ///
    /// Replies are not authenticated, so the union may contain names that no operator entered.
    fn roster(&self) -> Later<'_, Roster> {
        Box::pin(async { Roster::default() })
    }

    /// Opens a session with a station, the equivalent of a WebSocket to it. The first message has
    /// to be `session.hello` with the token.
    fn open(&self, station: StationId) -> Later<'_, Result<Channel, SiteError>>;
}

/// Most arrivals and departures in an inbox before it overflows. A choice: more than any real site
/// produces while a watcher is busy, and little memory. States do not count, because one per arm is
/// kept.
const WAITING: usize = 4096;

#[derive(Debug, Default)]
struct Inbox {
    waiting: VecDeque<Entry>,
    /// Newest unread state of each arm.
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
                    // Otherwise the unread state would be delivered after the departure.
                    self.news.remove(at);
                    self.waiting
                        .retain(|entry| !matches!(entry, Entry::News(news) if news == at));
                }
                self.waiting.push_back(Entry::Other(other));
            }
        }
        // States do not count: at most one per arm waits.
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

/// Receiving end of a site's events, in order. Only the newest unread state of each arm is kept.
#[derive(Debug)]
pub struct SiteEvents(Arc<Shared>);

/// Sending end for one watcher of a site, used by the transport.
#[derive(Clone, Debug)]
pub struct SiteTeller(Weak<Shared>);

/// Creates a watcher: the sender and the stream of its events.
#[must_use]
pub fn watcher() -> (SiteTeller, SiteEvents) {
    let shared = Arc::new(Shared::default());
    (SiteTeller(Arc::downgrade(&shared)), SiteEvents(shared))
}

impl SiteTeller {
    /// Queues an event without blocking. Returns false if the watcher is gone.
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
    /// Waits for the next event. Cancel safe: dropping the future loses no event.
    pub async fn next(&mut self) -> SiteEvent {
        loop {
            if let Some(event) = self.try_next() {
                return event;
            }
            self.0.awake.notified().await;
        }
    }

    /// Returns the next unread event without waiting, or `None`.
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

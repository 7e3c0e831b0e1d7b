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
pub struct ArmReport {
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
    Report(ArmAt, ArmReport),
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
pub type BoxFuture<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// A site as seen by a program, independent of the transport.
pub trait Site: Send + Sync + 'static {
    /// Name of the site.
    fn name(&self) -> &str;

    /// Arms present now, each with its last state report. `None` until the first report.
    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmReport>>;

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
    ) -> BoxFuture<'a, Result<Option<String>, SiteError>>;

    /// Expected arms: the union of the rosters of all stations that answer in time.
    ///
    /// Replies are not authenticated, so the union may contain names that no operator entered.
    fn roster(&self) -> BoxFuture<'_, Roster> {
        Box::pin(async { Roster::default() })
    }

    /// Opens a session with a station, the equivalent of a WebSocket to it. The first message has
    /// to be `session.hello` with the token.
    fn open(&self, station: StationId) -> BoxFuture<'_, Result<Channel, SiteError>>;
}

/// Most arrivals and departures in an inbox before it overflows. A choice: more than any real site
/// produces while a watcher is busy, and little memory. States do not count, because one per arm is
/// kept.
const MAX_WAITING: usize = 4096;

#[derive(Debug, Default)]
struct Inbox {
    waiting: VecDeque<Entry>,
    /// Newest unread state of each arm.
    reports: BTreeMap<ArmAt, ArmReport>,
    missed: bool,
}

#[derive(Debug)]
enum Entry {
    Report(ArmAt),
    Other(SiteEvent),
}

impl Inbox {
    fn push(&mut self, event: SiteEvent) {
        match event {
            SiteEvent::Report(at, report) => {
                if self.reports.insert(at.clone(), report).is_none() {
                    self.waiting.push_back(Entry::Report(at));
                }
            }
            other => {
                if let SiteEvent::Left(at) = &other {
                    // Otherwise the unread state would be delivered after the departure.
                    self.reports.remove(at);
                    self.waiting
                        .retain(|entry| !matches!(entry, Entry::Report(report) if report == at));
                }
                self.waiting.push_back(Entry::Other(other));
            }
        }
        // States do not count: at most one per arm waits.
        if self.waiting.len() - self.reports.len() > MAX_WAITING {
            self.waiting.clear();
            self.reports.clear();
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
                Entry::Report(at) => {
                    if let Some(report) = self.reports.remove(&at) {
                        return Some(SiteEvent::Report(at, report));
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
pub struct SiteEventSender(Weak<Shared>);

/// Creates a watcher: the sender and the stream of its events.
#[must_use]
pub fn event_channel() -> (SiteEventSender, SiteEvents) {
    let shared = Arc::new(Shared::default());
    (SiteEventSender(Arc::downgrade(&shared)), SiteEvents(shared))
}

impl SiteEventSender {
    /// Queues an event without blocking. Returns false if the watcher is gone.
    pub fn send(&self, event: SiteEvent) -> bool {
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

    fn report(arm: &str, x: u32) -> SiteEvent {
        let report = ArmReport {
            machine: "here".to_owned(),
            port: "sim".to_owned(),
            is_virtual: true,
            state: json!({"x": x}),
        };
        SiteEvent::Report(at(arm), report)
    }

    fn read(events: &mut SiteEvents) -> Vec<SiteEvent> {
        std::iter::from_fn(|| events.try_next()).collect()
    }

    #[test]
    fn station_id_has_one_text_form() {
        assert_eq!(StationId(0xab).to_string(), "00000000000000ab");
        assert_eq!(StationId::named("00000000000000ab"), Some(StationId(0xab)));
        for wrong in ["ab", "00000000000000AB", "+0000000000000ab", "", "é"] {
            assert_eq!(StationId::named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn only_the_newest_unread_state_is_delivered() {
        let (sender, mut events) = event_channel();
        for event in [
            SiteEvent::Arrived(at("a")),
            report("a", 1),
            report("b", 1),
            SiteEvent::Left(at("c")),
            report("a", 2),
        ] {
            assert!(sender.send(event));
        }
        let expected = [
            SiteEvent::Arrived(at("a")),
            report("a", 2),
            report("b", 1),
            SiteEvent::Left(at("c")),
        ];
        assert_eq!(read(&mut events), expected);
        sender.send(report("a", 3));
        assert_eq!(read(&mut events), [report("a", 3)]);
        drop(events);
        assert!(!sender.send(report("a", 4)));
    }

    #[test]
    fn no_state_follows_a_departure() {
        let (sender, mut events) = event_channel();
        sender.send(report("a", 1));
        sender.send(SiteEvent::Left(at("a")));
        sender.send(SiteEvent::Arrived(at("a")));
        sender.send(report("a", 2));
        let expected = [
            SiteEvent::Left(at("a")),
            SiteEvent::Arrived(at("a")),
            report("a", 2),
        ];
        assert_eq!(read(&mut events), expected);
    }

    #[test]
    fn slow_reader_gets_a_missed_event() {
        let (sender, mut events) = event_channel();
        for _ in 0..=MAX_WAITING {
            sender.send(SiteEvent::Left(at("b")));
        }
        sender.send(report("a", 1));
        assert_eq!(read(&mut events), [SiteEvent::Missed, report("a", 1)]);
    }
}

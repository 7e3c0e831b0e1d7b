//! One connection of a client: its session, its limits, what it subscribes to, and what waits to be sent.

#[cfg(feature = "class")]
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use magician::admission::Origin;
use magician_protocol::HostInstant;
use serde_json::{Map, Value};

use super::Grant;
use super::newest::Newest;
use super::outbox::Outbox;
use super::throttle::{Pace, Throttle};
use crate::control::{ArmId, SessionId};

/// Messages of a client in any second.
pub const RATE: usize = 200;
/// Requests of a client under way.
pub const UNDER_WAY: usize = 64;
/// Subscriptions.
pub(super) const SUBSCRIPTIONS: usize = 16;
/// Time to say hello for a client of this machine.
const HELLO: Duration = Duration::from_secs(5);
/// Time to say hello for a client from elsewhere. A page says it as soon as it is connected; who only holds a place is shut
/// out sooner.
const HELLO_FROM_ELSEWHERE: Duration = Duration::from_secs(2);

/// Time in which a client of this machine gives way to no other: for a program that is slow to say hello on a busy machine.
/// The four silent sockets of this machine are 40 a second then.
const GRACE: Duration = Duration::from_millis(100);
/// The same for a client from elsewhere: a round trip of a bad wireless network. Twelve silent sockets are 24 a second.
const GRACE_FROM_ELSEWHERE: Duration = Duration::from_millis(500);

/// The code of a close, as in RFC 6455, and this API's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CloseCode(pub u16);

impl CloseCode {
    /// The first message was no good hello.
    pub const HELLO: Self = Self(4400);
    /// No token, or a wrong one.
    pub const TOKEN: Self = Self(4401);
    /// What the client may do has changed: it comes again. (Service restart, RFC 6455's registry.)
    pub const AGAIN: Self = Self(1012);
    /// The token was revoked.
    pub const REVOKED: Self = Self(4403);
    /// No hello in time.
    pub const LATE: Self = Self(4408);
    /// The session has another socket now.
    pub const TAKEN_OVER: Self = Self(4409);
    /// Too much waits to be read.
    pub const SLOW: Self = Self(4413);
    /// Too many messages.
    pub const TOO_MANY: Self = Self(4429);
    /// The station has as many sessions, or viewers, as it takes.
    pub const FULL: Self = Self(4503);
}

/// Who is at the other end, as the listener knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// What it may do without a token; none: what its place may do, which is nothing from elsewhere, and on this machine a
    /// teacher's role, or a viewer's while a class is set.
    pub grant: Option<Grant>,
    /// Where it comes from.
    pub origin: Origin,
    /// Its address, and behind a blank the name in its certificate if it has shown one; for the journal.
    pub address: String,
    /// A secret for the session to come back with: new for each socket, at least 16 random bytes as text.
    pub secret: String,
}

impl Peer {
    /// What tells its place from others where tries are counted: the machine, without the port; of IPv6 the network, of which
    /// a host has all addresses.
    #[cfg(feature = "class")]
    pub(super) fn place(&self) -> String {
        let address = self.address.split(' ').next().unwrap_or_default();
        let address: Option<SocketAddr> = address.parse().ok();
        match address.map(|address| address.ip().to_canonical()) {
            Some(IpAddr::V6(address)) if !address.is_loopback() => {
                let [a, b, c, d, ..] = address.segments();
                format!("{a:x}:{b:x}:{c:x}:{d:x}::/64")
            }
            Some(address) => address.to_string(),
            None => self.address.clone(),
        }
    }
}

/// What a listener sends.
#[derive(Clone, Debug, PartialEq)]
pub enum Outgoing {
    /// A text message.
    Text(String),
    /// A binary message.
    Frame(Vec<u8>),
    /// The end, after which nothing comes.
    Close(CloseCode),
}

/// A subscription of a socket.
#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) id: u16,
    pub(super) arm: ArmId,
    pub(super) period: Duration,
    pub(super) binary: bool,
    pub(super) pins: Vec<magician::Pin>,
    /// When the next state is due.
    pub(super) due: HostInstant,
    /// The state that was sent last, in JSON.
    pub(super) sent: Arc<Map<String, Value>>,
    /// States that were due so far.
    pub(super) sequence: u32,
    /// Whether its line was told to be lost.
    pub(super) lost: bool,
}

#[derive(Debug)]
pub(super) struct Socket {
    pub(super) peer: Peer,
    /// What the token of its hello allows.
    pub(super) vouched: Option<Grant>,
    pub(super) session: Option<SessionId>,
    pub(super) opened: HostInstant,
    pub(super) subscriptions: Vec<Subscription>,
    pub(super) under_way: usize,
    next_subscription: u16,
    pub(super) outbox: Outbox<Newest>,
    throttle: Throttle,
    /// It is a link's: it has methods of its own, and its own bounds in place of those of a socket.
    pub(super) link: bool,
    /// The program's call that a link's message is made for.
    pub(super) calls: Option<String>,
}

impl Socket {
    pub(super) fn new(now: HostInstant, peer: Peer) -> Self {
        Self {
            peer,
            vouched: None,
            session: None,
            opened: now,
            subscriptions: Vec::new(),
            under_way: 0,
            next_subscription: 0,
            outbox: Outbox::default(),
            throttle: Throttle::default(),
            link: false,
            calls: None,
        }
    }

    /// Time in which a client from there gives way to no other.
    pub(super) const fn grace(origin: Origin) -> Duration {
        match origin {
            Origin::Loopback => GRACE,
            Origin::Elsewhere => GRACE_FROM_ELSEWHERE,
        }
    }

    /// When it is closed if it has not said hello.
    pub(super) fn hello_due(&self) -> HostInstant {
        let time = match self.peer.origin {
            Origin::Loopback => HELLO,
            Origin::Elsewhere => HELLO_FROM_ELSEWHERE,
        };
        self.opened + time
    }

    /// Counts a message.
    pub(super) fn hears(&mut self, now: HostInstant) -> Pace {
        if self.link {
            return Pace::Fine;
        }
        self.throttle.hears(now, RATE)
    }

    pub(super) fn next_subscription(&mut self) -> u16 {
        loop {
            self.next_subscription = self.next_subscription.checked_add(1).unwrap_or(1);
            // After the last number come those that have ended.
            let id = self.next_subscription;
            if self.subscriptions.iter().all(|one| one.id != id) {
                return id;
            }
        }
    }
}

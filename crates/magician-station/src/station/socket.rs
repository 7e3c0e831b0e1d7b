//! Connection of a client: session, limits, subscriptions, outbox.

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
use super::throttle::{RateVerdict, Throttle};
use crate::control::{ArmId, SessionId};

/// Most messages of a client within any second. A choice, far above what a page sends.
pub const MAX_MESSAGES_PER_SECOND: usize = 200;
/// Most requests of a client in flight.
pub const MAX_REQUESTS_IN_FLIGHT: usize = 64;
/// Most subscriptions of a socket.
pub(super) const MAX_SUBSCRIPTIONS: usize = 16;
/// Time for a hello from this machine.
const HELLO_TIME: Duration = Duration::from_secs(5);
/// Time for a hello from elsewhere. A page sends it as soon as it is connected, so a socket without
/// one only occupies a place.
const REMOTE_HELLO_TIMEOUT: Duration = Duration::from_secs(2);

/// Time for which a socket of this machine is not evicted, so that a program on a busy machine can
/// say hello. With four places this admits 40 silent sockets per second.
const EVICTION_GRACE: Duration = Duration::from_millis(100);
/// The same for a socket from elsewhere: a round trip on a bad wireless network. With twelve places
/// this admits 24 silent sockets per second.
const REMOTE_EVICTION_GRACE: Duration = Duration::from_millis(500);

/// Close code of a WebSocket, from RFC 6455 or of this API.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CloseCode(pub u16);

impl CloseCode {
    /// The first message was not a valid hello.
    pub const BAD_HELLO: Self = Self(4400);
    /// The token is missing or invalid.
    pub const BAD_TOKEN: Self = Self(4401);
    /// The rights of the client have changed: reconnect. (Service restart in the registry of RFC
    /// 6455.)
    pub const RECONNECT: Self = Self(1012);
    /// The token was revoked.
    pub const REVOKED: Self = Self(4403);
    /// No hello in time.
    pub const HELLO_TIMEOUT: Self = Self(4408);
    /// Another socket has resumed the session.
    pub const TAKEN_OVER: Self = Self(4409);
    /// Too many unread messages.
    pub const SLOW: Self = Self(4413);
    /// Too many messages sent.
    pub const TOO_MANY: Self = Self(4429);
    /// All sessions, or all places for viewers, are in use.
    pub const FULL: Self = Self(4503);
}

/// Client at the other end, as known to the listener.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Rights without a token. `None` for those of the origin: none from elsewhere; on this machine
    /// those of a teacher, or of a viewer while a class is set.
    pub grant: Option<Grant>,
    /// Origin of the connection.
    pub origin: Origin,
    /// Address, followed by a space and the name in its certificate if it has shown one; for the
    /// journal.
    pub address: String,
    /// Secret for resuming the session: at least 16 random bytes as text, new for each socket.
    pub secret: String,
}

impl Peer {
    /// Returns the key under which tries of this client are counted: the host without the port. For
    /// IPv6 the /64 network, because a host owns all addresses in it.
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

/// Message to a client.
#[derive(Clone, Debug, PartialEq)]
pub enum Outgoing {
    /// Text message.
    Text(String),
    /// Binary message.
    Frame(Vec<u8>),
    /// Close. Nothing follows.
    Close(CloseCode),
}

/// Subscription of a socket.
#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) id: u16,
    pub(super) arm: ArmId,
    pub(super) period: Duration,
    pub(super) binary: bool,
    pub(super) pins: Vec<magician::Pin>,
    /// Instant at which the next state is due.
    pub(super) due: HostInstant,
    /// Last state that was sent as JSON.
    pub(super) sent: Arc<Map<String, Value>>,
    /// Number of states that were due so far.
    pub(super) sequence: u32,
    /// True if the client was notified that the line is lost.
    pub(super) lost: bool,
}

#[derive(Debug)]
pub(super) struct Socket {
    pub(super) peer: Peer,
    /// Rights of the token in its hello.
    pub(super) token_grant: Option<Grant>,
    pub(super) session: Option<SessionId>,
    pub(super) opened: HostInstant,
    pub(super) subscriptions: Vec<Subscription>,
    pub(super) under_way: usize,
    next_subscription: u16,
    pub(super) outbox: Outbox<Newest>,
    throttle: Throttle,
    /// True for a link, which has its own methods and limits.
    pub(super) link: bool,
    /// Call of the program for which a link's message was made.
    pub(super) calls: Option<String>,
}

impl Socket {
    pub(super) fn new(now: HostInstant, peer: Peer) -> Self {
        Self {
            peer,
            token_grant: None,
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

    /// Returns the time for which a client from this origin is not evicted.
    pub(super) const fn grace(origin: Origin) -> Duration {
        match origin {
            Origin::Loopback => EVICTION_GRACE,
            Origin::Elsewhere => REMOTE_EVICTION_GRACE,
        }
    }

    /// Returns the instant at which the socket is closed unless it has said hello.
    pub(super) fn hello_due(&self) -> HostInstant {
        let time = match self.peer.origin {
            Origin::Loopback => HELLO_TIME,
            Origin::Elsewhere => REMOTE_HELLO_TIMEOUT,
        };
        self.opened + time
    }

    /// Counts a message.
    pub(super) fn count_message(&mut self, now: HostInstant) -> RateVerdict {
        // A link limits its program itself.
        if self.link {
            return RateVerdict::Accept;
        }
        self.throttle.check(now, MAX_MESSAGES_PER_SECOND)
    }

    pub(super) fn next_subscription(&mut self) -> u16 {
        loop {
            self.next_subscription = self.next_subscription.checked_add(1).unwrap_or(1);
            // After the last number, numbers of ended subscriptions are used again.
            let id = self.next_subscription;
            if self.subscriptions.iter().all(|one| one.id != id) {
                return id;
            }
        }
    }
}

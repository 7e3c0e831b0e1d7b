//! One connection of a client: its session, its limits, what it subscribes to, and what waits to be sent.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::{Map, Value};

use super::Grant;
use crate::control::{ArmId, SessionId};

/// Messages in any second.
pub(super) const RATE: usize = 200;
/// Requests under way.
pub(super) const UNDER_WAY: usize = 64;
/// Subscriptions.
pub(super) const SUBSCRIPTIONS: usize = 16;
/// A socket that does not say hello for so long is closed.
pub(super) const HELLO: Duration = Duration::from_secs(5);
/// A socket that sends too much for so long is closed.
const OVER: Duration = Duration::from_secs(5);
/// Unsent notifications and frames, bytes.
const NOTICES: usize = 256 * 1024;
/// Unsent answers, bytes.
const ANSWERS: usize = 8 * 1024 * 1024;

/// The code of a close, as in RFC 6455, and this API's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CloseCode(pub u16);

impl CloseCode {
    /// The first message was no good hello.
    pub const HELLO: Self = Self(4400);
    /// No token, or a wrong one.
    pub const TOKEN: Self = Self(4401);
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
}

/// Who is at the other end, as the listener knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// What it may do without a token; none: it needs one.
    pub grant: Option<Grant>,
    /// Its address, for the journal.
    pub address: String,
    /// A secret for the session to come back with: new for each socket, at least 16 random bytes as text.
    pub secret: String,
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

/// What waits to be sent.
#[derive(Debug)]
enum Waiting {
    Answer(String),
    Notice(String),
    /// The newest state, made when it is sent.
    State(u16),
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
    waiting: VecDeque<Waiting>,
    notices: usize,
    answers: usize,
    /// It is over when what waits was sent.
    closing: Option<CloseCode>,
    /// The end was sent.
    ended: bool,
    /// The last messages.
    heard: VecDeque<HostInstant>,
    over_since: Option<HostInstant>,
    /// It is a link's: it has methods of its own, and its own bounds in place of those of a socket.
    pub(super) link: bool,
    /// The program's call that a link's message is made for.
    pub(super) calls: Option<String>,
}

/// How a message stands to the limits.
pub(super) enum Pace {
    Fine,
    TooMany,
    Close,
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
            waiting: VecDeque::new(),
            notices: 0,
            answers: 0,
            closing: None,
            ended: false,
            heard: VecDeque::new(),
            over_since: None,
            link: false,
            calls: None,
        }
    }

    /// Counts a message.
    pub(super) fn hears(&mut self, now: HostInstant) -> Pace {
        if self.link {
            return Pace::Fine;
        }
        let second = Duration::from_secs(1);
        while self.heard.front().is_some_and(|at| now - *at >= second) {
            self.heard.pop_front();
        }
        if self.heard.len() < RATE {
            self.heard.push_back(now);
            self.over_since = self.over_since.filter(|since| now - *since < second);
            return Pace::Fine;
        }
        // What is refused counts, too: the second goes on.
        self.heard.pop_front();
        self.heard.push_back(now);
        let since = *self.over_since.get_or_insert(now);
        if now - since >= OVER {
            Pace::Close
        } else {
            Pace::TooMany
        }
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

    pub(super) fn is_closing(&self) -> bool {
        self.closing.is_some()
    }

    /// Ends it when what waits was sent.
    pub(super) fn close(&mut self, code: CloseCode) {
        self.closing.get_or_insert(code);
    }

    /// Ends it now: what waits is not sent.
    fn cut(&mut self, code: CloseCode) {
        self.waiting.clear();
        (self.notices, self.answers) = (0, 0);
        self.closing = Some(code);
    }

    pub(super) fn answer(&mut self, text: String) {
        // Nothing comes behind the end.
        if self.ended {
            return;
        }
        self.answers += text.len();
        self.waiting.push_back(Waiting::Answer(text));
        if self.answers > ANSWERS {
            self.cut(CloseCode::SLOW);
        }
    }

    pub(super) fn notice(&mut self, text: String) {
        if self.closing.is_some() {
            return;
        }
        self.notices += text.len();
        self.waiting.push_back(Waiting::Notice(text));
        if self.notices > NOTICES {
            self.cut(CloseCode::SLOW);
        }
    }

    /// Goes with the state that is sent just now.
    pub(super) fn notice_next(&mut self, text: String) {
        self.notices += text.len();
        self.waiting.push_front(Waiting::Notice(text));
    }

    /// A state is due. One that waits already is the newest when it is sent.
    pub(super) fn state_due(&mut self, subscription: u16) -> bool {
        let waits =
            |waiting: &Waiting| matches!(waiting, Waiting::State(id) if *id == subscription);
        if self.closing.is_some() || self.waiting.iter().any(waits) {
            return false;
        }
        self.waiting.push_back(Waiting::State(subscription));
        true
    }

    /// A state that was due is not sent.
    pub(super) fn state_is_void(&mut self, subscription: u16) {
        self.waiting
            .retain(|waiting| !matches!(waiting, Waiting::State(id) if *id == subscription));
    }

    /// What waits to be sent: bytes, without states.
    pub(super) fn unsent(&self) -> usize {
        let text = |waiting: &Waiting| match waiting {
            Waiting::Answer(text) | Waiting::Notice(text) => text.len(),
            Waiting::State(_) => 0,
        };
        self.waiting.iter().map(text).sum()
    }

    /// What is to be sent next: a text, the state of a subscription, or the end.
    pub(super) fn next(&mut self) -> Option<Next> {
        match self.waiting.pop_front() {
            Some(Waiting::Answer(text)) => {
                self.answers -= text.len();
                Some(Next::Text(text))
            }
            Some(Waiting::Notice(text)) => {
                self.notices -= text.len();
                Some(Next::Text(text))
            }
            Some(Waiting::State(subscription)) => Some(Next::State(subscription)),
            None => {
                self.ended = self.closing.is_some();
                self.closing.map(Next::Close)
            }
        }
    }
}

/// What a socket sends next.
pub(super) enum Next {
    Text(String),
    State(u16),
    Close(CloseCode),
}

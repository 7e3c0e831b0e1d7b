//! The hub: a gateway that shows all arms of a site to clients as the arms of one station.
//!
//! Clients talk to a hub exactly as to a station. For each client the hub opens a session of its
//! own at every station that the client needs, over a *line* (a [`Channel`](crate::Channel)), and
//! passes requests on. A lease therefore stays with the station that owns the arm: if the hub dies,
//! the stations' own keep-alive timeouts end its clients' jogs and leases, and nothing else stops.
//! Requests that concern no arm go to the hub's own station without arms, called *home*. Requests
//! about several stations are *gathered*: the hub asks each of them and merges the replies.
//!
//! Ids of stations would clash, so the hub prefixes each with a number for its station (`names`).
//! Lost lines are opened again with backoff, but no request is ever retransmitted: its client gets
//! an error that says whether the request was sent.
//!
//! [`Hub`] is a state machine without I/O and clock. [`RunningHub`] drives it on a tokio runtime.

mod answers;
mod arms;
mod class;
mod class_watch;
mod clients;
mod driver;
mod gather;
mod lines;
mod names;
mod requests;
mod running;
mod socket;
mod stops;
mod subscriptions;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::api::{MessageId, RpcError, answer_due, notification};
use magician_station::{Next, Outgoing};
use serde_json::Value;

use self::arms::{ArmEntry, DEPARTED_LISTED_TIME};
use self::clients::{ClientSession, RESUME_TIME};
use self::gather::{Gather, GatherId};
use self::names::Names;
pub use self::running::{HubClient, HubConfig, RunningHub};
use self::socket::{Line, Pending, Socket};
use crate::site::{ArmAt, StationId};

/// Timeout of a line: for its hello, and for the reply to a probe. Equal to the timeout after which
/// stations release the lease of a silent holder, so that both sides give up at about the same
/// time.
const LINE_TIMEOUT: Duration = Duration::from_secs(5);

/// Connection of a client to the hub.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SocketId(pub u64);

/// Line of one client to one station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineId(pub u64);

/// Request that the hub has passed on. Also its JSON-RPC id at the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RequestId(pub u64);

/// Action that the hub asks its driver to carry out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HubAction {
    /// Send this message to home, over the client's own connection there.
    Home(SocketId, String),
    /// Open a session with a station. Answer with [`Hub::line_opened`] or [`Hub::line_ended`].
    Open(LineId, StationId),
    /// The line has a message to send. Fetch it with [`Hub::poll_line`].
    Awake(LineId),
    /// Close the line.
    Drop(LineId),
    /// Send a single request outside of all lines. Answer with [`Hub::call_completed`].
    Call {
        /// Id for the reply.
        request: RequestId,
        /// Client that made the request.
        socket: SocketId,
        /// Arm whose station gets the request.
        at: ArmAt,
        /// Token of the client.
        token: Option<String>,
        /// JSON-RPC text of the request.
        text: String,
        /// True if the request is cancelled when its client disconnects. False for a stop.
        ends: bool,
    },
}

/// Message to a station over a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineMessage {
    /// JSON-RPC message.
    Text(String),
    /// Keep-alive of the client.
    KeepAlive,
}

/// State machine that serves all arms of a site to many clients.
///
/// Inputs are events on the site ([`site`](Self::site)), messages of clients
/// ([`receive`](Self::receive)), and messages from home and from lines. After each input,
/// [`poll_action`](Self::poll_action) returns the actions to carry out, and
/// [`poll_send`](Self::poll_send) the messages for a client. The hub reads no clock: each input
/// carries the time, and [`poll_timeout`](Self::poll_timeout) says when
/// [`handle_timeout`](Self::handle_timeout) is due.
pub struct Hub {
    /// Token for clients of this machine that bring none.
    token: Option<String>,
    /// Unix time in seconds at [`HostInstant::ZERO`].
    unix_zero: f64,
    /// Unpredictable numbers, used to generate the codes of pupils.
    random: fn() -> u64,
    names: Names,
    stations: BTreeMap<StationId, (u32, BTreeSet<String>)>,
    arms: BTreeMap<String, ArmEntry>,
    client_sessions: BTreeMap<String, ClientSession>,
    sockets: BTreeMap<SocketId, Socket>,
    lines: BTreeMap<LineId, Line>,
    pending: BTreeMap<RequestId, Pending>,
    gathers: BTreeMap<GatherId, Gather>,
    /// Sessions of home as of its last notification.
    sessions: Value,
    actions: VecDeque<HubAction>,
    awake: BTreeSet<SocketId>,
    ids: u64,
}

impl fmt::Debug for Hub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hub")
            .field("stations", &self.stations)
            .field("sockets", &self.sockets.len())
            .field("lines", &self.lines.len())
            .field("pending", &self.pending.len())
            .finish_non_exhaustive()
    }
}

impl Hub {
    /// Creates the hub of a site of which nothing is known yet.
    ///
    /// Clients of this machine without a token use `token` at stations. `unix_zero` is the Unix
    /// time in seconds at [`HostInstant::ZERO`]. `random` has to be unpredictable: codes of pupils
    /// are made from it.
    #[must_use]
    pub fn new(token: Option<String>, unix_zero: f64, random: fn() -> u64) -> Self {
        Self {
            token,
            unix_zero,
            random,
            names: Names::default(),
            stations: BTreeMap::new(),
            arms: BTreeMap::new(),
            client_sessions: BTreeMap::new(),
            sockets: BTreeMap::new(),
            lines: BTreeMap::new(),
            pending: BTreeMap::new(),
            gathers: BTreeMap::new(),
            sessions: Value::Null,
            actions: VecDeque::new(),
            awake: BTreeSet::new(),
            // Above any id that a client is likely to use: home sees the ids of the hub and of the
            // client on the same connection.
            ids: 1 << 40,
        }
    }

    /// Token for clients of this machine that bring none.
    fn token(&self) -> Option<String> {
        self.token.clone()
    }

    /// Returns the next action to carry out, or `None` if nothing is queued.
    pub fn poll_action(&mut self) -> Option<HubAction> {
        self.actions.pop_front()
    }

    /// Returns a client with new messages since the last call, or `None`.
    pub fn poll_awake(&mut self) -> Option<SocketId> {
        self.awake.pop_first()
    }

    /// Returns the next message for a client. Call it only when the client can take a message:
    /// states are encoded at this moment, so that they are the newest.
    pub fn poll_send(&mut self, socket: SocketId) -> Option<Outgoing> {
        loop {
            match self.sockets.get_mut(&socket)?.outbox.pop()? {
                Next::Text(text) => return Some(Outgoing::Text(text)),
                Next::Close(code) => return Some(Outgoing::Close(code)),
                Next::State(SESSIONS_SUBSCRIPTION) => {
                    let list = self.known_sessions(socket);
                    return Some(Outgoing::Text(notification("session.changed", &list)));
                }
                Next::State(subscription) => {
                    if let Some(state) = self.state_for(socket, subscription) {
                        return Some(state);
                    }
                }
            }
        }
    }

    /// Handles all timeouts that are due at `now`.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        for gather in keys_where(&self.gathers, |gather| gather.due <= now) {
            self.finish_gather(now, gather);
        }
        let silent = |line: &Line| line.reply_deadline().is_some_and(|at| at <= now);
        for line in keys_where(&self.lines, silent) {
            let why = "its station does not answer";
            self.lose_line(now, line, RpcError::arm(magician::ErrorKind::Port, why));
        }
        self.reopen_lines(now);
        for socket in keys_where(&self.sockets, |socket| socket.sessions_changed) {
            self.send_sessions(now, socket);
        }
        let over = |client: &ClientSession| {
            client
                .disconnected_at
                .is_some_and(|gone| gone + RESUME_TIME <= now)
        };
        for session in keys_where(&self.client_sessions, over) {
            self.forget(&session);
        }
        self.arms.retain(|_, entry| {
            entry
                .departed_at
                .is_none_or(|gone| gone + DEPARTED_LISTED_TIME > now)
        });
    }

    /// Time of the next [`handle_timeout`](Self::handle_timeout), or `None` if nothing is pending.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let client_sessions = self.client_sessions.values();
        let client_sessions =
            client_sessions.filter_map(|client| Some(client.disconnected_at? + RESUME_TIME));
        let arms = self.arms.values();
        let arms = arms.filter_map(|entry| Some(entry.departed_at? + DEPARTED_LISTED_TIME));
        { self.gathers.values() }
            .map(|gather| gather.due)
            .chain(self.lines.values().filter_map(Line::reply_deadline))
            .chain(self.reopen_times())
            .chain(client_sessions)
            .chain(arms)
            .chain(self.sockets.values().filter_map(Socket::list_due))
            .min()
    }

    fn next_id(&mut self) -> u64 {
        self.ids += 1;
        self.ids
    }

    fn unix(&self, now: HostInstant) -> f64 {
        // Rounded to the resolution of the clock, 1 us, so that JSON shows no floating-point noise.
        ((self.unix_zero + now.as_micros() as f64 / 1e6) * 1e6).round() / 1e6
    }

    /// Replies to a request that was counted as in flight.
    fn finish(
        &mut self,
        socket: SocketId,
        id: Option<&MessageId>,
        outcome: &Result<Value, RpcError>,
    ) {
        self.request_finished(socket);
        self.respond(socket, id, outcome);
    }

    /// Decrements the number of a client's requests in flight.
    fn request_finished(&mut self, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.in_flight = open.in_flight.saturating_sub(1);
        }
    }

    /// Sends a reply, unless the request was a notification.
    fn respond(
        &mut self,
        socket: SocketId,
        id: Option<&MessageId>,
        outcome: &Result<Value, RpcError>,
    ) {
        if let Some(text) = answer_due(id, outcome)
            && let Some(open) = self.sockets.get_mut(&socket)
        {
            open.outbox.answer(text);
            self.awake.insert(socket);
        }
    }
}

/// Keys of the entries whose values satisfy the predicate.
fn keys_where<K: Clone, V>(map: &BTreeMap<K, V>, is: impl Fn(&V) -> bool) -> Vec<K> {
    let entries = map.iter().filter(|(_, value)| is(value));
    entries.map(|(key, _)| key.clone()).collect()
}

/// Pseudo subscription for the list of sessions in the outbox. Real subscriptions start at 1.
const SESSIONS_SUBSCRIPTION: u16 = 0;

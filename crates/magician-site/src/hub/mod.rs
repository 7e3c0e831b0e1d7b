//! The hub: clients see all arms of a site as the arms of one station.
//!
//! [`Hub`] is the whole of it without I/O and clock. Each client has a session of its own at each station, by a line that is
//! opened when it is needed first: a lease stays with the station that has the arm, and a hub that dies stops nothing but the
//! jogs and leases of its clients, by the stations' own clocks. What needs no arm a station without arms answers, the hub's own
//! ("home"). [`RunningHub`] is a hub at work.

mod acting;
mod answers;
mod arms;
mod class;
mod clients;
mod elsewhere;
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

use self::arms::{ArmPlace, GONE};
use self::clients::{Person, RESUMES};
use self::gather::{Gather, GatherId};
use self::names::Names;
pub use self::running::{HubClient, HubConfig, RunningHub};
use self::socket::{Line, Pending, Socket};
use crate::site::{ArmAt, StationId};

/// A line that does not come up, and a station that does not say a word for so long, are given up.
const SILENT: Duration = Duration::from_secs(5);

/// A client of the hub.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SocketId(pub u64);

/// A line of a client to a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineId(pub u64);

/// A request that the hub has sent on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RequestId(pub u64);

/// What the hub wants done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HubAct {
    /// This message goes to the hub's own station, by the client's connection there.
    Home(SocketId, String),
    /// A session with a station: [`Hub::line_opened`] or [`Hub::line_ended`] follows.
    Open(LineId, StationId),
    /// Something waits for a line: [`Hub::poll_line`].
    Awake(LineId),
    /// A line is given up.
    Drop(LineId),
    /// A request beside all lines: [`Hub::called`] follows.
    Call {
        /// Under this number.
        request: RequestId,
        /// For whom.
        socket: SocketId,
        /// To an arm's station.
        at: ArmAt,
        /// With this token.
        token: Option<String>,
        /// The request.
        text: String,
        /// Whether it ends with its client. A stop does not.
        ends: bool,
    },
}

/// What goes to a station by a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineMessage {
    /// A message.
    Text(String),
    /// A sign of life of the client.
    Alive,
}

/// All arms of a site for many clients.
///
/// It is told what happens on the site ([`site`](Self::site)), what clients send ([`receive`](Self::receive)), and what comes from
/// its own station and from lines; [`poll_act`](Self::poll_act) says what is to be done, [`poll_send`](Self::poll_send) what a
/// client is to be sent. Time is what the calls say; [`poll_timeout`](Self::poll_timeout) tells when
/// [`handle_timeout`](Self::handle_timeout) is due.
pub struct Hub {
    /// The token for clients of this machine that have none.
    token: Option<String>,
    /// Unix seconds at [`HostInstant::ZERO`].
    unix_zero: f64,
    /// Numbers that nobody can guess, for the codes of a class.
    random: fn() -> u64,
    names: Names,
    stations: BTreeMap<StationId, (u32, BTreeSet<String>)>,
    arms: BTreeMap<String, ArmPlace>,
    people: BTreeMap<String, Person>,
    sockets: BTreeMap<SocketId, Socket>,
    lines: BTreeMap<LineId, Line>,
    pending: BTreeMap<RequestId, Pending>,
    gathers: BTreeMap<GatherId, Gather>,
    /// The sessions of home, as it told of them last.
    sessions: Value,
    acts: VecDeque<HubAct>,
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
    /// A hub of a site on which nothing is known yet. Clients of this machine that bring no token have `token` at stations;
    /// `unix_zero` is the time at [`HostInstant::ZERO`], Unix seconds; codes of a class are made of the numbers of `random`.
    #[must_use]
    pub fn new(token: Option<String>, unix_zero: f64, random: fn() -> u64) -> Self {
        Self {
            token,
            unix_zero,
            random,
            names: Names::default(),
            stations: BTreeMap::new(),
            arms: BTreeMap::new(),
            people: BTreeMap::new(),
            sockets: BTreeMap::new(),
            lines: BTreeMap::new(),
            pending: BTreeMap::new(),
            gathers: BTreeMap::new(),
            sessions: Value::Null,
            acts: VecDeque::new(),
            awake: BTreeSet::new(),
            // Beyond what clients count to: home sees both.
            ids: 1 << 40,
        }
    }

    /// The token for clients of this machine that have none.
    fn token(&self) -> Option<String> {
        self.token.clone()
    }

    /// What is to be done next.
    pub fn poll_act(&mut self) -> Option<HubAct> {
        self.acts.pop_front()
    }

    /// A client that has something to be sent since it was asked last.
    pub fn poll_awake(&mut self) -> Option<SocketId> {
        self.awake.pop_first()
    }

    /// What a client is to be sent next. Ask when it can take it: a state is the newest one then.
    pub fn poll_send(&mut self, socket: SocketId) -> Option<Outgoing> {
        loop {
            match self.sockets.get_mut(&socket)?.outbox.pop()? {
                Next::Text(text) => return Some(Outgoing::Text(text)),
                Next::Close(code) => return Some(Outgoing::Close(code)),
                Next::State(SESSIONS) => {
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

    /// Something that is due by now.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        for gather in keys_where(&self.gathers, |gather| gather.due <= now) {
            self.gathered(now, gather);
        }
        let silent = |line: &Line| line.silent_at().is_some_and(|at| at <= now);
        for line in keys_where(&self.lines, silent) {
            let why = "its station does not answer";
            self.lose_line(now, line, RpcError::arm(magician::ErrorKind::Port, why));
        }
        self.open_again(now);
        for socket in keys_where(&self.sockets, |socket| socket.list_waits) {
            self.tell_sessions(now, socket);
        }
        let over = |person: &Person| person.gone.is_some_and(|gone| gone + RESUMES <= now);
        for session in keys_where(&self.people, over) {
            self.forget(&session);
        }
        self.arms
            .retain(|_, place| place.gone.is_none_or(|gone| gone + GONE > now));
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let people = self.people.values();
        let people = people.filter_map(|person| Some(person.gone? + RESUMES));
        let arms = self.arms.values();
        let arms = arms.filter_map(|place| Some(place.gone? + GONE));
        { self.gathers.values() }
            .map(|gather| gather.due)
            .chain(self.lines.values().filter_map(Line::silent_at))
            .chain(self.opens_at())
            .chain(people)
            .chain(arms)
            .chain(self.sockets.values().filter_map(Socket::list_due))
            .min()
    }

    fn next_id(&mut self) -> u64 {
        self.ids += 1;
        self.ids
    }

    fn unix(&self, now: HostInstant) -> f64 {
        ((self.unix_zero + now.as_micros() as f64 / 1e6) * 1e6).round() / 1e6
    }

    /// Answers a request that was counted as under way.
    fn finish(
        &mut self,
        socket: SocketId,
        id: Option<&MessageId>,
        outcome: &Result<Value, RpcError>,
    ) {
        self.is_over(socket);
        self.respond(socket, id, outcome);
    }

    /// A request of a client is under way no more.
    fn is_over(&mut self, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.under_way = open.under_way.saturating_sub(1);
        }
    }

    /// Answers, unless it was a notification, which has no answer.
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

/// The keys whose values are so.
fn keys_where<K: Clone, V>(map: &BTreeMap<K, V>, is: impl Fn(&V) -> bool) -> Vec<K> {
    let entries = map.iter().filter(|(_, value)| is(value));
    entries.map(|(key, _)| key.clone()).collect()
}

/// In place of a subscription, whose numbers begin with 1: the list of sessions is due.
const SESSIONS: u16 = 0;

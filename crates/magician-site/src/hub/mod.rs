//! The hub: clients see all arms of a site as the arms of one station.
//!
//! [`Hub`] is the whole of it without I/O and clock. Each client has a session of its own at each station, by a line that is
//! opened when it is needed first: a lease stays with the station that has the arm, and a hub that dies stops nothing but the
//! jogs and leases of its clients, by the stations' own clocks. What needs no arm a station without arms answers, the hub's own
//! ("home"). [`RunningHub`] is a hub at work.

mod class;
mod lines;
mod lists;
mod names;
mod requests;
mod running;
mod socket;
mod subscriptions;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::api::{MessageId, Role, RpcError, answer_due, notification};
use magician_station::{LIST_INTERVAL, Next, Outgoing, SOCKETS};
use serde_json::Value;

use self::names::Names;
pub use self::running::{HubClient, HubConfig, RunningHub};
use self::socket::{Gather, GatherId, Line, Pending, Socket};
use crate::roster::Roster;
use crate::site::{ArmAt, ArmNews, SiteEvent, StationId};

/// A line that does not come up, and a station that does not say a word for so long, are given up.
const SILENT: Duration = Duration::from_secs(5);
/// An arm that is gone is shown, and named by a stop of all, for so long.
const GONE: Duration = Duration::from_secs(600);
/// Sessions at stations wait so long for a client that comes back; stations have 5 s.
const RESUMES: Duration = Duration::from_secs(6);
/// Arms that are gone, at most.
const MOST_GONE: usize = 1000;

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

/// An arm, as far as it is known.
#[derive(Debug, Default)]
struct ArmPlace {
    /// The stations that have it: one, but where two have the same name.
    at: BTreeMap<StationId, Option<(HostInstant, ArmNews)>>,
    /// What was listed of it last.
    row: Option<Value>,
    gone: Option<HostInstant>,
    /// It is in the roster: it is named as missing until it comes, however long that takes.
    expected: bool,
}

/// A session of the hub, as stations know it.
#[derive(Debug, Default)]
struct Person {
    name: String,
    /// Where it has a session: the secret to come back with, and its id there.
    at: BTreeMap<StationId, (String, String)>,
    gone: Option<HostInstant>,
    /// The role of the socket that it left with.
    left_as: Option<Role>,
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

    /// Something happens on the site. Of [`SiteEvent::Missed`] nothing follows: [`on_site`](Self::on_site) tells what is there.
    pub fn site(&mut self, now: HostInstant, event: SiteEvent) {
        match event {
            SiteEvent::Arrived(at) => self.arrives(now, at),
            SiteEvent::Left(at) => self.leaves(now, &at),
            SiteEvent::News(at, news) => {
                let place = self.arms.get_mut(&at.arm);
                if let Some(known) = place.and_then(|place| place.at.get_mut(&at.station)) {
                    *known = Some((now, news));
                }
            }
            // Clients hear of these by their own sessions.
            SiteEvent::Event(..) | SiteEvent::Job(..) | SiteEvent::Missed => {}
        }
    }

    /// These arms are on the site, and no others.
    pub fn on_site(&mut self, now: HostInstant, arms: BTreeSet<ArmAt>) {
        let known = self.arms.iter().flat_map(|(arm, place)| {
            let at = |station: &StationId| ArmAt {
                arm: arm.clone(),
                station: *station,
            };
            place.at.keys().map(at).collect::<Vec<_>>()
        });
        for gone in known.filter(|at| !arms.contains(at)).collect::<Vec<_>>() {
            self.leaves(now, &gone);
        }
        for at in arms {
            self.arrives(now, at);
        }
    }

    /// These arms are expected on the site: whatever is asked of all names those that are missing.
    pub fn expects(&mut self, roster: &Roster) {
        for (arm, _) in roster.arms() {
            self.arms.entry(arm.to_owned()).or_default().expected = true;
        }
    }

    fn arrives(&mut self, now: HostInstant, at: ArmAt) {
        let ArmAt { arm, station } = at;
        let slot = self.names.arrives(station, &arm);
        let (_, arms) = self
            .stations
            .entry(station)
            .or_insert((slot, BTreeSet::new()));
        arms.insert(arm.clone());
        let place = self.arms.entry(arm.clone()).or_default();
        place.gone = None;
        place.at.entry(station).or_insert(None);
        let wants = |socket: &Socket| {
            let subscribes = || socket.subscriptions.values().any(|one| one.arm == arm);
            socket.session.is_some() && (socket.wide || subscribes())
        };
        let wanting = self.sockets.iter().filter(|(_, socket)| wants(socket));
        for socket in wanting.map(|(id, _)| *id).collect::<Vec<_>>() {
            let _ = self.line_to(now, socket, station);
        }
    }

    fn leaves(&mut self, now: HostInstant, at: &ArmAt) {
        if let Some(place) = self.arms.get_mut(&at.arm) {
            place.at.remove(&at.station);
            if place.at.is_empty() && !place.expected {
                place.gone = Some(now);
            }
        }
        let Some((_, arms)) = self.stations.get_mut(&at.station) else {
            return;
        };
        arms.remove(&at.arm);
        if arms.is_empty() {
            self.stations.remove(&at.station);
            let of = |(id, line): (&LineId, &Line)| (line.station == at.station).then_some(*id);
            for line in self.lines.iter().filter_map(of).collect::<Vec<_>>() {
                let why = "its station is not on the site any more";
                self.lose_line(now, line, RpcError::arm(magician::ErrorKind::Port, why));
            }
            self.names.leaves(at.station);
            for socket in self.sockets.values_mut() {
                socket.ways.remove(&at.station);
            }
        }
        let gone = self.arms.iter().filter(|(_, place)| place.gone.is_some());
        if gone.count() > MOST_GONE {
            self.arms.retain(|_, place| place.gone.is_none());
        }
    }

    /// A client connects, with the token of its request if it has one.
    pub fn open(&mut self, bearer: Option<String>) -> SocketId {
        let id = SocketId(self.next_id());
        // Until home says what it is.
        let socket = Socket::new(bearer, Role::Viewer, false);
        self.sockets.insert(id, socket);
        id
    }

    /// The token for clients of this machine that have none.
    pub(super) fn token(&self) -> Option<String> {
        self.token.clone()
    }

    /// A client connects for one request, which it may make by this role.
    pub fn open_once(&mut self, bearer: Option<String>, role: Role) -> SocketId {
        let id = SocketId(self.next_id());
        let token = bearer.clone().or_else(|| self.token.clone());
        let mut socket = Socket::new(bearer, role, true);
        socket.token = token;
        self.sockets.insert(id, socket);
        id
    }

    /// A client is gone, or was closed.
    pub fn close(&mut self, now: HostInstant, socket: SocketId) {
        self.drop_lines(socket);
        let Some(gone) = self.sockets.remove(&socket) else {
            return;
        };
        self.pending.retain(|_, pending| pending.socket != socket);
        self.gathers.retain(|_, gather| gather.socket != socket);
        let Some(session) = gone.session else {
            return;
        };
        // Another socket of the same session may have taken it over.
        let taken = |other: &Socket| other.session.as_ref() == Some(&session);
        if !self.sockets.values().any(taken)
            && let Some(person) = self.people.get_mut(&session)
        {
            person.gone = Some(now);
            person.left_as = Some(gone.role);
            self.bound_gone();
        }
    }

    /// Bounds those who may come back, as a station does: the least role ends first, and of it who left first.
    fn bound_gone(&mut self) {
        let gone = self.people.iter().filter_map(|(id, person)| {
            let gone = person.gone?;
            Some((person.left_as, gone, id.clone()))
        });
        let gone: Vec<_> = gone.collect();
        if gone.len() > SOCKETS
            && let Some((_, _, first)) = gone.into_iter().min()
        {
            self.people.remove(&first);
            self.names.forget(&first);
        }
    }

    /// The lines of a client end, whatever they wait for.
    fn drop_lines(&mut self, socket: SocketId) {
        let of = |(id, line): (&LineId, &Line)| (line.socket == socket).then_some(*id);
        for line in self.lines.iter().filter_map(of).collect::<Vec<_>>() {
            self.lines.remove(&line);
            self.acts.push_back(HubAct::Drop(line));
        }
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.ways.clear();
        }
    }

    /// The answer of a client to a ping, which its stations hear: a holder without a word for five seconds loses its lease.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        let of = |(id, line): (&LineId, &Line)| (line.socket == socket && line.up).then_some(*id);
        for line in self.lines.iter().filter_map(of).collect::<Vec<_>>() {
            self.probe(now, line);
            if let Some(line) = self.lines.get_mut(&line) {
                line.alive = true;
            }
            self.acts.push_back(HubAct::Awake(line));
        }
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
        let late = |gather: &Gather| gather.due <= now;
        let late = self.gathers.iter().filter(|(_, gather)| late(gather));
        for gather in late.map(|(id, _)| *id).collect::<Vec<_>>() {
            self.gathered(now, gather);
        }
        let silent = |line: &Line| line.silent_at().is_some_and(|at| at <= now);
        let silent = self.lines.iter().filter(|(_, line)| silent(line));
        for line in silent.map(|(id, _)| *id).collect::<Vec<_>>() {
            let why = "its station does not answer";
            self.lose_line(now, line, RpcError::arm(magician::ErrorKind::Port, why));
        }
        self.open_again(now);
        let due = |socket: &Socket| list_due(socket).is_some_and(|due| due <= now);
        let due = self.sockets.iter().filter(|(_, socket)| due(socket));
        for socket in due.map(|(id, _)| *id).collect::<Vec<_>>() {
            self.tell_sessions(now, socket);
        }
        let over = |person: &Person| person.gone.is_some_and(|gone| gone + RESUMES <= now);
        let over = self.people.iter().filter(|(_, person)| over(person));
        for session in over.map(|(id, _)| id.clone()).collect::<Vec<_>>() {
            self.people.remove(&session);
            self.names.forget(&session);
        }
        self.arms
            .retain(|_, place| place.gone.is_none_or(|gone| gone + GONE > now));
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let gathers = self.gathers.values().map(|gather| gather.due);
        let lines = self.lines.values().filter_map(Line::silent_at);
        let people = self
            .people
            .values()
            .filter_map(|person| Some(person.gone? + RESUMES));
        let arms = self
            .arms
            .values()
            .filter_map(|place| Some(place.gone? + GONE));
        gathers
            .chain(lines)
            .chain(self.opens_at())
            .chain(people)
            .chain(arms)
            .chain(self.sockets.values().filter_map(list_due))
            .min()
    }

    fn next_id(&mut self) -> u64 {
        self.ids += 1;
        self.ids
    }

    fn unix(&self, now: HostInstant) -> f64 {
        ((self.unix_zero + now.as_micros() as f64 / 1e6) * 1e6).round() / 1e6
    }

    /// The names of all arms.
    fn arm_names(&self) -> Vec<&str> {
        self.arms.keys().map(String::as_str).collect()
    }

    /// Answers a request that was counted as under way.
    fn finish(
        &mut self,
        socket: SocketId,
        id: Option<&MessageId>,
        outcome: &Result<Value, RpcError>,
    ) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.under_way = open.under_way.saturating_sub(1);
        }
        self.respond(socket, id, outcome);
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

    fn notice(&mut self, socket: SocketId, method: &str, params: &Value) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.notice(notification(method, params));
            self.awake.insert(socket);
        }
    }

    /// The sessions have changed: a client hears of it once, however often they did, and five times a second at most.
    fn sessions_changed(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.session.is_some()
        {
            open.list_waits = true;
            if list_due(open).is_some_and(|due| due <= now) {
                self.tell_sessions(now, socket);
            }
        }
    }

    fn tell_sessions(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            (open.list_waits, open.listed) = (false, Some(now));
            if open.outbox.state_due(SESSIONS) {
                self.awake.insert(socket);
            }
        }
    }
}

/// When a client is to be sent the list of sessions. `None` if it has the newest.
fn list_due(socket: &Socket) -> Option<HostInstant> {
    let next = socket.listed.map(|listed| listed + LIST_INTERVAL);
    socket.list_waits.then(|| next.unwrap_or(HostInstant::ZERO))
}

/// In place of a subscription, whose numbers begin with 1: the list of sessions is due.
const SESSIONS: u16 = 0;

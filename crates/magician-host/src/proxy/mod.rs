//! Proxy: several programs share one arm, without I/O and without a clock.
//!
//! A [`Proxy`] stands between any number of clients and the line to one arm. To each client it
//! looks like a private arm: every request is answered once, with its id and Ctrl, in the
//! client's order, and never with another client's answer. Its methods are of the same kinds as
//! those of [`Connection`](crate::connection::Connection): queries, our own side
//! ([`open`](Proxy::open), [`close`](Proxy::close), [`lose_line`](Proxy::lose_line),
//! [`find_line`](Proxy::find_line)), input ([`receive`](Proxy::receive),
//! [`receive_from_arm`](Proxy::receive_from_arm)), time, and output. After any of the others, call
//! the `poll_` methods of the output until they return `None`.
//!
//! * **Turns.** Replies carry no number, so one request is in flight at a time and clients take
//!   turns. A stop (StopExec, ForceStop, Clear, the immediate stop of a jog) overtakes all waiting
//!   requests and does not wait for the one in flight. Earlier requests of the same client that
//!   would change something and were not sent yet are dropped, because they must not run after the
//!   stop.
//! * **Shared reads.** A get equal to one that another client has in flight, or that was answered
//!   less than [`max_reply_age`](Settings::max_reply_age) ago, gets the same reply if nothing that
//!   may change the arm was sent meanwhile. No client gets the same reply twice, so a client that
//!   polls as fast as it can gets as many readings as it would alone.
//!   [`Row::only_looks`](magician_protocol::Row::only_looks) says which gets can be shared.
//! * **No retransmission.** A missing reply stays missing, as it would with the arm itself; the
//!   client decides whether to ask again. An overdue reply no longer blocks the line. The client
//!   still gets it if it arrives before the reply to a later request, which proves it lost, and
//!   within the [lifetime](connection::Settings::lifetime) of a frame. Before another request with
//!   the same id and Ctrl a *fence* is sent, by the rules of [`connection`].
//! * **Whole frames.** Bytes outside of frames are reported and, unless
//!   [`transparent`](Settings::transparent), not passed on, because they would disturb the other
//!   clients. Frames with unknown ids pass.
//! * **Disconnection.** When a client disconnects, its unsent requests are dropped except stops,
//!   and a jog that it started is stopped (unless [`keep_going`](Settings::keep_going)). Commands
//!   that it has queued in the arm are not touched.
//! * **Lost line.** All pending requests end without a reply. Requests that arrive before the line
//!   is back are dropped, so none is executed later.

mod arm;
mod cut;
mod event;
mod hear;
mod kind;
mod member;
mod reading;
#[cfg(test)]
mod tests;
mod transmit;

use std::collections::{BTreeMap, VecDeque};

use magician_protocol::FrameBuf;

use crate::connection::{self, Micros, Ticket};
use arm::{ArmLine, Flight, Purpose};
pub use event::{Chunk, Client, Event, Reason};
use member::{ClientQueue, PendingRequest, RequestKind, State};
use reading::Readings;

/// Largest number of pending events; the oldest are dropped.
const MAX_EVENTS: usize = 1024;
/// Largest number of transmissions of the stop of a jog.
// A choice that covers a bad line for many timeouts.
const MAX_STOP_TRANSMISSIONS: u32 = 32;

/// Settings of a [`Proxy`].
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Line to the arm: whether it keeps the order, and how long a reply may take.
    pub line: connection::Settings,
    /// Largest age of a reply that is given to another client, us. 0: every get goes to the arm.
    pub max_reply_age: Micros,
    /// True if bytes outside of frames are passed on to the arm.
    pub transparent: bool,
    /// True if a jog continues when the client that started it disconnects.
    pub keep_going: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            line: connection::Settings::ORDERED,
            // A choice: one period, for which even a moving arm reports the same pose.
            max_reply_age: 20_000,
            transparent: false,
            keep_going: false,
        }
    }
}

/// Several clients sharing one arm; see the [module](self).
#[derive(Debug)]
pub struct Proxy {
    settings: Settings,
    members: BTreeMap<Client, ClientQueue>,
    /// Client whose turn was last.
    turn: Option<Client>,
    arm: ArmLine,
    /// True if there is a line to the arm.
    online: bool,
    /// Frames of the proxy's own, with transmissions left; sent before everything else.
    own: VecDeque<(FrameBuf, u32)>,
    jog: Option<Jog>,
    readings: Readings,
    /// Counts possible changes of the arm.
    epoch: u64,
    events: VecDeque<Event>,
    tickets: u64,
}

/// A jog started by a client.
#[derive(Clone, Copy, Debug)]
struct Jog {
    client: Client,
    end: FrameBuf,
    serial: u64,
}

/// Queries.
impl Proxy {
    /// Creates a proxy without clients on an open line.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            members: BTreeMap::new(),
            turn: None,
            arm: ArmLine::new(&settings),
            online: true,
            own: VecDeque::new(),
            jog: None,
            readings: Readings::default(),
            epoch: 0,
            events: VecDeque::new(),
            tickets: 0,
            settings,
        }
    }

    /// Number of bytes that a client may send before it should be made to wait. Beyond that, whole
    /// frames may be dropped.
    #[must_use]
    pub fn room(&self, client: Client) -> usize {
        self.members.get(&client).map_or(0, ClientQueue::room)
    }

    /// True if a client has a reply to fetch. [`poll_transmit_to_arm`](Self::poll_transmit_to_arm)
    /// may produce one as well, for a request that it answers from a shared reply.
    #[must_use]
    pub fn is_answering(&self) -> bool {
        self.members.values().any(ClientQueue::has_reply)
    }

    /// True while the arm has not confirmed a stop: the proxy's own stop of a jog, or a stop of a
    /// client that is in flight or was left by a client that disconnected.
    #[must_use]
    pub fn is_letting_go(&self) -> bool {
        !self.own.is_empty() || self.arm.is_stopping()
    }
}

/// Our own side: clients connect and disconnect.
impl Proxy {
    /// Adds a client.
    pub fn open(&mut self, client: Client) {
        self.members.insert(client, ClientQueue::default());
    }

    /// Removes a client.
    pub fn close(&mut self, client: Client) {
        self.give_up_late(client, |_| true);
        let Some(member) = self.members.remove(&client) else {
            return;
        };
        self.readings.forget_client(client);
        for slot in member.slots.into_iter().filter(PendingRequest::waits) {
            match slot.what {
                // A stop stays valid when its client disconnects.
                RequestKind::Request { frame, stop: true } => self.own.push_back((frame, 1)),
                RequestKind::Request { frame, .. } => self.dropped(client, frame, Reason::Left),
                RequestKind::Foreign(_) => {}
            }
        }
        if self.jog.is_some_and(|jog| jog.client == client) {
            self.let_go();
        }
    }

    /// Notes that the line to the arm is lost. Clients stay connected and get no replies.
    pub fn lose_line(&mut self) {
        self.online = false;
        self.changed();
        for flight in self.arm.lost() {
            self.try_again(&flight);
            self.unanswered(&flight);
        }
        let clients: Vec<Client> = self.members.keys().copied().collect();
        for client in clients {
            self.drop_waiting(client, Reason::NoLine, |_| true);
        }
        // On the next line, whenever that is, only the stop of a jog is sent.
        self.own.retain(|(_, tries)| *tries > 1);
        self.let_go();
    }

    /// Notes that there is a line to the arm again.
    pub fn find_line(&mut self) {
        self.online = true;
    }

    /// Stops the jog in progress, if there is one.
    fn let_go(&mut self) {
        if let Some(jog) = self.jog.take()
            && !self.settings.keep_going
        {
            self.own.push_back((jog.end, MAX_STOP_TRANSMISSIONS));
        }
    }
}

/// Time.
impl Proxy {
    /// Instant at which [`handle_timeout`](Self::handle_timeout) must be called. `None` if there is
    /// none.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        let members = self.members.values();
        let silences = members.filter_map(|member| member.cutter.poll_timeout());
        silences.chain(self.arm.poll_timeout()).min()
    }

    /// Processes all timers up to `now`.
    pub fn handle_timeout(&mut self, now: Micros) {
        let mut cutter = std::mem::take(&mut self.arm.cutter);
        cutter.handle_timeout(now, |piece| self.hear_arm(now, &piece));
        self.arm.cutter = cutter;
        let due = |member: &ClientQueue| member.cutter.poll_timeout().is_some_and(|at| at <= now);
        let silent: Vec<Client> = (self.members.iter())
            .filter(|(_, member)| due(member))
            .map(|(client, _)| *client)
            .collect();
        for client in silent {
            self.listen(client, |cutter, hear| cutter.handle_timeout(now, hear));
        }
        for flight in self.arm.too_late(now) {
            self.unanswered(&flight);
        }
        for flight in self.arm.overdue(now) {
            self.go_on_without(flight);
        }
    }

    /// Frees the line for others, because the reply is overdue. The client that sent the request
    /// may still get it.
    fn go_on_without(&mut self, flight: Flight) {
        let taker = flight.takers.first();
        if !taker.is_some_and(|(client, _)| self.members.contains_key(client)) {
            return self.give_up(&flight);
        }
        self.ask_for_joined(&flight);
        self.arm.let_come_late(flight);
    }

    /// Ends requests of a client whose late replies it no longer waits for.
    fn give_up_late(&mut self, client: Client, which: impl Fn(&Flight) -> bool) {
        let of_client = |flight: &Flight| flight.takers.iter().any(|(taker, _)| *taker == client);
        for flight in (self.arm).give_up_late(|flight| of_client(flight) && which(flight)) {
            self.unanswered(&flight);
        }
    }

    /// Ends a request whose reply does not arrive; its client gets no reply.
    fn give_up(&mut self, flight: &Flight) {
        self.try_again(flight);
        self.ask_for_joined(flight);
        if let Some((client, ticket)) = flight.takers.first() {
            self.end_unanswered(*client, *ticket, flight.frame);
        }
    }

    /// Lets the reads that joined this one wait for their own turn, because its reply does not
    /// arrive.
    fn ask_for_joined(&mut self, flight: &Flight) {
        for (client, ticket) in flight.takers.iter().skip(1) {
            let member = self.members.get_mut(client);
            if let Some(slot) = member.and_then(|member| member.slot(*ticket)) {
                slot.state = State::Waiting;
            }
        }
    }

    /// Retransmits a frame of the proxy's own, which is idempotent.
    fn try_again(&mut self, flight: &Flight) {
        // Fences and clients' stops are not repeated: the client decides.
        if let Purpose::Own { tries: tries @ 1.. } = flight.purpose {
            self.own.push_back((flight.frame, tries));
        }
    }

    /// Ends a request for all clients that wait for it.
    fn unanswered(&mut self, flight: &Flight) {
        for (client, ticket) in &flight.takers {
            self.end_unanswered(*client, *ticket, flight.frame);
        }
    }

    fn end_unanswered(&mut self, client: Client, ticket: Ticket, frame: FrameBuf) {
        let member = self.members.get_mut(&client);
        if member.and_then(|member| member.remove(ticket)).is_some() {
            self.tell(Event::Unanswered { client, frame });
        }
    }
}

/// Output.
impl Proxy {
    /// Returns the next event. `None` if all were returned.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn tell(&mut self, event: Event) {
        if self.events.len() >= MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    fn dropped(&mut self, client: Client, frame: FrameBuf, reason: Reason) {
        self.tell(Event::Dropped {
            client,
            frame,
            reason,
        });
    }

    /// Notes a possible change of the arm: earlier readings are no longer valid.
    fn changed(&mut self) {
        self.epoch = self.epoch.saturating_add(1);
        self.readings.forget();
    }

    fn ticket(&mut self) -> Ticket {
        self.tickets = self.tickets.wrapping_add(1);
        Ticket(self.tickets)
    }
}

//! Several programs at one arm, without I/O and without a clock.
//!
//! A [`Proxy`] stands between any number of clients and the line to one arm. Each client sees an
//! arm of its own: every request is answered once, with its id and Ctrl, in the client's own order,
//! and never with an answer that is another's. Its methods come in the kinds of
//! [`Connection`](crate::connection::Connection): look, our own side ([`open`](Proxy::open),
//! [`close`](Proxy::close), [`lose_line`](Proxy::lose_line), [`find_line`](Proxy::find_line)), bytes
//! that came ([`receive`](Proxy::receive), [`receive_from_arm`](Proxy::receive_from_arm)), time, and
//! what comes out; `poll_` methods are asked until they return `None` after each of the others.
//!
//! * **In turn.** The arm's answers have no number, so one request is in flight at a time, and
//!   clients take turns. A stop (StopExec, ForceStop, Clear, the immediate end of a jog) overtakes
//!   all that waits and does not wait for the one in flight. What the same client asked before it,
//!   other than to look, and what has not gone out, is dropped: it must not come after the stop.
//! * **Shared looks.** A get that another client has in flight, or that was answered less than
//!   [`fresh`](Settings::fresh) ago, is answered by that answer, if nothing that may change the arm
//!   went out meanwhile. No client is given the same answer twice, so that one that asks as fast as
//!   it can gets as many readings as without the others.
//!   [`Row::only_looks`](magician_protocol::Row::only_looks) says what can be shared.
//! * **Nothing is sent twice.** An answer that does not come is not given, as the arm would not
//!   give it; whether to ask again is for the client to decide. The line is not kept for an answer
//!   that takes longer than usual, but the client that asked still gets it: until
//!   something later is answered, which shows that it was lost, and for the
//!   [lifetime](connection::Settings::lifetime) of a frame at most. A *fence* goes out before another
//!   request with the same id and Ctrl, by the rules of [`connection`].
//! * **Whole frames.** Bytes that are no frame are shown and, unless
//!   [`transparent`](Settings::transparent), go no further: they would disturb the others. Frames
//!   with unknown ids pass.
//! * **A client that disconnects lets go.** Requests that have not gone out are dropped, but not stops; a jog that
//!   the client began is ended ([`keep_going`](Settings::keep_going)). What it queued is its
//!   business. A lost line ends what waits and what comes meanwhile: nothing is done later that was
//!   asked for before.

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
use member::{Member, Slot, State, What};
use reading::Readings;

/// Most things that wait to be told; older ones are forgotten.
const EVENTS: usize = 1024;
/// How often the end of a jog goes out at most.
const TRIES: u32 = 32;

/// How a [`Proxy`] behaves.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The line to the arm: whether it keeps its order, and how long an answer may take.
    pub line: connection::Settings,
    /// How old an answer may be that is given to another client, us; 0: every get goes to the arm.
    pub fresh: Micros,
    /// Whether bytes that are no frame are passed on to the arm.
    pub transparent: bool,
    /// Whether a jog goes on when the client that began it leaves.
    pub keep_going: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            line: connection::Settings::ORDERED,
            fresh: 20_000,
            transparent: false,
            keep_going: false,
        }
    }
}

/// Several clients, one arm; see the [module](self).
#[derive(Debug)]
pub struct Proxy {
    settings: Settings,
    members: BTreeMap<Client, Member>,
    /// The client of the last turn.
    turn: Option<Client>,
    arm: ArmLine,
    /// Whether there is a line to the arm.
    online: bool,
    /// What the proxy has to say itself, before all else.
    own: VecDeque<(FrameBuf, u32)>,
    jog: Option<Jog>,
    readings: Readings,
    /// Counts what may have changed the arm.
    epoch: u64,
    events: VecDeque<Event>,
    tickets: u64,
}

/// A jog that a client began.
#[derive(Clone, Copy, Debug)]
struct Jog {
    client: Client,
    end: FrameBuf,
    serial: u64,
}

/// Look.
impl Proxy {
    /// A proxy without clients, on a line that is open.
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

    /// Bytes that a client may send before it should be made to wait. What comes beyond that may be
    /// dropped, whole frames at a time.
    #[must_use]
    pub fn room(&self, client: Client) -> usize {
        self.members.get(&client).map_or(0, Member::room)
    }

    /// Whether there is an answer that a client has not taken: asking what is for the arm may find
    /// one, among those that need not go there.
    #[must_use]
    pub fn is_answering(&self) -> bool {
        self.members.values().any(Member::has_reply)
    }

    /// Whether the proxy has something to say to the arm itself that the arm has not confirmed:
    /// the end of a jog.
    #[must_use]
    pub fn is_letting_go(&self) -> bool {
        !self.own.is_empty() || self.arm.is_stopping()
    }
}

/// Our own side: which clients connect and disconnect.
impl Proxy {
    /// A client comes.
    pub fn open(&mut self, client: Client) {
        self.members.insert(client, Member::default());
    }

    /// A client goes.
    pub fn close(&mut self, client: Client) {
        self.give_up_late(client, |_| true);
        let Some(member) = self.members.remove(&client) else {
            return;
        };
        self.readings.forget_client(client);
        for slot in member.slots.into_iter().filter(Slot::waits) {
            match slot.what {
                What::Request { frame, stop: true } => self.own.push_back((frame, 1)),
                What::Request { frame, .. } => self.dropped(client, frame, Reason::Left),
                What::Foreign(_) => {}
            }
        }
        if self.jog.is_some_and(|jog| jog.client == client) {
            self.let_go();
        }
    }

    /// The line to the arm is gone. Clients stay and are not answered.
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
        // What is to be said on the next line, whenever that is, is the end of a jog and no more.
        self.own.retain(|(_, tries)| *tries > 1);
        self.let_go();
    }

    /// There is a line to the arm again.
    pub fn find_line(&mut self) {
        self.online = true;
    }

    /// Ends the jog that is under way, if there is one.
    fn let_go(&mut self) {
        if let Some(jog) = self.jog.take()
            && !self.settings.keep_going
        {
            self.own.push_back((jog.end, TRIES));
        }
    }
}

/// Time.
impl Proxy {
    /// The instant at which [`handle_timeout`](Self::handle_timeout) is to be called, if any.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        let members = self.members.values();
        let silences = members.filter_map(|member| member.cutter.poll_timeout());
        silences.chain(self.arm.poll_timeout()).min()
    }

    /// Lets time pass.
    pub fn handle_timeout(&mut self, now: Micros) {
        let mut cutter = std::mem::take(&mut self.arm.cutter);
        cutter.handle_timeout(now, |piece| self.hear_arm(now, &piece));
        self.arm.cutter = cutter;
        let due = |member: &Member| member.cutter.poll_timeout().is_some_and(|at| at <= now);
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

    /// The answer has not come in the time that answers take: the line is free for others. Whose
    /// request it was may still get it.
    fn go_on_without(&mut self, flight: Flight) {
        let taker = flight.takers.first();
        if !taker.is_some_and(|(client, _)| self.members.contains_key(client)) {
            return self.give_up(&flight);
        }
        self.ask_for_joined(&flight);
        self.arm.let_come_late(flight);
    }

    /// A client does not wait for these late answers any more.
    fn give_up_late(&mut self, client: Client, which: impl Fn(&Flight) -> bool) {
        let of_client = |flight: &Flight| flight.takers.iter().any(|(taker, _)| *taker == client);
        for flight in (self.arm).give_up_late(|flight| of_client(flight) && which(flight)) {
            self.unanswered(&flight);
        }
    }

    /// The answer does not come. Whose request it was is not answered.
    fn give_up(&mut self, flight: &Flight) {
        self.try_again(flight);
        self.ask_for_joined(flight);
        if let Some((client, ticket)) = flight.takers.first() {
            self.end_unanswered(*client, *ticket, flight.frame);
        }
    }

    /// A read that was only joined is sent for the client itself, for the first time.
    fn ask_for_joined(&mut self, flight: &Flight) {
        for (client, ticket) in flight.takers.iter().skip(1) {
            let member = self.members.get_mut(client);
            if let Some(slot) = member.and_then(|member| member.slot(*ticket)) {
                slot.state = State::Waiting;
            }
        }
    }

    /// What the proxy says itself does no harm when it is said again.
    fn try_again(&mut self, flight: &Flight) {
        if let Purpose::Own { tries: tries @ 1.. } = flight.purpose {
            self.own.push_back((flight.frame, tries));
        }
    }

    /// None of the waiting clients gets a reply.
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

/// What there is to tell.
impl Proxy {
    /// The next thing to tell.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn tell(&mut self, event: Event) {
        if self.events.len() >= EVENTS {
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

    /// Something may have changed the arm: what was read before says nothing any more.
    fn changed(&mut self) {
        self.epoch = self.epoch.saturating_add(1);
        self.readings.forget();
    }

    fn ticket(&mut self) -> Ticket {
        self.tickets = self.tickets.wrapping_add(1);
        Ticket(self.tickets)
    }
}

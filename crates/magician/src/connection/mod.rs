//! The host's end of the protocol, without I/O and without a clock.
//!
//! A [`Connection`] turns requests into frames and frames into answers. Its methods come in five
//! kinds, and every shell calls them in the same round:
//!
//! * look: `&self` methods, which change nothing;
//! * [`submit`](Connection::submit): our own side wants something;
//! * [`receive`](Connection::receive): bytes came from the controller;
//! * time: [`poll_timeout`](Connection::poll_timeout) names the instant at which
//!   [`handle_timeout`](Connection::handle_timeout) is to be called;
//! * what comes out: [`poll_transmit`](Connection::poll_transmit) the next frame to write,
//!   [`poll_event`](Connection::poll_event) the next thing to tell. Both are asked until they
//!   return `None`, after each of the calls above.
//!
//! Time is microseconds from any origin and never goes back. The same calls give the same results.
//! State is bounded, nothing panics on any bytes, and in steady state nothing is allocated.
//!
//! # Which reply answers which request
//!
//! A reply repeats id and Ctrl of its request (its *key*) and nothing else, so the danger is a
//! reply that comes after its request was given up and is taken for the answer to a later one. The
//! rule that excludes it on an ordered link, where the controller answers in the order of arrival
//! (errata E06):
//!
//! 1. Every frame that went out stays *outstanding* until its reply has come or cannot come any
//!    more, whether or not somebody still waits for it.
//! 2. A reply belongs to the *oldest* outstanding frame of its key. Should that one's reply have
//!    been lost, the true owner is younger, and this only errs towards distrust.
//! 3. A reply proves that no reply to an older frame can come: those are no longer outstanding.
//!    By 2 the assumed owner is never younger than the true one, so the proof holds.
//! 4. A frame is sent only if no outstanding frame of its key belongs to another request.
//!    Otherwise a *fence* goes first: a read with another key, whose reply does what 3 says. (By 2
//!    the request would be safe without it; its own reply would be distrusted once, and it would
//!    cost a timeout.)
//!
//! Hence at window 1 all outstanding frames of a key are copies of one request, and a reply with
//! that key answers it. A fence that is lost is followed by one with another id. A stop does not
//! wait for 4: its reply is dropped while an older frame of its key is outstanding, and it is
//! simply sent again. On an unordered link (UDP) rules 3 and 4 are replaced by time: a frame is
//! outstanding until its reply has come or for the [`lifetime`](Settings::lifetime).
//! A link that invents replies, or doubles one and holds the double back while the same thing is
//! asked again, can pass off an old reading as a new one; queued commands are safe from that too,
//! by their index.
//!
//! # Queued commands are never sent again blindly
//!
//! A reply is accepted when its index follows the one accepted last. When it is lost, or repeats
//! the last index, the command is *in doubt*: current index and left space are read until two
//! pairs in succession are equal, and the ledger judges (its file says how). Lost: it is sent again.
//! Taken: on we go. Anything else: [`Failure::Uncertain`] with the interval of indices, and the
//! next accepted index is a new beginning. The readings follow the command on the wire, so on an
//! ordered link it can no longer be under way when they arrive; on an unordered one, "lost" is
//! concluded only from readings made after its lifetime.
//!
//! A datagram that the network doubles is executed twice by any controller. A surplus answer, or a
//! current index beyond the last one accepted, shows that: [`Event::Unaccounted`]. What no index
//! shows is a second copy that takes the very place of the next command of the same id when that one
//! is lost: over UDP the arm then repeats the one and leaves out the other.

mod doubt;
pub(crate) mod estimator;
mod flaw;
mod job;
mod ledger;
pub(crate) mod outstanding;
mod reply;
mod request;
#[cfg(test)]
mod tests;
pub(crate) mod transmit;

use std::collections::VecDeque;

use magician_protocol::{Deframer, INTER_BYTE_TIMEOUT_MS, QueuedCmdIndex};

use doubt::Doubt;
use estimator::Estimator;
use flaw::{Flaw, planted};
use job::{Job, Policy, Purpose};
use ledger::Ledger;
use outstanding::Outstanding;
pub use request::{Event, Failure, Priority, Request, Settings, Ticket};

/// Microseconds from an origin of the caller's choice.
pub type Micros = u64;

/// Most requests that wait in one lane.
const LANE: usize = 64;
/// Most requests that may be in flight.
const MAX_WINDOW: usize = 8;
/// Pause between looks at a queue that drains after a Clear.
const DRAIN_PAUSE: Micros = 10_000;

/// What went over the line so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Frames sent.
    pub sent: u64,
    /// Frames sent again.
    pub resent: u64,
    /// Bytes received.
    pub bytes: u64,
    /// Whole frames received.
    pub frames: u64,
    /// Frames that came too late and were dropped.
    pub late: u64,
    /// Frames nobody had asked for.
    pub unsolicited: u64,
    /// Damaged frames and runs of foreign bytes.
    pub noise: u64,
}

/// The host's end of the protocol; see the [module](self).
#[derive(Debug)]
pub struct Connection {
    settings: Settings,
    deframer: Deframer,
    heard: Micros,
    estimator: Estimator,
    ledger: Ledger,
    outstanding: Outstanding,
    lanes: [VecDeque<Job>; 3],
    flight: Vec<Job>,
    doubt: Option<Doubt>,
    events: VecDeque<Event>,
    next_ticket: u64,
    streak: u32,
    next_fence: usize,
    /// When to look again whether the queue has drained; `None`: now.
    drain_at: Option<Micros>,
    stats: Stats,
}

/// Look.
impl Connection {
    /// A connection that has sent and seen nothing.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        let settings = Settings {
            window: settings.window.clamp(1, MAX_WINDOW),
            ..settings
        };
        Self {
            deframer: Deframer::new(),
            heard: 0,
            estimator: Estimator::new(&settings),
            ledger: Ledger::new(settings.capacity),
            outstanding: Outstanding::new(settings.ordered),
            lanes: std::array::from_fn(|_| VecDeque::with_capacity(LANE)),
            flight: Vec::with_capacity(MAX_WINDOW + 4),
            doubt: None,
            events: VecDeque::with_capacity(LANE),
            next_ticket: 0,
            streak: 0,
            next_fence: 0,
            drain_at: None,
            stats: Stats::default(),
            settings,
        }
    }

    /// What went over the line so far.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// The smoothed time from a request to its answer, us.
    #[must_use]
    pub fn round_trip(&self) -> Option<Micros> {
        self.estimator.round_trip()
    }

    /// From when on an answer counts as lost at present, us.
    #[must_use]
    pub fn answer_timeout(&self) -> Micros {
        self.estimator.timeout()
    }

    /// The index accepted last, while it is certain.
    #[must_use]
    pub fn last_index(&self) -> Option<QueuedCmdIndex> {
        self.ledger.last().map(QueuedCmdIndex)
    }

    /// Places in the controller's queue: as set, or more if the controller showed more.
    #[must_use]
    pub fn capacity(&self) -> u32 {
        self.ledger.capacity()
    }

    /// Whether bytes that came while nobody looked could pass for answers to what is sent next:
    /// look at the line once more before you submit.
    #[must_use]
    pub fn is_owed(&self) -> bool {
        !self.settings.ordered || !self.outstanding.is_empty()
    }

    /// The index up to which every accepted command is beyond doubt: it was taken, once and in its place. Above window 1 it
    /// may be behind [`last_index`](Self::last_index).
    #[must_use]
    pub fn confirmed_index(&self) -> Option<QueuedCmdIndex> {
        self.ledger.confirmed().map(QueuedCmdIndex)
    }

    /// Whether nothing waits and nothing is in flight.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.flight.is_empty() && self.doubt.is_none() && self.lanes.iter().all(VecDeque::is_empty)
    }
}

/// Our own side, and time.
impl Connection {
    /// Takes a request. Its ticket comes back in exactly one [`Event::Done`].
    ///
    /// A [`Priority::Stop`] ends every request of the stream that has not gone out yet with
    /// [`Failure::Stopped`].
    pub fn submit(&mut self, request: Request) -> Ticket {
        let ticket = self.ticket();
        if request.priority == Priority::Stop {
            self.drop_stream();
        }
        let lane = &mut self.lanes[request.priority as usize];
        if lane.len() < LANE {
            lane.push_back(Job::new(ticket, Purpose::Caller, &request));
        } else {
            self.done(ticket, Err(Failure::Busy));
        }
        ticket
    }

    /// Nobody waits for this request any more. One that has not gone out will not, and ends with
    /// [`Failure::Stopped`]; one that has is seen to its end but not sent again. A stop goes on.
    pub fn cancel(&mut self, ticket: Ticket) {
        for lane in [Priority::Stream, Priority::Poll] {
            let lane = &mut self.lanes[lane as usize];
            if let Some(at) = lane.iter().position(|job| job.ticket == ticket) {
                lane.remove(at);
                self.done(ticket, Err(Failure::Stopped));
            }
        }
        let due = |job: &Job| job.ticket == ticket && job.due && job.priority != Priority::Stop;
        if let Some(at) = self.flight.iter().position(due) {
            self.flight.remove(at);
            self.done(ticket, Err(Failure::Stopped));
        }
        let doubt = self.doubt.as_mut().map(|doubt| &mut doubt.job);
        let out = self.flight.iter_mut().chain(doubt);
        for job in out.filter(|job| job.ticket == ticket) {
            job.over = job.priority != Priority::Stop;
        }
    }

    /// The line is gone. Nothing that was submitted goes out any more, on no line: a command that went out and was not
    /// answered ends as [`Failure::Uncertain`], everything else as [`Failure::Lost`].
    pub fn interrupt(&mut self) {
        self.deframer.expire();
        self.drop_stream();
        while let Some(job) = self.flight.pop() {
            match job.policy {
                Policy::Resend => self.done(job.ticket, Err(Failure::Lost)),
                Policy::Once | Policy::Doubt => self.uncertain(job),
            }
        }
        while let Some(job) = self.lanes.iter_mut().find_map(VecDeque::pop_front) {
            self.done(job.ticket, Err(Failure::Lost));
        }
    }

    /// The instant at which [`handle_timeout`](Self::handle_timeout) is to be called, if any.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        let mut next = Micros::MAX;
        for job in &self.flight {
            next = next.min(job.deadline);
            if !job.due {
                next = next.min(job.timer);
            }
        }
        for job in self.lanes.iter().flatten() {
            next = next.min(job.deadline);
        }
        if let Some(doubt) = &self.doubt {
            next = next.min(doubt.job.deadline);
            next = next.min(doubt.not_before.unwrap_or(Micros::MAX));
        }
        if let (true, Some(at)) = (self.wants_drain(), self.drain_at) {
            next = next.min(at);
        }
        if self.is_waiting_for_bytes() {
            next = next.min(self.heard.saturating_add(INTER_BYTE_TIMEOUT_MS * 1000));
        }
        if let Some(at) = self.outstanding.next_expiry(self.settings.lifetime) {
            next = next.min(at);
        }
        (next != Micros::MAX).then_some(next)
    }

    /// Lets time pass.
    pub fn handle_timeout(&mut self, now: Micros) {
        if self.is_waiting_for_bytes()
            && now >= self.heard.saturating_add(INTER_BYTE_TIMEOUT_MS * 1000)
        {
            self.deframer.expire();
            self.hear(now, &[]);
        }
        self.outstanding.expire(now, self.settings.lifetime);
        if self.drain_at.is_some_and(|at| at <= now) {
            self.drain_at = None;
        }
        self.end_at_deadline(now);
        while let Some(at) = (self.flight.iter()).position(|job| !job.due && job.timer <= now) {
            self.estimator.back_off();
            self.lost(at);
        }
        if let Some(doubt) = &mut self.doubt
            && doubt.not_before.is_some_and(|at| at <= now)
        {
            doubt.not_before = None;
        }
    }

    fn is_waiting_for_bytes(&self) -> bool {
        self.deframer.pending() && !planted(Flaw::NoInterByteTimeout)
    }

    /// The next thing to tell.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn ticket(&mut self) -> Ticket {
        self.next_ticket = self.next_ticket.wrapping_add(1);
        Ticket(self.next_ticket)
    }
}

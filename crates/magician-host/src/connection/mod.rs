//! The host's end of the protocol, without I/O and without a clock.
//!
//! A [`Connection`] turns requests into frames and frames into answers. Its methods come in five
//! kinds, and every caller uses them in the same loop:
//!
//! * look: `&self` methods, which change nothing;
//! * [`submit`](Connection::submit): a request of our own side;
//! * [`receive`](Connection::receive): bytes from the controller;
//! * time: [`poll_timeout`](Connection::poll_timeout) returns the instant at which
//!   [`handle_timeout`](Connection::handle_timeout) must be called;
//! * output: [`poll_transmit`](Connection::poll_transmit) returns the next frame to write,
//!   [`poll_event`](Connection::poll_event) the next event. After each call above, both are polled
//!   until they return `None`.
//!
//! Time is microseconds from any origin and never goes back. The same calls give the same results.
//! State is bounded, no input causes a panic, and in steady state nothing is allocated.
//!
//! # Which reply answers which request
//!
//! A reply repeats id and Ctrl of its request (its *key*) and nothing else. The danger is a reply
//! that arrives after its request timed out and is taken for the answer to a later request. The
//! following rules exclude this on an ordered link, where the controller answers in the order of
//! arrival (errata E06):
//!
//! 1. Every frame sent stays *outstanding* until its reply has arrived or can no longer arrive,
//!    whether or not its caller still waits.
//! 2. A reply is assigned to the *oldest* outstanding frame of its key. If the reply to that frame
//!    was lost, the true owner is a younger frame, and the only consequence is that a good reply is
//!    distrusted.
//! 3. A reply proves that no reply to an older frame can arrive: older frames are no longer
//!    outstanding. By rule 2 the assumed owner is never younger than the true one, so the proof
//!    holds.
//! 4. A frame is sent only if no outstanding frame of its key belongs to another request. Otherwise
//!    a *fence* is sent first: a read with another key, whose reply clears older frames by rule 3.
//!    (Rule 2 alone would be safe, but the request's own reply would be distrusted once, which
//!    costs a timeout.)
//!
//! Hence at window 1 all outstanding frames of a key are copies of one request, and a reply with
//! that key answers it. If a fence is lost, the next one has another id. A stop does not wait for
//! rule 4: its reply is dropped while an older frame of its key is outstanding, and the stop is
//! retransmitted.
//!
//! On an unordered link (UDP) time replaces rules 3 and 4: a frame is outstanding until its reply
//! has arrived or its [`lifetime`](Connection::lifetime) has passed, which is measured from round
//! trips. No frame is retransmitted earlier, so two frames of one key are never under way.
//!
//! One attack remains: a link that invents replies, or that duplicates one and delays the copy
//! until the same request is repeated, can pass off an old reading as new. Queued commands are safe
//! from that too, by their index.
//!
//! # A read beside a queued command
//!
//! A queue of 32 places must be read at least once for every 32 commands, and a read that waits its
//! turn costs as much line time as a command. So at window 1 one read may be in flight together
//! with one queued command ([`Settings::reads_beside`]). Rules 1 to 4 hold unchanged, because the
//! two have different keys and the reply to the later one proves that no reply to the earlier one
//! can arrive. If the command's reply is lost, the command is in doubt alone, as without the read.
//!
//! The vendor's host program sends such pairs to real arms (errata E06), but how often an arm loses
//! one of the two frames is not known. After a loss from a pair, reads therefore wait their turn:
//! for 256 replies at first, and twice as long after each further loss. A controller that answers
//! the read first would break rule 3; the command is then in doubt until its own reply arrives, and
//! this counts as a loss.
//!
//! # Queued commands: taken once, or reported
//!
//! A queued command that is sent twice moves the arm twice, and no reply says which frame it
//! answers. Certainty comes from the index law (errata E37): the controller gives each accepted
//! command the index after the previous one. Whether this arm follows the law is [learnt by
//! listening](Connection::law); nothing is queued to find out.
//!
//! A command is in one of these states:
//!
//! | state | event | next state |
//! |---|---|---|
//! | waiting | its turn: no doubt, no stop, no drain, the line is up, room in the window | in flight |
//! | in flight, alone | its reply, with the next index | taken, confirmed |
//! | | its reply, with the last index again | in doubt |
//! | | its reply, with any other index | uncertain |
//! | | no reply in time, or a reply to a later frame | in doubt; uncertain if the law is broken |
//! | in flight, in a window | its reply, with the next index | taken; confirmed at the next *settle point* |
//! | | any other event, for it or its neighbours | uncertain, with all unconfirmed ones |
//! | in doubt | two equal readings of current index and left space: not taken | in flight again; [`Failure::Lost`] if the line broke meanwhile; [`Failure::Stopped`] after a stop |
//! | | … : taken | taken, confirmed |
//! | | … : neither; or a Clear, reset, stop or the deadline came first; or the law is broken | uncertain |
//! | | the line breaks | in doubt until [`restored`](Connection::restored) |
//!
//! *Uncertain* is [`Failure::Uncertain`] with the interval of indices that may have been given:
//! from the one after the last confirmed index to the last accepted one plus one for each
//! unanswered command. The command is never retransmitted, the next accepted index starts a new
//! count, and above window 1 the queued commands waiting behind it are dropped.
//!
//! Why *not taken* is certain: while one command is in doubt, no other queued command is unanswered
//! and none is sent. So the controller has given either the last known index or the next one, and
//! current index, capacity and left space show which (`index_tracker` explains how, and when they
//! do not). A single pair of readings may be torn by a command that ends between them; between two
//! equal pairs no command ended. On an ordered link a reading follows the command on the wire, so
//! once it is answered the command is no longer under way. On an unordered link, "not taken" is
//! concluded only from readings begun after the command's [lifetime](Connection::lifetime). So no
//! command is retransmitted while its first copy can still arrive.
//!
//! Why *confirmed* is certain: commands in a window share a key, so if one is lost, the next one's
//! reply passes for its reply, with the index it would have had. But then one reply is missing at
//! the end. A settle point is a reply to a request of another kind on an ordered link, or a moment
//! without unanswered queued commands: each frame sent before it has been answered or never will be
//! (rules 2 and 3). If there are as many replies as frames, with consecutive indices, each command
//! was taken in its place. If one is missing, the interval above is reported. Reads are settle
//! points; without reads, a fence is sent after every few commands. Only
//! [repeatable](Request::repeatable) commands share a window, because commands behind a gap may
//! have been taken without the missing one: the caller stops, clears the queue and continues from
//! [`confirmed_index`](Connection::confirmed_index). Datagrams have no settle points, and so no
//! window.
//!
//! After a reset (current index or [clock](Event::Reset) going back) nothing is retransmitted.
//! After a lost line, nothing of the stream is sent until the controller's clock, current index and
//! left space were read on the new line. Frames of the old line stay outstanding, so that their
//! late replies are recognised.
//!
//! Before the first command the last index is not known. If the arm was seen at rest (queue empty,
//! then the current index read), these two serve for comparison: any accepted command has changed
//! one of them. Only the number may be too low
//! ([`is_last_index_estimated`](Connection::is_last_index_estimated)).
//!
//! A datagram that the network duplicates is executed twice by any controller. A surplus reply, or
//! a current index or left space beyond the last accepted index, reveals it:
//! [`Event::Unaccounted`]. One case leaves no trace in the indices: a second copy takes the place
//! of the next command while that command is lost. So over datagrams the next command is sent only
//! when no second copy can arrive any more ([`Settings::echo`]) and two equal readings since then
//! have shown that none was taken; after that, only the command itself can take the next index.
//! This costs the waiting time and four reads per queued command. After a retransmission the wait
//! is a whole lifetime, so that a very late first copy is seen as well.
//!
//! Two cases are not excluded: an arm that breaks the law before this was recognised may take a
//! command twice, which the next index reports; and a second copy of the last command that is
//! cleared before it was seen is noticed only when the next command is taken.
//!
//! # What goes first
//!
//! A [stop](Priority::Stop) overtakes everything and is handed out at once. Otherwise the stream
//! goes before reads, but a waiting read gets its turn after a few requests of the stream, and
//! sooner if more reads wait. With [`Settings::baud`] set, frames are handed out only as fast as
//! the line carries them.

mod doubt;
mod duplicate_check;
pub(crate) mod estimator;
mod index_tracker;
mod interruption;
mod job;
mod law;
mod lifetime;
pub(crate) mod outstanding;
mod pace;
mod paired_reads;
mod planted_bug;
mod reply;
mod request;
#[cfg(test)]
mod tests;
pub(crate) mod transmit;
mod uptime;

use std::collections::VecDeque;

use magician_protocol::commands::JogCmd;
use magician_protocol::{Deframer, INTER_BYTE_TIMEOUT_MS, QueuedCmdIndex, Writable};

use doubt::Doubt;
use estimator::Estimator;
use index_tracker::IndexTracker;
use interruption::Link;
pub use job::must_not_repeat;
use job::{Job, Purpose};
use law::IndexLawMonitor;
pub use law::{IndexLaw, LawViolation};
use lifetime::Lifetime;
use outstanding::Outstanding;
use pace::Pace;
use paired_reads::PairedReads;
use planted_bug::{PlantedBug, is_planted};
pub use request::{Event, Failure, Priority, Request, Settings, Ticket};

use duplicate_check::DuplicateCheck;
use uptime::Uptime;

/// Microseconds since an origin of the caller's choice.
pub type Micros = u64;

/// Largest number of requests waiting in one lane.
// A choice that bounds memory: a full lane refuses with `Failure::Busy`.
const LANE_CAPACITY: usize = 64;
/// Initial capacity of a lane and of the events. A frame is large, and sessions seldom need more.
const INITIAL_CAPACITY: usize = 8;
/// Largest window, requests.
// A choice that bounds the interval of uncertain indices after a loss.
const MAX_WINDOW: usize = 8;
/// Number of recent commands whose send time is remembered, to recognise late replies.
const MAX_RECENT_INDICES: usize = 8;
/// Interval between reads of the left space while the queue drains after a Clear.
// A choice: short against a motion, long enough to leave the line to others.
const DRAIN_POLL_INTERVAL: Micros = 10_000;

/// Traffic counters of a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Frames sent.
    pub sent: u64,
    /// Retransmitted frames.
    pub resent: u64,
    /// Bytes received.
    pub bytes: u64,
    /// Whole frames received.
    pub frames: u64,
    /// Replies that arrived after their request ended, and were dropped.
    pub late: u64,
    /// Unsolicited frames.
    pub unsolicited: u64,
    /// Damaged frames and runs of foreign bytes.
    pub noise: u64,
}

/// The host's end of the protocol; see the [module](self).
#[derive(Clone, Debug)]
pub struct Connection {
    settings: Settings,
    deframer: Deframer,
    last_receive: Micros,
    /// Instant until which the caller was held up. Round trips of frames sent before are not
    /// measured.
    resumed_at: Micros,
    estimator: Estimator,
    lifetime: Lifetime,
    tracker: IndexTracker,
    law_monitor: IndexLawMonitor,
    uptime: Uptime,
    pace: Pace,
    pairs: PairedReads,
    link: Link,
    outstanding: Outstanding,
    lanes: [VecDeque<Job>; 3],
    flight: Vec<Job>,
    doubt: Option<Doubt>,
    duplicate_check: Option<DuplicateCheck>,
    events: VecDeque<Event>,
    next_ticket: u64,
    stream_streak: u32,
    next_fence: usize,
    /// Number of queued commands sent.
    order: u64,
    /// Indices given most recently, with the send times of their commands.
    given: VecDeque<(u64, Micros)>,
    /// Value of `order` when the last frame other than a queued command was sent. Its reply settles
    /// all commands sent before it.
    settled: u64,
    /// Instant of the next read while the queue drains. `None`: now.
    drain_at: Option<Micros>,
    stats: Stats,
}

/// Construction and state.
impl Connection {
    /// Creates a connection without any history.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        let settings = Settings {
            // Without order a reply does not prove anything about older frames, so there is no
            // window.
            window: if settings.ordered {
                settings.window.clamp(1, MAX_WINDOW)
            } else {
                1
            },
            ..settings
        };
        Self {
            deframer: Deframer::new(),
            last_receive: 0,
            resumed_at: 0,
            estimator: Estimator::new(&settings),
            lifetime: Lifetime::new(&settings),
            tracker: IndexTracker::new(settings.capacity),
            law_monitor: IndexLawMonitor::default(),
            uptime: Uptime::new(settings.free_clock),
            pace: Pace::new(settings.baud),
            pairs: PairedReads::default(),
            link: Link::Up,
            outstanding: Outstanding::new(settings.ordered),
            lanes: std::array::from_fn(|_| VecDeque::with_capacity(INITIAL_CAPACITY)),
            // The window, with stops and readings outside of it.
            flight: Vec::with_capacity(MAX_WINDOW + 4),
            doubt: None,
            duplicate_check: None,
            events: VecDeque::with_capacity(INITIAL_CAPACITY),
            next_ticket: 0,
            stream_streak: 0,
            next_fence: 0,
            order: 0,
            given: VecDeque::with_capacity(MAX_RECENT_INDICES),
            settled: 0,
            drain_at: None,
            stats: Stats::default(),
            settings,
        }
    }

    /// Traffic counters.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Smoothed round-trip time, us. `None` before the first reply.
    #[must_use]
    pub fn round_trip(&self) -> Option<Micros> {
        self.estimator.round_trip()
    }

    /// Current retransmission timeout, us.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn answer_timeout(&self) -> Micros {
        self.estimator.timeout()
    }

    /// Numbers of reads and of queued commands in flight.
    #[cfg(test)]
    pub(crate) fn in_flight(&self) -> [usize; 2] {
        let queued = self.flight.iter().filter(|job| job.queued()).count();
        [self.flight.len() - queued, queued]
    }

    /// Longest time that a frame or its reply may be under way, us. Measured on an unordered link.
    #[must_use]
    pub fn lifetime(&self) -> Micros {
        self.lifetime.get()
    }

    /// Index accepted last. `None` while it is not certain.
    #[must_use]
    pub fn last_index(&self) -> Option<QueuedCmdIndex> {
        let last = self
            .tracker
            .last()
            .filter(|_| !self.law_monitor.is_broken());
        last.map(QueuedCmdIndex)
    }

    /// True if the last index may be too low.
    ///
    /// It was then derived from readings of an arm at rest, whose queue may have been cleared
    /// before. The next reply gives the true index and so the difference.
    #[must_use]
    pub fn is_last_index_estimated(&self) -> bool {
        self.tracker.is_guess()
    }

    /// State of the index law for this arm, on which all conclusions from indices rest.
    #[must_use]
    pub fn law(&self) -> IndexLaw {
        self.law_monitor.law()
    }

    /// Capacity of the controller's queue, commands: as set, or larger if the controller reported
    /// more.
    #[must_use]
    pub fn capacity(&self) -> u32 {
        self.tracker.capacity()
    }

    /// True if bytes that have arrived but were not read could be taken for replies to the next
    /// request.
    ///
    /// Read the line once more before submitting.
    #[must_use]
    pub fn must_read_before_submit(&self) -> bool {
        !self.settings.ordered || !self.outstanding.is_empty()
    }

    /// Index up to which every accepted command is certain to have been taken once and in its
    /// place.
    ///
    /// Above window 1 it may lag behind [`last_index`](Self::last_index): a reply proves that *a*
    /// command of this id was taken, but which one is known only when all earlier frames were
    /// answered. `None` while it is not certain.
    #[must_use]
    pub fn confirmed_index(&self) -> Option<QueuedCmdIndex> {
        let confirmed = self.tracker.confirmed();
        let confirmed = confirmed.filter(|_| !self.law_monitor.is_broken());
        confirmed.map(QueuedCmdIndex)
    }

    /// True if nothing is waiting or in flight and, over datagrams, no duplicate can arrive any
    /// more.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let settled = self.doubt.is_none() && !self.is_checking_duplicates();
        settled && self.flight.is_empty() && self.lanes.iter().all(VecDeque::is_empty)
    }
}

/// Requests, time and events.
impl Connection {
    /// Submits a request. Its ticket is returned in exactly one [`Event::Done`].
    ///
    /// A [`Priority::Stop`] ends every request of the stream that has not been sent yet with
    /// [`Failure::Stopped`]. The stop of a jog spares immediate settings, which neither move nor
    /// burn.
    pub fn submit(&mut self, request: Request) -> Ticket {
        let ticket = self.ticket();
        if request.priority == Priority::Stop {
            // The stop of a jog concerns motion alone: pending settings stay valid.
            if request.frame.frame().id() == JogCmd::ROW.id {
                self.drop_motions()
            } else {
                self.drop_stream()
            }
        }
        let lane = &mut self.lanes[request.priority as usize];
        // Stops have a lane of their own, so a full lane of commands never blocks one.
        if lane.len() < LANE_CAPACITY {
            lane.push_back(Job::new(ticket, Purpose::Caller, &request));
        } else {
            self.done(ticket, Err(Failure::Busy));
        }
        ticket
    }

    /// Withdraws a request whose caller has gone.
    ///
    /// A request not sent yet ends with [`Failure::Stopped`]; a request in flight runs to its end
    /// but is not retransmitted. Stops are not withdrawn.
    pub fn cancel(&mut self, ticket: Ticket) {
        for lane in [Priority::Stream, Priority::Poll] {
            let lane = &mut self.lanes[lane as usize];
            if let Some(at) = lane.iter().position(|job| job.ticket == ticket) {
                lane.remove(at);
                self.done(ticket, Err(Failure::Stopped));
            }
        }
        // Due: waiting for a retransmission, so the last copy is known to be lost or harmless.
        let due = |job: &Job| {
            job.ticket == ticket && job.needs_retransmit && job.priority != Priority::Stop
        };
        if let Some(at) = self.flight.iter().position(due) {
            self.flight.remove(at);
            self.done(ticket, Err(Failure::Stopped));
        }
        let doubt = self.doubt.as_mut().map(|doubt| &mut doubt.job);
        let out = self.flight.iter_mut().chain(doubt);
        for job in out.filter(|job| job.ticket == ticket) {
            job.no_retransmit = job.priority != Priority::Stop;
        }
    }

    /// Instant at which [`handle_timeout`](Self::handle_timeout) must be called. `None` if there is
    /// none.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        let mut next = Micros::MAX;
        for job in &self.flight {
            next = next.min(job.deadline);
            if !job.needs_retransmit {
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
        // A frame held back by the pacing must not wait for an unrelated event.
        next = next.min(self.pace.wakes().unwrap_or(Micros::MAX));
        next = next.min(self.next_check_timeout().unwrap_or(Micros::MAX));
        if let (true, Some(at)) = (self.wants_drain(), self.drain_at) {
            next = next.min(at);
        }
        if self.is_waiting_for_bytes() {
            next = next.min(
                self.last_receive
                    .saturating_add(INTER_BYTE_TIMEOUT_MS * 1000),
            );
        }
        if let Some(at) = self.outstanding.next_expiry(self.lifetime.get()) {
            next = next.min(at);
        }
        (next != Micros::MAX).then_some(next)
    }

    /// Processes all timers up to `now`.
    pub fn handle_timeout(&mut self, now: Micros) {
        if self.is_waiting_for_bytes()
            && now
                >= self
                    .last_receive
                    .saturating_add(INTER_BYTE_TIMEOUT_MS * 1000)
        {
            // Only after a silence: the bytes of one frame follow each other closely (errata E04).
            // The bytes of the broken frame may contain whole frames.
            self.deframer.expire();
            self.process_bytes(now, &[]);
        }
        self.outstanding.expire(now, self.lifetime.get());
        self.pace.pass(now);
        self.handle_check_timeout(now);
        if self.drain_at.is_some_and(|at| at <= now) {
            self.drain_at = None;
        }
        self.end_at_deadline(now);
        while let Some(at) =
            (self.flight.iter()).position(|job| !job.needs_retransmit && job.timer <= now)
        {
            self.estimator.back_off();
            self.handle_loss(at);
        }
        if let Some(doubt) = &mut self.doubt
            && doubt.not_before.is_some_and(|at| at <= now)
        {
            doubt.not_before = None;
        }
    }

    /// Reports that the caller was held up from `since` to `now`: suspended, or stopped in a
    /// debugger.
    ///
    /// Deadlines do not run during that time, and timers of requests in flight start again. Call
    /// this before the bytes that arrived meanwhile are [received](Self::receive).
    pub fn note_suspension(&mut self, since: Micros, now: Micros) {
        let time = now.saturating_sub(since);
        let timer = now.saturating_add(self.estimator.timeout());
        let doubt = self.doubt.as_mut().map(|doubt| &mut doubt.job);
        let waiting = self.lanes.iter_mut().flatten();
        for job in self.flight.iter_mut().chain(doubt).chain(waiting) {
            job.deadline = job.deadline.saturating_add(time);
            // MAX: the job was not sent yet or its timer has expired, so only the deadline runs.
            if job.timer != Micros::MAX {
                job.timer = job.timer.max(timer);
            }
        }
        self.resumed_at = now;
    }

    fn is_waiting_for_bytes(&self) -> bool {
        self.deframer.pending() && !is_planted(PlantedBug::NoInterByteTimeout)
    }

    /// Returns the next event. `None` if the queue of events is empty.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn ticket(&mut self) -> Ticket {
        // 64 bits do not wrap in practice; wrapping only avoids a panic.
        self.next_ticket = self.next_ticket.wrapping_add(1);
        Ticket(self.next_ticket)
    }
}

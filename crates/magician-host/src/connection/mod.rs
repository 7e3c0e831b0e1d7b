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
//!    more, whether or not its caller still waits for it.
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
//! outstanding until its reply has come or for the [`lifetime`](Connection::lifetime), which is measured from round trips.
//! None is sent again before, so that no two of the same key are under way.
//! A link that invents replies, or doubles one and holds the double back while the same thing is
//! asked again, can pass off an old reading as a new one; queued commands are safe from that too,
//! by their index.
//!
//! # A read beside a queued command
//!
//! A queue of 32 places has to be looked at once for at most 32 commands, and a look that waits its turn
//! costs as much of a line as a command. So at window 1 a read may be in flight together with one queued
//! command ([`Settings::reads_beside`]). Rules 1 to 4 hold as they are: the two have different keys, and
//! the reply to the later one proves that no reply to the earlier one can come. A command whose reply was
//! lost so is alone in doubt, as without the read.
//!
//! The vendor's host program sends so to real arms (errata E06), but how often an arm loses one of two
//! frames is not known. After each loss from a pair reads wait their turn, 256 replies at first and twice
//! as many each time. A controller that answers the read first would break rule 3; the command is then
//! in doubt until its own reply ends that, and this counts as a loss.
//!
//! # Queued commands: taken once, or reported
//!
//! A queued command moves the arm again when it is sent again, and no reply says which frame it answers. What is certain
//! rests on the index law (errata E37): the controller gives every command that it takes the index after the last one.
//! Whether this arm keeps it is [learnt by listening](Connection::law) and nothing is queued to find out.
//!
//! A command is in one of these states, and only these steps lead on:
//!
//! | state | what happens | next |
//! |---|---|---|
//! | waiting | its turn: no doubt, no stop, no drain, a line, room in the window | in flight |
//! | in flight, alone | its answer, with the next index | taken, confirmed |
//! | | its answer, with the last index again | in doubt |
//! | | its answer, with any other index | uncertain |
//! | | no answer in time, or one to a later frame | in doubt; uncertain if the law is broken |
//! | in flight, in a window | its answer, with the next index | taken; confirmed at the next *settle point* |
//! | | anything else, of it or of one beside it | uncertain, with all that are not confirmed |
//! | in doubt | two equal readings of current index and left space: not taken | in flight again; [`Failure::Lost`] if the line broke meanwhile; [`Failure::Stopped`] after a stop |
//! | | … : taken | taken, confirmed |
//! | | … : neither; a Clear, a reset, a stop or the deadline came first; the law is broken | uncertain |
//! | | the line breaks | in doubt until [`restored`](Connection::restored) |
//!
//! *Uncertain* is [`Failure::Uncertain`] with the interval of indices that may have been given: from the one after the last
//! confirmed to the last one accepted and one for each command unanswered. It is never sent again, the next accepted
//! index is a new beginning, and above window 1 the queued commands that wait behind it are dropped.
//!
//! Why *not taken* is certain. While one command is in doubt no other queued command is unanswered and none goes out, so
//! the controller has given the last known index or the one after, and current index, capacity and left space tell which
//! (the `tracker` says how, and when they do not). A single pair may be torn by a command that ends between its two
//! readings; between two equal pairs none did. On an ordered link a reading follows the command on the wire, so when its
//! answer is there the command is no longer under way; on an unordered one "not taken" is concluded only from readings
//! begun after its [lifetime](Connection::lifetime). So nothing that is sent again can still arrive from the first time.
//!
//! Why *confirmed* is certain. In a window commands share a key, so when one of them is lost the next one's answer passes for
//! its own, with the index it would have had. But then one answer too few comes. A settle point is an answer to a
//! request of another kind on an ordered link, or the moment when nothing queued is unanswered: each frame sent before has
//! been answered or will never be (rules 2 and 3). As many answers as frames, with indices in a row: each was taken, in
//! its place. One less: the interval above. Reads are settle points; where none are asked for, a fence is one after every
//! few commands. Only [repeatable](Request::repeatable) commands share a window, because what follows a gap may have been
//! taken without it: the caller stops, clears, and goes on from what [`confirmed_index`](Connection::confirmed_index) said.
//! Datagrams have no settle points, and no window.
//!
//! After a reset (current index or [clock](Event::Reset) going back) nothing is sent again. After a lost line nothing of the
//! stream goes out until the controller's clock, current index and left space were read on the new one; frames of the old
//! one stay outstanding, so that a late answer from there is known for what it is.
//!
//! Of the first command no last index is known. If the arm was seen at rest before, its queue empty and then its current
//! index, those two are what is compared with: anything that was taken has changed one of them. Only the number may be too
//! low ([`is_last_a_guess`](Connection::is_last_a_guess)).
//!
//! A datagram that the network doubles is executed twice by any controller. A surplus answer, a current index or left
//! space beyond the last one accepted shows that: [`Event::Unaccounted`]. What no index shows is a second copy that takes
//! the very place of the next command when that one is lost. So over datagrams the next one goes out only when no second
//! copy can come any more ([`Settings::echo`]) and two equal readings since then have shown that none was taken: from then
//! on nothing but the command itself can take the next index. This costs the time and four reads for each queued command. After one that had to be sent again it is a
//! whole lifetime, so that a first copy that comes far too late shows as well.
//!
//! What is not excluded: an arm that breaks the law before it was recognised may take a command twice; the next index then
//! reports it. A second copy of the last command that is cleared before it was seen shows when the next one is taken.
//!
//! # What goes first
//!
//! A [stop](Priority::Stop) overtakes everything and is handed out at once. Of the others the stream goes before
//! reads, but after a few of the stream a read that waits has its turn, the sooner the more of them wait. With
//! [`Settings::baud`] set frames are handed out only as fast as the line carries them.

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
mod pairs;
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
pub use job::is_once;
use job::{Job, Purpose};
use law::IndexLawMonitor;
pub use law::{Breach, Law};
use lifetime::Lifetime;
use outstanding::Outstanding;
use pace::Pace;
use pairs::Pairs;
use planted_bug::{PlantedBug, planted};
pub use request::{Event, Failure, Priority, Request, Settings, Ticket};

use duplicate_check::DuplicateCheck;
use uptime::Uptime;

/// Microseconds from an origin of the caller's choice.
pub type Micros = u64;

/// Most requests that wait in one lane.
const LANE: usize = 64;
/// Requests of a lane, and events, for which there is room from the start: a frame is large, and a session seldom has more.
const USUAL: usize = 8;
/// Most requests that may be in flight.
const MAX_WINDOW: usize = 8;
/// So many commands are remembered with when they went out.
const GIVEN: usize = 8;
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
    heard: Micros,
    /// Until then the caller was held up: what went out before was not timed.
    awake: Micros,
    estimator: Estimator,
    lifetime: Lifetime,
    tracker: IndexTracker,
    witness: IndexLawMonitor,
    uptime: Uptime,
    pace: Pace,
    pairs: Pairs,
    link: Link,
    outstanding: Outstanding,
    lanes: [VecDeque<Job>; 3],
    flight: Vec<Job>,
    doubt: Option<Doubt>,
    duplicate_check: Option<DuplicateCheck>,
    events: VecDeque<Event>,
    next_ticket: u64,
    streak: u32,
    next_fence: usize,
    /// Queued commands sent.
    order: u64,
    /// Indices given last, and when their commands went out.
    given: VecDeque<(u64, Micros)>,
    /// `order` when a frame went out last whose reply settles those before.
    settled: u64,
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
            window: if settings.ordered {
                settings.window.clamp(1, MAX_WINDOW)
            } else {
                1
            },
            ..settings
        };
        Self {
            deframer: Deframer::new(),
            heard: 0,
            awake: 0,
            estimator: Estimator::new(&settings),
            lifetime: Lifetime::new(&settings),
            tracker: IndexTracker::new(settings.capacity),
            witness: IndexLawMonitor::default(),
            uptime: Uptime::new(settings.free_clock),
            pace: Pace::new(settings.baud),
            pairs: Pairs::default(),
            link: Link::Up,
            outstanding: Outstanding::new(settings.ordered),
            lanes: std::array::from_fn(|_| VecDeque::with_capacity(USUAL)),
            flight: Vec::with_capacity(MAX_WINDOW + 4),
            doubt: None,
            duplicate_check: None,
            events: VecDeque::with_capacity(USUAL),
            next_ticket: 0,
            streak: 0,
            next_fence: 0,
            order: 0,
            given: VecDeque::with_capacity(GIVEN),
            settled: 0,
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
    #[cfg(test)]
    pub(crate) fn answer_timeout(&self) -> Micros {
        self.estimator.timeout()
    }

    /// Reads and queued commands in flight.
    #[cfg(test)]
    pub(crate) fn in_flight(&self) -> [usize; 2] {
        let queued = self.flight.iter().filter(|job| job.queued()).count();
        [self.flight.len() - queued, queued]
    }

    /// How long a frame or its answer may be under way, us: on an unordered link as measured.
    #[must_use]
    pub fn lifetime(&self) -> Micros {
        self.lifetime.get()
    }

    /// The index accepted last, while it is certain.
    #[must_use]
    pub fn last_index(&self) -> Option<QueuedCmdIndex> {
        let last = self.tracker.last().filter(|_| !self.witness.is_broken());
        last.map(QueuedCmdIndex)
    }

    /// Whether the index told last may be too low: it was concluded from the readings of an arm at rest, whose queue may
    /// have been cleared before. The next answer gives its own, and shows by how much.
    #[must_use]
    pub fn is_last_a_guess(&self) -> bool {
        self.tracker.is_guess()
    }

    /// Whether this arm numbers its queued commands as every conclusion from a number supposes.
    #[must_use]
    pub fn law(&self) -> Law {
        self.witness.law()
    }

    /// Places in the controller's queue: as set, or more if the controller showed more.
    #[must_use]
    pub fn capacity(&self) -> u32 {
        self.tracker.capacity()
    }

    /// Whether bytes that arrived unread could pass for replies to what is sent next:
    /// look at the line once more before you submit.
    #[must_use]
    pub fn is_owed(&self) -> bool {
        !self.settings.ordered || !self.outstanding.is_empty()
    }

    /// The index up to which every accepted command is beyond doubt: it was taken, once and in its place. Above window 1
    /// it may be behind [`last_index`](Self::last_index): an answer with an index says that *a* command of this id was
    /// taken, and only when all that was sent before has been answered which one.
    #[must_use]
    pub fn confirmed_index(&self) -> Option<QueuedCmdIndex> {
        let confirmed = self.tracker.confirmed();
        let confirmed = confirmed.filter(|_| !self.witness.is_broken());
        confirmed.map(QueuedCmdIndex)
    }

    /// Whether nothing waits and nothing is in flight, and over datagrams nothing may come twice any more.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let settled = self.doubt.is_none() && !self.is_vetting();
        settled && self.flight.is_empty() && self.lanes.iter().all(VecDeque::is_empty)
    }
}

/// Our own side, and time.
impl Connection {
    /// Takes a request. Its ticket comes back in exactly one [`Event::Done`].
    ///
    /// A [`Priority::Stop`] ends every request of the stream that has not gone out yet with
    /// [`Failure::Stopped`]; the stop of a jog spares what only sets something, and neither moves nor burns.
    pub fn submit(&mut self, request: Request) -> Ticket {
        let ticket = self.ticket();
        if request.priority == Priority::Stop {
            if request.frame.frame().id() == JogCmd::ROW.id {
                self.drop_motions()
            } else {
                self.drop_stream()
            }
        }
        let lane = &mut self.lanes[request.priority as usize];
        if lane.len() < LANE {
            lane.push_back(Job::new(ticket, Purpose::Caller, &request));
        } else {
            self.done(ticket, Err(Failure::Busy));
        }
        ticket
    }

    /// The caller of this request has gone. One that has not gone out will not, and ends with
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
        next = next.min(self.pace.wakes().unwrap_or(Micros::MAX));
        next = next.min(self.vet_wakes().unwrap_or(Micros::MAX));
        if let (true, Some(at)) = (self.wants_drain(), self.drain_at) {
            next = next.min(at);
        }
        if self.is_waiting_for_bytes() {
            next = next.min(self.heard.saturating_add(INTER_BYTE_TIMEOUT_MS * 1000));
        }
        if let Some(at) = self.outstanding.next_expiry(self.lifetime.get()) {
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
        self.outstanding.expire(now, self.lifetime.get());
        self.pace.pass(now);
        self.pass_vet(now);
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

    /// The caller was held up from `since` to `now`: stopped, asleep, in a debugger. No deadline ran meanwhile, and what
    /// is in flight is waited for anew. Call it before what has come is [received](Self::receive).
    pub fn slept(&mut self, since: Micros, now: Micros) {
        let time = now.saturating_sub(since);
        let timer = now.saturating_add(self.estimator.timeout());
        let doubt = self.doubt.as_mut().map(|doubt| &mut doubt.job);
        let waiting = self.lanes.iter_mut().flatten();
        for job in self.flight.iter_mut().chain(doubt).chain(waiting) {
            job.deadline = job.deadline.saturating_add(time);
            if job.timer != Micros::MAX {
                job.timer = job.timer.max(timer);
            }
        }
        self.awake = now;
    }

    fn is_waiting_for_bytes(&self) -> bool {
        self.deframer.pending() && !planted(PlantedBug::NoInterByteTimeout)
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

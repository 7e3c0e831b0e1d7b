//! Losses: what happens to a request whose reply did not arrive, and how the fate of a queued
//! command is found out.
//!
//! Reads and repeatable sets are retransmitted. A queued command that was alone in flight is put in
//! *doubt*: the connection reads current index and left space until two pairs are equal, and then
//! knows whether the controller has taken it (proof in the head of [`connection`](super)).
//! Everything else ends as [`Failure::Uncertain`]. This file also drops requests after a stop or
//! reset and ends requests at their deadline.

use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex};

use super::index_tracker::Verdict;
use super::job::{Job, Policy, Purpose};
use super::planted_bug::{PlantedBug, is_planted};
use super::{Connection, Failure, Micros, Priority};

/// A queued command whose reply was lost, and the readings taken since.
#[derive(Clone, Debug)]
pub(super) struct Doubt {
    pub(super) job: Job,
    /// Instant at which the current pair of readings began.
    pub(super) begun: Option<Micros>,
    pub(super) current: Option<u64>,
    /// Last complete pair, and when its reading began.
    pair: Option<((u64, u32), Micros)>,
    /// Readings begun before this instant prove nothing (unordered links).
    pub(super) not_before: Option<Micros>,
}

impl Doubt {
    /// Discards the readings so far.
    pub(super) fn reset_readings(&mut self) {
        (self.begun, self.current, self.pair) = (None, None, None);
    }
}

/// Losses and doubts.
impl Connection {
    /// Handles a job in flight whose reply did not arrive in time, or can no longer arrive.
    pub(super) fn handle_loss(&mut self, at: usize) {
        self.lost_from_pair(at);
        let Some(job) = self.flight.get_mut(at) else {
            return;
        };
        let unordered_or_awaited = !self.settings.ordered || self.outstanding.awaits(job.ticket);
        match (job.purpose, job.policy) {
            (Purpose::Fence | Purpose::Drain, _) => {
                self.flight.remove(at);
            }
            (Purpose::Clock, _) => {
                self.flight.remove(at);
                self.note_clock_timeout();
            }
            // No doubt needs this reading: retransmit it if the duplicate check does, or drop it.
            (Purpose::Current | Purpose::Left, _) if self.doubt.is_none() => {
                let sent = job.sent;
                if self.retries_reading(sent)
                    && let Some(job) = self.flight.get_mut(at)
                {
                    job.needs_retransmit = true;
                } else {
                    self.flight.remove(at);
                }
            }
            (_, Policy::Resend) if job.no_retransmit => {
                let job = self.flight.remove(at);
                self.done(job.ticket, Err(Failure::Stopped));
            }
            (_, Policy::Resend) => job.needs_retransmit = true,
            // The reply may still arrive: until the deadline it is the only way to learn the
            // outcome.
            (_, Policy::AtMostOnce) if unordered_or_awaited => {
                job.timed_out = true;
                job.timer = Micros::MAX;
            }
            (_, Policy::AtMostOnce) => {
                let job = self.flight.remove(at);
                self.uncertain(job);
            }
            (_, Policy::Doubt) if is_planted(PlantedBug::ResendBlindly) => {
                job.needs_retransmit = true
            }
            (_, Policy::Doubt) => {
                let job = self.flight.remove(at);
                // Beside other unaccounted commands the readings do not show which of them is
                // missing.
                if self.has_at_most_one_unaccounted() && !self.law_monitor.is_broken() {
                    self.enter_doubt(job);
                } else {
                    self.uncertain(job);
                }
            }
        }
    }

    /// True if at most one queued command is unaccounted for.
    pub(super) fn has_at_most_one_unaccounted(&self) -> bool {
        self.queued_unanswered() == 0 && self.doubt.is_none() && self.tracker.is_confirmed()
    }

    pub(super) fn queued_unanswered(&self) -> u64 {
        self.flight.iter().filter(|job| job.queued()).count() as u64
    }

    pub(super) fn enter_doubt(&mut self, job: Job) {
        self.doubt = Some(Doubt {
            job,
            begun: None,
            current: None,
            pair: None,
            not_before: None,
        });
    }

    /// Processes a reading for the command in doubt, and judges it when two pairs are equal.
    pub(super) fn read(&mut self, purpose: Purpose, frame: &FrameBuf, now: Micros) {
        let Some(mut doubt) = self.doubt.take() else {
            return self.process_reading(purpose, frame);
        };
        let view = frame.frame();
        match doubt.current {
            // Readings of an earlier doubt that ended while they were under way.
            None if purpose != Purpose::Current => {}
            Some(_) if purpose != Purpose::Left => {}
            None => {
                let read = QueuedCmdCurrentIndex::decode(view.params());
                doubt.current = read.ok().map(|read| read.queued_cmd_current_index);
            }
            Some(current) => {
                doubt.current = None;
                if let Ok(read) = QueuedCmdLeftSpace::decode(view.params()) {
                    let pair = (current, read.left_space);
                    let begun = doubt.begun.take().unwrap_or(now);
                    if let Some((before, since)) = doubt.pair.replace((pair, begun))
                        && before == pair
                    {
                        return self.judge(doubt, pair, since, now);
                    }
                }
            }
        }
        self.doubt = Some(doubt);
    }

    /// Decides on a command in doubt from two equal pairs, the first of which began at `since`.
    pub(super) fn judge(
        &mut self,
        mut doubt: Doubt,
        (current, left): (u64, u32),
        since: Micros,
        now: Micros,
    ) {
        // On an unordered link the command may overtake later readings, or arrive between them,
        // until its lifetime has passed.
        let arrived = doubt.job.since.saturating_add(self.lifetime.get());
        let premature =
            !self.settings.ordered && since < arrived && !is_planted(PlantedBug::NoLifetime);
        let verdict = match self.tracker.judge(current, left) {
            // A Clear since then has dropped commands: the indices prove nothing.
            _ if doubt.job.clears != self.tracker.clears() => Verdict::Unclear,
            _ if self.law_monitor.is_broken() => Verdict::Unclear,
            verdict => verdict,
        };
        match verdict {
            // Over datagrams a tail beyond the next index means that some command was taken twice.
            Verdict::Unclear => match self.tracker.tail(current, left) {
                Some(tail) if !self.settings.ordered && self.tracker.is_beyond(tail) => {
                    self.end_after_surplus(doubt.job, tail);
                }
                _ => self.uncertain(doubt.job),
            },
            // The lost reply is reconstructed, so the caller sees it as if it had arrived.
            Verdict::Taken(index) => {
                let certain = self.tracker.accept_recovered(index, doubt.job.order);
                self.tracker.confirm();
                self.law_monitor.resume(Some(index).filter(|_| certain));
                self.note_given(index, doubt.job.since);
                let key = doubt.job.key;
                let frame = FrameBuf::encode(key.id, key.ctrl, &QueuedCmdIndex(index));
                self.done(doubt.job.ticket, frame.map_err(|_| Failure::NoIndex));
            }
            Verdict::NotTaken if premature => {
                doubt.not_before = (arrived > now).then_some(arrived);
                doubt.pair = None;
                self.doubt = Some(doubt);
            }
            Verdict::NotTaken if doubt.job.line_broke => {
                self.done(doubt.job.ticket, Err(Failure::Lost))
            }
            Verdict::NotTaken if doubt.job.no_retransmit => {
                self.done(doubt.job.ticket, Err(Failure::Stopped))
            }
            // A full queue refuses commands: retransmitting now would fail as well.
            Verdict::NotTaken if left == 0 => self.done(doubt.job.ticket, Err(Failure::QueueFull)),
            Verdict::NotTaken => {
                doubt.job.needs_retransmit = true;
                self.flight.push(doubt.job);
            }
        }
    }

    /// Over datagrams: ends a command in doubt when the controller has taken more commands than
    /// were sent, up to index `to`. Which of them are duplicates is unknown; counting continues
    /// after `to`.
    pub(super) fn end_after_surplus(&mut self, job: Job, to: u64) {
        let from = self.tracker.last().map(|last| last.saturating_add(1));
        let failure = Failure::Uncertain { from, to: Some(to) };
        self.done(job.ticket, Err(failure));
        self.rebase(to);
    }

    /// Ends a command that may or may not have been taken; if it is queued, also all queued
    /// commands in flight.
    ///
    /// Above window 1 the queued commands waiting behind the gap are dropped too.
    pub(super) fn uncertain(&mut self, job: Job) {
        let (mut from, mut to) = (None, None);
        if job.queued() && !self.law_monitor.is_broken() {
            // Each datagram may have been duplicated, so twice as many indices may be used up.
            let copies = if self.settings.ordered { 1 } else { 2 };
            (from, to) = self.tracker.doubt(copies * (1 + self.queued_unanswered()));
        }
        let failure = Failure::Uncertain { from, to };
        self.done(job.ticket, Err(failure));
        if !job.queued() {
            return;
        }
        self.tracker.forget();
        self.law_monitor.resume(None);
        while let Some(at) = self.flight.iter().position(Job::queued) {
            let job = self.flight.remove(at);
            self.done(job.ticket, Err(failure));
        }
        if job.repeatable && self.settings.window > 1 {
            // A program of repeatable commands relies on their order: what follows a gap must not
            // run.
            self.drop_waiting();
        }
    }

    /// Drops the queued commands that were not sent yet.
    fn drop_waiting(&mut self) {
        let lane = Priority::Stream as usize;
        while let Some(at) = self.lanes[lane].iter().position(Job::queued) {
            if let Some(job) = self.lanes[lane].remove(at) {
                self.done(job.ticket, Err(Failure::Stopped));
            }
        }
    }

    /// Drops all requests of the stream after a stop or reset: none is sent or retransmitted any
    /// more.
    pub(super) fn drop_stream(&mut self) {
        self.drop_stream_but(|_| false);
    }

    /// Drops all requests of the stream after the stop of a jog, except settings that neither move
    /// nor burn.
    pub(super) fn drop_motions(&mut self) {
        self.drop_stream_but(Job::only_sets);
    }

    fn drop_stream_but(&mut self, spares: fn(&Job) -> bool) {
        for _ in 0..self.lanes[Priority::Stream as usize].len() {
            match self.lanes[Priority::Stream as usize].pop_front() {
                Some(job) if spares(&job) => {
                    self.lanes[Priority::Stream as usize].push_back(job);
                }
                Some(job) => self.done(job.ticket, Err(Failure::Stopped)),
                None => break,
            }
        }
        if let Some(doubt) = self.doubt.take() {
            // Readings prove nothing after a reset, or after the Clear that most stops include.
            self.uncertain(doubt.job);
        }
        let dropped = |job: &Job| job.priority == Priority::Stream && !spares(job);
        while let Some(at) =
            (self.flight.iter()).position(|job| job.needs_retransmit && dropped(job))
        {
            // A job due for retransmission had no effect, or may be repeated.
            let job = self.flight.remove(at);
            self.done(job.ticket, Err(Failure::Stopped));
        }
        // In flight: their replies still count, but they are not retransmitted.
        for job in &mut self.flight {
            job.no_retransmit |= dropped(job) && !is_planted(PlantedBug::ResendAfterStop);
        }
    }

    pub(super) fn end_at_deadline(&mut self, now: Micros) {
        for lane in 0..self.lanes.len() {
            while let Some(at) = self.lanes[lane].iter().position(|job| job.deadline <= now) {
                if let Some(job) = self.lanes[lane].remove(at) {
                    let failure = if job.queued() && self.tracker.draining() {
                        // The queue never drained, so the controller is busy rather than
                        // unreachable.
                        Failure::Draining
                    } else {
                        Failure::Timeout { sent: 0 }
                    };
                    self.done(job.ticket, Err(failure));
                }
            }
        }
        while let Some(at) = self.flight.iter().position(|job| job.deadline <= now) {
            let job = self.flight.remove(at);
            match job.policy {
                Policy::Resend => self.done(job.ticket, Err(Failure::Timeout { sent: job.sent })),
                Policy::AtMostOnce | Policy::Doubt => self.uncertain(job),
            }
        }
        if let Some(doubt) = self.doubt.take_if(|doubt| doubt.job.deadline <= now) {
            self.uncertain(doubt.job);
        }
    }
}

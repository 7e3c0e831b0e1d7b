use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex};

use super::index_tracker::Verdict;
use super::job::{Job, Policy, Purpose};
use super::planted_bug::{PlantedBug, planted};
use super::{Connection, Failure, Micros, Priority};

/// A queued command whose answer was lost, and what was read to find out its fate.
#[derive(Clone, Debug)]
pub(super) struct Doubt {
    pub(super) job: Job,
    /// When the reading of the pair under way began.
    pub(super) begun: Option<Micros>,
    pub(super) current: Option<u64>,
    /// The last whole pair, and when its reading began.
    pair: Option<((u64, u32), Micros)>,
    /// Readings before this instant prove nothing (unordered links).
    pub(super) not_before: Option<Micros>,
}

impl Doubt {
    /// What was read so far proves nothing any more.
    pub(super) fn begin_anew(&mut self) {
        (self.begun, self.current, self.pair) = (None, None, None);
    }
}

/// Losses and doubts.
impl Connection {
    /// The answer to a job in flight did not come in time, or cannot come any more.
    pub(super) fn lost(&mut self, at: usize) {
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
                self.missed_clock();
            }
            (Purpose::Current | Purpose::Left, _) if self.doubt.is_none() => {
                let sent = job.sent;
                if self.vets_on(sent)
                    && let Some(job) = self.flight.get_mut(at)
                {
                    job.due = true;
                } else {
                    self.flight.remove(at);
                }
            }
            (_, Policy::Resend) if job.over => {
                let job = self.flight.remove(at);
                self.done(job.ticket, Err(Failure::Stopped));
            }
            (_, Policy::Resend) => job.due = true,
            (_, Policy::Once) if unordered_or_awaited => {
                job.lingers = true;
                job.timer = Micros::MAX;
            }
            (_, Policy::Once) => {
                let job = self.flight.remove(at);
                self.uncertain(job);
            }
            (_, Policy::Doubt) if planted(PlantedBug::ResendBlindly) => job.due = true,
            (_, Policy::Doubt) => {
                let job = self.flight.remove(at);
                if self.alone() && !self.witness.is_broken() {
                    self.enter_doubt(job);
                } else {
                    self.uncertain(job);
                }
            }
        }
    }

    /// Whether at most one queued command is not accounted for.
    pub(super) fn alone(&self) -> bool {
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

    /// Takes a reading for the command in doubt, and judges it when two pairs are equal.
    pub(super) fn read(&mut self, purpose: Purpose, frame: &FrameBuf, now: Micros) {
        let Some(mut doubt) = self.doubt.take() else {
            return self.vet_reading(purpose, frame);
        };
        let view = frame.frame();
        match doubt.current {
            // A reading for an earlier doubt that ended while it was under way.
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

    /// Judges by two equal pairs, the first of which began to be read at `since`.
    pub(super) fn judge(
        &mut self,
        mut doubt: Doubt,
        (current, left): (u64, u32),
        since: Micros,
        now: Micros,
    ) {
        // On an unordered link the command may overtake readings that were sent after it, or come
        // between them, as long as it may be under way.
        let arrived = doubt.job.since.saturating_add(self.lifetime.get());
        let premature =
            !self.settings.ordered && since < arrived && !planted(PlantedBug::NoLifetime);
        let verdict = match self.tracker.judge(current, left) {
            _ if doubt.job.clears != self.tracker.clears() => Verdict::Unclear,
            _ if self.witness.is_broken() => Verdict::Unclear,
            verdict => verdict,
        };
        match verdict {
            Verdict::Unclear => match self.tracker.tail(current, left) {
                Some(tail) if !self.settings.ordered && self.tracker.is_beyond(tail) => {
                    self.surpassed(doubt.job, tail);
                }
                _ => self.uncertain(doubt.job),
            },
            Verdict::Taken(index) => {
                let certain = self.tracker.find(index, doubt.job.order);
                self.tracker.confirm();
                self.witness.resume(Some(index).filter(|_| certain));
                self.note_given(index, doubt.job.since);
                let key = doubt.job.key;
                let frame = FrameBuf::encode(key.id, key.ctrl, &QueuedCmdIndex(index));
                self.done(doubt.job.ticket, frame.map_err(|_| Failure::NoIndex));
            }
            Verdict::Lost if premature => {
                doubt.not_before = (arrived > now).then_some(arrived);
                doubt.pair = None;
                self.doubt = Some(doubt);
            }
            Verdict::Lost if doubt.job.cut => self.done(doubt.job.ticket, Err(Failure::Lost)),
            Verdict::Lost if doubt.job.over => self.done(doubt.job.ticket, Err(Failure::Stopped)),
            Verdict::Lost if left == 0 => self.done(doubt.job.ticket, Err(Failure::QueueFull)),
            Verdict::Lost => {
                doubt.job.due = true;
                self.flight.push(doubt.job);
            }
        }
    }

    /// Over datagrams: more commands were taken than were sent, up to this index. It is unknown which; the next one
    /// follows it.
    pub(super) fn surpassed(&mut self, job: Job, to: u64) {
        let from = self.tracker.last().map(|last| last.saturating_add(1));
        let failure = Failure::Uncertain { from, to: Some(to) };
        self.done(job.ticket, Err(failure));
        self.rebase(to);
    }

    /// Ends a command that may or may not have been taken, and for a queued one all that
    /// are in flight with it. Above window 1 what waits behind such a gap does not go out either.
    pub(super) fn uncertain(&mut self, job: Job) {
        let (mut from, mut to) = (None, None);
        if job.queued() && !self.witness.is_broken() {
            // A datagram may have come twice.
            let copies = if self.settings.ordered { 1 } else { 2 };
            (from, to) = self.tracker.doubt(copies * (1 + self.queued_unanswered()));
        }
        let failure = Failure::Uncertain { from, to };
        self.done(job.ticket, Err(failure));
        if !job.queued() {
            return;
        }
        self.tracker.forget();
        self.witness.resume(None);
        while let Some(at) = self.flight.iter().position(Job::queued) {
            let job = self.flight.remove(at);
            self.done(job.ticket, Err(failure));
        }
        if job.repeatable && self.settings.window > 1 {
            self.drop_waiting();
        }
    }

    /// Queued commands that wait do not go out.
    fn drop_waiting(&mut self) {
        let lane = Priority::Stream as usize;
        while let Some(at) = self.lanes[lane].iter().position(Job::queued) {
            if let Some(job) = self.lanes[lane].remove(at) {
                self.done(job.ticket, Err(Failure::Stopped));
            }
        }
    }

    /// A stop was submitted, or the controller was reset: nothing that the stream has by now goes
    /// out any more, not even a second time.
    pub(super) fn drop_stream(&mut self) {
        self.drop_stream_but(|_| false);
    }

    /// The stop of a jog was submitted: the same for all but what only sets something, and that neither moves nor burns.
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
            self.uncertain(doubt.job);
        }
        let dropped = |job: &Job| job.priority == Priority::Stream && !spares(job);
        while let Some(at) = (self.flight.iter()).position(|job| job.due && dropped(job)) {
            // What is due is known to have gone nowhere, or may be repeated.
            let job = self.flight.remove(at);
            self.done(job.ticket, Err(Failure::Stopped));
        }
        for job in &mut self.flight {
            job.over |= dropped(job) && !planted(PlantedBug::ResendAfterStop);
        }
    }

    pub(super) fn end_at_deadline(&mut self, now: Micros) {
        for lane in 0..self.lanes.len() {
            while let Some(at) = self.lanes[lane].iter().position(|job| job.deadline <= now) {
                if let Some(job) = self.lanes[lane].remove(at) {
                    let failure = if job.queued() && self.tracker.draining() {
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
                Policy::Once | Policy::Doubt => self.uncertain(job),
            }
        }
        if let Some(doubt) = self.doubt.take_if(|doubt| doubt.job.deadline <= now) {
            self.uncertain(doubt.job);
        }
    }
}

use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex};

use super::flaw::{Flaw, planted};
use super::job::{Job, Purpose};
use super::outstanding::Key;
use super::{Connection, DRAIN_PAUSE, Event, Failure, Micros, Ticket};

/// What comes in.
impl Connection {
    /// Takes bytes from the controller, cut anywhere.
    pub fn receive(&mut self, now: Micros, bytes: &[u8]) {
        self.stats.bytes = self.stats.bytes.saturating_add(bytes.len() as u64);
        self.heard = now;
        self.hear(now, bytes);
    }

    pub(super) fn hear(&mut self, now: Micros, mut bytes: &[u8]) {
        while let Some(event) = self.deframer.next(&mut bytes) {
            if let magician_protocol::Event::Frame { frame, .. } = event {
                let frame = FrameBuf::from(frame);
                self.stats.frames += 1;
                self.reply(now, &frame);
            } else {
                self.stats.noise += 1;
            }
        }
    }

    pub(super) fn reply(&mut self, now: Micros, frame: &FrameBuf) {
        let same_id = |job: &Job| job.key.id == frame.frame().id();
        if planted(Flaw::MatchById)
            && let Some(at) = self.flight.iter().position(same_id)
        {
            let job = self.flight.remove(at);
            return self.answer(job, frame, now);
        }
        let Some(copy) = self.outstanding.answered(Key::of(&frame.frame())) else {
            self.stats.unsolicited += 1;
            self.unasked(frame);
            return;
        };
        // Jobs that this reply proves lost come first: they were sent before, and the answered one
        // counts among those that may stand in the queue in their place.
        let judged_apart = (self.flight.iter().position(|job| job.ticket == copy.ticket))
            .filter(|_| planted(Flaw::JudgeInWindow));
        if let Some(at) = judged_apart {
            let job = self.flight.remove(at);
            self.settle(copy.ticket);
            return self.answer(job, frame, now);
        }
        self.settle(copy.ticket);
        let answered = (self.flight.iter()).position(|job| job.ticket == copy.ticket);
        if let Some(at) = answered {
            let job = self.flight.remove(at);
            self.answer(job, frame, now);
        } else if let Some(doubt) = self.doubt.take_if(|doubt| doubt.job.ticket == copy.ticket) {
            self.answer_queued(doubt.job, frame);
        } else {
            self.stats.late += 1;
        }
    }

    /// A reply that nobody waits for. One to a queued command, with an index beyond the last, says
    /// that the controller took a command twice: the line doubled it (UDP).
    fn unasked(&mut self, frame: &FrameBuf) {
        let view = frame.frame();
        let queues = view.ctrl().queued() && !view.ctrl().error();
        let index = QueuedCmdIndex::decode(view.params());
        if let (true, Ok(QueuedCmdIndex(index))) = (queues, index)
            && self.ledger.is_beyond(index)
        {
            self.unaccounted(index);
        }
    }

    /// The controller has taken more commands than this connection knows of.
    fn unaccounted(&mut self, to: u64) {
        let from = self.ledger.last().map_or(to, |last| last.saturating_add(1));
        self.events.push_back(Event::Unaccounted { from, to });
        self.ledger.forget();
    }

    /// The controller has finished more than it was given here. On an ordered link that was another
    /// host, whose business it is; on an unordered one a command of ours may have come twice.
    fn overtaken(&mut self, current: u64) {
        match self.settings.ordered {
            true => self.ledger.forget(),
            false => self.unaccounted(current),
        }
    }

    /// Ends or sends again every job whose reply can no longer come, but for the one answered now.
    pub(super) fn settle(&mut self, answered: Ticket) {
        if !self.settings.ordered {
            return;
        }
        let gone = |connection: &Self, job: &Job| {
            job.ticket != answered && !job.due && !connection.outstanding.awaits(job.ticket)
        };
        while let Some(at) = self.flight.iter().position(|job| gone(self, job)) {
            self.lost(at);
        }
    }

    pub(super) fn answer(&mut self, job: Job, frame: &FrameBuf, now: Micros) {
        if job.sent == 1 {
            self.estimator.sample(now.saturating_sub(job.since));
        }
        if job.queued() {
            return self.answer_queued(job, frame);
        }
        let reset = self.observe(&job, frame, now);
        if self.settings.ordered && !reset {
            self.ledger.confirm();
        }
        match job.purpose {
            Purpose::Caller if frame.frame().ctrl().error() => {
                self.done(job.ticket, Err(Failure::Refused));
            }
            Purpose::Caller => self.done(job.ticket, Ok(*frame)),
            Purpose::Fence => {}
            Purpose::Drain => self.drain_at = Some(now.saturating_add(DRAIN_PAUSE)),
            purpose @ (Purpose::Current | Purpose::Left) => self.read(purpose, frame, now),
        }
    }

    pub(super) fn answer_queued(&mut self, job: Job, frame: &FrameBuf) {
        let view = frame.frame();
        let index = match QueuedCmdIndex::decode(view.params()) {
            _ if view.ctrl().error() => return self.done(job.ticket, Err(Failure::QueueFull)),
            Err(_) => return self.done(job.ticket, Err(Failure::NoIndex)),
            Ok(QueuedCmdIndex(0)) => return self.done(job.ticket, Err(Failure::QueueFull)),
            Ok(QueuedCmdIndex(index)) => index,
        };
        if self.ledger.follows(index) || planted(Flaw::AcceptGaps) {
            self.ledger.accept(index);
            if self.queued_unanswered() == 0 && self.settings.window == 1 {
                self.ledger.confirm();
            }
            self.done(job.ticket, Ok(*frame));
        } else if self.ledger.last() == Some(index) && self.alone() {
            self.enter_doubt(job);
        } else {
            self.uncertain(job);
        }
    }

    /// Notes what a reading says about the queue; true when it shows a reset.
    pub(super) fn observe(&mut self, job: &Job, frame: &FrameBuf, now: Micros) -> bool {
        let idle = self.doubt.is_none() && self.queued_unanswered() == 0;
        let params = frame.frame();
        let params = params.params();
        match job.key.id {
            246 => {
                let Ok(read) = QueuedCmdCurrentIndex::decode(params) else {
                    return false;
                };
                let (current, ordered) = (read.queued_cmd_current_index, self.settings.ordered);
                let reset = self.ledger.read_current(current, ordered);
                match reset {
                    true => self.reset(),
                    false if idle && self.ledger.is_beyond(current) => self.overtaken(current),
                    false => {}
                }
                reset
            }
            247 => {
                if let Ok(read) = QueuedCmdLeftSpace::decode(params) {
                    self.ledger.read_left(read.left_space, idle, now);
                }
                false
            }
            _ => false,
        }
    }

    pub(super) fn reset(&mut self) {
        if !self.events.contains(&Event::Reset) {
            self.events.push_back(Event::Reset);
        }
        self.drop_stream();
    }

    pub(super) fn done(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        self.events.push_back(Event::Done { ticket, result });
    }
}

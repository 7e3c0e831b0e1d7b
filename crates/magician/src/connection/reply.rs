use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex};

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
        let Some(copy) = self.outstanding.answered(Key::of(&frame.frame())) else {
            self.stats.unsolicited += 1;
            return;
        };
        let answered = (self.flight.iter()).position(|job| job.ticket == copy.ticket);
        // Jobs that this reply proves lost come first: they were sent before.
        if let Some(at) = answered {
            let job = self.flight.remove(at);
            self.settle();
            self.answer(job, frame, now);
        } else if let Some(doubt) = self.doubt.take_if(|doubt| doubt.job.ticket == copy.ticket) {
            self.settle();
            self.answer_queued(doubt.job, frame);
        } else {
            self.stats.late += 1;
            self.settle();
        }
    }

    /// Ends or sends again every job whose reply can no longer come.
    pub(super) fn settle(&mut self) {
        if !self.settings.ordered {
            return;
        }
        let gone =
            |connection: &Self, job: &Job| !job.due && !connection.outstanding.awaits(job.ticket);
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
        let reset = self.observe(&job, frame);
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
            Purpose::Current | Purpose::Left => self.read(frame, now),
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
        if self.ledger.follows(index) {
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
    pub(super) fn observe(&mut self, job: &Job, frame: &FrameBuf) -> bool {
        let params = frame.frame();
        let params = params.params();
        match job.key.id {
            246 => {
                let Ok(read) = QueuedCmdCurrentIndex::decode(params) else {
                    return false;
                };
                let reset = self.ledger.read_current(read.queued_cmd_current_index);
                if reset {
                    self.reset();
                }
                reset
            }
            247 => {
                let idle = self.doubt.is_none() && self.queued_unanswered() == 0;
                if let Ok(read) = QueuedCmdLeftSpace::decode(params) {
                    self.ledger.read_left(read.left_space, idle);
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
        if let Some(doubt) = self.doubt.take() {
            self.uncertain(doubt.job);
        }
    }

    pub(super) fn done(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        self.events.push_back(Event::Done { ticket, result });
    }
}

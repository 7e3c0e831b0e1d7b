use magician_protocol::commands::{DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex, Readable};

use super::job::{Job, Purpose};
use super::outstanding::{Copy, Key};
use super::planted_bug::{PlantedBug, planted};
use super::{Connection, DRAIN_PAUSE, Event, Failure, GIVEN, Micros, Ticket};

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
        if planted(PlantedBug::MatchById)
            && let Some(at) = self.flight.iter().position(same_id)
        {
            let job = self.flight.remove(at);
            let copy = Copy {
                key: job.key,
                ticket: job.ticket,
                at: job.since,
                order: job.order,
            };
            return self.answer(job, copy, frame, now);
        }
        let Some(copy) = self.outstanding.answered(Key::of(&frame.frame())) else {
            self.stats.unsolicited += 1;
            self.unasked(frame, now);
            return;
        };
        if self.outstanding.is_empty() {
            // The answer shows that the last frame has passed.
            self.pace.begin_anew();
        }
        // Jobs that this reply proves lost come first: they were sent before, and the answered one
        // counts among those that may stand in the queue in their place.
        let judged_apart = (self.flight.iter().position(|job| job.ticket == copy.ticket))
            .filter(|_| planted(PlantedBug::JudgeInWindow));
        if let Some(at) = judged_apart {
            let job = self.flight.remove(at);
            self.settle(copy.ticket);
            return self.answer(job, copy, frame, now);
        }
        self.settle(copy.ticket);
        let answered = (self.flight.iter()).position(|job| job.ticket == copy.ticket);
        if let Some(at) = answered {
            let job = self.flight.remove(at);
            self.answer(job, copy, frame, now);
        } else if let Some(doubt) = self.doubt.take_if(|doubt| doubt.job.ticket == copy.ticket) {
            self.time(&doubt.job, now);
            self.answer_queued(doubt.job, copy, frame, now);
        } else {
            self.stats.late += 1;
            self.hurry_fence(copy.key);
        }
    }

    /// A reply to an abandoned request came while a fence of the same key is out: it may have been the
    /// fence's own. Copies of the fence are not confused with each other, so it goes again at once; on a line found
    /// again there is no time to wait until it counts as lost. Each such reply leaves one frame less of before.
    fn hurry_fence(&mut self, key: Key) {
        let fence = |job: &&mut Job| job.purpose == Purpose::Fence && job.key == key;
        if let Some(fence) = self.flight.iter_mut().find(fence) {
            fence.due = true;
        }
    }

    /// A reply without a waiting request. One to a queued command, with an index beyond the last, says
    /// that the controller took a command twice: the line doubled it (UDP).
    fn unasked(&mut self, frame: &FrameBuf, now: Micros) {
        let view = frame.frame();
        let queues = view.ctrl().queued() && !view.ctrl().error();
        let index = QueuedCmdIndex::decode(view.params());
        let (true, Ok(QueuedCmdIndex(index))) = (queues, index) else {
            return;
        };
        if self.ends_doubt_late(frame, index, now) {
            return;
        }
        self.came_late(index, now);
        if self.tracker.is_beyond(index) && !self.tracker.is_guess() && !self.witness.is_broken() {
            self.unaccounted(index);
        }
    }

    /// The answer to a command that was answered before shows for how long answers may come.
    fn came_late(&mut self, index: u64, now: Micros) {
        let given = self.given.iter().find(|(given, _)| *given == index);
        let sent = given.map(|(_, sent)| *sent);
        if let Some(sent) = sent.filter(|sent| *sent >= self.awake) {
            self.lifetime.saw(now, now.saturating_sub(sent));
        }
    }

    pub(super) fn note_given(&mut self, index: u64, sent: Micros) {
        if self.given.len() >= GIVEN {
            self.given.pop_front();
        }
        self.given.push_back((index, sent));
    }

    /// The controller has taken more commands than this connection knows of.
    pub(super) fn unaccounted(&mut self, to: u64) {
        let from = self.tracker.next().unwrap_or(to);
        self.events.push_back(Event::Unaccounted { from, to });
        if self.settings.ordered {
            self.tracker.forget()
        } else {
            self.rebase(to)
        }
    }

    /// Over datagrams: this is the index given last, to any host.
    pub(super) fn rebase(&mut self, to: u64) {
        self.tracker.accept(to, self.order);
        self.tracker.confirm();
        self.witness.resume(Some(to));
    }

    /// The controller has finished more than it was given here. On an ordered link that was another
    /// host, whose business it is; on an unordered one a command of ours may have come twice.
    fn overtaken(&mut self, current: u64) {
        if self.settings.ordered {
            self.tracker.forget()
        } else {
            self.unaccounted(current)
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

    /// A job was answered, to the copy of it that went out first of those that may be meant.
    fn answer(&mut self, job: Job, copy: Copy, frame: &FrameBuf, now: Micros) {
        self.time(&job, now);
        if job.queued() {
            return self.answer_queued(job, copy, frame, now);
        }
        if self.settings.ordered {
            self.tracker.confirm_to(copy.order);
        }
        self.observe(&job, copy, frame, now);
        match job.purpose {
            Purpose::Caller if frame.frame().ctrl().error() => {
                self.done(job.ticket, Err(Failure::Refused));
            }
            Purpose::Caller => self.done(job.ticket, Ok(*frame)),
            Purpose::Fence | Purpose::Clock => {}
            Purpose::Drain => self.drain_at = Some(now.saturating_add(DRAIN_PAUSE)),
            purpose @ (Purpose::Current | Purpose::Left) => self.read(purpose, frame, now),
        }
    }

    /// Notes how long an answer took, where it can only be to the one time that the job went out.
    fn time(&mut self, job: &Job, now: Micros) {
        if job.sent == 1 && job.since >= self.awake {
            let time = now.saturating_sub(job.since);
            self.estimator.sample(time);
            self.lifetime.saw(now, time);
        }
    }

    pub(super) fn answer_queued(&mut self, job: Job, copy: Copy, frame: &FrameBuf, now: Micros) {
        let view = frame.frame();
        let alone = self.alone();
        let refusal = match QueuedCmdIndex::decode(view.params()) {
            _ if view.ctrl().error() => Err(Failure::QueueFull),
            Err(_) => Err(Failure::NoIndex),
            Ok(QueuedCmdIndex(0)) => Err(Failure::QueueFull),
            Ok(QueuedCmdIndex(index)) => Ok(index),
        };
        let index = match refusal {
            Ok(index) => index,
            Err(failure) if alone => return self.done(job.ticket, Err(failure)),
            // It is unknown which of those in flight was refused, and those behind it may be taken.
            Err(_) => return self.uncertain(job),
        };
        // Over datagrams an answer may simply come again.
        let telling = alone && (self.settings.ordered || self.tracker.last() != Some(index));
        self.witness.answered(index, telling, job.highest);
        // An arm that numbers its commands in its own way has still taken the one that it answered.
        let lawless = alone && self.witness.is_broken();
        if self.tracker.follows(index) || lawless || planted(PlantedBug::AcceptGaps) {
            self.note_given(index, job.since);
            self.tracker.accept(index, job.order);
            if self.queued_unanswered() == 0 || planted(PlantedBug::ConfirmAtOnce) {
                self.tracker.confirm();
            }
            self.done(job.ticket, Ok(*frame));
            return;
        }
        if !self.settings.ordered {
            // That was another command's answer come again, or the answer to its second copy; its own may follow.
            self.outstanding.sent(copy);
            self.came_late(index, now);
            if alone && self.tracker.is_beyond(index) {
                // It was taken, and something else before it: its own second copy.
                self.unaccounted(index.saturating_sub(1));
                self.rebase(index);
                return self.done(job.ticket, Ok(*frame));
            } else if alone {
                return self.enter_doubt(job);
            }
        }
        if self.tracker.last() == Some(index) && alone {
            self.enter_doubt(job);
        } else {
            self.uncertain(job);
            self.tracker.disbelieve(index);
            self.witness.resume(Some(index));
        }
    }

    /// Notes what a reading says about the controller.
    fn observe(&mut self, job: &Job, copy: Copy, frame: &FrameBuf, now: Micros) {
        let view = frame.frame();
        if view.ctrl().error() {
            return;
        }
        if job.key == Key::read(DeviceTime::ROW) {
            if let Ok(read) = DeviceTime::decode(view.params()) {
                self.observe_clock(read.g_systick, copy.at, now);
            }
        } else if job.key == Key::read(QueuedCmdCurrentIndex::ROW) {
            if let Ok(read) = QueuedCmdCurrentIndex::decode(view.params()) {
                self.observe_current(read.queued_cmd_current_index);
            }
        } else if job.key == Key::read(QueuedCmdLeftSpace::ROW)
            && let Ok(read) = QueuedCmdLeftSpace::decode(view.params())
        {
            self.observe_left(read.left_space, job.sent == 1, now);
        }
    }

    fn observe_clock(&mut self, ms: u32, asked: Micros, now: Micros) {
        self.seen(Purpose::Clock);
        if self.uptime.read(ms, asked, now, self.settings.ordered) {
            self.reset(None);
        }
    }

    fn observe_current(&mut self, current: u64) {
        self.seen(Purpose::Current);
        let lower = self.tracker.read_current(current, self.settings.ordered);
        if lower && self.witness.trusts_current() {
            return self.reset(Some(current));
        }
        self.witness.current(current, self.tracker.reached(current));
        if self.is_accounted() && self.tracker.is_beyond(current) && !self.witness.is_broken() {
            self.overtaken(current);
        }
    }

    /// `once`: the reading was asked for once, so nothing that was sent later can be in it.
    fn observe_left(&mut self, left: u32, once: bool, now: Micros) {
        self.seen(Purpose::Left);
        if self.settings.ordered
            && once
            && self.doubt.is_none()
            && let Some(look) = self.tracker.look(left)
        {
            self.witness.look(look);
        }
        self.tracker.read_left(left, self.is_accounted(), now);
    }

    /// Whether no queued command waits for its answer.
    pub(super) fn is_accounted(&self) -> bool {
        self.doubt.is_none() && self.queued_unanswered() == 0
    }

    /// The controller was reset; `current` is what it counts from now, where that was seen.
    fn reset(&mut self, current: Option<u64>) {
        if !self.events.contains(&Event::Reset) {
            self.events.push_back(Event::Reset);
        }
        self.witness.reset(current.is_some());
        // What is in doubt is named by the indices that were, so these are forgotten last.
        self.drop_stream();
        if !self.alone()
            && let Some(at) = self.flight.iter().position(Job::queued)
        {
            let job = self.flight.remove(at);
            self.uncertain(job);
        }
        if self.settings.ordered {
            // What was answered before has come: the first index of the new count may be the last one of the old.
            self.tracker.begin_anew();
        }
        self.tracker.restart(current.unwrap_or(0));
        if current.is_some() {
            self.uptime.forget();
        }
    }

    pub(super) fn done(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        self.events.push_back(Event::Done { ticket, result });
    }
}

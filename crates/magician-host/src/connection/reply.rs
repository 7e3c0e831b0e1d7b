//! Incoming frames: matching replies to requests, and what each reply says about the controller.

use magician_protocol::commands::{DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout, QueuedCmdIndex, Readable};

use super::job::{Job, Purpose};
use super::outstanding::{Key, SentFrame};
use super::planted_bug::{PlantedBug, is_planted};
use super::{Connection, DRAIN_POLL_INTERVAL, Event, Failure, MAX_RECENT_INDICES, Micros, Ticket};

/// Input.
impl Connection {
    /// Processes bytes from the controller, split anywhere.
    pub fn receive(&mut self, now: Micros, bytes: &[u8]) {
        self.stats.bytes = self.stats.bytes.saturating_add(bytes.len() as u64);
        self.last_receive = now;
        self.process_bytes(now, bytes);
    }

    pub(super) fn process_bytes(&mut self, now: Micros, mut bytes: &[u8]) {
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
        if is_planted(PlantedBug::MatchById)
            && let Some(at) = self.flight.iter().position(same_id)
        {
            let job = self.flight.remove(at);
            let copy = SentFrame {
                key: job.key,
                ticket: job.ticket,
                at: job.since,
                order: job.order,
            };
            return self.answer(job, copy, frame, now);
        }
        let Some(copy) = self.outstanding.answered(Key::of(&frame.frame())) else {
            self.stats.unsolicited += 1;
            self.handle_unsolicited(frame, now);
            return;
        };
        if self.outstanding.is_empty() {
            // This reply shows that the last frame has left the line.
            self.pace.begin_anew();
        }
        // Jobs that this reply proves lost are handled first: they were sent earlier, and the index
        // in the reply may be the one that a lost job would have got.
        let judged_apart = (self.flight.iter().position(|job| job.ticket == copy.ticket))
            .filter(|_| is_planted(PlantedBug::JudgeInWindow));
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
            self.retransmit_fence(copy.key);
        }
    }

    /// Retransmits a fence at once after a reply to an abandoned request with the fence's key.
    ///
    /// That reply may have been the fence's own. Copies of the fence need not be told apart, so it
    /// does not wait for its timeout, which would delay a restored line. Each such reply removes
    /// one old frame.
    fn retransmit_fence(&mut self, key: Key) {
        let fence = |job: &&mut Job| job.purpose == Purpose::Fence && job.key == key;
        if let Some(fence) = self.flight.iter_mut().find(fence) {
            fence.needs_retransmit = true;
        }
    }

    /// Handles a reply that matches no outstanding frame. If it belongs to a queued command and its
    /// index is beyond the last, the line duplicated a command (UDP) or another host sent one.
    fn handle_unsolicited(&mut self, frame: &FrameBuf, now: Micros) {
        let view = frame.frame();
        let queues = view.ctrl().queued() && !view.ctrl().error();
        let index = QueuedCmdIndex::decode(view.params());
        let (true, Ok(QueuedCmdIndex(index))) = (queues, index) else {
            return;
        };
        if self.ends_doubt_late(frame, index, now) {
            return;
        }
        self.measure_late_reply(index, now);
        if self.tracker.is_beyond(index)
            && !self.tracker.is_guess()
            && !self.law_monitor.is_broken()
        {
            self.unaccounted(index);
        }
    }

    /// Adds the round trip of a second reply to a recent command to the measured lifetime.
    fn measure_late_reply(&mut self, index: u64, now: Micros) {
        let given = self.given.iter().find(|(given, _)| *given == index);
        let sent = given.map(|(_, sent)| *sent);
        if let Some(sent) = sent.filter(|sent| *sent >= self.resumed_at) {
            self.lifetime.add_round_trip(now, now.saturating_sub(sent));
        }
    }

    pub(super) fn note_given(&mut self, index: u64, sent: Micros) {
        // Late replies belong to recent commands, so a few are enough.
        if self.given.len() >= MAX_RECENT_INDICES {
            self.given.pop_front();
        }
        self.given.push_back((index, sent));
    }

    /// Reports that the controller has taken more commands than this connection sent.
    pub(super) fn unaccounted(&mut self, to: u64) {
        let from = self.tracker.next().unwrap_or(to);
        self.events.push_back(Event::Unaccounted { from, to });
        // On an ordered link another host must be at work, so the count is no longer ours.
        if self.settings.ordered {
            self.tracker.forget()
        } else {
            self.rebase(to)
        }
    }

    /// Sets the last index, over datagrams, to the last one given to any host.
    pub(super) fn rebase(&mut self, to: u64) {
        self.tracker.accept(to, self.order);
        self.tracker.confirm();
        self.law_monitor.resume(Some(to));
    }

    /// Handles a current index beyond the last accepted index. On an ordered link that is another
    /// host's doing; on an unordered one, a command of ours may have been duplicated.
    fn handle_foreign_progress(&mut self, current: u64) {
        if self.settings.ordered {
            self.tracker.forget()
        } else {
            self.unaccounted(current)
        }
    }

    /// Ends or retransmits every job whose reply can no longer arrive, except the one answered now.
    pub(super) fn settle(&mut self, answered: Ticket) {
        if !self.settings.ordered {
            return;
        }
        let gone = |connection: &Self, job: &Job| {
            job.ticket != answered
                && !job.needs_retransmit
                && !connection.outstanding.awaits(job.ticket)
        };
        while let Some(at) = self.flight.iter().position(|job| gone(self, job)) {
            self.handle_loss(at);
        }
    }

    /// Handles the reply to a job. `copy` is the oldest transmission that the reply may belong to.
    fn answer(&mut self, job: Job, copy: SentFrame, frame: &FrameBuf, now: Micros) {
        self.time(&job, now);
        if job.queued() {
            return self.answer_queued(job, copy, frame, now);
        }
        // A settle point: on an ordered link every command sent before this frame has been
        // answered.
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
            Purpose::Drain => self.drain_at = Some(now.saturating_add(DRAIN_POLL_INTERVAL)),
            purpose @ (Purpose::Current | Purpose::Left) => self.read(purpose, frame, now),
        }
    }

    /// Samples the round trip, if the reply can only belong to a single transmission.
    fn time(&mut self, job: &Job, now: Micros) {
        // Karn's algorithm, and no samples from before the caller was held up.
        if job.sent == 1 && job.since >= self.resumed_at {
            let time = now.saturating_sub(job.since);
            self.estimator.sample(time);
            self.lifetime.add_round_trip(now, time);
        }
    }

    pub(super) fn answer_queued(
        &mut self,
        job: Job,
        copy: SentFrame,
        frame: &FrameBuf,
        now: Micros,
    ) {
        let view = frame.frame();
        let alone = self.has_at_most_one_unaccounted();
        let refusal = match QueuedCmdIndex::decode(view.params()) {
            _ if view.ctrl().error() => Err(Failure::QueueFull),
            Err(_) => Err(Failure::NoIndex),
            // Controllers refuse by the error bit or by index 0, which is never given.
            Ok(QueuedCmdIndex(0)) => Err(Failure::QueueFull),
            Ok(QueuedCmdIndex(index)) => Ok(index),
        };
        let index = match refusal {
            Ok(index) => index,
            Err(failure) if alone => return self.done(job.ticket, Err(failure)),
            // Which command in flight was refused is unknown, and those behind it may have been
            // taken.
            Err(_) => return self.uncertain(job),
        };
        // Over datagrams a reply may be a duplicate.
        let telling = alone && (self.settings.ordered || self.tracker.last() != Some(index));
        self.law_monitor.note_reply(index, telling, job.highest);
        // An arm with its own numbering has nevertheless taken the command that it answered.
        let lawless = alone && self.law_monitor.is_broken();
        if self.tracker.follows(index) || lawless || is_planted(PlantedBug::AcceptGaps) {
            self.note_given(index, job.since);
            self.tracker.accept(index, job.order);
            if self.queued_unanswered() == 0 || is_planted(PlantedBug::ConfirmAtOnce) {
                self.tracker.confirm();
            }
            self.done(job.ticket, Ok(*frame));
            return;
        }
        if !self.settings.ordered {
            // A duplicated reply to another command, or the reply to the second copy of that
            // command; the reply to this one may still arrive.
            self.outstanding.sent(copy);
            self.measure_late_reply(index, now);
            if alone && self.tracker.is_beyond(index) {
                // The command was taken twice: its other copy got the index before this one.
                self.unaccounted(index.saturating_sub(1));
                self.rebase(index);
                return self.done(job.ticket, Ok(*frame));
            } else if alone {
                return self.enter_doubt(job);
            }
        }
        // The last index again: a duplicated reply, while the command's own was lost.
        if self.tracker.last() == Some(index) && alone {
            self.enter_doubt(job);
        } else {
            self.uncertain(job);
            self.tracker.disbelieve(index);
            self.law_monitor.resume(Some(index));
        }
    }

    /// Evaluates what a reading says about the controller.
    fn observe(&mut self, job: &Job, copy: SentFrame, frame: &FrameBuf, now: Micros) {
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
        self.note_restore_reading(Purpose::Clock);
        if self.uptime.read(ms, asked, now, self.settings.ordered) {
            self.reset(None);
        }
    }

    fn observe_current(&mut self, current: u64) {
        self.note_restore_reading(Purpose::Current);
        let lower = self.tracker.read_current(current, self.settings.ordered);
        if lower && self.law_monitor.trusts_current() {
            return self.reset(Some(current));
        }
        self.law_monitor
            .note_current(current, self.tracker.reached(current));
        if self.is_accounted() && self.tracker.is_beyond(current) && !self.law_monitor.is_broken() {
            self.handle_foreign_progress(current);
        }
    }

    /// Processes a reading of the left space. `once` is true if the read was sent only once, so its
    /// reply cannot include commands sent later.
    fn observe_left(&mut self, left: u32, once: bool, now: Micros) {
        self.note_restore_reading(Purpose::Left);
        // Beside a doubt or on an unordered link a mismatch would prove nothing about the law.
        if self.settings.ordered
            && once
            && self.doubt.is_none()
            && let Some(reading) = self.tracker.look(left)
        {
            self.law_monitor.note_left_space(reading);
        }
        self.tracker.read_left(left, self.is_accounted(), now);
    }

    /// True if no queued command waits for its reply.
    pub(super) fn is_accounted(&self) -> bool {
        self.doubt.is_none() && self.queued_unanswered() == 0
    }

    /// Handles a reset of the controller. `current` is its new current index, if that was read.
    fn reset(&mut self, current: Option<u64>) {
        // Clock and index may both show the same reset: report it once.
        if !self.events.contains(&Event::Reset) {
            self.events.push_back(Event::Reset);
        }
        self.law_monitor.reset(current.is_some());
        // Commands in doubt are reported with the old indices, so these are discarded last.
        self.drop_stream();
        if !self.has_at_most_one_unaccounted()
            && let Some(at) = self.flight.iter().position(Job::queued)
        {
            let job = self.flight.remove(at);
            self.uncertain(job);
        }
        if self.settings.ordered {
            // Earlier replies have all arrived: the first index of the new count may equal the last
            // of the old.
            self.tracker.begin_anew();
        }
        self.tracker.restart(current.unwrap_or(0));
        // The clock is evaluated anew, or the same reset would be reported twice.
        if current.is_some() {
            self.uptime.forget();
        }
    }

    pub(super) fn done(&mut self, ticket: Ticket, result: Result<FrameBuf, Failure>) {
        self.events.push_back(Event::Done { ticket, result });
    }
}

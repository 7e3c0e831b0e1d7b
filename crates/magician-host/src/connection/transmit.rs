//! Outgoing frames: which one goes next, and when a fence or a reading must go first.

use magician_protocol::commands::{
    AlarmsState, DeviceTime, DeviceVersion, Pose, QueuedCmdClear, QueuedCmdCurrentIndex,
    QueuedCmdLeftSpace,
};
use magician_protocol::{Ctrl, FrameBuf, Readable, Row, Writable};

use super::interruption::Link;
use super::job::{Job, Purpose};
use super::outstanding::{Key, SentFrame};
use super::planted_bug::{PlantedBug, is_planted};
use super::{Connection, IndexLaw, Micros, Priority, Request, Ticket};

/// Consecutive requests of the stream after which a waiting read has its turn; fewer if several
/// reads wait.
// A choice: reads get at least every fifth frame.
const MAX_STREAM_STREAK: u32 = 4;
/// Number of consecutive queued commands in a window above 1 after which a fence is sent: only a
/// reply to a request of another kind, or a moment without any in flight, confirms them.
const MAX_UNFENCED_COMMANDS: u64 = 8;
/// Reads that every controller answers, used as fences in turn.
pub(crate) const FENCES: [&Row; 6] = [
    QueuedCmdCurrentIndex::ROW,
    QueuedCmdLeftSpace::ROW,
    <AlarmsState as Readable>::ROW,
    <Pose as Readable>::ROW,
    DeviceTime::ROW,
    DeviceVersion::ROW,
];

/// Output.
impl Connection {
    /// Returns the next frame to write. `None` if nothing may be sent at present.
    pub fn poll_transmit(&mut self, now: Micros) -> Option<FrameBuf> {
        if self.link == Link::Down {
            return None;
        }
        // Stops ignore window and pace: they must not wait behind anything.
        if !self.outstanding.is_choked()
            && let Some(frame) = self.transmit_stop(now)
        {
            return Some(frame);
        }
        if self.outstanding.is_full() {
            return None;
        }
        let due = self.flight.iter().position(|job| job.needs_retransmit);
        let busy = self.flight.iter().filter(|job| job.in_window()).count();
        // The pace is asked only for a frame that could be sent, because a refusal sets a timer.
        if due.is_none() && busy >= self.window() {
            return self.transmit_beside(now);
        }
        if !self.pace.admits(now) {
            return None;
        }
        if let Some(at) = due {
            if (self.flight.get(at)).is_some_and(|job| self.must_travel_alone(job)) {
                return None;
            }
            let job = self.flight.remove(at);
            return Some(self.send(job, now));
        }
        if let Some(purpose) = self.next_reading(now) {
            return self.send_reading(purpose, now);
        }
        // The more reads wait, the shorter the streak that may precede them.
        let polls = u32::try_from(self.lanes[Priority::Poll as usize].len()).unwrap_or(u32::MAX);
        let poll_first = self.stream_streak >= (MAX_STREAM_STREAK / polls.max(1)).max(1);
        let [first, second] = if poll_first {
            [Priority::Poll, Priority::Stream]
        } else {
            [Priority::Stream, Priority::Poll]
        };
        self.transmit_lane(first, now)
            .or_else(|| self.transmit_lane(second, now))
    }

    fn transmit_stop(&mut self, now: Micros) -> Option<FrameBuf> {
        let stop = |job: &Job| job.priority == Priority::Stop;
        match self.flight.iter().position(stop) {
            Some(at) if self.flight.get(at).is_some_and(|job| job.needs_retransmit) => {
                let job = self.flight.remove(at);
                Some(self.send(job, now))
            }
            // Stops go one at a time: their order matters, and each must be answered before the
            // next.
            Some(_) => None,
            None => {
                let job = self.lanes[Priority::Stop as usize].pop_front()?;
                Some(self.send(job, now))
            }
        }
    }

    /// Largest number of requests in flight at present: as set, or 1 on an unordered link or an arm
    /// that breaks the index law.
    #[must_use]
    pub fn window(&self) -> usize {
        if self.law_monitor.is_broken() {
            1
        } else {
            self.settings.window
        }
    }

    /// Next reading for a restored line, a command in doubt or the duplicate check. `None` while
    /// one is in flight.
    fn next_reading(&self, now: Micros) -> Option<Purpose> {
        let readings = [Purpose::Current, Purpose::Left, Purpose::Clock];
        if (self.flight.iter()).any(|job| readings.contains(&job.purpose)) {
            return None;
        }
        if let Some(purpose) = self.next_restore_reading() {
            return Some(purpose);
        }
        let Some(doubt) = &self.doubt else {
            return self.next_check_reading(now);
        };
        if doubt.not_before.is_some() {
            return None;
        }
        Some(match doubt.current {
            None => Purpose::Current,
            Some(_) => Purpose::Left,
        })
    }

    fn send_reading(&mut self, purpose: Purpose, now: Micros) -> Option<FrameBuf> {
        let row = match purpose {
            Purpose::Clock => DeviceTime::ROW,
            Purpose::Current => QueuedCmdCurrentIndex::ROW,
            // Left space; `next_reading` returns no other purpose.
            _ => QueuedCmdLeftSpace::ROW,
        };
        if let Some(doubt) = &mut self.doubt
            && purpose != Purpose::Clock
        {
            doubt.begun.get_or_insert(now);
        }
        if purpose != Purpose::Clock {
            self.note_check_reading();
        }
        self.send_own(purpose, row, now)
    }

    fn transmit_lane(&mut self, lane: Priority, now: Micros) -> Option<FrameBuf> {
        if lane == Priority::Stream && self.wants_drain() {
            let looking = |job: &Job| job.purpose == Purpose::Drain;
            if self.drain_at.is_some() || self.flight.iter().any(looking) {
                return None;
            }
            return self.send_own(Purpose::Drain, QueuedCmdLeftSpace::ROW, now);
        }
        let job = *self.lanes[lane as usize].front()?;
        if !self.may_join(&job) || job.queued() && !self.may_send_queued(now) {
            return None;
        }
        let unsettled = self.order.saturating_sub(self.settled);
        if self.must_wait_for_fence(&job)
            || job.may_share_window()
                && self.settings.window > 1
                && unsettled >= MAX_UNFENCED_COMMANDS
        {
            return self.send_fence(now);
        }
        Some(self.send_front(lane, job, now))
    }

    /// Sends the first job of a lane.
    pub(super) fn send_front(&mut self, lane: Priority, job: Job, now: Micros) -> FrameBuf {
        self.lanes[lane as usize].pop_front();
        self.stream_streak = match lane {
            Priority::Poll => 0,
            _ => self.stream_streak.saturating_add(1),
        };
        self.send(job, now)
    }

    /// True if a job may be in flight beside the others: requests of the stream only if both share
    /// the window and the law is followed, all others if their keys differ.
    pub(super) fn may_join(&self, job: &Job) -> bool {
        let stream = job.priority == Priority::Stream;
        if stream && (self.doubt.is_some() || self.stopping() || self.link != Link::Up) {
            return false;
        }
        let lawful = self.law_monitor.law() == IndexLaw::Followed;
        let mut beside = self.flight.iter().filter(|other| !other.timed_out);
        beside.all(|other| {
            if stream && other.priority == job.priority {
                lawful && job.may_share_window() && other.may_share_window()
            } else {
                other.key != job.key
            }
        })
    }

    /// True while a stop is unanswered. A retransmitted Clear must not drop a command that was
    /// accepted after its first copy.
    fn stopping(&self) -> bool {
        let stop = |job: &Job| job.priority == Priority::Stop;
        let any = !self.lanes[Priority::Stop as usize].is_empty() || self.flight.iter().any(stop);
        any && !is_planted(PlantedBug::QueueWhileStopping)
    }

    /// True if a queued command waits for the queue to drain after a Clear.
    pub(super) fn wants_drain(&self) -> bool {
        let head = self.lanes[Priority::Stream as usize].front();
        self.tracker.draining() && head.is_some_and(Job::queued)
    }

    /// Rule 4: true if an outstanding frame of the job's key belongs to a request that is no longer
    /// waited for in the window.
    pub(super) fn must_wait_for_fence(&self, job: &Job) -> bool {
        let waited_for = |ticket: Ticket| {
            ticket == job.ticket
                || (self.flight.iter()).any(|other| other.ticket == ticket && !other.timed_out)
        };
        self.outstanding.has_abandoned(job.key, waited_for) && !is_planted(PlantedBug::NoFence)
    }

    /// Sends a reading, or a fence if another request's reply could be taken for its own.
    fn send_own(&mut self, purpose: Purpose, row: &Row, now: Micros) -> Option<FrameBuf> {
        let request = Request::raw(row.id, Ctrl::GET, &[]).ok()?;
        let ticket = self.ticket();
        let job = Job::new(ticket, purpose, &request);
        if purpose != Purpose::Fence && self.must_wait_for_fence(&job) {
            return self.send_fence(now);
        }
        Some(self.send(job, now))
    }

    /// Sends a fence unless one is in flight. Unordered links have no fences.
    fn send_fence(&mut self, now: Micros) -> Option<FrameBuf> {
        let fenced = self.flight.iter().any(|job| job.purpose == Purpose::Fence);
        if fenced || !self.settings.ordered {
            return None;
        }
        let turn = FENCES[self.next_fence % FENCES.len()];
        // A row without outstanding frames needs no fence itself.
        let clean = FENCES
            .iter()
            .find(|row| !self.outstanding.contains(Key::read(row)));
        self.next_fence = (self.next_fence + 1) % FENCES.len();
        self.send_own(Purpose::Fence, clean.copied().unwrap_or(turn), now)
    }

    /// Notes that the queue is cleared.
    pub(super) fn note_clear(&mut self) {
        self.tracker.clearing();
        self.law_monitor.drop_open_checks();
        self.drain_at = None;
    }

    fn send(&mut self, mut job: Job, now: Micros) -> FrameBuf {
        if job.key.ctrl.write() && job.key.id == QueuedCmdClear::ROW.id {
            self.note_clear();
        }
        self.stats.sent += 1;
        self.stats.resent += u64::from(job.sent > 0);
        self.note_pair(&mut job);
        job.needs_retransmit = false;
        job.sent = job.sent.saturating_add(1);
        job.since = now;
        // On an unordered link a retransmission within the lifetime of the first copy would block
        // the next request of its key, so wait at least that long.
        let lifetime = (self.lifetime.measured()).filter(|_| !is_planted(PlantedBug::NoLifetime));
        let patience = match job.priority {
            // No backoff for a stop: it may be executed twice, and no command is sent meanwhile.
            Priority::Stop => self.estimator.first_timeout(),
            _ => self.estimator.timeout(),
        };
        let patience = patience.max(lifetime.unwrap_or(0));
        job.timer = now.saturating_add(patience);
        job.clears = self.tracker.clears();
        if job.queued() {
            self.order += 1;
            self.tracker.note_queued_sent();
            self.begin_duplicate_check(now, job.sent);
        } else {
            // The reply to this frame will settle the queued commands sent so far.
            self.settled = self.order;
        }
        job.order = self.order;
        job.highest = self.law_monitor.highest();
        self.outstanding.sent(SentFrame {
            key: job.key,
            ticket: job.ticket,
            at: now,
            order: job.order,
        });
        self.pace.sent(now, job.frame.bytes().len());
        let frame = job.frame;
        self.flight.push(job);
        frame
    }
}

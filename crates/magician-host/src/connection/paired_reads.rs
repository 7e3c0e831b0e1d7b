//! A read in flight beside a queued command at window 1.
//!
//! Without it, the reads that watch the queue cost nearly as much line time as the commands. See "A
//! read beside a queued command" in the head of [`connection`](super).

use magician_protocol::FrameBuf;

use super::doubt::Doubt;
use super::job::{Job, Purpose};
use super::outstanding::{Key, SentFrame};
use super::planted_bug::{PlantedBug, is_planted};
use super::{Connection, IndexLaw, Micros, Priority};

/// Number of received frames after the first lost frame of a pair until pairs are sent again. Each
/// further loss doubles it.
// A choice: a controller that accepts one frame at a time then puts only a few commands in doubt.
const FIRST_PAUSE: u64 = 256;
/// Largest number of doublings of [`FIRST_PAUSE`]. The pause then lasts days on a busy line.
const MAX_DOUBLINGS: u32 = 20;

/// Tracks whether this controller accepts a read and a queued command at the same time. This
/// is assumed until a frame of a pair is lost; then reads wait their turn for a while.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairedReads {
    losses: u32,
    /// Number of received frames at which pairs are allowed again.
    resume_at: u64,
}

impl PairedReads {
    fn are_allowed(self, frames: u64) -> bool {
        frames >= self.resume_at || is_planted(PlantedBug::PairAfterLoss)
    }

    fn lost(&mut self, frames: u64) {
        let pause = FIRST_PAUSE << self.losses.min(MAX_DOUBLINGS);
        self.losses = self.losses.saturating_add(1);
        self.resume_at = frames.saturating_add(pause);
    }
}

/// Pairs of a read and a queued command.
impl Connection {
    /// True if a read and a queued command may be in flight together at window 1.
    fn may_pair(&self) -> bool {
        self.settings.reads_beside
            && self.settings.ordered
            && self.window() == 1
            && self.law_monitor.law() == IndexLaw::Followed
            && self.pairs.are_allowed(self.stats.frames)
    }

    /// Next frame at window 1 while another is in flight: a read beside a queued command or the
    /// command beside the read, so that neither waits for the other's reply.
    pub(super) fn transmit_beside(&mut self, now: Micros) -> Option<FrameBuf> {
        if !self.may_pair() {
            return None;
        }
        let mut in_flight = self.flight.iter().filter(|job| job.in_window());
        let (Some(only), None) = (in_flight.next(), in_flight.next()) else {
            return None;
        };
        let lane = if only.queued() {
            Priority::Poll
        } else {
            Priority::Stream
        };
        let job = *self.lanes[lane as usize].front()?;
        let pairs = only.queued() && job.reads() || only.reads() && job.queued();
        let waits = lane == Priority::Stream && self.wants_drain();
        // Byte counts for the pacing: a read sent directly behind the command travels while the
        // controller answers the command.
        let [before, bytes] = [only, &job].map(|job| job.frame.bytes().len());
        if !pairs || waits || !self.may_join(&job) || self.must_wait_for_fence(&job) {
            return None;
        }
        if !self.pace.admits_behind(now, before, bytes) && !self.pace.admits(now) {
            return None;
        }
        Some(self.send_front(lane, job, now))
    }

    /// True if a retransmission must wait, because it would be in flight beside another frame.
    pub(super) fn must_travel_alone(&self, job: &Job) -> bool {
        let beside = |other: &Job| {
            other.in_window() && !other.needs_retransmit && other.ticket != job.ticket
        };
        self.settings.window == 1
            && self.settings.reads_beside
            && self.flight.iter().any(beside)
            && !self.may_pair()
    }

    /// Notes that a job is sent while another is in flight.
    pub(super) fn note_pair(&mut self, job: &mut Job) {
        job.paired = false;
        if self.settings.window > 1 || !job.in_window() {
            return;
        }
        for other in self.flight.iter_mut().filter(|other| other.in_window()) {
            // Both, because the controller may drop either.
            (job.paired, other.paired) = (true, true);
        }
    }

    /// Notes that a job counts as lost. If it was in a pair, the controller may not accept pairs.
    pub(super) fn lost_from_pair(&mut self, at: usize) {
        if self.flight.get(at).is_some_and(|job| job.paired) {
            self.pairs.lost(self.stats.frames);
        }
    }

    /// Ends the doubt if a reply that matches no outstanding frame, with this `index`, answers the
    /// command in doubt. Returns true if it does.
    ///
    /// This happens if the controller answers the read of a pair before the command, contrary to
    /// errata E06: the command is then in doubt although nothing was lost. The reply must be that
    /// of the command, because at window 1 no other frame with the same key is unanswered, and the
    /// index is the next one.
    pub(super) fn ends_doubt_late(&mut self, frame: &FrameBuf, index: u64, now: Micros) -> bool {
        let (key, next) = (Key::of(&frame.frame()), self.tracker.next());
        let answers = |doubt: &mut Doubt| doubt.job.paired && doubt.job.key == key;
        if next != Some(index) || is_planted(PlantedBug::OneOrderOnly) {
            return false;
        }
        let Some(Doubt { job, .. }) = self.doubt.take_if(answers) else {
            return false;
        };
        let copy = SentFrame {
            key,
            ticket: job.ticket,
            at: job.since,
            order: job.order,
        };
        self.answer_queued(job, copy, frame, now);
        true
    }
}

impl Job {
    /// True if it is a read of the caller.
    fn reads(&self) -> bool {
        let ctrl = self.key.ctrl;
        self.purpose == Purpose::Caller && !ctrl.write() && !ctrl.queued()
    }
}

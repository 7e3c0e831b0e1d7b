use magician_protocol::FrameBuf;

use super::doubt::Doubt;
use super::job::{Job, Purpose};
use super::outstanding::{Copy, Key};
use super::planted_bug::{PlantedBug, planted};
use super::{Connection, Law, Micros, Priority};

/// Answers for which reads wait their turn after the first loss from a pair; doubled by each further loss.
const FIRST_PAUSE: u64 = 256;
/// Most doublings: [`FIRST_PAUSE`] then is days of a full line.
const MOST_DOUBLINGS: u32 = 20;

/// Whether this controller takes a read and a queued command at the same time. It is assumed until a
/// frame of a pair is lost: then reads wait their turn for a while.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pairs {
    losses: u32,
    /// Frames received by which pairs are allowed again.
    resume_at: u64,
}

impl Pairs {
    fn are_allowed(self, frames: u64) -> bool {
        frames >= self.resume_at || planted(PlantedBug::PairAfterLoss)
    }

    fn lost(&mut self, frames: u64) {
        let pause = FIRST_PAUSE << self.losses.min(MOST_DOUBLINGS);
        self.losses = self.losses.saturating_add(1);
        self.resume_at = frames.saturating_add(pause);
    }
}

/// Pairs of a read and a queued command.
impl Connection {
    /// True if a read and a queued command may be in flight together although the window is 1.
    fn may_pair(&self) -> bool {
        self.settings.reads_beside
            && self.settings.ordered
            && self.window() == 1
            && self.witness.law() == Law::Followed
            && self.pairs.are_allowed(self.stats.frames)
    }

    /// The next frame at window 1 while one is in flight: a read beside a queued command, or the
    /// command beside the read, so that neither waits for the other's reply.
    pub(super) fn transmit_beside(&mut self, now: Micros) -> Option<FrameBuf> {
        if !self.may_pair() {
            return None;
        }
        let mut flying = self.flight.iter().filter(|job| job.in_window());
        let (Some(only), None) = (flying.next(), flying.next()) else {
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
        // Right behind the command the read is on the line while the controller answers the command.
        let [before, bytes] = [only, &job].map(|job| job.frame.bytes().len());
        if !pairs || waits || !self.may_join(&job) || self.haunted(&job) {
            return None;
        }
        if !self.pace.admits_behind(now, before, bytes) && !self.pace.admits(now) {
            return None;
        }
        Some(self.send_front(lane, job, now))
    }

    /// True if a job that is to go out again has to wait, because it would be beside another one.
    pub(super) fn waits_alone(&self, job: &Job) -> bool {
        let beside = |other: &Job| other.in_window() && !other.due && other.ticket != job.ticket;
        self.settings.window == 1
            && self.settings.reads_beside
            && self.flight.iter().any(beside)
            && !self.may_pair()
    }

    /// Notes that a job goes out while another one is in flight.
    pub(super) fn note_pair(&mut self, job: &mut Job) {
        job.paired = false;
        if self.settings.window > 1 || !job.in_window() {
            return;
        }
        for other in self.flight.iter_mut().filter(|other| other.in_window()) {
            (job.paired, other.paired) = (true, true);
        }
    }

    /// A job counts as lost. A frame of a pair that is lost may be one that this controller does not take.
    pub(super) fn lost_from_pair(&mut self, at: usize) {
        if self.flight.get(at).is_some_and(|job| job.paired) {
            self.pairs.lost(self.stats.frames);
        }
    }

    /// A reply to nothing outstanding, with this index, came. If it answers the command of a pair, the
    /// controller has answered the read first, against errata E06, and the command is in doubt although
    /// nothing was lost. At window 1 no other frame of its key can be meant, and the index is the one
    /// that it would have.
    pub(super) fn ends_doubt_late(&mut self, frame: &FrameBuf, index: u64, now: Micros) -> bool {
        let (key, next) = (Key::of(&frame.frame()), self.tracker.next());
        let answers = |doubt: &mut Doubt| doubt.job.paired && doubt.job.key == key;
        if next != Some(index) || planted(PlantedBug::OneOrderOnly) {
            return false;
        }
        let Some(Doubt { job, .. }) = self.doubt.take_if(answers) else {
            return false;
        };
        let copy = Copy {
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
    /// True if it is a caller's read.
    fn reads(&self) -> bool {
        let ctrl = self.key.ctrl;
        self.purpose == Purpose::Caller && !ctrl.write() && !ctrl.queued()
    }
}

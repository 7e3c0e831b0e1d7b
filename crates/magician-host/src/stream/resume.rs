//! Resuming: what an ended stream leaves, and how another stream accounts for it before it sends
//! anything.

use magician_protocol::ArmInstant;

use super::drive::Phase;
use super::item::{Entry, Fate, Item};
use super::reading::Reader;
use super::{MAX_KEPT, Stream, StreamEvent, StreamFailure, StreamSettings};
use crate::connection::Micros;

/// Largest deviation of an arm at rest from its expected pose, mm for x, y, z and degrees for r.
// A choice, well above its repeatability and below a visible error.
pub(crate) const POSE_TOLERANCE: f64 = 0.5;

/// Interval between readings of an arm that moves, us.
pub(super) const MOVING_PAUSE: Micros = 50_000;

/// Queue and pose from one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QueueSnapshot {
    /// Instant at which the reading ended.
    pub(super) at: ArmInstant,
    pub(super) current: u64,
    pub(super) left: u32,
    pub(super) pose: [f64; 4],
}

impl QueueSnapshot {
    /// True if the other reading has the same values.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let read = |look: &Self| (look.current, look.left, look.pose);
        read(self) == read(other)
    }
}

/// Commands that an ended stream has not seen finished, and what is known of them.
#[derive(Debug)]
pub struct Leftover(Stream);

impl Leftover {
    /// Commands not known to be finished and confirmed, in order, with the indices of
    /// those known to have been taken. Commands that the stream inserted between two chunks of the
    /// laser are included.
    pub fn items(&self) -> impl Iterator<Item = (Option<u64>, &Item)> {
        (self.0.entries.iter()).map(|entry| (entry.index(), &entry.item))
    }

    /// Number of these commands.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.entries.len()
    }

    /// True if there are no such commands.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.entries.is_empty()
    }

    /// True if any of them may have been sent to the arm.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.0.first.is_some() || !self.0.entries.iter().all(Entry::is_waiting)
    }

    /// Index of the command that was last seen finished.
    #[must_use]
    pub fn current(&self) -> u64 {
        self.0.reader.current
    }
}

impl Leftover {
    /// Declares that the queue was stopped and cleared after the stream ended, because a laser may
    /// have been burning. [`Stream::resume`] then begins with the first command that the arm had
    /// not finished.
    #[must_use]
    pub fn cleared(mut self) -> Self {
        self.0.cleared = self.has_begun();
        self
    }
}

impl Stream {
    /// Ends the stream and returns the commands not known to be finished and confirmed.
    /// Commands that the connection has not ended yet are in doubt; the resumed stream takes their
    /// answers.
    #[must_use]
    pub fn leftover(mut self) -> Leftover {
        if self.phase != Phase::Ended {
            self.note_interruption();
        }
        Leftover(self)
    }

    /// Continues where another stream ended, on the same arm.
    ///
    /// The new stream first finds out the fate of what was sent and waits until the arm has
    /// finished what it had. The arm must then be at the end of its last finished command, within
    /// 0.5 mm and degrees; the first command that was not taken is sent next. If the readings do
    /// not add up, the stream ends with a reason and sends nothing. It does not look at alarms.
    /// More commands may be offered if the interrupted stream was not declared finished.
    #[must_use]
    pub fn resume(leftover: Leftover, settings: StreamSettings) -> Self {
        let begun = leftover.has_begun();
        let Leftover(mut stream) = leftover;
        stream.settings = StreamSettings {
            window: settings.window.max(1),
            ..settings
        };
        stream.window = stream.settings.window;
        stream.reader = if begun {
            Reader::after(stream.reader.current)
        } else {
            Reader::new()
        };
        stream.phase = if begun {
            Phase::Resolve(None)
        } else {
            Phase::Begin
        };
        stream.reader.look_closely(ArmInstant::ZERO, true);
        (stream.control, stream.retry_at, stream.gathering_since) = (None, None, None);
        (
            stream.gap,
            stream.finished_reported,
            stream.is_dry,
            stream.credit.full,
        ) = (false, false, false, false);
        stream
    }

    /// Remembers the phase in which the stream ends, which decides how it is resumed.
    pub(super) fn note_interruption(&mut self) {
        self.phase_at_end = match self.phase {
            // The fate of the commands of an earlier phase is still unknown, so that phase counts.
            Phase::Resolve(_) | Phase::Ended => self.phase_at_end,
            _ if self.gap => Phase::Settle,
            phase => phase,
        };
    }

    /// Evaluates a reading while the fate of what was sent is found out.
    pub(super) fn resolve(&mut self, now: ArmInstant, before: Option<QueueSnapshot>) {
        let glance = self.reader.snapshot(now);
        let QueueSnapshot { current, left, .. } = glance;
        self.phase = Phase::Resolve(Some(glance));
        let stands = self.stands(now, before);
        // An arm in a WAIT stands still as well: keep reading until everything is accounted for.
        self.look_again(now);
        if !stands {
            return;
        }
        self.credit.places = self.credit.places.max(left);
        if self.cleared {
            return self.resume_cleared(current);
        }
        if self.must_recover() {
            self.go_back()
        } else {
            self.account_by_tail(current, left)
        }
    }

    /// Resumes on a cleared queue with the arm at rest: the current index shows what is done, all
    /// else waits again.
    fn resume_cleared(&mut self, current: u64) {
        let last = self.last.unwrap_or(self.base);
        let gone = self.entries.iter().filter(|entry| !entry.is_waiting());
        let doubtful = gone.filter(|entry| entry.index().is_none()).count() as u64;
        let to = last.saturating_add(doubtful);
        if current > to {
            let found = current;
            return self.fail(StreamFailure::Tail {
                found,
                from: last,
                to,
            });
        }
        let found = if current > last {
            self.mark_taken(last, current)
        } else {
            0
        };
        if self.check_pose(current) {
            (self.cleared, self.confirmed) = (false, Some(current));
            self.release_done();
            self.queue_again();
            self.relight();
            self.report_resumed(found);
        }
    }

    /// True if indices prove nothing because the queue was or may have been cleared.
    fn must_recover(&self) -> bool {
        let recovering = matches!(
            self.phase_at_end,
            Phase::Settle | Phase::Halt | Phase::AwaitStop(_) | Phase::Clear | Phase::Drain { .. }
        );
        recovering || self.gaps > 0 && self.expected.is_none()
    }

    /// Accounts for all commands by the last index given, with the arm at rest.
    fn account_by_tail(&mut self, current: u64, left: u32) {
        let queued = u64::from(self.credit.places.saturating_sub(left));
        // Same rule as in `index_tracker`: after a Clear the base stands in for the current index.
        let tail = current.max(self.base).saturating_add(queued);
        let last = self.last.unwrap_or(self.base);
        let gone = self.entries.iter().filter(|entry| !entry.is_waiting());
        let doubtful = gone.filter(|entry| entry.index().is_none()).count() as u64;
        let unsure = (self.unconfirmed().count() as u64).saturating_sub(doubtful);
        let (from, to) = (last.saturating_sub(unsure), last.saturating_add(doubtful));
        // The first index of an arm is 1 or 2 (model section 14), and none has come yet.
        if self.base == 0 && self.last.is_none() {
            match (current, doubtful) {
                // Assume 1: the reply to the next command corrects it.
                (0, _) => self.guessed = true,
                (_, 1) if tail == 2 => {
                    self.base = 1;
                    return self.account_by_tail(current, left);
                }
                (_, 2..) if self.may_go_back() => return self.go_back(),
                _ => {}
            }
        }
        if !(from..=to).contains(&tail) {
            return self.fail(StreamFailure::Tail {
                found: tail,
                from,
                to,
            });
        }
        let none = unsure == 0 && tail == last;
        if tail != to && !none {
            // A command may be missing in the middle.
            return if self.may_go_back() {
                self.go_back()
            } else {
                let confirmed = self.confirmed;
                self.fail(StreamFailure::Unclear {
                    confirmed,
                    found: tail,
                });
            };
        }
        let found = self.mark_taken(last, tail);
        if current >= tail {
            return self.resume_finished(found);
        }
        let loading = matches!(
            self.phase_at_end,
            Phase::Load | Phase::AwaitRest(_) | Phase::Start
        );
        if loading && self.check_pose(current) {
            // The arm stands although commands wait: the queue was not started yet.
            self.phase = Phase::Load;
            self.report_resumed(found);
        }
    }

    /// Marks all commands up to `tail` as taken and all others as not. Returns how many had been in
    /// doubt.
    fn mark_taken(&mut self, last: u64, tail: u64) -> usize {
        let mut next = last.saturating_add(1);
        let mut found = 0;
        let Self {
            group,
            accepted,
            first,
            last,
            ..
        } = self;
        self.entries.change(0..usize::MAX, |entry| {
            if entry.is_waiting() || entry.index().is_some() {
                return;
            }
            if next > tail {
                entry.fate = Fate::Waiting;
                if let Some(group) = group {
                    *group += 1;
                }
                return;
            }
            entry.fate = Fate::Accepted(next);
            *accepted += u64::from(!entry.inserted);
            (*first, *last) = (first.or(Some(next)), Some(next));
            next = next.saturating_add(1);
            found += 1;
        });
        (self.confirmed, self.expected) = (Some(tail), tail.checked_add(1));
        self.found += found;
        self.found
    }

    /// Continues with an arm that has finished all it had.
    fn resume_finished(&mut self, found: usize) {
        if self.check_pose(u64::MAX) {
            (self.credit.foreign, self.stopped, self.group) = (0, false, None);
            self.phase = if self.settings.start {
                Phase::Choose
            } else {
                Phase::Run
            };
            self.report_resumed(found);
        }
    }

    /// Begins a recovery, which clears the queue and continues from the vertex at which the arm
    /// stands. Fails the stream if an unconfirmed command must not be repeated.
    fn go_back(&mut self) {
        if !self.may_go_back() {
            let (confirmed, found) = (self.confirmed, self.reader.current);
            return self.fail(StreamFailure::Unclear { confirmed, found });
        }
        if self.check_poses() {
            // The queue is cleared in any case, so late replies do not matter.
            self.entries.change(0..usize::MAX, |entry| {
                if entry.is_in_flight() {
                    entry.fate = Fate::Doubtful;
                }
            });
            self.report_resumed(0);
            // A start that was under way may have got through.
            self.stopped &= self.phase_at_end == Phase::Load;
            self.begin_recovery();
        }
    }

    fn report_resumed(&mut self, found: usize) {
        let waiting = self.entries.waiting();
        self.found = 0;
        self.events.push(StreamEvent::Resumed { found, waiting });
        // The commands found may have been the last.
        self.report_progress();
    }

    /// Pose of the arm after the command with this index. `None` if unknown.
    fn pose_after(&self, index: u64) -> Option<[f64; 4]> {
        let done = |entry: &&Entry| entry.index().is_some_and(|at| at <= index);
        match self.entries.iter().rev().find(done) {
            Some(entry) => entry.item.end,
            None => self.last_pose,
        }
    }

    /// True if the arm is at the end of the command with this index. Otherwise ends the stream.
    fn check_pose(&mut self, index: u64) -> bool {
        let expected = self.pose_after(index);
        self.stands_at(expected, [])
    }

    /// Does the same as [`check_pose`](Self::check_pose) if it is uncertain which commands were
    /// executed: the arm must be at the end of one of them.
    fn check_poses(&mut self) -> bool {
        let certain = self.reader.current.min(self.confirmed.unwrap_or(self.base));
        // Copied to the stack, because `stands_at` may fail the stream.
        let ends: [_; MAX_KEPT] = {
            let mut unconfirmed = self.unconfirmed().map(|entry| entry.item.end);
            std::array::from_fn(|_| unconfirmed.next())
        };
        let expected = self.pose_after(certain);
        self.stands_at(expected, ends)
    }

    fn stands_at<const N: usize>(
        &mut self,
        expected: Option<[f64; 4]>,
        others: [Option<Option<[f64; 4]>>; N],
    ) -> bool {
        let found = self.reader.pose;
        let places = || std::iter::once(expected).chain(others.into_iter().flatten());
        if places().flatten().any(|place| is_at(place, found)) {
            return true;
        }
        match expected {
            Some(expected) if places().all(|place| place.is_some()) => {
                self.fail(StreamFailure::Pose { expected, found });
                false
            }
            // The caller has looked at the arm.
            _ if self.settings.trust_pose => true,
            _ => {
                self.fail(StreamFailure::PoseUnknown { found });
                false
            }
        }
    }
}

fn is_at(place: [f64; 4], found: [f64; 4]) -> bool {
    let mut both = place.iter().zip(&found);
    both.all(|(place, found)| (place - found).abs() <= POSE_TOLERANCE)
}

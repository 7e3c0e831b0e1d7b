use magician_protocol::ArmInstant;

use super::drive::Phase;
use super::item::{Entry, Fate, Item};
use super::reading::Reader;
use super::{KEPT, Stream, StreamEvent, StreamFailure, StreamSettings};
use crate::connection::Micros;

/// How far from where it should stand an arm may be found, in mm for x, y, z and degrees for r.
pub(crate) const POSE_TOLERANCE: f64 = 0.5;

/// Pause between looks at an arm that moves.
pub(super) const MOVING_PAUSE: Micros = 50_000;

/// Queue and pose as one look has read them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QueueSnapshot {
    /// When the look ended.
    pub(super) at: ArmInstant,
    pub(super) current: u64,
    pub(super) left: u32,
    pub(super) pose: [f64; 4],
}

impl QueueSnapshot {
    /// True if the other look has read the same.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let read = |look: &Self| (look.current, look.left, look.pose);
        read(self) == read(other)
    }
}

/// What an ended stream has not seen finished, and what is known of it.
#[derive(Debug)]
pub struct Leftover(Stream);

impl Leftover {
    /// The commands that are not known to be finished and confirmed, in order, with the indices of those that are known
    /// to have been taken. A few that the stream put in by itself between two chunks of the laser are among them.
    pub fn items(&self) -> impl Iterator<Item = (Option<u64>, &Item)> {
        (self.0.entries.iter()).map(|entry| (entry.index(), &entry.item))
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.entries.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.entries.is_empty()
    }

    /// Whether anything of it may have gone to the arm.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.0.first.is_some() || !self.0.entries.iter().all(Entry::is_waiting)
    }

    /// Index of the command that was seen finished last.
    #[must_use]
    pub fn current(&self) -> u64 {
        self.0.reader.current
    }
}

impl Leftover {
    /// The queue was stopped and cleared since, on a line on which a laser may have burnt: what the arm had not finished is
    /// not done, and [`Stream::resume`] begins with it.
    #[must_use]
    pub fn cleared(mut self) -> Self {
        self.0.cleared = self.has_begun();
        self
    }
}

impl Stream {
    /// What is not known to be finished and confirmed. Commands that the connection has not ended yet are in doubt; the
    /// stream that goes on with them takes their answers.
    #[must_use]
    pub fn leftover(mut self) -> Leftover {
        if self.phase != Phase::Over {
            self.note_interruption();
        }
        Leftover(self)
    }

    /// Goes on where another stream ended, on the same arm. It first finds out what became of what that one sent, and
    /// waits until the arm has finished what it had; then the arm must stand where its last finished command leaves it,
    /// within 0.5 mm and degrees, and the first command that was not taken is the next to go. What does not add up ends the
    /// stream with a reason, and nothing is sent. Alarms are not its business. More may be offered if the interrupted stream
    /// had not been told that no more comes.
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
        (stream.control, stream.retry_at, stream.gathers) = (None, None, None);
        (stream.gap, stream.told, stream.dry, stream.credit.full) = (false, false, false, false);
        stream
    }

    /// The stream ends: what it was about decides how it is resumed.
    pub(super) fn note_interruption(&mut self) {
        self.was = match self.phase {
            // It had not found out.
            Phase::Resolve(_) | Phase::Over => self.was,
            _ if self.gap => Phase::Settle,
            phase => phase,
        };
    }

    /// A look while it is found out what became of what was sent.
    pub(super) fn resolve(&mut self, now: ArmInstant, before: Option<QueueSnapshot>) {
        let glance = self.reader.snapshot(now);
        let QueueSnapshot { current, left, .. } = glance;
        self.phase = Phase::Resolve(Some(glance));
        let stands = self.stands(now, before);
        // An arm in a WAIT stands as well: the looks go on until all is accounted for.
        self.look_again(now);
        if !stands {
            return;
        }
        self.credit.places = self.credit.places.max(left);
        if self.cleared {
            return self.take_up(current);
        }
        if self.must_recover() {
            self.go_back()
        } else {
            self.account(current, left)
        }
    }

    /// The queue was cleared, and the arm stands: the current index tells what is done, and all else waits again.
    fn take_up(&mut self, current: u64) {
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
            self.adopt(last, current)
        } else {
            0
        };
        if self.check_pose(current) {
            (self.cleared, self.confirmed) = (false, Some(current));
            self.let_go_of_done();
            self.queue_again();
            self.relight();
            self.tell_resumed(found);
        }
    }

    /// Whether indices say nothing because the queue was or may have been cleared.
    fn must_recover(&self) -> bool {
        let recovering = matches!(
            self.was,
            Phase::Settle | Phase::Halt | Phase::Brake(_) | Phase::Clear | Phase::Drain { .. }
        );
        recovering || self.gaps > 0 && self.expected.is_none()
    }

    /// The arm stands still: accounts for everything by the last index it gave.
    fn account(&mut self, current: u64, left: u32) {
        let queued = u64::from(self.credit.places.saturating_sub(left));
        let tail = current.max(self.base).saturating_add(queued);
        let last = self.last.unwrap_or(self.base);
        let gone = self.entries.iter().filter(|entry| !entry.is_waiting());
        let doubtful = gone.filter(|entry| entry.index().is_none()).count() as u64;
        let unsure = (self.unconfirmed().count() as u64).saturating_sub(doubtful);
        let (from, to) = (last.saturating_sub(unsure), last.saturating_add(doubtful));
        // The first index that an arm gives is 1 or 2 (model section 14); none has come yet.
        if self.base == 0 && self.last.is_none() {
            match (current, doubtful) {
                // As if it were 1: the answer to the next command corrects it.
                (0, _) => self.guessed = true,
                (_, 1) if tail == 2 => {
                    self.base = 1;
                    return self.account(current, left);
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
            // Something may be missing in the middle.
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
        let found = self.adopt(last, tail);
        if current >= tail {
            return self.go_on(found);
        }
        let loading = matches!(self.was, Phase::Load | Phase::Stand(_) | Phase::Start);
        if loading && self.check_pose(current) {
            // It stands although commands wait: the queue was not started yet.
            self.phase = Phase::Load;
            self.tell_resumed(found);
        }
    }

    /// All up to `tail` was taken, and nothing else; returns how many of these had been in doubt.
    fn adopt(&mut self, last: u64, tail: u64) -> usize {
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

    /// The arm has finished all it had.
    fn go_on(&mut self, found: usize) {
        if self.check_pose(u64::MAX) {
            (self.credit.strangers, self.stopped, self.group) = (0, false, None);
            self.phase = if self.settings.start {
                Phase::Choose
            } else {
                Phase::Run
            };
            self.tell_resumed(found);
        }
    }

    /// What is not certain may all be done once more: clears the queue and goes back to the last certain vertex.
    fn go_back(&mut self) {
        if !self.may_go_back() {
            let (confirmed, found) = (self.confirmed, self.reader.current);
            return self.fail(StreamFailure::Unclear { confirmed, found });
        }
        if self.check_poses() {
            // The queue is cleared in any case.
            self.entries.change(0..usize::MAX, |entry| {
                if entry.is_flying() {
                    entry.fate = Fate::Doubtful;
                }
            });
            self.tell_resumed(0);
            // A start that was under way may have got through.
            self.stopped &= self.was == Phase::Load;
            self.begin_recovery();
        }
    }

    fn tell_resumed(&mut self, found: usize) {
        let waiting = self.entries.waiting();
        self.found = 0;
        self.events.push(StreamEvent::Resumed { found, waiting });
        // Those that were found may have been the last.
        self.tell_progress();
    }

    /// Where the arm stands after the command of this index, when that is known.
    fn pose_after(&self, index: u64) -> Option<[f64; 4]> {
        let done = |entry: &&Entry| entry.index().is_some_and(|at| at <= index);
        match self.entries.iter().rev().find(done) {
            Some(entry) => entry.item.end,
            None => self.stood,
        }
    }

    /// Whether the arm stands where it should after the command of this index. Ends the stream if not.
    fn check_pose(&mut self, index: u64) -> bool {
        let expected = self.pose_after(index);
        self.stands_at(expected, [])
    }

    /// As [`check_pose`](Self::check_pose) where it is not certain which commands were carried out: the arm stands where one
    /// of those leaves it.
    fn check_poses(&mut self) -> bool {
        let certain = self.reader.current.min(self.confirmed.unwrap_or(self.base));
        let ends: [_; KEPT] = {
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

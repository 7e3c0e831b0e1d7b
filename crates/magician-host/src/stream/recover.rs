//! Recovery after a loss between others: stop, clear, and continue from the vertex at which the arm
//! stands.

use magician_protocol::ArmInstant;

use super::drive::Phase;
use super::item::{Entry, Fate};
use super::line::distance;
use super::{POSE_TOLERANCE, Stream, StreamEvent, StreamFailure};
use crate::connection::Micros;

/// Losses after which the rest is sent one at a time.
// A choice: such a line is too bad for a window.
pub(super) const MAX_GAPS: usize = 3;
/// Interval between readings of a draining queue, us.
const DRAIN_POLL_INTERVAL: Micros = 20_000;
/// Time after its expected end at which an unfinished command shows that the queue does not run,
/// us.
// A choice: above the error of calculated times, so that a late command is not taken for a stopped
// queue.
const OVERDUE_AFTER: Micros = 2_000_000;
/// Time after which a cleared queue with constant left space counts as stuck, us.
// A choice: longer than any usual motion.
const STUCK_AFTER: Micros = 30_000_000;

/// Recovery after a loss between others.
impl Stream {
    pub(super) fn begin_recovery(&mut self) {
        self.phase = Phase::Settle;
        (self.group, self.control) = (None, None);
    }

    /// Waits for the other replies, and for a WAIT or TRIG that a stop would cut short.
    pub(super) fn settle(&mut self, now: ArmInstant) {
        if self.flying() > 0 {
            return;
        }
        let confirmed = self.confirmed;
        let certain = |entry: &&Entry| entry.index() <= confirmed;
        let waits = self.unfinished().filter(certain).any(Entry::is_cut_by_stop);
        // A queue that does not run would never finish them.
        if waits && !self.stopped && self.may_run(now) {
            self.pace(now);
            return;
        }
        self.gap = false;
        self.phase = Phase::Halt;
    }

    /// True if the queue may be running: its first command is not overdue by [`OVERDUE_AFTER`].
    fn may_run(&self, now: ArmInstant) -> bool {
        let head = self.unfinished().next().map_or(0, |head| head.item.time);
        let ends = self.reader.begun().after_micros(head);
        now < ends.after_micros(OVERDUE_AFTER)
    }

    /// Evaluates a reading of the cleared queue. Left space was read first, so the current index is
    /// that of an empty queue.
    pub(super) fn drained(&mut self, now: ArmInstant, since: ArmInstant, before: u32) {
        let (left, places) = (self.reader.left, self.credit.places);
        if left >= places {
            return self.restart();
        }
        let since = if left == before { since } else { now };
        if now.micros_since(since) >= STUCK_AFTER {
            return self.fail(StreamFailure::NotDrained { left, places });
        }
        self.phase = Phase::Drain { since, left };
        self.reader
            .look_closely(now.after_micros(DRAIN_POLL_INTERVAL), true);
    }

    /// Restarts from the stopped, empty queue and the arm at rest: commands up to its position are
    /// done, all others wait again.
    fn restart(&mut self) {
        self.release_done();
        let Some(passed) = self.passed_commands() else {
            return;
        };
        for _ in 0..passed {
            let counted = |entry: &Entry| entry.index().is_none() && !entry.inserted;
            self.accepted += u64::from(self.entries.front().is_some_and(counted));
            self.release_first();
        }
        self.queue_again();
    }

    /// Releases commands that are finished and confirmed.
    pub(super) fn release_done(&mut self) {
        let (current, confirmed) = (self.reader.current, self.confirmed);
        let done = |index: u64| index <= current && confirmed.is_some_and(|all| index <= all);
        while self
            .entries
            .front()
            .is_some_and(|entry| entry.index().is_some_and(done))
        {
            self.release_first();
        }
    }

    /// Makes all commands that were sent and not done wait again, because the queue is empty.
    pub(super) fn queue_again(&mut self) {
        let mut again = 0;
        let accepted = &mut self.accepted;
        self.entries.change(0..usize::MAX, |entry| {
            let counted = entry.index().is_some() && !entry.inserted;
            *accepted = accepted.saturating_sub(counted.into());
            again += usize::from(!entry.is_waiting());
            entry.fate = Fate::Waiting;
        });
        self.gaps += 1;
        // A window of one is slow but loses nothing between others.
        if self.gaps >= MAX_GAPS {
            self.window = 1;
        }
        // The numbers of dropped commands are skipped.
        (self.expected, self.confirmed) = (None, None);
        (self.credit.foreign, self.stopped) = (0, true);
        self.cleared_at = self.reader.current;
        self.phase = Phase::Choose;
        let window = self.window;
        self.events.push(StreamEvent::Recovered { again, window });
    }

    /// Number of unconfirmed commands up to the arm's position. If the arm stands at the end of
    /// none of them, fails the stream and returns `None`. Lost ones in between make no difference:
    /// see `keeps_line`.
    fn passed_commands(&mut self) -> Option<usize> {
        let current = self.reader.current;
        let [x, y, z, _] = self.reader.pose;
        let found = [x, y, z];
        let gone = self.entries.kept();
        // At least this many were executed: each has advanced the current index by one.
        let least = match self.confirmed {
            Some(confirmed) => current.saturating_sub(confirmed),
            None => u64::from(current > self.cleared_at),
        };
        let certain = |entry: &Entry| entry.index().is_some_and(|at| Some(at) <= self.confirmed);
        // No unconfirmed command was executed, so the arm must stand where the confirmed ones left
        // it.
        if least == 0 || self.entries.front().is_some_and(certain) {
            let stands = self.last_position.is_none_or(|place| is_near(place, found));
            return if stands {
                Some(0)
            } else {
                self.fail_position(self.last_pose)
            };
        }
        let least = usize::try_from(least).unwrap_or(usize::MAX);
        if least > gone {
            let (from, to) = (self.confirmed.unwrap_or(self.cleared_at), current);
            let to_most = from.saturating_add(gone as u64);
            self.fail(StreamFailure::Tail {
                found: to,
                from,
                to: to_most,
            });
            return None;
        }
        let places = self.entries.iter().enumerate();
        let places = places.filter(|(_, entry)| !entry.is_waiting());
        let places = places
            .skip(least - 1)
            .filter_map(|(nth, entry)| Some((nth + 1, entry.place()?)));
        let near = places.map(|(count, place)| (count, distance(place, found)));
        // A closed figure passes one position several times: the closest end decides.
        let nearest = near.min_by(|(_, one), (_, other)| one.total_cmp(other));
        match nearest.filter(|(_, off)| *off <= POSE_TOLERANCE) {
            Some((count, _)) => Some(count),
            None => {
                let expected = self.entries.get(least - 1).and_then(|entry| entry.item.end);
                self.fail_position(expected)
            }
        }
    }

    /// Fails the stream, because the arm stands where no command sent leaves it.
    fn fail_position(&mut self, expected: Option<[f64; 4]>) -> Option<usize> {
        let found = self.reader.pose;
        self.fail(match expected {
            Some(expected) => StreamFailure::Pose { expected, found },
            None => StreamFailure::PoseUnknown { found },
        });
        None
    }
}

fn is_near(place: [f64; 3], found: [f64; 3]) -> bool {
    distance(place, found) <= POSE_TOLERANCE
}

//! State of the controller's queue, derived from the indices of errata E37.

use super::Micros;
use super::law::QueueReading;

/// Time after which a queue that stays as empty as it was ever seen counts as drained.
// A choice: if another host's command runs longer, readings are inconclusive, but commands flow
// again.
const DRAINED_AFTER: Micros = 1_000_000;
/// Equal readings needed on an unordered link, where a single one may be old.
const REQUIRED_EQUAL_READINGS: u32 = 2;

/// Tracks the controller's queue by the indices it gave (errata E37): +1 for every accepted
/// command, never reset by a Clear.
///
/// The commands in the queue are the last ones accepted, so the last index given is
/// `head + capacity - left space`, where `head` is the index before the oldest command in the
/// queue. `head` is the current index, except after a Clear: then the current index stays behind
/// the dropped numbers until a later command finishes, and `head` is the last index given before
/// the Clear. That number, the `floor`, becomes known in two ways: the queue was once seen empty
/// (the floor is then the last index given), or the current index has reached a command accepted
/// since the floor was lost.
///
/// Before the first reply no given index is known. But an arm seen at rest (queue empty, then its
/// current index read) has a `rest` index to compare with: an accepted command makes the queue
/// longer or, once finished, the current index higher, and nothing else does. Only the number is
/// uncertain in this case: a Clear of an earlier connection may have dropped commands, so the
/// derived index may be too low until the next reply gives the true one.
#[derive(Clone, Debug)]
pub(super) struct IndexTracker {
    capacity: u32,
    /// True if `capacity` was read from an empty queue. Until then no conclusions are drawn: a
    /// place too many or too few would turn lost into taken.
    capacity_is_known: bool,
    /// True if the controller reported more places than assumed.
    capacity_grew: bool,
    /// Largest left space seen.
    max_left_space: u32,
    /// Index accepted last.
    last: Option<u64>,
    /// Index in the last reply, accepted or not. A link may duplicate that reply and delay the
    /// copy.
    heard: Option<u64>,
    /// Ordinal, among the queued commands sent, of the one with index `last`.
    order: u64,
    /// All indices up to here are certain. Below `last` only while several commands are in flight.
    confirmed: Option<u64>,
    floor: Floor,
    /// First known value of the floor since it was lost, whatever the left space said later.
    /// Readings of the left space are checked against it.
    base: Floor,
    /// Current index read last.
    current: u64,
    /// True if the last reading of the current index was lower, which is not confirmed yet.
    suspect: bool,
    /// Left space that stays constant while the queue drains, and since when.
    stands: Option<(u32, Micros)>,
    /// True if a Clear was sent and the queue was not seen empty since.
    draining: bool,
    /// Number of Clears sent.
    clears: u32,
    /// True if the queue was seen empty and nothing was sent since.
    seen_empty: bool,
    /// Current index read since the queue was seen empty, and the number of equal readings.
    rest_candidate: Option<(u64, u32)>,
    /// Current index of the arm at rest, while nothing is accepted.
    rest: Option<u64>,
    /// True if `last` was derived from `rest`.
    guessed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    /// Unknown.
    Unknown,
    /// The queue was empty before the first accepted index.
    Empty,
    /// The first index accepted since the floor was lost.
    Since(u64),
    Known(u64),
}

impl Floor {
    /// Floor after `index` was accepted.
    fn before(self, index: u64) -> Self {
        match self {
            Self::Unknown => Self::Since(index),
            Self::Empty => Self::Known(index.saturating_sub(1)),
            known => known,
        }
    }

    /// Floor raised by `more`, by which the estimated index was too low.
    fn plus(self, more: u64) -> Self {
        match self {
            Self::Known(floor) => Self::Known(floor.saturating_add(more)),
            Self::Since(first) => Self::Since(first.saturating_add(more)),
            other => other,
        }
    }

    /// Index before the oldest command in the queue, given the current index. `None` if unknown.
    fn head(self, current: u64) -> Option<u64> {
        match self {
            Self::Known(floor) => Some(current.max(floor)),
            Self::Since(first) if current >= first => Some(current),
            _ => None,
        }
    }
}

/// Conclusion about a command in doubt from two equal readings of current index and left space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The controller has not taken it.
    NotTaken,
    /// The controller has taken it, with this index.
    Taken(u64),
    /// The readings do not decide.
    Unclear,
}

impl IndexTracker {
    pub(super) fn new(capacity: u32) -> Self {
        Self {
            capacity,
            capacity_is_known: false,
            capacity_grew: false,
            max_left_space: 0,
            last: None,
            heard: None,
            order: 0,
            confirmed: None,
            floor: Floor::Unknown,
            base: Floor::Unknown,
            current: 0,
            suspect: false,
            stands: None,
            draining: false,
            clears: 0,
            seen_empty: false,
            rest_candidate: None,
            rest: None,
            guessed: false,
        }
    }

    pub(super) fn last(&self) -> Option<u64> {
        self.last
    }

    pub(super) fn confirmed(&self) -> Option<u64> {
        self.confirmed
    }

    pub(super) fn capacity(&self) -> u32 {
        self.capacity
    }

    pub(super) fn draining(&self) -> bool {
        self.draining
    }

    pub(super) fn clears(&self) -> u32 {
        self.clears
    }

    /// True if the last accepted index may be too low.
    pub(super) fn is_guess(&self) -> bool {
        self.guessed
    }

    /// True if `index` follows the last accepted one. With no previous index any index is valid,
    /// except a repeat of the last reply.
    pub(super) fn follows(&self, index: u64) -> bool {
        match self.last {
            // The guess may be too low by the number of commands that a Clear dropped.
            Some(last) if self.guessed => index > last,
            Some(last) => last.checked_add(1) == Some(index),
            None => self.heard != Some(index),
        }
    }

    /// Notes the index of a reply that was not believed.
    pub(super) fn disbelieve(&mut self, index: u64) {
        self.heard = Some(index);
    }

    /// True if the queue may have given `index` after the last accepted one.
    pub(super) fn is_beyond(&self, index: u64) -> bool {
        // If the last index is a guess, finished commands may have other numbers.
        if self.guessed && self.floor.head(self.current) == Some(self.current) {
            return false;
        }
        let ahead = self.last.and_then(|last| index.checked_sub(last));
        // Twice the capacity: farther ahead it is a different count rather than a few extra
        // commands.
        ahead.is_some_and(|ahead| ahead > 0 && ahead <= 2 * u64::from(self.capacity))
    }

    /// True if the controller gave `index` beyond the last accepted one, or beyond that of the arm
    /// at rest.
    pub(super) fn is_surplus(&self, index: u64) -> bool {
        match (self.last, self.rest) {
            (None, Some(rest)) => index > rest,
            _ => self.is_beyond(index),
        }
    }

    /// Index that the next accepted command gets. `None` if the last index is unknown.
    pub(super) fn next(&self) -> Option<u64> {
        let last = self.last.or(self.rest);
        last.map(|last| last.saturating_add(1))
    }

    /// Notes that the `order`th command sent was accepted with `index`.
    pub(super) fn accept(&mut self, index: u64, order: u64) {
        self.order = order;
        if let (true, Some(last)) = (self.guessed, self.last) {
            let more = index.saturating_sub(last.saturating_add(1));
            (self.floor, self.base) = (self.floor.plus(more), self.base.plus(more));
        }
        self.floor = self.floor.before(index);
        self.base = self.base.before(index);
        (self.last, self.heard) = (Some(index), Some(index));
        (self.rest, self.guessed) = (None, false);
    }

    /// Notes that the `order`th command sent turned out to be accepted. True if its index is
    /// certain.
    pub(super) fn accept_recovered(&mut self, index: u64, order: u64) -> bool {
        let guessed = self.guessed || self.last.is_none();
        self.accept(index, order);
        self.guessed = guessed;
        !guessed
    }

    /// Notes that a queued command is sent.
    pub(super) fn note_queued_sent(&mut self) {
        (self.seen_empty, self.rest_candidate) = (false, None);
    }

    /// True if all accepted commands are certain.
    pub(super) fn is_confirmed(&self) -> bool {
        self.confirmed == self.last
    }

    /// Marks all accepted commands as certain, because no command is unanswered.
    pub(super) fn confirm(&mut self) {
        self.confirmed = self.last;
    }

    /// Marks the first `order` commands sent as certain, because none of them is unanswered.
    ///
    /// Without a gap, commands get consecutive indices in the order of sending. If one of them was
    /// sent twice, the confirmed index is too low, which is safe.
    pub(super) fn confirm_to(&mut self, order: u64) {
        let behind = self.order.saturating_sub(order);
        let known = self.last.and_then(|last| last.checked_sub(behind));
        self.confirmed = self.confirmed.max(known);
    }

    /// Interval of indices that may belong to `unanswered` commands in flight and to accepted
    /// commands that are not confirmed yet.
    pub(super) fn doubt(&self, unanswered: u64) -> (Option<u64>, Option<u64>) {
        let from = self.confirmed.or(self.rest);
        let from = from.map(|index| index.saturating_add(1));
        let to = self.last.or(self.rest);
        let to = to.map(|index| index.saturating_add(unanswered));
        (from, to)
    }

    /// Discards the indices; the next accepted one starts a new count.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.confirmed = None;
        self.floor = Floor::Unknown;
        self.base = Floor::Unknown;
        self.forget_rest();
    }

    /// Notes that the arm may no longer be at rest.
    fn forget_rest(&mut self) {
        self.note_queued_sent();
        (self.rest, self.guessed) = (None, false);
    }

    /// Like [`forget`](Self::forget), and accepts any next index, because no earlier reply can
    /// arrive any more.
    pub(super) fn begin_anew(&mut self) {
        self.forget();
        self.heard = None;
    }

    /// Notes that a Clear is sent.
    pub(super) fn clearing(&mut self) {
        self.draining = true;
        self.stands = None;
        self.clears = self.clears.wrapping_add(1);
        self.floor = Floor::Unknown;
        self.base = Floor::Unknown;
        self.note_queued_sent();
        self.rest = None;
    }

    /// Notes a reset of the controller, whose current index is `current` now.
    pub(super) fn restart(&mut self, current: u64) {
        self.forget();
        (self.current, self.suspect) = (current, false);
    }

    /// Processes a reading of the current index. True if it shows a reset of the controller.
    ///
    /// On an unordered link a single lower reading may be old; only a second one proves a reset.
    pub(super) fn read_current(&mut self, current: u64, ordered: bool) -> bool {
        // The index only grows, except at a reset.
        let lower = current < self.current;
        let reset = lower && (ordered || self.suspect);
        self.suspect = lower && !reset;
        if !lower {
            self.current = current;
            self.rests_at(current, ordered);
        }
        reset
    }

    /// Processes a reading of the current index that may be that of an arm at rest.
    fn rests_at(&mut self, current: u64, ordered: bool) {
        if !self.seen_empty || self.last.is_some() {
            return;
        }
        let times = match self.rest_candidate {
            Some((stood, times)) if stood == current => times + 1,
            _ => 1,
        };
        self.rest_candidate = Some((current, times));
        if ordered || times >= REQUIRED_EQUAL_READINGS {
            self.rest = Some(current);
        }
    }

    /// Lowest possible head of the queue, given this current index and the first known floor.
    pub(super) fn reached(&self, current: u64) -> Option<u64> {
        self.base.head(current)
    }

    /// Combines a left space with the indices known, to check the law. `None` while too little is
    /// known.
    pub(super) fn look(&self, left: u32) -> Option<QueueReading> {
        if !self.capacity_is_known || self.draining {
            return None;
        }
        Some(QueueReading {
            left,
            waiting: self.capacity.checked_sub(left)?,
            last: self.last?,
            reached: self.reached(self.current)?,
        })
    }

    /// Processes a reading of the left space. `idle` is true if no queued command is unanswered.
    pub(super) fn read_left(&mut self, left: u32, idle: bool, now: Micros) {
        if left > self.capacity {
            // More places than assumed: the reading is not proof that the queue is empty.
            self.capacity = left;
            (self.capacity_grew, self.capacity_is_known) = (true, false);
        }
        // The emptiest state seen, as a fallback for queues with fewer places than assumed.
        self.max_left_space = self.max_left_space.max(left);
        let full = left == self.capacity;
        self.capacity_is_known |= full && (!self.capacity_grew || self.last == Some(self.current));
        if !idle {
            return;
        }
        self.seen_empty = full;
        if !full && self.last.is_none() {
            self.forget_rest();
        }
        if full {
            self.draining = false;
            self.floor = self.last.map_or(Floor::Empty, Floor::Known);
            if self.base == Floor::Unknown {
                self.base = self.floor;
            }
        } else if self.draining && left == self.max_left_space {
            // The queue is as empty as it was ever seen: it has fewer places than assumed, or a
            // long command of another host runs. Nothing is known, but commands may flow again.
            let (_, since) = *(self.stands.get_or_insert((left, now)));
            self.draining = now.saturating_sub(since) < DRAINED_AFTER;
        } else {
            self.stands = None;
        }
    }

    /// Last index given, derived from these readings. `None` if it cannot be.
    pub(super) fn tail(&self, current: u64, left: u32) -> Option<u64> {
        // A full left space proves the capacity at this moment.
        let sure = self.capacity_is_known || left == self.capacity && !self.capacity_grew;
        let head = match (self.last, self.rest) {
            (None, Some(rest)) => Some(rest.max(current)),
            _ => self.floor.head(current),
        };
        let head = head.filter(|_| sure)?;
        let waiting = self.capacity.checked_sub(left)?;
        Some(head.saturating_add(waiting.into()))
    }

    /// Judges the single command in doubt from a pair of readings that was read twice.
    pub(super) fn judge(&self, current: u64, left: u32) -> Verdict {
        let Some(tail) = self.tail(current, left) else {
            return Verdict::Unclear;
        };
        match self.last.or(self.rest) {
            Some(last) if tail == last => Verdict::NotTaken,
            Some(last) if Some(tail) == last.checked_add(1) => Verdict::Taken(tail),
            _ => Verdict::Unclear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_tells_taken_from_lost() {
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(32, true, 0);
        tracker.accept(7, 1);
        assert_eq!(
            tracker.judge(3, 31),
            Verdict::NotTaken,
            "numbers 4 to 6 were dropped unseen"
        );
        assert_eq!(tracker.judge(3, 30), Verdict::Taken(8));
        assert_eq!(tracker.judge(7, 31), Verdict::Taken(8));
        assert_eq!(tracker.judge(3, 29), Verdict::Unclear);
        assert_eq!(tracker.judge(3, 33), Verdict::Unclear);
    }

    #[test]
    fn without_an_empty_queue_the_current_index_must_have_passed_the_first() {
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(30, true, 0);
        tracker.accept(7, 1);
        assert_eq!(tracker.judge(4, 29), Verdict::Unclear);
        assert_eq!(tracker.judge(7, 32), Verdict::NotTaken);
    }

    #[test]
    fn after_a_clear_the_floor_is_the_last_index_before_it() {
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(32, true, 0);
        (1..=5).for_each(|index| tracker.accept(index, index));
        tracker.clearing();
        assert!(tracker.draining());
        assert_eq!(tracker.judge(2, 31), Verdict::Unclear);
        tracker.read_left(31, true, 0);
        assert!(tracker.draining(), "the motion under way has not ended");
        tracker.read_left(32, true, 0);
        assert!(!tracker.draining());
        assert_eq!(tracker.judge(2, 32), Verdict::NotTaken);
        assert_eq!(tracker.judge(2, 31), Verdict::Taken(6));
    }

    #[test]
    fn a_current_index_that_goes_back_is_a_reset() {
        let mut tracker = IndexTracker::new(32);
        assert!(!tracker.read_current(9, true));
        tracker.accept(10, 1);
        assert!(tracker.read_current(0, true));
        tracker.restart(0);
        assert_eq!(tracker.last(), None);
    }

    #[test]
    fn a_reading_held_up_by_an_unordered_link_is_no_reset() {
        let mut tracker = IndexTracker::new(32);
        assert!(!tracker.read_current(9, false));
        assert!(!tracker.read_current(8, false));
        assert!(!tracker.read_current(10, false));
        assert!(!tracker.read_current(0, false));
        assert!(tracker.read_current(0, false));
    }

    #[test]
    fn nothing_is_concluded_from_a_queue_of_unknown_depth() {
        // 31 places instead of 32: an occupied place cannot be told from a missing one.
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(31, true, 0);
        tracker.accept(1, 1);
        assert_eq!(tracker.judge(1, 31), Verdict::Unclear, "nothing waits");
        // 33 places, one of them taken by another host's command when we connected.
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(32, true, 0);
        tracker.accept(8, 1);
        tracker.read_left(33, false, 0);
        assert_eq!(tracker.judge(7, 32), Verdict::Unclear);
        tracker.read_current(8, true);
        tracker.read_left(33, true, 0);
        assert_eq!(tracker.judge(8, 33), Verdict::NotTaken);
        assert_eq!(tracker.judge(8, 32), Verdict::Taken(9));
    }

    #[test]
    fn a_queue_with_fewer_places_than_assumed_drains_too() {
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(30, true, 0);
        tracker.accept(1, 1);
        tracker.clearing();
        tracker.read_left(29, true, 10);
        tracker.read_left(30, true, 20);
        assert!(tracker.draining());
        tracker.read_left(30, true, 20 + DRAINED_AFTER);
        assert!(!tracker.draining());
        assert_eq!(tracker.judge(1, 30), Verdict::Unclear);
    }
}

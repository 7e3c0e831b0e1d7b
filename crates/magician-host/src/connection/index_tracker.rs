use super::Micros;
use super::law::QueueReading;

/// A queue that is as empty as it was ever seen for so long counts as drained.
const STANDING: Micros = 1_000_000;
/// On an unordered link one reading may be an old one; two of the same are none.
const LOOKS: u32 = 2;

/// What is known of the controller's queue from the indices it gave (errata E37): +1 for every
/// command it accepts, never reset by a Clear.
///
/// The commands in the queue are the last ones accepted, so the index given last is
/// `head + capacity - left space`, where `head` is the index before the oldest command still in
/// the queue. `head` is the current index, except after a Clear: the current index stands still
/// over the dropped numbers until a later command finishes, and `head` is then the index given
/// last before the Clear. That number, the `floor`, is known in two ways: the queue was once seen
/// empty (then it is the index given last), or the current index has reached a command accepted
/// since the floor was lost.
///
/// Before the first answer no index given is known. But an arm that is seen to rest, its queue empty and then its current
/// index, has a `rest` to compare with: a command that it takes makes the queue longer or, when it has finished, the
/// current index higher, and nothing else does. What is not certain then is the number: a Clear of an earlier connection
/// may have dropped some, so that the one concluded may be too low, until the next answer gives its own.
#[derive(Clone, Debug)]
pub(super) struct IndexTracker {
    capacity: u32,
    /// `capacity` was read from an empty queue. While it is a guess nothing is concluded from it:
    /// one place too many or too few turns lost into taken.
    sure: bool,
    /// The controller has shown more places than were assumed.
    grown: bool,
    /// Most free places seen.
    most: u32,
    /// Index accepted last.
    last: Option<u64>,
    /// Index in the last answer, accepted or not. A link may double that answer and hold it up.
    heard: Option<u64>,
    /// Which of the queued commands sent was given it, counting them.
    order: u64,
    /// All up to here are beyond doubt; below `last` only while several are in flight.
    confirmed: Option<u64>,
    floor: Floor,
    /// The floor as it was known first since it was lost, whatever the left space said later: what the left space itself
    /// is held against.
    base: Floor,
    /// Current index read last.
    current: u64,
    /// A lower one was read last, and not believed yet.
    suspect: bool,
    /// The left space that stands while the queue drains, and since when.
    stands: Option<(u32, Micros)>,
    /// A Clear went out and the queue was not seen empty since.
    draining: bool,
    /// How many Clears went out.
    clears: u32,
    /// The queue was seen empty, and nothing went out since.
    vacant: bool,
    /// The current index read since then, and how often.
    stood: Option<(u64, u32)>,
    /// The current index of the arm at rest, while nothing is accepted.
    rest: Option<u64>,
    /// `last` was concluded from `rest`.
    guessed: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    /// Nothing is known.
    Unknown,
    /// The queue was empty before the first accepted index.
    Empty,
    /// The first index accepted since the floor was lost.
    Since(u64),
    Known(u64),
}

impl Floor {
    /// The floor once this index was accepted.
    fn before(self, index: u64) -> Self {
        match self {
            Self::Unknown => Self::Since(index),
            Self::Empty => Self::Known(index.saturating_sub(1)),
            known => known,
        }
    }

    /// It was told too low by so much.
    fn plus(self, more: u64) -> Self {
        match self {
            Self::Known(floor) => Self::Known(floor.saturating_add(more)),
            Self::Since(first) => Self::Since(first.saturating_add(more)),
            other => other,
        }
    }

    /// The index before the oldest command in the queue, at this current index.
    fn head(self, current: u64) -> Option<u64> {
        match self {
            Self::Known(floor) => Some(current.max(floor)),
            Self::Since(first) if current >= first => Some(current),
            _ => None,
        }
    }
}

/// What two equal readings of current index and left space say about a command in doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The controller has not taken it.
    Lost,
    /// The controller has taken it, with this index.
    Taken(u64),
    /// Neither.
    Unclear,
}

impl IndexTracker {
    pub(super) fn new(capacity: u32) -> Self {
        Self {
            capacity,
            sure: false,
            grown: false,
            most: 0,
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
            vacant: false,
            stood: None,
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

    /// Whether the index accepted last may be too low.
    pub(super) fn is_guess(&self) -> bool {
        self.guessed
    }

    /// Whether `index` follows the one accepted last. Anything follows nothing, but for the last answer come again.
    pub(super) fn follows(&self, index: u64) -> bool {
        match self.last {
            Some(last) if self.guessed => index > last,
            Some(last) => last.checked_add(1) == Some(index),
            None => self.heard != Some(index),
        }
    }

    /// An answer with an index that does not follow was not believed.
    pub(super) fn disbelieve(&mut self, index: u64) {
        self.heard = Some(index);
    }

    /// Whether `index` is one that the queue may have given after the last one accepted.
    pub(super) fn is_beyond(&self, index: u64) -> bool {
        // Where the last one is a guess, the numbers of what has ended are other ones.
        if self.guessed && self.floor.head(self.current) == Some(self.current) {
            return false;
        }
        let ahead = self.last.and_then(|last| index.checked_sub(last));
        ahead.is_some_and(|ahead| ahead > 0 && ahead <= 2 * u64::from(self.capacity))
    }

    /// Whether a queue that was watched since the last one accepted, or since the arm was at rest, has given this index.
    pub(super) fn is_surplus(&self, index: u64) -> bool {
        match (self.last, self.rest) {
            (None, Some(rest)) => index > rest,
            _ => self.is_beyond(index),
        }
    }

    /// The index after the last one accepted, or after the one of an arm at rest.
    pub(super) fn next(&self) -> Option<u64> {
        let last = self.last.or(self.rest);
        last.map(|last| last.saturating_add(1))
    }

    /// A command was accepted, the `order`th that was sent.
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

    /// A command turned out to be accepted, the `order`th that was sent; whether its index is certain.
    pub(super) fn find(&mut self, index: u64, order: u64) -> bool {
        let guessed = self.guessed || self.last.is_none();
        self.accept(index, order);
        self.guessed = guessed;
        !guessed
    }

    /// A queued command goes out.
    pub(super) fn sends(&mut self) {
        (self.vacant, self.stood) = (false, None);
    }

    /// Whether all that was accepted is beyond doubt.
    pub(super) fn is_confirmed(&self) -> bool {
        self.confirmed == self.last
    }

    /// Nothing sent before is unanswered: what was accepted is beyond doubt.
    pub(super) fn confirm(&mut self) {
        self.confirmed = self.last;
    }

    /// None of the first `order` commands sent is unanswered. The indices in a row without a gap are theirs in turn; one
    /// that was sent twice in between makes this err towards less.
    pub(super) fn confirm_to(&mut self, order: u64) {
        let behind = self.order.saturating_sub(order);
        let known = self.last.and_then(|last| last.checked_sub(behind));
        self.confirmed = self.confirmed.max(known);
    }

    /// The indices that `unanswered` commands in flight, and those accepted but not confirmed,
    /// may have been given.
    pub(super) fn doubt(&self, unanswered: u64) -> (Option<u64>, Option<u64>) {
        let from = self.confirmed.or(self.rest);
        let from = from.map(|index| index.saturating_add(1));
        let to = self.last.or(self.rest);
        let to = to.map(|index| index.saturating_add(unanswered));
        (from, to)
    }

    /// The indices are no longer certain; the next accepted one is a new beginning.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.confirmed = None;
        self.floor = Floor::Unknown;
        self.base = Floor::Unknown;
        self.stir();
    }

    /// The arm may not be at rest any more.
    fn stir(&mut self) {
        self.sends();
        (self.rest, self.guessed) = (None, false);
    }

    /// As [`forget`](Self::forget), where no answer from before can come any more either.
    pub(super) fn begin_anew(&mut self) {
        self.forget();
        self.heard = None;
    }

    /// A Clear goes out.
    pub(super) fn clearing(&mut self) {
        self.draining = true;
        self.stands = None;
        self.clears = self.clears.wrapping_add(1);
        self.floor = Floor::Unknown;
        self.base = Floor::Unknown;
        self.sends();
        self.rest = None;
    }

    /// The controller was reset, and its current index is this now.
    pub(super) fn restart(&mut self, current: u64) {
        self.forget();
        (self.current, self.suspect) = (current, false);
    }

    /// A current index was read; true when it shows that the controller was reset. On an unordered
    /// link one lower reading may be an old one that was held up; the next one tells.
    pub(super) fn read_current(&mut self, current: u64, ordered: bool) -> bool {
        let lower = current < self.current;
        let reset = lower && (ordered || self.suspect);
        self.suspect = lower && !reset;
        if !lower {
            self.current = current;
            self.rests_at(current, ordered);
        }
        reset
    }

    /// A current index was read that may be that of an arm at rest.
    fn rests_at(&mut self, current: u64, ordered: bool) {
        if !self.vacant || self.last.is_some() {
            return;
        }
        let times = match self.stood {
            Some((stood, times)) if stood == current => times + 1,
            _ => 1,
        };
        self.stood = Some((current, times));
        if ordered || times >= LOOKS {
            self.rest = Some(current);
        }
    }

    /// Where the oldest command in the queue stands at least, by this current index and the first known floor.
    pub(super) fn reached(&self, current: u64) -> Option<u64> {
        self.base.head(current)
    }

    /// What a left space says about the queue's head, where that can be said.
    pub(super) fn look(&self, left: u32) -> Option<QueueReading> {
        if !self.sure || self.draining {
            return None;
        }
        Some(QueueReading {
            left,
            waiting: self.capacity.checked_sub(left)?,
            last: self.last?,
            reached: self.reached(self.current)?,
        })
    }

    /// A left space was read. `idle`: no queued command is unanswered.
    pub(super) fn read_left(&mut self, left: u32, idle: bool, now: Micros) {
        if left > self.capacity {
            self.capacity = left;
            (self.grown, self.sure) = (true, false);
        }
        self.most = self.most.max(left);
        let full = left == self.capacity;
        self.sure |= full && (!self.grown || self.last == Some(self.current));
        if !idle {
            return;
        }
        self.vacant = full;
        if !full && self.last.is_none() {
            self.stir();
        }
        if full {
            self.draining = false;
            self.floor = self.last.map_or(Floor::Empty, Floor::Known);
            if self.base == Floor::Unknown {
                self.base = self.floor;
            }
        } else if self.draining && left == self.most {
            // As empty as it was ever seen: a queue with fewer places than assumed, or one in which
            // a long command of another host runs. Nothing is known, but it goes on.
            let (_, since) = *(self.stands.get_or_insert((left, now)));
            self.draining = now.saturating_sub(since) < STANDING;
        } else {
            self.stands = None;
        }
    }

    /// The index given last, by these readings.
    pub(super) fn tail(&self, current: u64, left: u32) -> Option<u64> {
        let sure = self.sure || left == self.capacity && !self.grown;
        let head = match (self.last, self.rest) {
            (None, Some(rest)) => Some(rest.max(current)),
            _ => self.floor.head(current),
        };
        let head = head.filter(|_| sure)?;
        let waiting = self.capacity.checked_sub(left)?;
        Some(head.saturating_add(waiting.into()))
    }

    /// Judges the one command in doubt from readings that were equal twice.
    pub(super) fn judge(&self, current: u64, left: u32) -> Verdict {
        let Some(tail) = self.tail(current, left) else {
            return Verdict::Unclear;
        };
        match self.last.or(self.rest) {
            Some(last) if tail == last => Verdict::Lost,
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
            Verdict::Lost,
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
        assert_eq!(tracker.judge(7, 32), Verdict::Lost);
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
        assert_eq!(tracker.judge(2, 32), Verdict::Lost);
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
        // 31 places: never seen to be 32, so one that waits cannot be told from one that does not.
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(31, true, 0);
        tracker.accept(1, 1);
        assert_eq!(tracker.judge(1, 31), Verdict::Unclear, "nothing waits");
        // 33 places, and a stranger's command in one when we came.
        let mut tracker = IndexTracker::new(32);
        tracker.read_left(32, true, 0);
        tracker.accept(8, 1);
        tracker.read_left(33, false, 0);
        assert_eq!(tracker.judge(7, 32), Verdict::Unclear);
        tracker.read_current(8, true);
        tracker.read_left(33, true, 0);
        assert_eq!(tracker.judge(8, 33), Verdict::Lost);
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
        tracker.read_left(30, true, 20 + STANDING);
        assert!(!tracker.draining());
        assert_eq!(tracker.judge(1, 30), Verdict::Unclear);
    }
}

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
#[derive(Clone, Debug)]
pub(super) struct Ledger {
    capacity: u32,
    /// Index accepted last.
    last: Option<u64>,
    /// All up to here are beyond doubt; below `last` only while several are in flight.
    confirmed: Option<u64>,
    floor: Floor,
    /// Highest current index seen.
    current: u64,
    /// A Clear went out and the queue was not seen empty since.
    draining: bool,
    /// How many Clears went out.
    clears: u32,
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

impl Ledger {
    pub(super) fn new(capacity: u32) -> Self {
        Self {
            capacity,
            last: None,
            confirmed: None,
            floor: Floor::Unknown,
            current: 0,
            draining: false,
            clears: 0,
        }
    }

    pub(super) fn last(&self) -> Option<u64> {
        self.last
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

    /// Whether `index` follows the one accepted last; anything follows nothing.
    pub(super) fn follows(&self, index: u64) -> bool {
        self.last
            .is_none_or(|last| last.checked_add(1) == Some(index))
    }

    /// A command was accepted.
    pub(super) fn accept(&mut self, index: u64) {
        self.floor = match self.floor {
            Floor::Unknown => Floor::Since(index),
            Floor::Empty => Floor::Known(index.saturating_sub(1)),
            known => known,
        };
        self.last = Some(index);
    }

    /// Whether all that was accepted is beyond doubt.
    pub(super) fn is_confirmed(&self) -> bool {
        self.confirmed == self.last
    }

    /// Nothing sent before is unanswered: what was accepted is beyond doubt.
    pub(super) fn confirm(&mut self) {
        self.confirmed = self.last;
    }

    /// The indices that `unanswered` commands in flight, and those accepted but not confirmed,
    /// may have been given.
    pub(super) fn doubt(&self, unanswered: u64) -> (Option<u64>, Option<u64>) {
        let from = self.confirmed.map(|index| index.saturating_add(1));
        let to = self.last.map(|index| index.saturating_add(unanswered));
        (from, to)
    }

    /// The indices are no longer certain; the next accepted one is a new beginning.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.confirmed = None;
        self.floor = Floor::Unknown;
    }

    /// A Clear goes out.
    pub(super) fn clearing(&mut self) {
        self.draining = true;
        self.clears = self.clears.wrapping_add(1);
        self.floor = Floor::Unknown;
    }

    /// A current index was read; true when it shows that the controller was reset.
    pub(super) fn read_current(&mut self, current: u64) -> bool {
        let reset = current < self.current;
        self.current = current;
        if reset {
            self.forget();
        }
        reset
    }

    /// A left space was read. `idle`: no queued command is unanswered.
    pub(super) fn read_left(&mut self, left: u32, idle: bool) {
        self.capacity = self.capacity.max(left);
        if left == self.capacity && idle {
            self.draining = false;
            self.floor = self.last.map_or(Floor::Empty, Floor::Known);
        }
    }

    /// Judges the one command in doubt from readings that were equal twice.
    pub(super) fn judge(&self, current: u64, left: u32) -> Verdict {
        let head = match self.floor {
            Floor::Known(floor) => current.max(floor),
            Floor::Since(first) if current >= first => current,
            _ => return Verdict::Unclear,
        };
        let Some(waiting) = self.capacity.checked_sub(left) else {
            return Verdict::Unclear;
        };
        let tail = head.saturating_add(waiting.into());
        match self.last {
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
        let mut ledger = Ledger::new(32);
        ledger.read_left(32, true);
        ledger.accept(7);
        assert_eq!(
            ledger.judge(3, 31),
            Verdict::Lost,
            "numbers 4 to 6 were dropped unseen"
        );
        assert_eq!(ledger.judge(3, 30), Verdict::Taken(8));
        assert_eq!(ledger.judge(7, 31), Verdict::Taken(8));
        assert_eq!(ledger.judge(3, 29), Verdict::Unclear);
        assert_eq!(ledger.judge(3, 33), Verdict::Unclear);
    }

    #[test]
    fn without_an_empty_queue_the_current_index_must_have_passed_the_first() {
        let mut ledger = Ledger::new(32);
        ledger.read_left(30, true);
        ledger.accept(7);
        assert_eq!(ledger.judge(4, 29), Verdict::Unclear);
        assert_eq!(ledger.judge(7, 32), Verdict::Lost);
    }

    #[test]
    fn after_a_clear_the_floor_is_the_last_index_before_it() {
        let mut ledger = Ledger::new(32);
        ledger.read_left(32, true);
        (1..=5).for_each(|index| ledger.accept(index));
        ledger.clearing();
        assert!(ledger.draining());
        assert_eq!(ledger.judge(2, 31), Verdict::Unclear);
        ledger.read_left(31, true);
        assert!(ledger.draining(), "the motion under way has not ended");
        ledger.read_left(32, true);
        assert!(!ledger.draining());
        assert_eq!(ledger.judge(2, 32), Verdict::Lost);
        assert_eq!(ledger.judge(2, 31), Verdict::Taken(6));
    }

    #[test]
    fn a_current_index_that_goes_back_is_a_reset() {
        let mut ledger = Ledger::new(32);
        assert!(!ledger.read_current(9));
        ledger.accept(10);
        assert!(ledger.read_current(0));
        assert_eq!(ledger.last(), None);
    }
}

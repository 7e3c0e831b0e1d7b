use std::collections::VecDeque;
use std::ops::{Deref, Range};

use super::item::{Entry, Fate};
use crate::connection::Micros;

/// The commands in a stream's care, in order, and what is asked of them at each turn, counted as they change: a turn costs
/// the same however many there are.
///
/// What stands behind a mark (the current index, the confirmed one) is counted for the marks [set](Self::mark) last. For others
/// it is counted when it is asked for, so that a mark that was forgotten costs time and nothing else.
#[derive(Debug)]
pub(super) struct Entries {
    list: VecDeque<Entry>,
    tally: Tally,
    /// Current index and confirmed one that are counted for.
    marks: (u64, Option<u64>),
}

/// Commands that the arm has yet to do, or that are on their way to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Load {
    pub(super) count: usize,
    /// Of many that take for ever, too.
    time: u128,
    burning: usize,
}

/// What is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    waiting: usize,
    /// The place of the first that waits, behind the last where none does.
    next: usize,
    flying: Load,
    doubtful: usize,
    /// Accepted, with an index above the current one.
    unfinished: Load,
    /// Accepted, with an index above the confirmed one, or gone and not accepted.
    unconfirmed: usize,
    /// The highest index accepted.
    highest: u64,
}

impl Load {
    fn add(&mut self, entry: &Entry) {
        self.count += 1;
        self.time += u128::from(entry.item.time);
        self.burning += usize::from(entry.burns());
    }

    fn drop(&mut self, entry: &Entry) {
        self.count -= 1;
        self.time -= u128::from(entry.item.time);
        self.burning -= usize::from(entry.burns());
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            time: self.time + other.time,
            burning: self.burning + other.burning,
        }
    }

    /// All of them one after the other.
    pub(super) fn time(&self) -> Micros {
        Micros::try_from(self.time).unwrap_or(Micros::MAX)
    }

    pub(super) fn burns(&self) -> bool {
        self.burning > 0
    }
}

impl Tally {
    fn of(list: &VecDeque<Entry>, marks: (u64, Option<u64>)) -> Self {
        let mut tally = Self {
            next: list.len(),
            ..Self::default()
        };
        for (at, entry) in list.iter().enumerate() {
            if entry.is_waiting() {
                tally.next = tally.next.min(at);
            }
            tally.add(entry, marks);
            tally.highest = tally.highest.max(entry.index().unwrap_or(0));
        }
        tally
    }

    fn add(&mut self, entry: &Entry, (current, confirmed): (u64, Option<u64>)) {
        match entry.fate {
            Fate::Waiting => self.waiting += 1,
            Fate::Flying(_) => {
                self.flying.add(entry);
                self.unconfirmed += 1;
            }
            Fate::Doubtful => {
                self.doubtful += 1;
                self.unconfirmed += 1;
            }
            Fate::Accepted(index) => {
                if index > current {
                    self.unfinished.add(entry);
                }
                self.unconfirmed += usize::from(is_above(index, confirmed));
            }
        }
    }

    fn drop(&mut self, entry: &Entry, (current, confirmed): (u64, Option<u64>)) {
        match entry.fate {
            Fate::Waiting => self.waiting -= 1,
            Fate::Flying(_) => {
                self.flying.drop(entry);
                self.unconfirmed -= 1;
            }
            Fate::Doubtful => {
                self.doubtful -= 1;
                self.unconfirmed -= 1;
            }
            Fate::Accepted(index) => {
                if index > current {
                    self.unfinished.drop(entry);
                }
                self.unconfirmed -= usize::from(is_above(index, confirmed));
            }
        }
    }
}

fn is_above(index: u64, confirmed: Option<u64>) -> bool {
    confirmed.is_none_or(|confirmed| index > confirmed)
}

impl Deref for Entries {
    type Target = VecDeque<Entry>;

    fn deref(&self) -> &VecDeque<Entry> {
        &self.list
    }
}

/// Look.
impl Entries {
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            list: VecDeque::with_capacity(capacity),
            tally: Tally::default(),
            marks: (0, None),
        }
    }

    /// How many wait.
    pub(super) fn waiting(&self) -> usize {
        self.tally.waiting
    }

    /// The place of the first that waits.
    pub(super) fn next(&self) -> Option<usize> {
        (self.tally.waiting > 0).then_some(self.tally.next)
    }

    /// How many do not wait: kept until they are finished and beyond doubt.
    pub(super) fn kept(&self) -> usize {
        self.list.len() - self.tally.waiting
    }

    pub(super) fn flying(&self) -> usize {
        self.tally.flying.count
    }

    /// What is accepted and not finished at this current index.
    pub(super) fn unfinished(&self, current: u64) -> Load {
        if current == self.marks.0 {
            return self.tally.unfinished;
        }
        Tally::of(&self.list, (current, self.marks.1)).unfinished
    }

    /// The same, and what is in flight.
    pub(super) fn under_way(&self, current: u64) -> Load {
        self.unfinished(current).and(self.tally.flying)
    }

    /// How many went out and are not beyond doubt, where all up to this index are.
    pub(super) fn unconfirmed(&self, confirmed: Option<u64>) -> usize {
        if confirmed == self.marks.1 {
            return self.tally.unconfirmed;
        }
        Tally::of(&self.list, (self.marks.0, confirmed)).unconfirmed
    }

    /// The place of the one that `is` it. Those that went out last are looked at first.
    pub(super) fn find(&self, is: impl Fn(&Entry) -> bool) -> Option<usize> {
        let (gone, rest) = (0..self.tally.next, self.tally.next..self.list.len());
        let is = |at: &usize| self.list.get(*at).is_some_and(&is);
        gone.rev().chain(rest).find(is)
    }

    /// Whether the counts are those of the list.
    pub(super) fn is_counted(&self) -> bool {
        let counted = Tally::of(&self.list, self.marks);
        // The highest index may be of one that has been let go.
        let highest = self.tally.highest.max(counted.highest);
        Tally { highest, ..counted } == self.tally
    }
}

/// Change.
impl Entries {
    /// The current index, and the one up to which all is beyond doubt.
    pub(super) fn mark(&mut self, current: u64, confirmed: Option<u64>) {
        let before = std::mem::replace(&mut self.marks, (current, confirmed));
        let Tally {
            doubtful, highest, ..
        } = self.tally;
        if confirmed != before.1 {
            if confirmed.is_none_or(|confirmed| highest > confirmed) {
                return self.count();
            }
            self.tally.unconfirmed = self.flying() + doubtful;
        }
        if current != before.0 {
            self.tally.unfinished = Load::default();
            let gone = self.list.iter().filter(|entry| !entry.is_waiting());
            for entry in gone.take(self.kept()) {
                if entry.index().is_some_and(|index| index > current) {
                    self.tally.unfinished.add(entry);
                }
            }
        }
    }

    pub(super) fn push(&mut self, entry: Entry) {
        self.tally.add(&entry, self.marks);
        self.list.push_back(entry);
        self.seek();
    }

    pub(super) fn insert(&mut self, at: usize, entry: Entry) {
        self.list.insert(at, entry);
        self.count();
    }

    pub(super) fn pop(&mut self) -> Option<Entry> {
        let entry = self.list.pop_front()?;
        self.tally.drop(&entry, self.marks);
        match self.tally.next.checked_sub(1) {
            Some(next) => self.tally.next = next,
            None => self.seek(),
        }
        Some(entry)
    }

    /// What became of the one at this place.
    pub(super) fn set_fate(&mut self, at: usize, fate: Fate) {
        let Some(entry) = self.list.get_mut(at) else {
            return;
        };
        self.tally.drop(entry, self.marks);
        entry.fate = fate;
        self.tally.add(entry, self.marks);
        self.tally.highest = self.tally.highest.max(entry.index().unwrap_or(0));
        if entry.is_waiting() {
            self.tally.next = self.tally.next.min(at);
        } else if at == self.tally.next {
            self.seek();
        }
    }

    /// Changes any of those in a range, and counts anew.
    pub(super) fn change(&mut self, range: Range<usize>, change: impl FnMut(&mut Entry)) {
        let range = range.start.min(self.list.len())..range.end.min(self.list.len());
        self.list.range_mut(range).for_each(change);
        self.count();
    }

    /// Finds the first that waits, from where it was on.
    fn seek(&mut self) {
        while (self.list.get(self.tally.next)).is_some_and(|entry| !entry.is_waiting()) {
            self.tally.next += 1;
        }
    }

    fn count(&mut self) {
        self.tally = Tally::of(&self.list, self.marks);
    }
}

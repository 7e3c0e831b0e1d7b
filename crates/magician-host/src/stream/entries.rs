//! The list of a stream's commands, with running counts.

use std::collections::VecDeque;
use std::ops::{Deref, Range};

use super::item::{Entry, Fate};
use crate::connection::Micros;

/// A stream's commands in order, with counts that are updated on each change, so a step costs the
/// same however many there are.
///
/// Counts that depend on a mark (current index, confirmed index) hold for the marks last
/// [set](Self::mark). For other marks they are computed on demand, so a forgotten update costs time
/// and nothing else.
#[derive(Debug)]
pub(super) struct Entries {
    list: VecDeque<Entry>,
    tally: EntryCounts,
    /// Current index and confirmed index for which the counts hold.
    marks: (u64, Option<u64>),
}

/// Number and time of commands that the arm has yet to do, or that are on their way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Workload {
    pub(super) count: usize,
    /// Sum of times, us. Wide enough for many unknown times of [`u64::MAX`].
    time: u128,
    burning: usize,
}

/// Counts of a list of commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct EntryCounts {
    waiting: usize,
    /// Position of the first waiting command; the length of the list if none waits.
    next: usize,
    flying: Workload,
    doubtful: usize,
    /// Accepted, with an index above the current one.
    unfinished: Workload,
    /// Accepted with an index above the confirmed one, or sent and not accepted.
    unconfirmed: usize,
    /// Highest index accepted.
    highest: u64,
}

impl Workload {
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

    /// Time of all, one after the other, us; saturating.
    pub(super) fn time(&self) -> Micros {
        Micros::try_from(self.time).unwrap_or(Micros::MAX)
    }

    pub(super) fn burns(&self) -> bool {
        self.burning > 0
    }
}

impl EntryCounts {
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
            Fate::InFlight(_) => {
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
            Fate::InFlight(_) => {
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

/// Queries.
impl Entries {
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            list: VecDeque::with_capacity(capacity),
            tally: EntryCounts::default(),
            marks: (0, None),
        }
    }

    /// Number of waiting commands.
    pub(super) fn waiting(&self) -> usize {
        self.tally.waiting
    }

    /// Position of the first waiting command. `None` if none waits.
    pub(super) fn next(&self) -> Option<usize> {
        (self.tally.waiting > 0).then_some(self.tally.next)
    }

    /// Number of commands kept until they are finished and confirmed.
    pub(super) fn kept(&self) -> usize {
        self.list.len() - self.tally.waiting
    }

    pub(super) fn flying(&self) -> usize {
        self.tally.flying.count
    }

    /// Commands accepted and not finished at this current index.
    pub(super) fn unfinished(&self, current: u64) -> Workload {
        if current == self.marks.0 {
            return self.tally.unfinished;
        }
        EntryCounts::of(&self.list, (current, self.marks.1)).unfinished
    }

    /// The same, with the commands in flight.
    pub(super) fn under_way(&self, current: u64) -> Workload {
        self.unfinished(current).and(self.tally.flying)
    }

    /// Number of commands sent and not confirmed, given the confirmed index.
    pub(super) fn unconfirmed(&self, confirmed: Option<u64>) -> usize {
        if confirmed == self.marks.1 {
            return self.tally.unconfirmed;
        }
        EntryCounts::of(&self.list, (self.marks.0, confirmed)).unconfirmed
    }

    /// Position of the first command that satisfies `is`, searching the most recently sent first.
    pub(super) fn find(&self, is: impl Fn(&Entry) -> bool) -> Option<usize> {
        let (gone, rest) = (0..self.tally.next, self.tally.next..self.list.len());
        let is = |at: &usize| self.list.get(*at).is_some_and(&is);
        gone.rev().chain(rest).find(is)
    }

    /// True if the counts match the list; for assertions.
    pub(super) fn is_counted(&self) -> bool {
        let counted = EntryCounts::of(&self.list, self.marks);
        // The highest index may belong to a command that was released.
        let highest = self.tally.highest.max(counted.highest);
        EntryCounts { highest, ..counted } == self.tally
    }
}

/// Changes.
impl Entries {
    /// Sets the current index, and the index up to which everything is confirmed.
    pub(super) fn mark(&mut self, current: u64, confirmed: Option<u64>) {
        let before = std::mem::replace(&mut self.marks, (current, confirmed));
        let EntryCounts {
            doubtful, highest, ..
        } = self.tally;
        if confirmed != before.1 {
            // Accepted commands may be unconfirmed: count anew. Otherwise only those in flight and
            // doubtful ones are.
            if confirmed.is_none_or(|confirmed| highest > confirmed) {
                return self.count();
            }
            self.tally.unconfirmed = self.flying() + doubtful;
        }
        if current != before.0 {
            self.tally.unfinished = Workload::default();
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
        // Rare, and all later positions change, so a full count is simplest.
        self.list.insert(at, entry);
        self.count();
    }

    pub(super) fn pop(&mut self) -> Option<Entry> {
        let entry = self.list.pop_front()?;
        self.tally.drop(&entry, self.marks);
        // All positions move down by one.
        match self.tally.next.checked_sub(1) {
            Some(next) => self.tally.next = next,
            None => self.seek(),
        }
        Some(entry)
    }

    /// Sets the fate of the command at this position.
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

    /// Changes commands in a range, and counts anew.
    pub(super) fn change(&mut self, range: Range<usize>, change: impl FnMut(&mut Entry)) {
        let range = range.start.min(self.list.len())..range.end.min(self.list.len());
        self.list.range_mut(range).for_each(change);
        self.count();
    }

    /// Advances `next` to the first waiting command.
    fn seek(&mut self) {
        while (self.list.get(self.tally.next)).is_some_and(|entry| !entry.is_waiting()) {
            self.tally.next += 1;
        }
    }

    fn count(&mut self) {
        self.tally = EntryCounts::of(&self.list, self.marks);
    }
}

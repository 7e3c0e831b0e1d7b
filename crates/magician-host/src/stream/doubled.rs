//! Indices that differ from the count without harm: a duplicated datagram, or a count that began
//! too low.

use super::Stream;
use super::item::{Entry, Fate};

/// Indices that differ from the count without harm.
impl Stream {
    /// Reports that the controller gave these indices to commands that were sent once, because the
    /// line duplicated a datagram. True if the stream continues.
    ///
    /// It continues after a single copy of a command that has the same result when repeated.
    /// Otherwise the stream does not count the copy, and the next index, which is out of order,
    /// ends it.
    pub fn note_duplicate(&mut self, from: u64, to: u64) -> bool {
        let next = self.expected == Some(from) && from == to;
        let flying = self.entries.iter().filter(|entry| entry.is_in_flight());
        let mut both = self.newest.iter().chain(flying);
        if self.is_over() || !next || !both.all(Entry::tolerates_duplicate) {
            return false;
        }
        let Some(newest) = self.newest else {
            return false;
        };
        // The copy occupies a place in the queue, and takes no time.
        let mut copy = Entry::inserted(newest.item.command, newest.item.end, newest.lit);
        copy.fate = Fate::Accepted(to);
        let accepted = |entry: &Entry| entry.index().is_some();
        let at = self.entries.iter().rposition(accepted);
        self.entries.insert(at.map_or(0, |at| at + 1), copy);
        self.last = Some(to);
        self.expected = to.checked_add(1);
        self.report_progress();
        true
    }

    /// Corrects earlier indices by the index of a reply: all of them may have been too low by the
    /// same amount.
    pub(super) fn correct(&mut self, index: u64) {
        let Some(more) =
            (self.expected.filter(|_| self.guessed)).and_then(|at| index.checked_sub(at))
        else {
            return;
        };
        let corrected = |at: &mut u64| *at = at.saturating_add(more);
        self.entries.change(0..usize::MAX, |entry| {
            if let Fate::Accepted(at) = &mut entry.fate {
                corrected(at);
            }
        });
        let told = [
            &mut self.first,
            &mut self.last,
            &mut self.expected,
            &mut self.confirmed,
        ];
        told.into_iter().flatten().for_each(corrected);
        self.base = self.base.saturating_add(more);
    }
}

//! Collector of notes that merges equal ones and counts them.

use magician_host::message;

use crate::Diagnostic;

/// Largest number of distinct notes. A choice: a user does not read more.
const MAX_NOTES: usize = 50;

/// Notes with their number of occurrences.
#[derive(Default)]
pub(super) struct Notes {
    made: Vec<(Diagnostic, usize)>,
}

impl Notes {
    /// Adds a note. Of equal messages the first keeps its place.
    pub(super) fn add(&mut self, note: Diagnostic) {
        let room = self.made.len() < MAX_NOTES;
        let same = |made: &&mut (Diagnostic, usize)| made.0.message == note.message;
        match self.made.iter_mut().find(same) {
            Some((_, times)) => *times += 1,
            None if room => self.made.push((note, 1)),
            None => {}
        }
    }

    /// True if there are no notes.
    pub(super) fn is_empty(&self) -> bool {
        self.made.is_empty()
    }

    pub(super) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let told = self.made.into_iter().map(|(mut note, times)| {
            if times > 1 {
                let what = &note.message;
                note.message = message!("{what} ({times} times)", what, times);
            }
            note
        });
        told.collect()
    }
}

//! Collector of notes that merges equal ones and counts them.

use magician_host::{Message, message};

use crate::{Diagnostic, DiagnosticCode, Origin};

/// Largest number of distinct notes to keep. A choice that bounds memory and output for damaged
/// files.
const MAX_DISTINCT_NOTES: usize = 200;

#[derive(Debug, Default)]
pub(super) struct Notes {
    found: Vec<(Diagnostic, u64)>,
    more: u64,
}

impl Notes {
    /// Adds a note, or counts it if the same message was added before.
    pub(super) fn add(
        &mut self,
        code: DiagnosticCode,
        origin: Origin,
        message: impl Into<Message>,
    ) {
        let message = message.into();
        if let Some((_, count)) = self.find(&message) {
            *count += 1;
        } else if self.found.len() < MAX_DISTINCT_NOTES {
            let diagnostic = Diagnostic::new(origin, message).coded(code);
            self.found.push((diagnostic, 1));
        } else {
            self.more += 1;
        }
    }

    /// Adds a note like [`add`](Self::add); `advised` adds advice to it.
    pub(super) fn add_with(
        &mut self,
        code: DiagnosticCode,
        origin: Origin,
        message: impl Into<Message>,
        advised: impl FnOnce(Diagnostic) -> Diagnostic,
    ) {
        let message = message.into();
        if self.find(&message).is_none() && self.found.len() < MAX_DISTINCT_NOTES {
            let diagnostic = Diagnostic::new(origin, message).coded(code);
            self.found.push((advised(diagnostic), 1));
        } else {
            self.add(code, origin, message);
        }
    }

    fn find(&mut self, message: &Message) -> Option<&mut (Diagnostic, u64)> {
        let mut found = self.found.iter_mut();
        found.find(|(diagnostic, _)| diagnostic.message == *message)
    }

    /// Returns the notes in the order in which they first occurred.
    pub(super) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let told = |(mut diagnostic, count): (Diagnostic, u64)| {
            if count > 1 {
                let what = &diagnostic.message;
                diagnostic.message = message!("{what} ({times} times)", what, times = count);
            }
            diagnostic
        };
        let more = (self.more > 0)
            .then(|| Diagnostic::of_file(message!("{more} more notes", more = self.more)));
        self.found.into_iter().map(told).chain(more).collect()
    }
}

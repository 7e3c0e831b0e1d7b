//! Diagnostics that refer to a range of bytes, before lines and columns are known.

use std::ops::Range;

use magician_host::{Message, Remedy};

use crate::{Diagnostic, Missing, Origin};

/// A [`Diagnostic`] with a byte range within its line instead of a place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpanDiagnostic {
    pub(super) range: Range<usize>,
    pub(super) message: Message,
    pub(super) help: Option<Message>,
    pub(super) remedies: Vec<Remedy>,
    pub(super) missing: Option<Missing>,
}

impl SpanDiagnostic {
    pub(super) fn new(range: Range<usize>, message: impl Into<Message>) -> Self {
        Self {
            range,
            message: message.into(),
            help: None,
            remedies: Vec::new(),
            missing: None,
        }
    }

    /// Wraps a diagnostic from another file that this file refers to.
    #[cfg(feature = "drawings")]
    pub(super) fn of(range: Range<usize>, diagnostic: Diagnostic) -> Self {
        Self {
            remedies: diagnostic.remedies,
            missing: diagnostic.missing,
            ..Self::new(range, diagnostic.message)
        }
    }

    /// Converts to a diagnostic at the place of the byte range.
    pub(super) fn into_diagnostic(self, origin: Origin) -> Diagnostic {
        let mut diagnostic = Diagnostic::new(origin, self.message).with_missing(self.missing);
        diagnostic.help = self.help;
        diagnostic.remedies = self.remedies;
        diagnostic
    }
}

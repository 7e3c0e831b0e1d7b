//! Where the tool is when the program begins, and what is said where that is not known.

use magician_host::{Given, Remedy, Setting};

use super::{GcodeOptions, Notes};
use crate::formats::span::SpanDiagnostic;
use crate::{Diagnostic, DiagnosticCode, Missing, Origin};

/// What to do where it is not known where the arm stands.
fn start() -> Remedy {
    let given = (Setting::Start, Given::Any("X,Y,Z"));
    Remedy::new(given, "sets where the program begins")
}

impl GcodeOptions {
    /// Where the tool is when the program begins, as far as that is known.
    pub(super) fn begins_at(&self) -> Option<[f64; 3]> {
        if self.placed {
            Some([0.0; 3])
        } else {
            self.start
        }
    }
}

impl Notes {
    /// Adds a note of what would be otherwise if it were known where the arm stands.
    pub(super) fn add_without_start(&mut self, origin: Origin, message: &str) {
        self.add_with(
            DiagnosticCode::Assumed,
            origin,
            message,
            Diagnostic::without_start,
        );
    }
}

impl Diagnostic {
    /// It is wrong only where the arm's position is unknown.
    pub(super) fn without_start(self) -> Self {
        self.with(start()).with_missing(Some(Missing::Start))
    }
}

impl SpanDiagnostic {
    /// It is wrong only where the arm's position is unknown.
    pub(super) fn without_start(mut self) -> Self {
        self.missing = Some(Missing::Start);
        self.with(start())
    }
}

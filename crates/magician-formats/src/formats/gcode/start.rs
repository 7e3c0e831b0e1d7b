//! Position of the tool when the program begins, and notes that depend on it.

use magician_host::{Message, Remedy, Setting, SettingValue};

use super::{GcodeOptions, Notes};
use crate::formats::span::SpanDiagnostic;
use crate::{Diagnostic, DiagnosticCode, Missing, Origin};

/// Remedy for an unknown position of the arm.
fn start() -> Remedy {
    let given = (Setting::Start, SettingValue::Any("X,Y,Z"));
    Remedy::new(given, "sets where the program begins")
}

impl GcodeOptions {
    /// Returns the position of the tool at the start, if known.
    pub(super) fn begins_at(&self) -> Option<[f64; 3]> {
        if self.placed {
            Some([0.0; 3])
        } else {
            self.start
        }
    }
}

impl Notes {
    /// Adds a note that would not be needed if the arm's position were known.
    pub(super) fn add_without_start(&mut self, origin: Origin, message: Message) {
        self.add_with(
            DiagnosticCode::Assumed,
            origin,
            message,
            Diagnostic::without_start,
        );
    }
}

impl Diagnostic {
    /// Marks an error that occurs only because the arm's position is unknown.
    pub(super) fn without_start(self) -> Self {
        self.with(start()).with_missing(Some(Missing::Start))
    }
}

impl SpanDiagnostic {
    /// Marks an error that occurs only because the arm's position is unknown.
    pub(super) fn without_start(mut self) -> Self {
        self.missing = Some(Missing::Start);
        self.with(start())
    }
}

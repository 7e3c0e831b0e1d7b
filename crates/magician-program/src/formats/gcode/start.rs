//! Where the tool is when the program begins, and what is said where that is not known.

use super::{GcodeOptions, Notes};
use crate::{Lack, NoteCode, Origin};

/// What to do where it is not known where the arm stands.
pub(super) const START_HELP: &str = "say where the arm stands when the program begins";

impl GcodeOptions {
    /// Where the tool is when the program begins, as far as that is known.
    pub(super) fn begins_at(&self) -> Option<[f64; 3]> {
        match self.placed {
            true => Some([0.0; 3]),
            false => self.start,
        }
    }
}

impl Notes {
    /// Adds a note of what would be otherwise if it were known where the arm stands.
    pub(super) fn add_without_start(&mut self, origin: Origin, message: &str) {
        self.add_with_help(NoteCode::Assumed, origin, message, START_HELP);
        if let Some((problem, _)) = self.find(message) {
            problem.lacks = Some(Lack::Start);
        }
    }
}

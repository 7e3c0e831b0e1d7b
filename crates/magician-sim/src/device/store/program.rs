//! The program that the flash keeps for the base key (document 1.19.4, model section 12).

use std::sync::Arc;

use magician_protocol::Set;

/// A program for the arm to run by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Program {
    /// How often it runs.
    pub(crate) loops: u32,
    /// Its commands. Shared, for a copy of the controller need not copy them.
    pub(crate) lines: Arc<Vec<Set>>,
}

impl Program {
    /// The command at a place, counted through all passes; `None` when the program is over.
    pub(crate) fn line(&self, at: u64) -> Option<&Set> {
        let count = self.lines.len() as u64;
        if count == 0 || at / count >= u64::from(self.loops) {
            return None;
        }
        self.lines.get(usize::try_from(at % count).ok()?)
    }

    /// Whether the command at a place is the first of its pass.
    pub(crate) fn begins_pass(&self, at: u64) -> bool {
        at.is_multiple_of(self.lines.len().max(1) as u64)
    }
}

//! The program that the flash keeps for the base key (document 1.19.4, model section 12).

use std::sync::Arc;

use magician_protocol::Set;

/// A stored program.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Program {
    /// Number of passes.
    pub(crate) loops: u32,
    /// Commands. Shared, so that a snapshot of the controller does not copy them.
    pub(crate) lines: Arc<Vec<Set>>,
}

impl Program {
    /// Command at a position counted over all passes; `None` after the last pass.
    pub(crate) fn line(&self, at: u64) -> Option<&Set> {
        let count = self.lines.len() as u64;
        if count == 0 || at / count >= u64::from(self.loops) {
            return None;
        }
        self.lines.get(usize::try_from(at % count).ok()?)
    }

    /// True if the position is the first of its pass.
    pub(crate) fn begins_pass(&self, at: u64) -> bool {
        // `max(1)` is for an empty program, which never runs.
        at.is_multiple_of(self.lines.len().max(1) as u64)
    }
}

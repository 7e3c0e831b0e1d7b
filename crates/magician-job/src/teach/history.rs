//! Undo and redo of whole states.

use std::collections::VecDeque;

/// So many edits can be undone.
const EDITS: usize = 500;

/// The states before each edit, and after each that was undone.
#[derive(Clone, Debug)]
pub(super) struct History<T> {
    undo: VecDeque<T>,
    redo: Vec<T>,
}

impl<T> History<T> {
    pub(super) const fn new() -> Self {
        Self {
            undo: VecDeque::new(),
            redo: Vec::new(),
        }
    }

    /// An edit was made of this state: what was undone before cannot be redone any more.
    pub(super) fn edited(&mut self, before: T) {
        if self.undo.len() == EDITS {
            self.undo.pop_front();
        }
        self.undo.push_back(before);
        self.redo.clear();
    }

    /// The state before the last edit, in place of this one.
    pub(super) fn undo(&mut self, now: T) -> Option<T> {
        let before = self.undo.pop_back()?;
        self.redo.push(now);
        Some(before)
    }

    /// The state after the edit that was undone last, in place of this one.
    pub(super) fn redo(&mut self, now: T) -> Option<T> {
        let after = self.redo.pop()?;
        self.undo.push_back(now);
        Some(after)
    }
}

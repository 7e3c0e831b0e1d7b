//! Undo and redo of complete states.

use std::collections::VecDeque;

/// Number of edits that can be undone. States share their steps, so each costs little.
const MAX_UNDO_STEPS: usize = 500;

/// States before each edit, and after each undone edit.
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

    /// Records an edit of `before`. Clears the redo list.
    pub(super) fn edited(&mut self, before: T) {
        if self.undo.len() == MAX_UNDO_STEPS {
            self.undo.pop_front();
        }
        self.undo.push_back(before);
        self.redo.clear();
    }

    /// State before the last edit, in exchange for the current one.
    pub(super) fn undo(&mut self, now: T) -> Option<T> {
        let before = self.undo.pop_back()?;
        self.redo.push(now);
        Some(before)
    }

    /// State after the edit undone last, in exchange for the current one.
    pub(super) fn redo(&mut self, now: T) -> Option<T> {
        let after = self.redo.pop()?;
        self.undo.push_back(now);
        Some(after)
    }
}

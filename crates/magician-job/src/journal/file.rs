//! The journal as a small file: there while the job lasts, gone at its good end.

use std::fs;
use std::path::PathBuf;

use magician_program::resume::Checkpoint;
use tracing::debug;

use super::{Journal, JournalError, JournalKey};
use crate::dirs;
use crate::files::replace_unsynced;

/// A [`Journal`] in the user's directory for state (`runs/KEY-ARM.json`), which all programs share: what one has left another
/// goes on with.
#[derive(Debug, Default)]
pub struct FileJournal {
    folder: Option<PathBuf>,
    path: Option<PathBuf>,
}

impl FileJournal {
    /// In the user's directory for state; where the system names none, nothing is kept.
    #[must_use]
    pub fn new() -> Self {
        Self {
            folder: dirs::state().map(|state| state.join("runs")),
            path: None,
        }
    }

    /// In this folder.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: Some(folder.into()),
            path: None,
        }
    }
}

impl Journal for FileJournal {
    fn open(&mut self, key: &JournalKey) {
        let plain = |sign: char| {
            if sign.is_ascii_alphanumeric() {
                sign
            } else {
                '-'
            }
        };
        let arm: String = key.arm.chars().map(plain).take(60).collect();
        let name = format!("{}-{arm}.json", key.program);
        self.path = self.folder.as_ref().map(|folder| folder.join(name));
    }

    fn left(&self) -> Result<Checkpoint, JournalError> {
        let path = self.path.as_ref().ok_or(JournalError::Nothing)?;
        let text = fs::read_to_string(path).map_err(|_| JournalError::Nothing)?;
        let checkpoint: Option<Checkpoint> = serde_json::from_str(&text).ok();
        let checkpoint = checkpoint.filter(|checkpoint| checkpoint.version == Checkpoint::VERSION);
        checkpoint.ok_or_else(|| JournalError::Unreadable {
            place: path.display().to_string(),
        })
    }

    /// A job without a journal is better than none: what goes wrong is only logged.
    fn write(&mut self, checkpoint: &Checkpoint) {
        let Some(path) = &self.path else {
            return;
        };
        let written = (|| {
            let text = serde_json::to_string(checkpoint)?;
            replace_unsynced(path, &text)
        })();
        if let Err(error) = written {
            debug!(%error, "{} cannot be written", path.display());
        }
    }

    fn remove(&mut self) {
        if let Some(path) = &self.path {
            // One that was never written is not there.
            let _ = fs::remove_file(path);
        }
    }
}

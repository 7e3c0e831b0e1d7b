//! Journals: the checkpoint that a job leaves for a later one to resume from.
//!
//! The engine decides when to write; an implementation only stores. `FileJournal` keeps files,
//! [`NoJournal`] nothing.

#[cfg(feature = "files")]
mod file;

use std::io;
use std::time::SystemTime;

use magician_program::resume::Checkpoint;

#[cfg(feature = "files")]
pub use file::{FileJournal, InterruptedRun, interrupted_runs};

/// Key of a journal: program and arm.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct JournalKey {
    /// Key of the program: [`Program::key`](magician_program::Program::key).
    pub program: String,
    /// Serial number of the arm, its name if it reports none, or `virtual` if it ends with this
    /// process.
    pub arm: String,
    /// Number of a virtual arm among those of this process: while the process lives its journal
    /// belongs to no other arm. `None` for an arm that outlives the process.
    pub virtual_arm: Option<u64>,
}

impl JournalKey {
    /// Key for an arm that outlives this process.
    #[must_use]
    pub fn new(program: impl Into<String>, arm: impl Into<String>) -> Self {
        Self {
            program: program.into(),
            arm: arm.into(),
            virtual_arm: None,
        }
    }
}

/// Interrupted job of another program.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct InterruptedJob {
    /// Title of its plan.
    pub title: String,
    /// Steps known to be finished.
    pub finished: u64,
    /// Time of the last write.
    pub at: SystemTime,
}

/// Error of reading a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JournalError {
    /// No job of this program was interrupted at this arm.
    NotFound,
    /// Like `NotFound`, but jobs of other programs were interrupted, newest first. The same file
    /// with another placement or other options is another program.
    OtherPrograms(Vec<InterruptedJob>),
    /// The journal exists but cannot be read: another version wrote it, or it is damaged.
    Unreadable {
        /// Path of the journal.
        place: String,
    },
}

/// Storage for the progress of a job, so that another job can resume it, even in another process.
///
/// Calls are made while the arm moves and must return quickly. The engine decides when to write; a
/// failed write does not stop the arm.
pub trait Journal: Send {
    /// Names the job. Always the first call.
    fn open(&mut self, key: &JournalKey);

    /// Returns the checkpoint of an earlier job with the same key.
    ///
    /// # Errors
    /// [`JournalError`] without such a checkpoint, or if it cannot be read.
    fn load(&self) -> Result<Checkpoint, JournalError>;

    /// Stores a checkpoint.
    ///
    /// # Errors
    /// The cause of the failure. Then nothing of the job may remain stored: an older checkpoint
    /// would be mistaken for the last one.
    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()>;

    /// Removes the checkpoint: the job has run to its end.
    fn remove(&mut self);
}

impl<J: Journal + ?Sized> Journal for Box<J> {
    fn open(&mut self, key: &JournalKey) {
        (**self).open(key);
    }

    fn load(&self) -> Result<Checkpoint, JournalError> {
        (**self).load()
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()> {
        (**self).write(checkpoint)
    }

    fn remove(&mut self) {
        (**self).remove();
    }
}

/// Journal that stores nothing: the job cannot be resumed.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJournal;

impl Journal for NoJournal {
    fn open(&mut self, _key: &JournalKey) {}

    fn load(&self) -> Result<Checkpoint, JournalError> {
        Err(JournalError::NotFound)
    }

    fn write(&mut self, _mark: &Checkpoint) -> io::Result<()> {
        Ok(())
    }

    fn remove(&mut self) {}
}

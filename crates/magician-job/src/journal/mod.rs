//! What a job leaves for the one that goes on with it.

#[cfg(feature = "files")]
mod file;

use std::io;
use std::time::SystemTime;

use magician_program::resume::Checkpoint;

#[cfg(feature = "files")]
pub use file::{FileJournal, LeftRun, left_runs};

/// Whose journal it is.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct JournalKey {
    /// The program: [`Program::key`](magician_program::Program::key).
    pub program: String,
    /// The arm: its serial number, or its name where it tells none, or `virtual` for one that ends with this process.
    pub arm: String,
    /// Number of a virtual arm among those of this process: its journal is of no other arm while this process
    /// lives. `None` for an arm that outlives it.
    pub virtual_arm: Option<u64>,
}

impl JournalKey {
    /// Key of a program at an arm that outlives this process.
    #[must_use]
    pub fn new(program: impl Into<String>, arm: impl Into<String>) -> Self {
        Self {
            program: program.into(),
            arm: arm.into(),
            virtual_arm: None,
        }
    }
}

/// A job of another program that was interrupted.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct InterruptedJob {
    /// What was run.
    pub title: String,
    /// Steps that are known to be finished.
    pub finished: u64,
    /// When that was written.
    pub at: SystemTime,
}

/// Why there is nothing to resume.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JournalError {
    /// No job of this program was interrupted at this arm.
    Nothing,
    /// The same, but jobs of other programs were: the newest first. The same file placed or drawn in another way is another
    /// program.
    Others(Vec<InterruptedJob>),
    /// It is there and cannot be read: another version wrote it, or something damaged it.
    Unreadable {
        /// Where it is.
        place: String,
    },
}

/// Keeps how far a job is, so that another one can go on with it, also in another process. Each call returns soon: it is made
/// while the arm moves.
///
/// The engine says when to write and how often; a journal that cannot be written is no reason to stop the arm.
pub trait Journal: Send {
    /// Names the job that it is of; the first call.
    fn open(&mut self, key: &JournalKey);

    /// What an earlier job of the same has left.
    ///
    /// # Errors
    /// [`JournalError`] if there is nothing, or nothing that can be read.
    fn left(&self) -> Result<Checkpoint, JournalError>;

    /// Keeps this.
    ///
    /// # Errors
    /// The cause if it cannot be kept. Nothing is left of the job then: an older state of it would be
    /// taken for its last one.
    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()>;

    /// The job has come to its end: nothing of it is left.
    fn remove(&mut self);
}

impl<J: Journal + ?Sized> Journal for Box<J> {
    fn open(&mut self, key: &JournalKey) {
        (**self).open(key);
    }

    fn left(&self) -> Result<Checkpoint, JournalError> {
        (**self).left()
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> io::Result<()> {
        (**self).write(checkpoint)
    }

    fn remove(&mut self) {
        (**self).remove();
    }
}

/// Keeps nothing: a job that cannot be resumed.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJournal;

impl Journal for NoJournal {
    fn open(&mut self, _key: &JournalKey) {}

    fn left(&self) -> Result<Checkpoint, JournalError> {
        Err(JournalError::Nothing)
    }

    fn write(&mut self, _mark: &Checkpoint) -> io::Result<()> {
        Ok(())
    }

    fn remove(&mut self) {}
}

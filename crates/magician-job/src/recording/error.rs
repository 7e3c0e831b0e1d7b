//! Why an arm is not recorded any more, as data.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use magician_program::Diagnostic;

/// Why an arm cannot be recorded, or no longer.
#[derive(Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum RecordError {
    /// The end of the file's name is that of no [`Format`](super::Format).
    Format(PathBuf),
    /// The file cannot be made or replaced.
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        why: io::Error,
    },
    /// The file takes nothing more, as on a full disk.
    Write(io::Error),
    /// The motion makes no program of this format.
    Program(Diagnostic),
    /// The arm did not say what has to be known of it.
    Arm(magician::Error),
    /// The line to the arm is gone; what was recorded before is in the file.
    Lost {
        /// Time of the last reading, s.
        seconds: f64,
        /// Readings until then.
        readings: u64,
        /// What became of the line; `None` if it was closed.
        why: Option<Arc<str>>,
    },
    /// The task is gone, with what it said last: an internal error.
    Died(String),
}

/// What to say of a file that the system does not let be written.
pub(super) fn unwritable(path: &Path) -> impl Fn(io::Error) -> RecordError {
    move |why| RecordError::Unwritable {
        path: path.to_owned(),
        why,
    }
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(path) => {
                let path = path.display();
                write!(f, "{path}: its name does not end in a format to record")
            }
            Self::Unwritable { path, why } => {
                write!(f, "{} cannot be written: {why}", path.display())
            }
            Self::Write(why) => write!(f, "the recording cannot be written: {why}"),
            Self::Program(problem) => problem.fmt(f),
            Self::Arm(error) => error.fmt(f),
            Self::Lost { seconds, why, .. } => {
                let why = why.as_deref().unwrap_or("it was closed");
                write!(f, "lost the line to the arm after {seconds:.1} s: {why}")
            }
            Self::Died(last) => f.write_str(last),
        }
    }
}

impl std::error::Error for RecordError {}

impl From<io::Error> for RecordError {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

impl From<magician::Error> for RecordError {
    fn from(error: magician::Error) -> Self {
        Self::Arm(error)
    }
}

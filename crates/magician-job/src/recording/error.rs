//! Errors of a recording, as data.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use magician_program::Diagnostic;

/// Error that prevents or ends a recording.
#[derive(Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum RecordError {
    /// The extension of the file belongs to no [`Format`](super::Format).
    Format(PathBuf),
    /// The file cannot be created or replaced.
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        why: io::Error,
    },
    /// Writing failed, for example on a full disk.
    Write(io::Error),
    /// The motion cannot be expressed as a program of this format.
    Program(Diagnostic),
    /// The arm did not answer a request that the recording needs.
    Arm(magician::Error),
    /// The line to the arm was lost; earlier readings are in the file.
    Lost {
        /// Time of the last reading, s.
        seconds: f64,
        /// Readings until then.
        readings: u64,
        /// Cause; `None` if the line was closed.
        why: Option<Arc<str>>,
    },
    /// The task died: an internal error, with its last message.
    TaskFailed(String),
}

/// Maps an I/O error of `path` to a [`RecordError`].
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
            Self::TaskFailed(last) => f.write_str(last),
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

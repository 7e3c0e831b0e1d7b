//! Return codes of the C interface, and the faults behind them.

use std::fmt;

use magician::{Error, ErrorKind, Voice};

use crate::voice::Vendor;

/// Return codes of the functions, numbered as in the vendor's headers
/// (docs/guide/VENDOR-LIBRARY.md, Results).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Code {
    /// Success.
    NoError = 0,
    /// The arm's queue is full, or too many calls are waiting. The caller may retry.
    BufferFull = 1,
    /// The arm did not answer, or the fate of the command is unknown.
    Timeout = 2,
    /// An argument is invalid, for example a null pointer.
    InvalidParams = 3,
    /// No arm has this id. Returned by `v3` only.
    InvalidDevice = 4,
}

/// Return codes of `ConnectDobot`, numbered as in the vendor's headers
/// (docs/guide/VENDOR-LIBRARY.md, Results).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub(crate) enum ConnectCode {
    /// Connected.
    NoError = 0,
    /// No name was given, and no arm was found.
    NotFound = 1,
    /// The port cannot be opened: missing, not permitted or in use.
    Occupied = 2,
}

impl Code {
    /// Maps an error kind to its code. This is the only place of that mapping.
    #[must_use]
    pub const fn of(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::QueueFull => Self::BufferFull,
            ErrorKind::InvalidInput | ErrorKind::Unreachable | ErrorKind::Unsupported => {
                Self::InvalidParams
            }
            // To the vendor's callers every other failure is a call without a usable reply.
            _ => Self::Timeout,
        }
    }
}

/// Failure of a function: a code for C, and a sentence for the log and `MagicianLastError`.
///
/// The code may be 0, if `DisconnectDobot` ended the call.
#[derive(Debug)]
pub struct Fault {
    /// Return code.
    pub code: Code,
    /// Sentence for people.
    pub message: String,
}

/// Result of the body of a function.
pub type Outcome = Result<(), Fault>;

impl Fault {
    /// Creates a fault with this code and sentence.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }

    /// Creates a fault for an invalid argument.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::new(Code::InvalidParams, message)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        let message = match Vendor.remedies(error.remedies()) {
            Some(remedies) => format!("{error}; {remedies}"),
            None => error.to_string(),
        };
        Self::new(Code::of(error.kind()), message)
    }
}

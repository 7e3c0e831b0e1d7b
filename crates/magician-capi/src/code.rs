use std::fmt;

use magician::{Error, ErrorKind, Voice};

use crate::voice::Vendor;

/// What the functions return: the numbers of the vendor's headers (docs/guide/VENDOR-LIBRARY.md, Results).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Code {
    /// Done.
    NoError = 0,
    /// There is no room in the arm's queue, or too many calls wait: try again.
    BufferFull = 1,
    /// The arm did not answer, or it cannot be told what became of the command.
    Timeout = 2,
    /// An argument makes no sense, a null pointer for one.
    InvalidParams = 3,
    /// No arm has this id; only `v3` says so.
    InvalidDevice = 4,
}

/// What `ConnectDobot` returns: the numbers of the vendor's headers (docs/guide/VENDOR-LIBRARY.md, Results).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub(crate) enum Connected {
    /// There is a connection.
    NoError = 0,
    /// No name was given and nothing was found.
    NotFound = 1,
    /// The port cannot be opened: it is not there, not allowed or in use.
    Occupied = 2,
}

impl Code {
    /// The code of a kind of error: the only place where the one becomes the other.
    #[must_use]
    pub const fn of(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::QueueFull => Self::BufferFull,
            ErrorKind::InvalidInput | ErrorKind::Unreachable | ErrorKind::Unsupported => {
                Self::InvalidParams
            }
            _ => Self::Timeout,
        }
    }
}

/// Why a function returns something else than 0, or 0 without having done what it is for: the code for C, the sentence
/// for the log and `MagicianLastError`.
#[derive(Debug)]
pub struct Fault {
    /// What C gets.
    pub code: Code,
    /// What a person reads.
    pub message: String,
}

/// What the body of a function comes to.
pub type Outcome = Result<(), Fault>;

impl Fault {
    /// A fault with this code and this sentence.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }

    /// A fault of the caller's: an argument that makes no sense.
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

//! Errors of decoding and encoding.

use core::fmt;

/// Error of decoding the parameters of a well-formed frame as the layout of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DecodeError {
    /// The parameter count fits no accepted form of the layout (errata E11).
    Length {
        /// Fewest parameter bytes accepted.
        expected: usize,
        /// Parameter bytes in the frame.
        found: usize,
    },
    /// The length of the output list is neither a multiple of 4 nor one more than that, for a
    /// count that comes first (errata E29).
    List {
        /// Bytes left for the list.
        found: usize,
    },
    /// The command table has no row with this id.
    UnknownId(u8),
    /// The command has no such form (a get of a set-only command, for instance).
    NoSuchForm(u8),
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, found } => {
                write!(f, "{found} parameter bytes, expected {expected}")
            }
            Self::List { found } => write!(
                f,
                "{found} bytes of output list, expected a multiple of 4, or one more with a count first"
            ),
            Self::UnknownId(id) => write!(f, "unknown command id {id}"),
            Self::NoSuchForm(id) => write!(f, "command id {id} has no such form"),
        }
    }
}

impl core::error::Error for DecodeError {}

/// Error of encoding a value that does not fit a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// More parameter bytes than the 248 a frame carries (errata E03).
    TooLong {
        /// Parameter bytes needed.
        needed: usize,
    },
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { needed } => {
                write!(
                    f,
                    "{needed} parameter bytes, a frame carries {}",
                    crate::MAX_PARAMS
                )
            }
        }
    }
}

impl core::error::Error for EncodeError {}

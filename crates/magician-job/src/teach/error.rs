//! Why something cannot be taught.

use std::fmt;

/// Why a program that is being taught was not changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TeachError {
    /// There are no steps yet.
    Empty,
    /// The step leads nowhere: it has no place that could be taught.
    NoTarget,
    /// An arc stays one: it goes through a point that no other way has.
    IsArc,
    /// The step is no move to a point, of which there are several ways.
    NotAMove,
    /// The arm moves: a point is where it stands.
    Moving,
    /// The arm does not answer: its position is unknown.
    NoAnswer,
}

/// For logs: what people read is made by the program that they use.
impl fmt::Display for TeachError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "there are no points yet",
            Self::NoTarget => "the step has no position",
            Self::IsArc => "an arc has one motion type only",
            Self::NotAMove => "the step is not a move to a point",
            Self::Moving => "the arm moves",
            Self::NoAnswer => "the arm does not answer",
        })
    }
}

impl std::error::Error for TeachError {}

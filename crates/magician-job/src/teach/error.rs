//! Errors of teaching.

use std::fmt;

/// Reason why a taught program was not changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TeachError {
    /// The program has no steps.
    Empty,
    /// The step has no target that could be taught.
    NoTarget,
    /// The step is an arc, which has a single motion type.
    IsArc,
    /// The step is not a move to a point, so it has no other motion types.
    NotAMove,
    /// The arm moves: a point can be stored only at rest.
    Moving,
    /// The arm does not answer: its position is unknown.
    NoAnswer,
}

/// For logs only: each front end words errors for its users itself.
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

//! Programs that a person shows the arm, point by point: what has been taught, with everything that can be undone ([`Lesson`]),
//! teaching it beside an arm ([`TeachEditor`]), and points that a hand teaches ([`follow`]).
//!
//! Where programs are kept, and what all of it looks like, is for the program that people use.

mod editor;
mod error;
mod hand;
mod lesson;

pub use editor::{Playing, TeachEditor};
pub use error::TeachError;
pub use hand::follow;
pub use lesson::{Lesson, Row};

//! Programs that a person shows the arm, point by point.

mod hand;
mod lesson;

pub use hand::follow;
pub use lesson::{Lesson, Row, place};

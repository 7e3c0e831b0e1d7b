//! Programs that a person shows the arm, point by point: the program with undo and redo ([`ProgramModel`]),
//! teaching it beside an arm ([`TeachEditor`]), and points that a hand teaches ([`guided_points`]).
//!
//! Where programs are kept, and what all of it looks like, is for the program that people use.

mod editor;
mod error;
mod guided;
mod history;
mod program;
mod step;

pub use editor::{Playing, TeachEditor};
pub use error::TeachError;
pub use guided::guided_points;
pub use program::ProgramModel;
pub use step::TeachStep;

//! Programs taught point by point: the program with undo and redo ([`ProgramModel`]), teaching next
//! to an arm ([`TeachEditor`]), and hand-guided points ([`guided_points`]).
//!
//! Storage and presentation of programs are left to the front end.

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

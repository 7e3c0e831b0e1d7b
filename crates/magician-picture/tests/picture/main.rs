//! Pictures of plans and drawings, and their comparison.

mod compare;
mod drawing;
mod preview;

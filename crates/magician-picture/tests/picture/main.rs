//! Tests of pictures of plans and drawings, and of their comparison.

mod compare;
mod drawing;
mod preview;

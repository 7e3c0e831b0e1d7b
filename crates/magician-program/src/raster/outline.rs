//! Outlines.

/// How.
#[derive(Clone, Debug)]
pub struct Trace {}

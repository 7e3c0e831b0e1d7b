//! Colours of all pictures.

/// Background.
pub const PAPER: &str = "#fff";
/// Text, frames and joints.
pub const INK: &str = "#1f2933";
/// Labels, units and secondary information.
pub const FAINT: &str = "#66727f";
/// Lines of a pen.
pub const DRAWN: &str = "#1a1a1a";
/// Lines of a laser.
pub const BURNT: &str = "#4a2508";
/// Path of an empty tool.
pub const EMPTY: &str = "#3b7dd8";
/// Path of a tool that holds something.
pub const CARRIED: &str = "#d9530b";
/// Objects after they were moved.
pub const CARGO: &str = "#ffd8a8";
/// Errors and refused steps.
pub const WRONG: &str = "#c4161c";
/// Lines out of reach.
pub const UNREACHABLE: &str = "#d6281e";
/// Area within reach.
pub const REACH: &str = "#e9edf1";
/// Edge of the area within reach.
pub const REACH_EDGE: &str = "#a9b5c1";
/// Base of the arm.
pub const BASE: &str = "#d5dae0";
/// Edges of sheets, and the arm's axis.
pub const EDGE: &str = "#999";

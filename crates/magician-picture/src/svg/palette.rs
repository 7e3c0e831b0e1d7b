//! The colours of all pictures.

/// The ground.
pub const PAPER: &str = "#fff";
/// Text, frames and joints.
pub const INK: &str = "#1f2933";
/// Numbers, units and what matters less.
pub const FAINT: &str = "#66727f";
/// What a pen has drawn.
pub const DRAWN: &str = "#1a1a1a";
/// What a laser has burnt.
pub const BURNT: &str = "#4a2508";
/// The path of an empty tool.
pub const EMPTY: &str = "#3b7dd8";
/// The path of a tool that holds something.
pub const CARRIED: &str = "#d9530b";
/// What was carried, where it was put down.
pub const CARGO: &str = "#ffd8a8";
/// What is refused.
pub const WRONG: &str = "#c4161c";
/// What is out of reach.
pub const UNREACHABLE: &str = "#d6281e";
/// What the arm reaches.
pub const REACH: &str = "#e9edf1";
/// The edge of that.
pub const REACH_EDGE: &str = "#a9b5c1";
/// The base of the arm.
pub const BASE: &str = "#d5dae0";
/// Edges of sheets, and the axis of the arm.
pub const EDGE: &str = "#999";

//! The tool as the world feels it.

/// The tool as the world feels it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolState {
    /// There is vacuum at the suction cup.
    pub sucking: bool,
    /// The gripper is closed.
    pub closed: bool,
    /// Power of the laser, 0 to 100 percent; 0 is off.
    pub laser: f64,
}

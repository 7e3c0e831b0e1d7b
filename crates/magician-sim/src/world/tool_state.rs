//! The tool as the world feels it, and how often it took hold of something.

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

/// How often the tool has tried to take something since power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GripCount {
    /// Times that suction or gripper began to grip with nothing held.
    pub begun: u64,
    /// Times that it took an object.
    pub taken: u64,
}

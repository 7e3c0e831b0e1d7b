//! State of the tool as seen by the world, and counts of its grips.

/// State of the tool as seen by the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolState {
    /// True if there is vacuum at the suction cup.
    pub sucking: bool,
    /// True if the gripper is closed.
    pub closed: bool,
    /// Laser power, 0 to 100 percent; 0 is off.
    pub laser: f64,
}

/// Counts of grips since power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GripCount {
    /// Times that suction or gripper started to grip with nothing held.
    pub begun: u64,
    /// Times that an object was taken.
    pub taken: u64,
}

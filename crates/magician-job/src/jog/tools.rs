//! What the tools of an arm do.

use magician::{Arm, GripperState, Result};
use magician_program::Grip;

use super::ToolOrder;

/// What the tools were last told or seen to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolState {
    /// Whether the suction cup is on.
    pub suction: bool,
    /// What the gripper does.
    pub gripper: Grip,
    /// Whether the laser burns.
    pub laser: bool,
}

/// All is off.
impl Default for ToolState {
    fn default() -> Self {
        Self {
            suction: false,
            gripper: Grip::Off,
            laser: false,
        }
    }
}

impl ToolState {
    /// Asks an arm. What it does not have, or is not known, is off.
    ///
    /// # Errors
    /// As [`Arm::get`], but for an arm that does not know the commands of a tool.
    pub async fn read(arm: &Arm) -> Result<Self> {
        let outputs = arm.read_outputs().await?;
        Ok(Self {
            suction: outputs.suction == Some(true),
            gripper: match outputs.gripper {
                Some(GripperState::Closed) => Grip::Close,
                Some(GripperState::Open) => Grip::Open,
                Some(GripperState::Off) | None => Grip::Off,
            },
            laser: outputs.laser == Some(true),
        })
    }

    /// The arm has done that. One pump is for suction cup and gripper: what is told to one ends the other.
    pub(super) const fn apply(&mut self, order: ToolOrder) {
        match order {
            ToolOrder::Suction(on) => {
                self.suction = on;
                self.gripper = Grip::Off;
            }
            ToolOrder::Gripper(grip) => {
                self.suction = false;
                self.gripper = grip;
            }
            ToolOrder::Laser(on) => self.laser = on,
            ToolOrder::Tip(_) => {}
        }
    }
}

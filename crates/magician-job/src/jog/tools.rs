//! State of the tools of an arm.

use magician::{Arm, GripperState, Result};
use magician_program::Grip;

use super::ToolOrder;

/// Last known state of the tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolState {
    /// True if the suction cup is on.
    pub suction: bool,
    /// State of the gripper.
    pub gripper: Grip,
    /// True if the laser burns.
    pub laser: bool,
}

/// All tools off.
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
    /// Reads the state from an arm. Missing or unknown outputs count as off.
    ///
    /// # Errors
    /// Same as [`Arm::get`], except for an arm that does not know the commands of a tool.
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

    /// Applies an order that the arm has carried out. Suction cup and gripper share one pump: an
    /// order to one ends the other.
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

//! What the tools of an arm do.

use magician::commands::{EndEffectorGripper, EndEffectorSuctionCup};
use magician::{Arm, Result};
use magician_program::Grip;

use super::ToolOrder;
use super::session::known;

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
    /// Asks an arm. What it does not have is off.
    ///
    /// # Errors
    /// As [`Arm::get`], but for an arm that does not know the commands of a tool.
    pub async fn read(arm: &Arm) -> Result<Self> {
        let suction = known(arm.get::<EndEffectorSuctionCup>().await)?;
        let gripper = known(arm.get::<EndEffectorGripper>().await)?;
        Ok(Self {
            suction: suction
                .is_some_and(|cup| cup.is_ctrl_enabled.is_on() && cup.is_sucked.is_on()),
            gripper: match gripper {
                Some(gripper) if gripper.is_ctrl_enabled.is_on() => {
                    if gripper.is_gripped.is_on() {
                        Grip::Close
                    } else {
                        Grip::Open
                    }
                }
                _ => Grip::Off,
            },
            laser: arm.laser().await? == Some(true),
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

//! What the firmware brings along and no command changes.

use magician_motion::{ArmModel, ToolBias};

use crate::Profile;

/// A profile, and the numbers of it by which motions are planned.
#[derive(Clone)]
pub(crate) struct Firmware {
    pub(crate) profile: Profile,
    pub(crate) model: ArmModel,
}

impl Firmware {
    pub(crate) fn new(profile: Profile) -> Self {
        Self {
            model: profile.arm_model(),
            profile,
        }
    }

    /// Another tool was chosen before power-up.
    pub(crate) fn had_tool(&mut self, tool: ToolBias) {
        self.profile.power_up.tool = tool;
        self.model.geometry.tool = tool;
    }
}

//! The firmware: a profile and its planning numbers, which no command changes.

use magician_motion::{ArmModel, ToolBias};

use crate::Profile;

/// A profile, and the numbers derived from it with which motions are planned.
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

    /// Changes the tool bias of power-up in both.
    pub(crate) fn set_initial_tool(&mut self, tool: ToolBias) {
        self.profile.power_up.tool = tool;
        self.model.geometry.tool = tool;
    }
}

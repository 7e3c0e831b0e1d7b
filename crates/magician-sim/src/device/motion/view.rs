//! The arm at an instant, as planning sees it.

use magician_motion::{ArmState, Geometry, MotionError, MotionLaw, Move, Plan, Planner, Speeds};

use super::Motion;
use crate::ArmInstant;
use crate::device::firmware::Firmware;
use crate::device::store::settings::Settings;

/// All that decides how a motion is planned. Planning changes nothing.
#[derive(Clone, Copy)]
pub(crate) struct ArmView<'a> {
    pub(crate) now: ArmInstant,
    pub(crate) firmware: &'a Firmware,
    pub(crate) settings: &'a Settings,
    pub(crate) motion: &'a Motion,
}

impl ArmView<'_> {
    /// Where the arm is commanded to be.
    pub(crate) fn arm(&self) -> ArmState {
        self.motion.state(self.now, &self.geometry())
    }

    /// Where the carriage is commanded to be, mm.
    pub(crate) fn rail(&self) -> f64 {
        self.motion.rail_at(self.now)
    }

    /// The arm with the tool bias that is set now.
    pub(crate) fn geometry(&self) -> Geometry {
        (self.firmware.model).geometry(self.settings.motion.tool())
    }

    /// How motions are computed.
    pub(crate) fn law(&self) -> MotionLaw {
        self.firmware.model.law
    }

    pub(crate) fn planner(&self, speeds: Speeds) -> Planner {
        self.firmware
            .model
            .planner(self.settings.motion.tool(), speeds)
    }

    /// The planner for jogs and paths, which are given their rates one by one.
    pub(crate) fn planner_given_rates(&self) -> Planner {
        self.planner(self.firmware.model.power_up.speeds())
    }

    /// What the arm would do about a move from where it is, at the speeds set now.
    pub(crate) fn plan(&self, request: &Move) -> Result<Plan, MotionError> {
        let planner = self.planner(self.settings.motion.speeds());
        planner.plan(&self.arm(), request)
    }
}

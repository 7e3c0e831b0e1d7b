//! The arm at an instant, as seen by the planner.

use magician_motion::{ArmState, Geometry, MotionError, MotionLaw, Move, Plan, Planner, Speeds};

use super::Motion;
use crate::ArmInstant;
use crate::device::firmware::Firmware;
use crate::device::store::settings::Settings;

/// Everything on which the plan of a motion depends. Planning changes nothing.
#[derive(Clone, Copy)]
pub(crate) struct ArmView<'a> {
    pub(crate) now: ArmInstant,
    pub(crate) firmware: &'a Firmware,
    pub(crate) settings: &'a Settings,
    pub(crate) motion: &'a Motion,
}

impl ArmView<'_> {
    /// Commanded state of the arm.
    pub(crate) fn arm(&self) -> ArmState {
        self.motion.state(self.now, &self.geometry())
    }

    /// Commanded position of the carriage, mm.
    pub(crate) fn rail(&self) -> f64 {
        self.motion.rail_at(self.now)
    }

    /// Geometry with the tool bias in force.
    pub(crate) fn geometry(&self) -> Geometry {
        (self.firmware.model).geometry(self.settings.motion.tool())
    }

    /// Law of motion.
    pub(crate) fn law(&self) -> MotionLaw {
        self.firmware.model.law
    }

    pub(crate) fn planner(&self, speeds: Speeds) -> Planner {
        self.firmware
            .model
            .planner(self.settings.motion.tool(), speeds)
    }

    /// Planner for jogs and paths, whose rates are passed one by one.
    pub(crate) fn planner_given_rates(&self) -> Planner {
        // The planner's speeds are not used here; those of power-up are merely valid.
        self.planner(self.firmware.model.power_up.speeds())
    }

    /// Plans a move from where the arm stands, at the present speeds.
    pub(crate) fn plan(&self, request: &Move) -> Result<Plan, MotionError> {
        let planner = self.planner(self.settings.motion.speeds());
        planner.plan(&self.arm(), request)
    }
}

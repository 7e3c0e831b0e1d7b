//! Connectors: pins, tools, motors and sensors (model section 13).

pub(crate) mod pins;
pub(crate) mod sensors;
pub(crate) mod steppers;
pub(crate) mod tools;
pub(crate) mod trigger;

use crate::world::ToolState;
use crate::{ArmInstant, Profile};
use pins::Pins;
use sensors::EnabledSensors;
use steppers::Steppers;
use tools::Actuators;

/// All connectors; each part keeps its own state.
#[derive(Clone, Debug)]
pub(crate) struct Io {
    pub(crate) pins: Pins,
    pub(crate) tools: Actuators,
    pub(crate) steppers: Steppers,
    pub(crate) color_sensors: EnabledSensors,
    pub(crate) infrared_sensors: EnabledSensors,
    /// Tool state last reported to the world.
    reported: ToolState,
}

impl Io {
    /// State at power-up. At a reset the world already knows the tool in the state `reported`.
    pub(crate) fn new(profile: &Profile, reported: ToolState) -> Self {
        let abilities = |at| profile.io.pins.get(at).copied().unwrap_or_default();
        Self {
            pins: Pins::new(std::array::from_fn(abilities)),
            tools: Actuators::new(&profile.tools),
            steppers: Steppers::default(),
            color_sensors: EnabledSensors::default(),
            infrared_sensors: EnabledSensors::default(),
            reported,
        }
    }

    /// Tool state last reported to the world.
    pub(crate) fn reported(&self) -> ToolState {
        self.reported
    }

    /// Updates the tools from the pins that drive them. Returns the new state of the tool if it has
    /// changed.
    pub(crate) fn update_tools(&mut self, now: ArmInstant) -> Option<ToolState> {
        let tool = self.tools.follow_wires(now, &self.pins);
        (std::mem::replace(&mut self.reported, tool) != tool).then_some(tool)
    }

    /// Next instant at which a tool or a motor finishes something.
    pub(crate) fn next_event(&self, now: ArmInstant) -> Option<ArmInstant> {
        let ends = [self.tools.next_event(now), self.steppers.next_event()];
        ends.into_iter().flatten().min()
    }
}

//! The world around the arm: what it can touch, hold, see and mark, and what happens there by
//! itself.
//!
//! Everything follows from the arm's time and what the world was told, so a run repeats itself bit
//! for bit. The world costs what happens in it, not what its milliseconds cost: it is told when a
//! motion begins and ends, and it says when something is due.

mod belt;
mod drawing;
mod event;
mod external;
mod forecast;
mod ink;
mod place;
mod samples;
mod scene;
mod script;
mod solid;
mod state;
#[cfg(test)]
mod tests;
mod timed_path;
mod tool_state;
mod touch;
mod traffic;
mod view;

use magician_protocol::Port;

use crate::ArmInstant;
use crate::scenario::{Action, Scenario};

pub use drawing::{Drawing, Stroke, StrokeKind};
pub use event::{WorldEvent, WorldEventKind};
pub use external::{Body, ExternalEvent, Press};
pub use place::ObjectPose;
pub(crate) use place::{Footprint, rotate};
pub use scene::Rest;
pub use timed_path::{JointState, TimedPath};
pub use tool_state::{GripCount, ToolState};
pub use view::{ObjectView, WorldView};

use state::WorldState;

/// The world around one arm. Lengths are mm and angles deg in the frame of the arm's base; a height
/// is the z that the arm reports when its tool touches it (model section 1).
///
/// The default is empty: nothing to touch, nothing connected. It costs nothing.
#[derive(Clone, Debug, Default)]
pub struct World {
    state: Option<Box<WorldState>>,
}

impl World {
    /// The world of a scenario at power-up.
    #[must_use]
    pub fn from_scenario(scenario: &Scenario) -> Self {
        Self {
            state: Some(Box::new(WorldState::new(scenario.clone()))),
        }
    }

    /// The scenario that it comes from, if it is not empty.
    #[must_use]
    pub fn scenario(&self) -> Option<&Scenario> {
        self.state.as_ref().map(|state| state.scenario())
    }

    /// Changes a digital input, address 1 to 20, from the present instant until the scenario or
    /// another call changes it; `false` if there is no such address.
    pub fn set_input(&mut self, address: u8, level: bool) -> bool {
        let action = Action::Digital { address, level };
        self.state_mut().override_input(action)
    }

    /// Changes an analog input, address 1 to 20, to a value from 0 to 4095 (more counts as 4095),
    /// as [`set_input`](Self::set_input).
    pub fn set_analog(&mut self, address: u8, value: u16) -> bool {
        let value = value.min(4095);
        self.state_mut()
            .override_input(Action::Analog { address, value })
    }

    /// A hand puts an object somewhere; false if none has that name.
    pub(crate) fn place(
        &mut self,
        now: ArmInstant,
        joint_state: &JointState,
        name: &str,
        at: [f64; 3],
    ) -> bool {
        let state = self.state.as_mut();
        state.is_some_and(|state| state.place(now, joint_state, name, at))
    }

    /// The world at an instant at which the arm stands so.
    #[must_use]
    pub fn look(&self, now: ArmInstant, joint_state: &JointState) -> WorldView<'_> {
        let state = self.state.as_deref();
        WorldView {
            state: state.map(|state| (state, state.frames(now, joint_state))),
            now,
        }
    }

    /// What pen and laser have left, up to the beginning of the motion under way.
    #[must_use]
    pub fn drawing(&self) -> Option<&Drawing> {
        self.state.as_ref().map(|state| state.drawing())
    }

    /// Drops what pen and laser have left, as a new sheet of paper does.
    pub(crate) fn clear_drawing(&mut self) {
        if let Some(state) = &mut self.state {
            state.clear_drawing();
        }
    }

    /// What pen and laser have left up to now, what the motion under way has added included.
    #[must_use]
    pub(crate) fn drawing_at(&self, now: ArmInstant, under_way: Option<&TimedPath<'_>>) -> Drawing {
        match (&self.state, under_way) {
            (Some(state), Some(path)) => state.drawing_with(now, path),
            (Some(state), None) => state.drawing().clone(),
            (None, _) => Drawing::default(),
        }
    }

    /// The next event of the world, oldest first; the latest 256 are kept.
    pub fn poll_event(&mut self) -> Option<WorldEvent> {
        self.state.as_mut()?.event()
    }

    fn state_mut(&mut self) -> &mut WorldState {
        self.state
            .get_or_insert_with(|| Box::new(WorldState::new(Scenario::default())))
    }
}

/// What the controller asks and tells.
///
/// A path is foretold when it begins and forgotten when the tool takes or lets go of something, and
/// it is foretold with the belt as it runs then. So a grip or a stepper that changes while the arm
/// moves, and a joint that slips or stalls, is told between the [`end`](World::end) of what has
/// been gone and the [`begin`](World::begin) of the rest. Power of the laser is not: it may change
/// on the way.
impl World {
    /// Level that something puts on an input, address 1 to 20 (model section 13); `None` where
    /// nothing is connected.
    pub(crate) fn digital(&self, _now: ArmInstant, address: u8) -> Option<bool> {
        self.state.as_ref()?.digital(address)
    }

    /// Voltage that something puts on an input, 0 to 4095 for 0 to 3.3 V; `None` where nothing is
    /// connected.
    pub(crate) fn analog(&self, _now: ArmInstant, address: u8) -> Option<u16> {
        self.state.as_ref()?.analog(address)
    }

    /// Whether the scenario has yet to change what an input reads.
    pub(crate) fn will_change(&self, address: u8) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.will_change(address))
    }

    /// Red, green and blue under the colour sensor of a connector.
    pub(crate) fn color(&self, now: ArmInstant, port: Port) -> [u8; 3] {
        let color = self.state.as_ref().and_then(|state| state.color(now, port));
        color.unwrap_or_default()
    }

    /// Whether something is in front of the infrared sensor of a connector.
    pub(crate) fn infrared(&self, now: ArmInstant, port: Port) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.infrared(now, port))
    }

    /// Whether the tool holds an object.
    pub(crate) fn holding(&self) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.scene().held().is_some())
    }

    /// The arm has begun a motion; unless it is told otherwise it follows the path to its end. May
    /// be told again with the rest of a path.
    pub(crate) fn begin(&mut self, path: &TimedPath<'_>) {
        if let Some(state) = &mut self.state {
            state.begin(path);
        }
    }

    /// The arm has followed the path until the path's end, which may lie before the one told at its
    /// beginning.
    pub(crate) fn end(&mut self, path: &TimedPath<'_>) {
        if let Some(state) = &mut self.state {
            state.end(path);
        }
    }

    /// The tool has come to another state, at rest or on its way.
    pub(crate) fn set_tool(&mut self, now: ArmInstant, tool: ToolState, at: &JointState) {
        if let Some(state) = &mut self.state {
            state.set_tool(now, tool, at);
        }
    }

    /// A stepper output (0 or 1) turns at so many pulses a second from now on, 0 for rest.
    pub(crate) fn stepper(&mut self, now: ArmInstant, index: usize, pulses_per_second: f64) {
        if let Some(state) = &mut self.state {
            state.stepper(now, index, pulses_per_second);
        }
    }

    /// A queued command comes to its turn.
    pub(crate) fn index_started(&mut self, now: ArmInstant, index: u64) {
        if let Some(state) = &mut self.state {
            state.index_started(now, index);
        }
    }

    /// When something next happens.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        self.state.as_ref()?.next_event()
    }

    /// What happens at the present instant: call again until there is nothing.
    pub(crate) fn poll_external(&mut self, now: ArmInstant) -> Option<ExternalEvent> {
        self.state.as_mut()?.poll_external(now)
    }
}

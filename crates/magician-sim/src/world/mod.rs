//! The world around the arm: bodies that it can touch and hold, sensors, traces, and scripted
//! events.
//!
//! The world is deterministic, bit for bit: its state depends only on the arm's clock and the calls
//! of the controller. The cost depends on events and not on elapsed time: the controller announces
//! the beginning and the end of a motion, and the world returns the time of the next event.

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
pub use scene::Support;
pub use timed_path::{JointState, TimedPath};
pub use tool_state::{GripCount, ToolState};
pub use view::{ObjectView, WorldView};

use state::WorldState;

/// The world around one arm. Lengths are in mm and angles in degrees, in the frame of the arm's
/// base. A height is the z that the arm reports when its tool touches there (model section 1).
///
/// The default is empty: nothing to touch, nothing connected, at no cost.
#[derive(Clone, Debug, Default)]
pub struct World {
    state: Option<Box<WorldState>>,
}

impl World {
    /// Creates the world of a scenario at power-up.
    #[must_use]
    pub fn from_scenario(scenario: &Scenario) -> Self {
        Self {
            // Boxed: most arms have no world, and a controller is cloned for snapshots.
            state: Some(Box::new(WorldState::new(scenario.clone()))),
        }
    }

    /// Scenario of the world; `None` if it is empty.
    #[must_use]
    pub fn scenario(&self) -> Option<&Scenario> {
        self.state.as_ref().map(|state| state.scenario())
    }

    /// Sets a digital input, address 1 to 20, until the scenario or another call changes it.
    /// Returns `false` if there is no such address.
    pub fn set_input(&mut self, address: u8, level: bool) -> bool {
        let action = Action::Digital { address, level };
        self.state_mut().override_input(action)
    }

    /// Sets an analog input, address 1 to 20, to a value from 0 to 4095 (clamped); see
    /// [`set_input`](Self::set_input).
    pub fn set_analog(&mut self, address: u8, value: u16) -> bool {
        // Full scale of the converter (model section 13).
        let value = value.min(4095);
        self.state_mut()
            .override_input(Action::Analog { address, value })
    }

    /// Moves an object by hand. Returns false if there is no object of that name.
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

    /// View of the world at an instant, for an arm in this state.
    #[must_use]
    pub fn look(&self, now: ArmInstant, joint_state: &JointState) -> WorldView<'_> {
        let state = self.state.as_deref();
        WorldView {
            state: state.map(|state| (state, state.frames(now, joint_state))),
            now,
        }
    }

    /// Traces of pen and laser, up to the start of the running motion.
    #[must_use]
    pub fn drawing(&self) -> Option<&Drawing> {
        self.state.as_ref().map(|state| state.drawing())
    }

    /// Removes all traces, like a new sheet of paper.
    pub(crate) fn clear_drawing(&mut self) {
        if let Some(state) = &mut self.state {
            state.clear_drawing();
        }
    }

    /// Traces of pen and laser up to now, including the running motion.
    #[must_use]
    pub(crate) fn drawing_at(&self, now: ArmInstant, under_way: Option<&TimedPath<'_>>) -> Drawing {
        match (&self.state, under_way) {
            (Some(state), Some(path)) => state.drawing_with(now, path),
            (Some(state), None) => state.drawing().clone(),
            (None, _) => Drawing::default(),
        }
    }

    /// Returns the next event, oldest first; the latest 256 are kept.
    pub fn poll_event(&mut self) -> Option<WorldEvent> {
        self.state.as_mut()?.event()
    }

    fn state_mut(&mut self) -> &mut WorldState {
        self.state
            .get_or_insert_with(|| Box::new(WorldState::new(Scenario::default())))
    }
}

/// The controller's interface.
///
/// The changes of a path are predicted when it begins, with the tool and the belt as they are then.
/// So the controller ends the elapsed part with [`end`](World::end) and begins the rest with
/// [`begin`](World::begin) whenever a grip, the stepper of the belt, a slip or a stall changes
/// during a motion. The power of the laser is exempt: it may change at any time.
impl World {
    /// Digital level at an input, address 1 to 20 (model section 13); `None` if nothing is
    /// connected.
    pub(crate) fn digital(&self, _now: ArmInstant, address: u8) -> Option<bool> {
        self.state.as_ref()?.digital(address)
    }

    /// Voltage at an input, 0 to 4095 for 0 to 3.3 V; `None` if nothing is connected.
    pub(crate) fn analog(&self, _now: ArmInstant, address: u8) -> Option<u16> {
        self.state.as_ref()?.analog(address)
    }

    /// True if the scenario will still change an input.
    pub(crate) fn will_change(&self, address: u8) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.will_change(address))
    }

    /// Red, green and blue at the colour sensor of a connector.
    pub(crate) fn color(&self, now: ArmInstant, port: Port) -> [u8; 3] {
        let color = self.state.as_ref().and_then(|state| state.color(now, port));
        color.unwrap_or_default()
    }

    /// True if an object is in front of the infrared sensor of a connector.
    pub(crate) fn infrared(&self, now: ArmInstant, port: Port) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.infrared(now, port))
    }

    /// True if the tool holds an object.
    pub(crate) fn holding(&self) -> bool {
        let state = self.state.as_ref();
        state.is_some_and(|state| state.scene().held().is_some())
    }

    /// Begins a motion along a path. May be called again with the rest of the path.
    pub(crate) fn begin(&mut self, path: &TimedPath<'_>) {
        if let Some(state) = &mut self.state {
            state.begin(path);
        }
    }

    /// Ends a motion. The path may end before the one given at its beginning.
    pub(crate) fn end(&mut self, path: &TimedPath<'_>) {
        if let Some(state) = &mut self.state {
            state.end(path);
        }
    }

    /// Sets the state of the tool, at rest or during a motion.
    pub(crate) fn set_tool(&mut self, now: ArmInstant, tool: ToolState, at: &JointState) {
        if let Some(state) = &mut self.state {
            state.set_tool(now, tool, at);
        }
    }

    /// Sets the rate of a stepper output (0 or 1) in pulses per second, 0 at rest.
    pub(crate) fn stepper(&mut self, now: ArmInstant, index: usize, pulses_per_second: f64) {
        if let Some(state) = &mut self.state {
            state.stepper(now, index, pulses_per_second);
        }
    }

    /// Reports that a queued command has started.
    pub(crate) fn index_started(&mut self, now: ArmInstant, index: u64) {
        if let Some(state) = &mut self.state {
            state.index_started(now, index);
        }
    }

    /// Next instant at which something happens.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        self.state.as_ref()?.next_event()
    }

    /// Returns the next event due at the present instant; call until `None`.
    pub(crate) fn poll_external(&mut self, now: ArmInstant) -> Option<ExternalEvent> {
        self.state.as_mut()?.poll_external(now)
    }
}

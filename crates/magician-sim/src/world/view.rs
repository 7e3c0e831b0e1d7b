//! View of the world at an instant.

use magician_protocol::Port;

use super::scene::Frames;
use super::state::WorldState;
use super::{GripCount, ObjectPose, Support};
use crate::ArmInstant;
use crate::scenario::{Color, Object};

/// The world at an instant.
#[derive(Clone, Copy, Debug)]
pub struct WorldView<'a> {
    pub(super) state: Option<(&'a WorldState, Frames)>,
    pub(super) now: ArmInstant,
}

impl<'a> WorldView<'a> {
    /// Returns the object of that name; `None` if absent.
    #[must_use]
    pub fn object(&self, name: &str) -> Option<ObjectView<'a>> {
        self.objects().find(|object| object.name() == name)
    }

    /// All objects, in the order of the scenario.
    pub fn objects(&self) -> impl Iterator<Item = ObjectView<'a>> + use<'a> {
        let state = self.state;
        state.into_iter().flat_map(|(state, frames)| {
            let ids = state.scene().ids();
            ids.filter_map(move |id| ObjectView::of(state, &frames, id))
        })
    }

    /// Object that the tool holds; `None` if it holds nothing.
    #[must_use]
    pub fn held(&self) -> Option<ObjectView<'a>> {
        self.objects().find(ObjectView::is_held)
    }

    /// Counts of attempted and successful grips.
    #[must_use]
    pub fn grip_count(&self) -> GripCount {
        self.state
            .map_or_else(GripCount::default, |(state, _)| state.grip_count())
    }

    /// True position and yaw of the tool's tip; `None` in an empty world.
    #[must_use]
    pub fn tip(&self) -> Option<ObjectPose> {
        self.state.map(|(_, frames)| frames.tool)
    }

    /// Travel of the belt in its direction, mm.
    #[must_use]
    pub fn belt_travel(&self) -> f64 {
        self.state
            .map_or(0.0, |(state, _)| state.belt_travel(self.now))
    }
}

/// An object at an instant.
#[derive(Clone, Copy, Debug)]
pub struct ObjectView<'a> {
    state: &'a WorldState,
    id: u16,
    object: &'a Object,
    place: ObjectPose,
}

impl<'a> ObjectView<'a> {
    fn of(state: &'a WorldState, frames: &Frames, id: u16) -> Option<Self> {
        let object = state.scenario().objects().get(usize::from(id))?;
        let place = state.scene().place(id, frames);
        Some(Self {
            state,
            id,
            object,
            place,
        })
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &'a str {
        &self.object.name
    }

    /// Length, width and height, mm.
    #[must_use]
    pub fn size(&self) -> [f64; 3] {
        self.object.size
    }

    /// Colour.
    #[must_use]
    pub fn color(&self) -> Color {
        self.object.color
    }

    /// Position and yaw.
    #[must_use]
    pub fn place(&self) -> ObjectPose {
        self.place
    }

    /// What the object rests on.
    #[must_use]
    pub fn rest(&self) -> Support {
        self.state.rest(self.id)
    }

    /// True if it stands directly on the conveyor's belt.
    #[must_use]
    pub fn on_belt(&self) -> bool {
        self.rest() == Support::Belt
    }

    /// True if it stands directly on the table.
    #[must_use]
    pub fn on_table(&self) -> bool {
        self.rest() == Support::Table
    }

    /// True if it stands directly on the object of that name.
    #[must_use]
    pub fn on(&self, name: &str) -> bool {
        let Support::Object(below) = self.rest() else {
            return false;
        };
        let below = self.state.scenario().objects().get(usize::from(below));
        below.is_some_and(|below| below.name == name)
    }

    /// True if the tool holds it. An object that stands on a held one is carried, not held.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.rest() == Support::Tool
    }

    /// True if it fell to the floor.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.rest() == Support::Floor
    }

    /// True if the sensor of a connector has seen it since power-up. An object hidden by another
    /// was not seen.
    #[must_use]
    pub fn seen_by(&self, port: Port) -> bool {
        let sensors = self.state.scenario().sensors().iter().enumerate();
        let seen_by = self.state.seen_by(self.id);
        sensors
            .filter(|(_, sensor)| sensor.port == port)
            .any(|(nth, _)| seen_by & (1 << nth) != 0)
    }
}

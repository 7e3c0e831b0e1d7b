//! Events in the world.

use std::collections::VecDeque;

use super::{Body, Support};
use crate::ArmInstant;

/// An event in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldEvent {
    /// Instant of the event.
    pub at: ArmInstant,
    /// Kind of the event.
    pub kind: WorldEventKind,
}

/// Kinds of events in the world. Objects are given by their index in the scenario, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WorldEventKind {
    /// The tool picked an object.
    Picked(u16),
    /// The tool released an object, which came to rest.
    Released(u16, Support),
    /// An object ran off the end of the belt and came to rest.
    FellOffBelt(u16, Support),
    /// The tool touches a body.
    Touched(Body),
    /// The tool ran into an object from the side. The object stays: a knock moves nothing here.
    Knocked(u16),
    /// The tool presses deeper than it gives way.
    Pressed(Body),
}

/// The latest events. When full, the oldest is dropped.
#[derive(Clone, Debug, Default)]
pub(super) struct WorldEvents(VecDeque<WorldEvent>);

impl WorldEvents {
    // Same size as the controller's log, into which events are copied after each step.
    const CAPACITY: usize = 256;

    pub(super) fn push(&mut self, at: ArmInstant, kind: WorldEventKind) {
        if self.0.len() >= Self::CAPACITY {
            self.0.pop_front();
        }
        self.0.push_back(WorldEvent { at, kind });
    }

    pub(super) fn pop(&mut self) -> Option<WorldEvent> {
        self.0.pop_front()
    }
}

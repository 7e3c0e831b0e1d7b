//! Events in the world.

use std::collections::VecDeque;

use super::{Body, Rest};
use crate::ArmInstant;

/// Something that happened in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldEvent {
    /// When.
    pub at: ArmInstant,
    /// What.
    pub kind: WorldEventKind,
}

/// What can happen in the world. Objects are named by their place in the scenario, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WorldEventKind {
    /// The tool has taken an object.
    Picked(u16),
    /// The tool has let go of an object, which has come to rest.
    Released(u16, Rest),
    /// The belt has run an object off its end, and it has come to rest.
    FellOffBelt(u16, Rest),
    /// The tool touches something.
    Touched(Body),
    /// The tool has run into an object from the side. It stays where it is: a knock moves nothing
    /// here.
    Knocked(u16),
    /// The tool presses harder than it gives way.
    Pressed(Body),
}

/// The latest events; when it is full the oldest goes.
#[derive(Clone, Debug, Default)]
pub(super) struct WorldEvents(VecDeque<WorldEvent>);

impl WorldEvents {
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

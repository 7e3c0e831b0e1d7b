//! What has happened in the world, for those who watch it.

use std::collections::VecDeque;

use super::{Rest, Thing};
use crate::Micros;

/// Something that happened in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// When.
    pub at: Micros,
    /// What.
    pub what: What,
}

/// What can happen in the world. Objects are named by their place in the scenario, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum What {
    /// The tool has taken an object.
    Picked(u16),
    /// The tool has let go of an object, which has come to rest.
    Released(u16, Rest),
    /// The belt has run an object off its end, and it has come to rest.
    FellOffBelt(u16, Rest),
    /// The tool touches something.
    Touched(Thing),
    /// The tool has run into an object from the side. It stays where it is: a knock moves nothing here.
    Knocked(u16),
    /// The tool presses harder than it gives way.
    Pressed(Thing),
}

/// The latest incidents; when it is full the oldest goes.
#[derive(Clone, Debug, Default)]
pub(super) struct Incidents(VecDeque<Incident>);

impl Incidents {
    const CAPACITY: usize = 256;

    pub(super) fn push(&mut self, at: Micros, what: What) {
        if self.0.len() >= Self::CAPACITY {
            self.0.pop_front();
        }
        self.0.push_back(Incident { at, what });
    }

    pub(super) fn pop(&mut self) -> Option<Incident> {
        self.0.pop_front()
    }
}

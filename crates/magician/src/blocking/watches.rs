//! Blocking versions of state watches, events and jogs.

use std::sync::Arc;

use super::Arm;
use super::owner::{Owner, Server};
use crate::build::JogDirection;
use crate::{Error, Event, JogOptions, Result, StateOptions, Status};

/// See [`crate::StateWatch`]. As an iterator it waits for each reading, until the connection ends.
#[derive(Debug)]
pub struct StateWatch {
    watch: crate::StateWatch,
    server: Arc<Server>,
}

impl StateWatch {
    /// See [`crate::StateWatch::latest`].
    #[must_use]
    pub fn latest(&self) -> Option<Status> {
        self.watch.latest()
    }

    /// See [`crate::StateWatch::changed`].
    ///
    /// # Errors
    /// As there.
    pub fn changed(&mut self) -> Result<Status> {
        self.server.block(self.watch.changed())
    }
}

impl Iterator for StateWatch {
    type Item = Status;

    fn next(&mut self) -> Option<Status> {
        self.changed().ok()
    }
}

/// See [`crate::Events`]. As an iterator it waits for each event, until the connection ends.
#[derive(Debug)]
pub struct Events {
    events: crate::Events,
    server: Arc<Server>,
}

impl Iterator for Events {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        let next = async { self.events.next().await.ok_or_else(Error::closed) };
        self.server.block(next).ok()
    }
}

/// See [`crate::Jog`].
#[derive(Debug)]
pub struct Jog {
    // Declared first, so that it is dropped before the connection may be.
    jog: crate::Jog,
    owner: Arc<Owner>,
}

impl Jog {
    /// See [`crate::Jog::keep`].
    ///
    /// # Errors
    /// As there.
    pub fn keep(&self) -> Result<()> {
        self.jog.keep()
    }

    /// See [`crate::Jog::stop`].
    ///
    /// # Errors
    /// As there.
    pub fn stop(self) -> Result<()> {
        let Self { jog, owner } = self;
        owner.block(|_| jog.stop())
    }
}

impl Arm {
    /// See [`crate::Arm::state`].
    ///
    /// # Errors
    /// As there.
    pub fn state(&self, rate: f64) -> Result<StateWatch> {
        self.state_with(StateOptions::at(rate))
    }

    /// See [`crate::Arm::state_with`].
    ///
    /// # Errors
    /// As there.
    pub fn state_with(&self, options: StateOptions) -> Result<StateWatch> {
        Ok(StateWatch {
            watch: self.owner.arm.state_with(options)?,
            server: Arc::clone(&self.owner.server),
        })
    }

    /// See [`crate::Arm::events`].
    #[must_use]
    pub fn events(&self) -> Events {
        Events {
            events: self.owner.arm.events(),
            server: Arc::clone(&self.owner.server),
        }
    }

    /// See [`crate::Arm::jog`].
    ///
    /// # Errors
    /// As there.
    pub fn jog(&self, direction: JogDirection) -> Result<Jog> {
        self.jog_with(direction, JogOptions::default())
    }

    /// See [`crate::Arm::jog_with`].
    ///
    /// # Errors
    /// As there.
    pub fn jog_with(&self, direction: JogDirection, options: JogOptions) -> Result<Jog> {
        Ok(Jog {
            jog: self.block(|arm| arm.jog_with(direction, options))?,
            owner: Arc::clone(&self.owner),
        })
    }
}

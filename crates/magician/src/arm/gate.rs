//! The motion gate of a connection, below all doors: see [`gate`](crate::gate).

use magician_protocol::{Frame, Set, Stepper};

use super::{Arm, Shared};
use crate::Result;
use crate::connection::{Priority, Request};
use crate::gate::{frame_jogs, refuse_unheld, unheld_jog};

impl Arm {
    /// A handle of the same connection that sends a [`JogCmd`](crate::commands::JogCmd) as it is: see
    /// [`Options::raw_jogs`](super::Options::raw_jogs).
    #[must_use]
    pub fn passing_jogs(&self) -> Self {
        Self {
            passes_jogs: true,
            ..self.clone()
        }
    }

    /// The motor outputs that run because of this connection, a belt for one, and go on until they are switched off:
    /// [`stop`](Self::stop) does that, and the end of the connection, unless it was [detached](Self::detach).
    #[must_use]
    pub fn running_motors(&self) -> Vec<Stepper> {
        self.inner.shared.gate().running_motors().collect()
    }

    /// Switches off what [`running_motors`](Self::running_motors) names.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub async fn stop_motors(&self) -> Result<()> {
        let running = self.running_motors();
        for (output, request) in motors_off() {
            if running.contains(&output) {
                // It is no stop: what others have asked for goes on.
                self.ask(request.priority(Priority::Stream)).await?;
            }
        }
        Ok(())
    }

    /// Refuses a jog that nothing holds; nothing is sent.
    pub(super) fn permit_jog(&self, frame: &Frame<'_>) -> Result<()> {
        if frame_jogs(frame) && !self.lets_jogs_pass() {
            Err(unheld_jog())
        } else {
            Ok(())
        }
    }

    /// Refuses a command that starts a jog that nothing holds.
    pub(super) fn permit_command(&self, command: &Set) -> Result<()> {
        if self.lets_jogs_pass() {
            Ok(())
        } else {
            refuse_unheld(command)
        }
    }

    fn lets_jogs_pass(&self) -> bool {
        self.passes_jogs && !self.inner.options.bounded_jogs
    }
}

impl Shared {
    /// The motors that this connection may have to switch off: [`Gate::held_motors`](crate::gate::Gate::held_motors).
    pub(super) fn held_motors(&self, moving: bool) -> Vec<Stepper> {
        self.gate().held_motors(moving).collect()
    }

    /// Returns the requests of a stop behind [`Request::halt`], in their order: the pins of a laser that was lit through them go
    /// low, and both motor outputs off, whoever started what runs there.
    pub(super) fn behind_halt(&self) -> Vec<Request> {
        let motors = motors_off().map(|(_, request)| request);
        self.lowered_pins().into_iter().chain(motors).collect()
    }
}

/// Each motor output, and what switches it off.
pub(super) fn motors_off() -> impl Iterator<Item = (Stepper, Request)> {
    let requests = Request::motors_off().into_iter().flatten();
    crate::gate::OUTPUTS.into_iter().zip(requests)
}

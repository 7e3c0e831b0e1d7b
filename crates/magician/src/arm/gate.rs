//! The motion gate of a connection, below all doors: see [`gate`](crate::gate).

use magician_protocol::Stepper;

use super::{Arm, Shared};
use crate::Result;
use crate::connection::{Priority, Request};

/// The motor outputs of an arm, a belt for one: [`Arm::motors`] hands them out.
#[derive(Clone, Copy, Debug)]
pub struct Motors<'a> {
    arm: &'a Arm,
}

impl Motors<'_> {
    /// The motor outputs that run because of this connection, a belt for one, and go on until they are switched off:
    /// [`stop`](Arm::stop) does that, and the end of the connection, unless it was [detached](Arm::detach).
    #[must_use]
    pub fn running(self) -> Vec<Stepper> {
        self.arm.picture().motors().running().collect()
    }

    /// Switches off what [`running`](Self::running) names.
    ///
    /// # Errors
    /// As [`set`](Arm::set).
    pub async fn stop(self) -> Result<()> {
        let running = self.running();
        for (output, request) in motors_off() {
            if running.contains(&output) {
                // It is no stop: what others have asked for goes on.
                self.arm.ask(request.priority(Priority::Stream)).await?;
            }
        }
        Ok(())
    }
}

impl Arm {
    /// The motor outputs.
    #[must_use]
    pub const fn motors(&self) -> Motors<'_> {
        Motors { arm: self }
    }
}

impl Shared {
    /// The motors that this connection may have to switch off: [`Motors::held`](crate::gate::Motors::held).
    pub(super) fn held_motors(&self, moving: bool) -> Vec<Stepper> {
        self.picture().motors().held(moving).collect()
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

//! Motor outputs, and the part of a stop that follows its first frames; see [`gate`](crate::gate).

use magician_protocol::Stepper;

use super::{Arm, Shared};
use crate::Result;
use crate::connection::{Priority, Request};

/// Motor outputs of an arm (a belt, for example), returned by [`Arm::motors`].
#[derive(Clone, Copy, Debug)]
pub struct Motors<'a> {
    arm: &'a Arm,
}

impl Motors<'_> {
    /// Returns the motor outputs that this connection started and that run until they are switched
    /// off. [`stop`](Arm::stop) switches them off, and so does the end of the connection unless it
    /// was [detached](Arm::detach).
    #[must_use]
    pub fn running(self) -> Vec<Stepper> {
        self.arm.picture().motors().running().collect()
    }

    /// Switches off the outputs that [`running`](Self::running) returns.
    ///
    /// # Errors
    /// Same as [`set`](Arm::set).
    pub async fn stop(self) -> Result<()> {
        let running = self.running();
        for (output, request) in motors_off() {
            if running.contains(&output) {
                // Not at stop priority: that would drop the pending requests of other calls.
                self.arm.ask(request.priority(Priority::Stream)).await?;
            }
        }
        Ok(())
    }
}

impl Arm {
    /// Returns the motor outputs.
    #[must_use]
    pub const fn motors(&self) -> Motors<'_> {
        Motors { arm: self }
    }
}

impl Shared {
    /// Returns the motors that this connection may have to switch off:
    /// [`Motors::held`](crate::gate::Motors::held).
    pub(super) fn held_motors(&self, moving: bool) -> Vec<Stepper> {
        self.picture().motors().held(moving).collect()
    }

    /// Returns the requests of a stop that follow [`Request::halt`], in order: they lower the pins
    /// of a laser lit through them, and switch off both motor outputs, whichever program started
    /// them.
    pub(super) fn behind_halt(&self) -> Vec<Request> {
        let motors = motors_off().map(|(_, request)| request);
        self.lowered_pins().into_iter().chain(motors).collect()
    }
}

/// Pairs each motor output with the request that switches it off.
pub(super) fn motors_off() -> impl Iterator<Item = (Stepper, Request)> {
    let requests = Request::motors_off().into_iter().flatten();
    crate::gate::OUTPUTS.into_iter().zip(requests)
}

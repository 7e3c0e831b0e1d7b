//! Waiting (document 1.13).

use magician_protocol::commands::WaitCmd;

use crate::Micros;
use crate::device::Device;
use crate::device::dispatch::{Apply, Step, Turn};

impl Apply for WaitCmd {
    /// In the queue it counts from its start; at once it has nothing to hold back (errata E34).
    fn apply(&self, core: &mut Device, turn: Turn) -> Step {
        match turn {
            Turn::Immediate => Step::Done,
            Turn::Queued => {
                let span = Micros::from(self.timeout).saturating_mul(1000);
                Step::Waiting(core.now.saturating_add(span))
            }
        }
    }
}

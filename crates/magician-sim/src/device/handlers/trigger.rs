//! Waiting for an input (document 1.14).

use magician_protocol::commands::TrigCmd;
use magician_protocol::{TriggerCondition, TriggerMode, Writable};

use crate::device::Device;
use crate::device::dispatch::{Apply, Step, Turn};
use crate::device::io::pins::place_of;
use crate::event::Refusal;
use crate::fidelity::Assumption;

/// What the queue waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Trigger {
    pub(crate) address: u8,
    condition: Condition,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Condition {
    Level(bool),
    Below(u16),
    AtMost(u16),
    AtLeast(u16),
    Above(u16),
}

impl Trigger {
    /// `None` for a pin that there is not and a condition without meaning (errata E35).
    fn new(order: &TrigCmd) -> Option<Self> {
        use TriggerCondition::{Above, AtLeast, DifferentOrAtMost, EqualOrBelow};
        let TrigCmd {
            address,
            mode,
            condition,
            threshold,
        } = *order;
        place_of(address)?;
        let condition = match (mode, condition) {
            (TriggerMode::Level, EqualOrBelow) => Condition::Level(threshold != 0),
            (TriggerMode::Level, DifferentOrAtMost) => Condition::Level(threshold == 0),
            (TriggerMode::Analog, EqualOrBelow) => Condition::Below(threshold),
            (TriggerMode::Analog, DifferentOrAtMost) => Condition::AtMost(threshold),
            (TriggerMode::Analog, AtLeast) => Condition::AtLeast(threshold),
            (TriggerMode::Analog, Above) => Condition::Above(threshold),
            _ => return None,
        };
        Some(Self { address, condition })
    }
}

impl Device {
    /// Whether the input reads what a trigger waits for.
    pub(crate) fn is_met(&self, trigger: &Trigger) -> bool {
        let analog = || self.analog(trigger.address);
        match trigger.condition {
            Condition::Level(level) => self.digital(trigger.address) == level,
            Condition::Below(value) => analog() < value,
            Condition::AtMost(value) => analog() <= value,
            Condition::AtLeast(value) => analog() >= value,
            Condition::Above(value) => analog() > value,
        }
    }
}

impl Apply for TrigCmd {
    /// In the queue it blocks until it is met, however long that takes; at once it has nothing to hold back. One that
    /// makes no sense would block for ever and is refused.
    fn apply(&self, core: &mut Device, turn: Turn) -> Step {
        let Some(trigger) = Trigger::new(self) else {
            return match core.allows(Self::ROW.id, Assumption::MeaninglessTrigger) {
                true => core.refuse(Self::ROW.id, Refusal::Trigger),
                false => Step::Done,
            };
        };
        if turn == Turn::Immediate || core.is_met(&trigger) {
            Step::Done
        } else {
            Step::Triggered(trigger)
        }
    }
}

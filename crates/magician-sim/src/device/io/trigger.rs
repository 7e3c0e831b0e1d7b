//! What a TRIG waits for (document 1.14).

use magician_protocol::commands::TrigCmd;
use magician_protocol::{TriggerCondition, TriggerMode};

use super::pins::Pins;
use crate::profile::pin_index;
use crate::{ArmInstant, World};

/// What the queue waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Trigger {
    address: u8,
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
    pub(crate) fn new(order: &TrigCmd) -> Option<Self> {
        use TriggerCondition::{Above, AtLeast, DifferentOrAtMost, EqualOrBelow};
        let TrigCmd {
            address,
            mode,
            condition,
            threshold,
        } = *order;
        pin_index(address)?;
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

    /// EIO address of the input that it waits for.
    pub(crate) fn address(&self) -> u8 {
        self.address
    }

    /// Whether the input reads what it waits for.
    pub(crate) fn is_met(&self, pins: &Pins, world: &World, now: ArmInstant) -> bool {
        let analog = || pins.analog(self.address, world, now);
        match self.condition {
            Condition::Level(level) => pins.digital(self.address, world, now) == level,
            Condition::Below(value) => analog() < value,
            Condition::AtMost(value) => analog() <= value,
            Condition::AtLeast(value) => analog() >= value,
            Condition::Above(value) => analog() > value,
        }
    }
}

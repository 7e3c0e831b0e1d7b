//! Condition of a TRIG (document 1.14).

use magician_protocol::commands::TrigCmd;
use magician_protocol::{TriggerCondition, TriggerMode};

use super::pins::Pins;
use crate::profile::pin_index;
use crate::{ArmInstant, World};

/// Condition on an input that the queue waits for.
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
    /// Decodes a TRIG. `None` for a missing pin or an undefined condition (errata E35).
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
            // Digital inputs know the first two conditions only.
            _ => return None,
        };
        Some(Self { address, condition })
    }

    /// EIO address of the input.
    pub(crate) fn address(&self) -> u8 {
        self.address
    }

    /// True if the input meets the condition.
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

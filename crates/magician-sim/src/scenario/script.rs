//! Scripted events and their times.

use magician_motion::JointAngles;

use crate::world::ExternalEvent;
use crate::{ArmInstant, Micros};

/// A scripted action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// An external event.
    Do(ExternalEvent),
    /// A change of a digital input.
    Digital { address: u8, level: bool },
    /// A change of an analog input.
    Analog { address: u8, value: u16 },
    /// The start of a movement by hand, from one set of joints to another.
    Guide {
        from: JointAngles,
        to: JointAngles,
        over: Micros,
    },
}

/// All scripted events.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Script {
    /// By the arm's clock, in order.
    pub(crate) timed: Vec<(ArmInstant, Action)>,
    /// By the index of a queued command: index, delay after its start, action.
    pub(crate) at_index: Vec<(u64, Micros, Action)>,
}

//! What happens by itself, and when.

use magician_motion::JointAngles;

use crate::world::ExternalEvent;
use crate::{ArmInstant, Micros};

/// Something that is done at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// It happens to the arm.
    Do(ExternalEvent),
    /// A digital input changes.
    Digital { address: u8, level: bool },
    /// An analog input changes.
    Analog { address: u8, value: u16 },
    /// A hand begins to move the arm from where its joints are to others.
    Guide {
        from: JointAngles,
        to: JointAngles,
        over: Micros,
    },
}

/// Everything that happens by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Script {
    /// By the arm's clock, in order.
    pub(crate) timed: Vec<(ArmInstant, Action)>,
    /// So long after the queued command of an index has come to its turn.
    pub(crate) at_index: Vec<(u64, Micros, Action)>,
}

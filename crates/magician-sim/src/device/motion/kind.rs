//! Kinds of motions. The kind decides what follows the end of a motion, and how a stop affects it.

use magician_motion::{Jog, JogAxis};

use super::path::Segment;

/// Purpose of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionKind {
    /// A move to a target, an arc or a circle.
    Move,
    /// A segment of a continuous path.
    Segment(Segment),
    /// A jog: it runs until a limit or a command stops it.
    Jog(Jog),
    /// The stop ramp of a jog, and the jog that follows it.
    JogStop {
        axis: JogAxis,
        then: Option<JogTarget>,
    },
    /// A stage of the search for the switch of J1.
    Search(HomingStage),
    /// The ramp of a forced stop.
    Brake,
    /// A jog of the rail's carriage or its stop ramp, and the jog that follows it.
    RailJog { then: Option<JogTarget> },
}

/// Stage of the search for the switch of J1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HomingStage {
    /// Fast, to the switch.
    Seek,
    /// Away from the switch.
    BackOff,
    /// Slowly, half of the way back.
    Creep,
    /// More slowly still, until the switch closes.
    Touch,
}

/// Axis and direction of a jog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JogTarget {
    /// An axis of the arm.
    Arm(Jog),
    /// The carriage on the rail.
    Rail {
        /// True if its position grows.
        positive: bool,
    },
}

//! What a motion is for: that decides what follows its end, and what a stop makes of it.

use magician_motion::{Jog, JogAxis};

use super::path::Segment;

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionKind {
    /// A move to a target.
    Move,
    /// A segment of a continuous path.
    Segment(Segment),
    /// A jog: it runs until a limit or a command stops it.
    Jog(Jog),
    /// The end of a jog, and the jog that follows it.
    JogStop { axis: JogAxis, then: Option<Jogged> },
    /// Homing, while it looks for the switch of J1.
    Search(Stage),
    /// The end of a motion that was force-stopped.
    Brake,
    /// A jog of the carriage on the rail, or its end and the jog that follows it.
    RailJog { then: Option<Jogged> },
}

/// A part of the search for the switch of J1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Fast, to the switch.
    Seek,
    /// Off the switch again.
    BackOff,
    /// Slowly, half of the way back.
    Creep,
    /// Slower still, until the switch closes.
    Touch,
}

/// What a jog moves, and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Jogged {
    /// An axis of the arm.
    Arm(Jog),
    /// The carriage on the rail.
    Rail {
        /// Whether its place grows.
        positive: bool,
    },
}

//! What a command does to the rest of the arm, as values: handlers return effects, and `apply.rs`
//! applies them.

use magician_motion::JointAngles;

use super::io::trigger::Trigger;
use super::motion::plan::NoPlan;
use super::motion::{JogPlan, PathPoint, Start};
use crate::ArmInstant;
use crate::event::Refusal;

/// How a command came to be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExecMode {
    /// On arrival.
    Immediate,
    /// At its place in the queue.
    Queued,
}

/// What a command leaves behind for the queue to wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Completion {
    /// Nothing: it has finished.
    Done,
    /// The motion that it began.
    Moving,
    /// An instant.
    Waiting(ArmInstant),
    /// An input.
    Triggered(Trigger),
    /// A stepper output that counts pulses.
    Turning(usize),
}

/// Something that a command does beyond the settings, pins and tools that its handler is lent.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "it lives for a call, and a box would allocate for each move"
)]
pub(crate) enum Effect {
    /// It was understood and is not carried out.
    Refuse(Refusal),
    /// It was accepted, and this simulation does not act on it.
    NotSimulated,
    /// An alarm is raised.
    Raise(u8),
    /// The alarms are cleared whose cause is gone.
    ClearAlarms,
    /// A motion begins in place of what moves, or says why not.
    Move(Result<Start, NoPlan>),
    /// A segment of a continuous path begins, at so much power of the laser.
    Segment(PathPoint, f32, ExecMode),
    /// A jog begins, turns or ends.
    Jog(JogPlan),
    /// Homing begins.
    Home,
    /// The reported joints are set; the arm does not move.
    SetReported(JointAngles),
    /// The tool has another bias.
    ToolChanged,
    /// The path under way may have another speed at its end.
    PathChanged,
    /// A stepper output turns at so many pulses a second, for so many pulses if that is given.
    Turn {
        output: usize,
        rate: f64,
        pulses: Option<u32>,
    },
    /// The queue waits until then.
    WaitUntil(ArmInstant),
    /// The queue waits for an input.
    WaitFor(Trigger),
    /// The queue takes commands.
    StartQueue,
    /// The queue takes no more commands, and a wait ends.
    StopQueue,
    /// The queue stops, and what moves brakes.
    ForceStop,
    /// What waits in the queue is dropped.
    ClearQueue,
    /// What is queued from now on is stored as a program.
    StartDownload { loops: u32, announced: u32 },
    /// The program that was stored takes its place in the flash, or is dropped.
    StopDownload { keep: bool },
}

/// The effects of one command, in the order in which they are applied.
#[derive(Clone, Debug, Default)]
pub(crate) struct Effects([Option<Effect>; Self::MOST]);

impl Effects {
    /// LostStepCmd has most: an alarm for each of three joints.
    const MOST: usize = 3;

    /// It changes nothing but what its handler was lent.
    pub(crate) fn none() -> Self {
        Self::default()
    }

    /// These, and another one after them.
    pub(crate) fn and(mut self, effect: Effect) -> Self {
        let free = self.0.iter_mut().find(|place| place.is_none());
        debug_assert!(free.is_some(), "no command has more effects");
        if let Some(place) = free {
            *place = Some(effect);
        }
        self
    }
}

impl From<Effect> for Effects {
    fn from(effect: Effect) -> Self {
        Self::none().and(effect)
    }
}

impl IntoIterator for Effects {
    type Item = Effect;
    type IntoIter = std::iter::Flatten<std::array::IntoIter<Option<Effect>, { Self::MOST }>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter().flatten()
    }
}

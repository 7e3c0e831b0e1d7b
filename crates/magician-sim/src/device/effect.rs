//! Effects of commands as values: handlers return them, `apply.rs` applies them.

use magician_motion::JointAngles;

use super::io::trigger::Trigger;
use super::motion::plan::PlanError;
use super::motion::{JogPlan, PathPoint, PlannedMotion};
use crate::ArmInstant;
use crate::event::Refusal;

/// Time at which a command is carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExecMode {
    /// Carried out on arrival.
    Immediate,
    /// Carried out at its turn in the queue.
    Queued,
}

/// Condition that completes a command; the queue waits for it before the next command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Completion {
    /// Complete already.
    Done,
    /// Complete at the end of the motion that it started.
    Moving,
    /// Complete at an instant.
    Waiting(ArmInstant),
    /// Complete when an input meets a condition.
    Triggered(Trigger),
    /// Complete when a stepper output, given by its index, has counted its pulses.
    Turning(usize),
}

/// A change beyond settings, pins and tools, which the handler changes itself.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "it lives for a call, and a box would allocate for each move"
)]
pub(crate) enum Effect {
    /// Refuses a command that was understood.
    Refuse(Refusal),
    /// Records a command that is accepted but not simulated.
    NotSimulated,
    /// Raises an alarm.
    Raise(u8),
    /// Clears the alarms whose cause is gone.
    ClearAlarms,
    /// Starts a motion in place of the running one, or raises the alarm of a failed plan.
    Move(Result<PlannedMotion, PlanError>),
    /// Starts a segment of a continuous path, at a laser power in percent.
    Segment(PathPoint, f32, ExecMode),
    /// Starts, reverses or ends a jog.
    Jog(JogPlan),
    /// Starts homing.
    Home,
    /// Sets the reported joints; the arm does not move.
    SetReported(JointAngles),
    /// The tool bias has changed.
    ToolChanged,
    /// Parameters of the running path have changed, so its segment may be replanned.
    PathChanged,
    /// Runs a stepper output at a rate in pulses per second, for a number of pulses if given.
    Turn {
        output: usize,
        rate: f64,
        pulses: Option<u32>,
    },
    /// Blocks the queue until an instant.
    WaitUntil(ArmInstant),
    /// Blocks the queue until an input meets a condition.
    WaitFor(Trigger),
    /// Starts the queue.
    StartQueue,
    /// Stops the queue and ends a running wait.
    StopQueue,
    /// Stops the queue and brakes the running motion.
    ForceStop,
    /// Drops all waiting commands.
    ClearQueue,
    /// Starts to store queued commands as a program.
    StartDownload { loops: u32, announced: u32 },
    /// Moves the stored program to the flash, or drops it.
    StopDownload { keep: bool },
}

/// Effects of one command, in the order of application.
#[derive(Clone, Debug, Default)]
pub(crate) struct Effects([Option<Effect>; Self::CAPACITY]);

impl Effects {
    /// LostStepCmd has the most: an alarm for each of three joints.
    const CAPACITY: usize = 3;

    /// No effect beyond the settings, pins and tools that the handler itself changed.
    pub(crate) fn none() -> Self {
        Self::default()
    }

    /// Appends an effect.
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
    type IntoIter = std::iter::Flatten<std::array::IntoIter<Option<Effect>, { Self::CAPACITY }>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter().flatten()
    }
}

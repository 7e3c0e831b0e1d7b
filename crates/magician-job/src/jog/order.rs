//! Orders of a pendant, and their outcomes.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use magician::build;
use magician::{Error, Set, ToolBias};
use magician_program::{Grip, Plan};

use super::JogDirection;
use crate::JobError;

/// Order from a person to an arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PendantOrder {
    /// Jogs until [`EndJog`](Self::EndJog), or until the keep-alive is missing for `keep`. Replaces
    /// another jog.
    Jog {
        /// Direction of the jog.
        direction: JogDirection,
        /// Hold time without [`PendantOrder::Keep`].
        keep: Duration,
    },
    /// Keeps the jog alive.
    Keep,
    /// Ends the jog. Drops a jog or step that waits for the end of a stop.
    EndJog,
    /// Makes a checked move by a length, from where the arm comes to rest.
    Step {
        /// Direction of the move.
        direction: JogDirection,
        /// Length, mm or deg; above 0.
        length: f32,
        /// True if the laser is on intentionally, so that the move may burn.
        burning: bool,
    },
    /// Stops all motion now: the queue is emptied, the laser goes off, and tool orders that wait
    /// are dropped.
    Stop,
    /// Homes the arm.
    Home,
    /// Clears the alarms.
    ClearAlarms,
    /// Switches a tool at once, bypassing the queue.
    Tool(ToolOrder),
    /// Sets the speed ratio of jogs and of moves, percent: above 0, at most 100.
    Speed(f32),
    /// Runs a program from a step (counted from 0). The whole program is checked first.
    Run {
        /// The program.
        plan: Box<Plan>,
        /// Step to begin with.
        from: usize,
    },
}

/// Order to a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum ToolOrder {
    /// Switches the suction cup on or off.
    Suction(bool),
    /// Closes or opens the gripper, or switches its pump off.
    Gripper(Grip),
    /// Switches the laser on or off. The caller has verified that it may burn.
    Laser(bool),
    /// Sets the tip that poses refer to: its offset from the flange, mm.
    Tip(ToolBias),
}

impl ToolOrder {
    pub(super) fn command(self) -> Set {
        match self {
            Self::Suction(on) => build::suction(on),
            Self::Gripper(Grip::Close) => build::grip(),
            Self::Gripper(Grip::Open) => build::release(),
            Self::Gripper(Grip::Off) => build::pump_off(),
            Self::Laser(on) => build::laser(on),
            Self::Tip(bias) => build::tool(bias),
        }
    }
}

/// Activity that an order starts, whether it moves the arm or not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Activity {
    /// A jog, for as long as it lasts.
    Jog(JogDirection),
    /// A checked move of one step.
    Step(JogDirection),
    /// A stop.
    Stop,
    /// Homing.
    Home,
    /// Clearing the alarms.
    ClearAlarms,
    /// Switching a tool.
    Tool(ToolOrder),
    /// Setting the speed ratios, percent.
    Speed(f32),
    /// A program.
    Run,
}

/// Outcome of an order.
#[derive(Debug)]
pub struct OrderDone {
    /// Activity that was ordered.
    pub activity: Activity,
    /// Result of the activity.
    pub outcome: Result<(), OrderError>,
}

/// Error of an order.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum OrderError {
    /// Another activity moves the arm. Only a stop replaces any activity; a jog replaces only a
    /// jog.
    Busy,
    /// An error of the arm or its line.
    Arm(Arc<Error>),
    /// The program did not run to its end.
    Program(Arc<JobError>),
}

impl From<Error> for OrderError {
    fn from(error: Error) -> Self {
        Self::Arm(Arc::new(error))
    }
}

/// For logs only: each front end words errors for its users itself.
impl fmt::Display for OrderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("the arm is doing something else"),
            Self::Arm(error) => error.fmt(f),
            Self::Program(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for OrderError {}

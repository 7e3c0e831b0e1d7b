//! What a pendant orders, and what comes of that.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use magician::build;
use magician::{Error, Set, ToolBias};
use magician_program::{Grip, Plan};

use super::JogDirection;
use crate::JobError;

/// What an arm is to do for a person.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PendantOrder {
    /// Jog until [`EndJog`](Self::EndJog), or until it was not kept up for so long. Takes the place of another jog.
    Jog {
        /// Which way.
        direction: JogDirection,
        /// How long it goes on without [`PendantOrder::Keep`].
        keep: Duration,
    },
    /// Let the jog go on.
    Keep,
    /// End the jog. A jog or a step that waits for the end of a stop is dropped.
    EndJog,
    /// A checked move by so much, from where the arm comes to rest.
    Step {
        /// Which way.
        direction: JogDirection,
        /// How far, mm or deg; above 0.
        length: f32,
        /// The laser burns, and that is meant.
        burning: bool,
    },
    /// Stop whatever moves, now: the queue is emptied, the laser is off, and orders for tools that wait are dropped.
    Stop,
    /// Home the arm.
    Home,
    /// Clear the alarms that stand.
    ClearAlarms,
    /// Something of the tools, at once and past the queue.
    Tool(ToolOrder),
    /// Share of the set speeds of jogs and moves, percent: above 0, at most 100.
    Speed(f32),
    /// A program from one of its steps (from 0) on, checked as a whole first.
    Run {
        /// The program.
        plan: Box<Plan>,
        /// The step it begins with.
        from: usize,
    },
}

/// What a tool is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum ToolOrder {
    /// The suction cup goes on or off.
    Suction(bool),
    /// The gripper closes, opens, or its pump goes off.
    Gripper(Grip),
    /// The laser burns, or is dark. The caller has made sure that it may burn.
    Laser(bool),
    /// The arm counts from a tip that is so far from its flange, mm.
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

/// What an order comes to: what moves the arm, or was done.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Activity {
    /// A jog, as long as it goes on.
    Jog(JogDirection),
    /// A checked move by a step.
    Step(JogDirection),
    /// A stop.
    Stop,
    /// Homing.
    Home,
    /// Clearing the alarms.
    ClearAlarms,
    /// Something of the tools.
    Tool(ToolOrder),
    /// Setting the speeds to so many percent.
    Speed(f32),
    /// A program.
    Run,
}

/// What came of an order.
#[derive(Debug)]
pub struct OrderDone {
    /// What was ordered.
    pub activity: Activity,
    /// Whether it was done.
    pub outcome: Result<(), OrderError>,
}

/// Why an order was not carried out.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum OrderError {
    /// Something else moves the arm: only a stop, and a jog for a jog, takes its place.
    Busy,
    /// The arm or its line.
    Arm(Arc<Error>),
    /// The program did not come to its end.
    Program(Arc<JobError>),
}

impl From<Error> for OrderError {
    fn from(error: Error) -> Self {
        Self::Arm(Arc::new(error))
    }
}

/// For logs: what people read is made by the program that they use.
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

//! What a station orders of its arms, and what they report: the border between its decisions and the driver.

use std::time::Duration;

use magician::words::{Axis, JogDirection};
use magician::{Pin, Set, ToolBias};
use serde_json::Value;

use crate::api::RpcError;
use crate::control::{JogEnd, JogId, RequestId};
use crate::reading::ArmReading;

/// Something that an arm is to do or to tell. Orders are carried out side by side; a stop overtakes all others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmOrder {
    /// Something is to be read.
    Read {
        /// The request that is answered with it.
        request: RequestId,
        /// What.
        read: ArmRead,
    },
    /// Something is to be done. One after the other.
    Act {
        /// The request that is answered when it is done.
        request: RequestId,
        /// What.
        act: Box<ArmAct>,
        /// Whether the laser may burn by it.
        laser: bool,
    },
    /// A jog begins.
    StartJog {
        /// The request that is answered when it has begun.
        request: RequestId,
        /// Its id.
        jog: JogId,
        /// Which way.
        direction: JogDirection,
        /// It ends by itself when it was not kept up for so long.
        keep: Duration,
        /// Share of the set jog speed, percent.
        percent: Option<f32>,
    },
    /// A jog goes on.
    KeepJog(JogId),
    /// A jog ends.
    EndJog(JogId),
    /// The arm stops, and its queue is emptied.
    Stop {
        /// The request that is answered when it stands.
        request: Option<RequestId>,
    },
    /// The arm is read so many times a second from now on; `None`: no more.
    Watch {
        /// Readings a second.
        rate: Option<u32>,
        /// Pins to read as well.
        pins: Vec<Pin>,
    },
}

/// Something to read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmRead {
    /// Its identity.
    Info,
    /// Its alarms.
    Alarms,
    /// Its state.
    State,
    /// Where it stands, once it stands.
    Stand,
    /// A value of the protocol.
    Get {
        /// Id of the command.
        id: u8,
        /// What it is asked for.
        params: Vec<u8>,
    },
}

/// Something to do.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmAct {
    /// A command that acts at once.
    Set(Set),
    /// A command for the queue.
    Enqueue(Set),
    /// A move.
    Move {
        /// Where to: four numbers.
        to: [f32; 4],
        /// Where on the rail, mm.
        rail: Option<f32>,
        /// Which path.
        by: Path,
        /// Whether `to` are joints.
        joints: bool,
        /// Whether `to` counts from where the arm stands.
        relative: bool,
        /// Whether it is over when the arm is there.
        wait: bool,
    },
    /// Homing.
    Home,
    /// The alarms are cleared.
    ClearAlarms,
    /// The tool whose tip is so far from the flange, mm.
    Tip(ToolBias),
    /// Something of the tools.
    Tool(Set),
    /// Share of the set speeds of moves and jogs, percent.
    Speed(f32),
    /// A checked step.
    Step {
        /// Along or about what.
        axis: Axis,
        /// How far, with its sign: mm or deg.
        by: f32,
        /// Whether x and y are turned by the arm's r.
        turned: bool,
        /// Share of the set speeds, percent.
        percent: Option<f32>,
    },
}

/// The path of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Whatever the joints make of it.
    Joint,
    /// A straight line.
    Linear,
    /// Up, across, down.
    Jump,
}

/// What a request comes to.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// This.
    Value(Value),
    /// The state of the arm, by the reading that was reported just before.
    State,
}

/// What an arm reports.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmReport {
    /// What came of a request.
    Done {
        /// The request.
        request: RequestId,
        /// Its outcome.
        outcome: Result<Outcome, RpcError>,
    },
    /// The arm was read.
    Reading(Box<ArmReading>),
    /// A jog has ended by itself, or did not begin.
    JogEnded {
        /// The jog.
        jog: JogId,
        /// Why.
        why: JogEnd,
    },
    /// Something happened: the name of an event, and its fields.
    Event {
        /// `alarm-raised`, `command-finished`, ..
        name: &'static str,
        /// What it is about.
        fields: Vec<(&'static str, Value)>,
    },
    /// The line to the arm broke, or is back.
    Link(bool),
}

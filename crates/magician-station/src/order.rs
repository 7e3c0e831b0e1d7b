//! Orders of a station to its arms, and their reports: the border between its decisions and the driver.

use std::time::Duration;

use magician::build::{Axis, JogDirection};
use magician::{ErrorCode, Fence, Pin, Set, ToolBias};
use magician_job::{JobProgress, JobState, PauseReason};
use magician_program::{SheetCorner, Travel};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::api::{ArmEvent, RpcError};
use crate::control::{JobId, JogEnd, JogId, RequestId};
use crate::job::{Source, SourceBytes};
use crate::reading::{ArmReading, ToolReading};

/// Something that an arm is to do or to tell. Orders are carried out side by side; a stop overtakes all others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmOrder {
    /// Something is to be read.
    Read {
        /// The request that is answered with it.
        request: RequestId,
        /// Reading that is taken.
        read: ArmRead,
    },
    /// Something is to be done. One after the other.
    Act {
        /// The request that is answered when it is done.
        request: RequestId,
        /// Action that is carried out.
        act: Box<ArmAct>,
        /// True if the laser may burn by it.
        laser: bool,
    },
    /// A jog begins.
    StartJog {
        /// The request that is answered when it has begun.
        request: RequestId,
        /// Id of the jog.
        jog: JogId,
        /// Axis and direction.
        direction: JogDirection,
        /// Longest time between two keeps; then it ends by itself.
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
        /// The request that is answered when it stands. A stop that nobody asked for, because a lease has ended, is none of a
        /// job: that has an order of its own.
        request: Option<RequestId>,
    },
    /// The lease has ended: motors that run on because of this station are switched off, unless a job has the arm.
    StopMotors,
    /// The arm gets another fence, at once.
    Fence {
        /// The request that is answered when it holds, and the arm stands where it had to be stopped.
        request: RequestId,
        /// The fence; none removes it.
        fence: Box<Option<Fence>>,
        /// True if what is under way has to end, because it was checked against the earlier fence.
        stops: bool,
    },
    /// The arm tells where its unlock key is released, or no more, beside all else.
    Guide {
        /// The request that is answered when it is so; none where the lease under which it told has ended.
        request: Option<RequestId>,
        /// True if it tells.
        on: bool,
        /// True if it tells although the arm is not known to be homed.
        unhomed: bool,
    },
    /// Something happens in the world of a virtual arm, at once.
    World {
        /// The request that is answered when it has happened.
        request: RequestId,
        /// Event that happens.
        act: WorldAct,
    },
    /// A program is checked.
    CheckJob {
        /// The request that is answered with what was found.
        request: RequestId,
        /// The program.
        source: Box<Source>,
        /// True if what it leaves is told, too.
        preview: bool,
    },
    /// A job begins, behind what the arm is at.
    StartJob(Box<JobStart>),
    /// A job pauses.
    PauseJob {
        /// The request that is answered when it is paused.
        request: Option<RequestId>,
        /// The job.
        job: JobId,
        /// Why.
        reason: PauseReason,
    },
    /// A job that is paused goes on.
    ResumeJob {
        /// The request that is answered when it runs.
        request: RequestId,
        /// The job.
        job: JobId,
        /// True if the arm may have been moved since.
        approach: bool,
        /// Refusal if it would burn and must not.
        laser: Result<(), Box<RpcError>>,
    },
    /// A job stops, and its pen goes up.
    StopJob(JobId),
    /// The arm is read so many times a second from now on; `None`: no more.
    Watch {
        /// Readings a second.
        rate: Option<u32>,
        /// Pins to read as well.
        pins: Vec<Pin>,
    },
}

/// Task of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JobOrder {
    /// The program.
    pub source: Source,
    /// Number of times; `None` without end.
    pub loops: Option<u64>,
    /// The first step, from 0 over all loops.
    pub from: u64,
    /// True if what is in the arm's queue comes first.
    pub keep: bool,
    /// True if an arm that was not homed since it was switched on is refused.
    pub require_homed: bool,
    /// True if it runs on an arm that is not known to be homed, too.
    pub unhomed: bool,
    /// Where it began, if it depends on that, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<[f64; 3]>,
}

impl JobOrder {
    /// A plan that is done so many times, from its first step on; `None`: until it is stopped. `start` is where it began, if it
    /// depends on that.
    #[must_use]
    pub fn of_plan(text: String, loops: Option<u64>, start: Option<[f64; 3]>) -> Self {
        Self {
            source: Source {
                bytes: SourceBytes::Text(text),
                format: Some("plan".to_owned()),
                setup: None,
                preset: None,
            },
            loops,
            from: 0,
            keep: false,
            require_homed: false,
            unhomed: false,
            start,
        }
    }
}

/// A job that begins.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JobStart {
    /// Its id.
    pub job: JobId,
    /// What it is to do.
    pub order: JobOrder,
    /// Whether it goes on where an earlier one of the same ended.
    pub resumes: bool,
    /// How far before that place it begins, along the line of a burn, mm.
    pub overlap: f64,
    /// Refusal if it would burn and must not.
    pub laser: Result<(), Box<RpcError>>,
    /// What is answered if it holds a command that is dangerous.
    pub danger: Result<(), Box<RpcError>>,
}

/// Something to read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmRead {
    /// Its identity.
    Info,
    /// Its links, limits and tool.
    Model,
    /// The world around a virtual arm.
    World {
        /// The mark of the drawing that is known.
        mark: Option<String>,
    },
    /// What its pins, sensors and steppers are, and do.
    Io,
    /// Its alarms.
    Alarms,
    /// Height of the work surface under it.
    Surface,
    /// Its state.
    State,
    /// Where it stands, once it stands.
    Stand,
    /// Where it stands, once it stands, as a step of a program.
    Capture {
        /// How the step is reached.
        by: Travel,
        /// True if an arm that is not known to be homed is taken, too.
        unhomed: bool,
    },
    /// What answers a frame that the protocol's table does not have.
    Raw {
        /// Id of the command.
        id: u8,
        /// Its parameters.
        params: Vec<u8>,
    },
    /// A value of the protocol.
    Get {
        /// Id of the command.
        id: u8,
        /// What it is asked for.
        params: Vec<u8>,
    },
}

/// What a touch of the work surface is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// A height; `adds` keeps the touches before it.
    Height {
        /// True if the touches before count as well.
        adds: bool,
    },
    /// A corner of a sheet.
    Corner(SheetCorner),
}

/// Something to do.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmAct {
    /// A command that acts at once.
    Set(Set),
    /// A command for the queue.
    Enqueue(Set),
    /// A frame that the protocol's table does not have.
    Raw {
        /// Id of the command.
        id: u8,
        /// Its parameters.
        params: Vec<u8>,
        /// Whether it goes to the queue.
        queued: bool,
        /// Whether it moves the arm.
        moves: bool,
    },
    /// The queue is started, if nothing waits in it.
    StartEmptyQueue,
    /// A move.
    Move {
        /// Where to: four numbers.
        to: [f32; 4],
        /// Where on the rail, mm.
        rail: Option<f32>,
        /// Which path.
        by: Travel,
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
    /// Something of the work surface is taken from where the tool touches it.
    Touch {
        /// What is taken.
        takes: Taken,
        /// True if an arm that is not known to be homed is taken, too.
        unhomed: bool,
    },
    /// What was measured of the work surface is forgotten.
    ForgetSurface,
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

/// Something that a hand does in the world of a virtual arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum WorldAct {
    /// The key at the base is pressed; long, or not.
    Press(bool),
    /// The unlock key is held, or released.
    Unlock(bool),
    /// The cable is plugged in, or pulled.
    Plug(bool),
    /// The arm is bent to these joints, deg. The answer is the state that follows.
    Guide([f64; 4]),
    /// An object is put somewhere, mm.
    Place {
        /// The object.
        name: String,
        /// The middle of its underside.
        at: [f64; 3],
    },
    /// A new sheet of paper is laid there.
    Paper,
    /// An input reads something else from now on.
    Input {
        /// EIO address.
        address: u8,
        /// Whether it is a voltage.
        analog: bool,
        /// The level, or counts of the voltage.
        value: u16,
    },
    /// Something goes wrong.
    Fault(Fault),
    /// The arm is switched off, and on again in the world of a scenario.
    Scenario(String),
}

/// What goes wrong in the world of a virtual arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// The alarm of this code is raised.
    Alarm(u8),
    /// A joint slips.
    Slip {
        /// J1 to J4 as 1 to 4.
        joint: u8,
        /// By how much, deg.
        degrees: f64,
    },
    /// The controller resets.
    Reset,
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
    /// Its tools, or its speed, have changed since the last reading.
    Outputs {
        /// Its tools.
        tool: ToolReading,
        /// Share of the set speed of moves, percent; `None` if not known.
        speed: Option<f32>,
    },
    /// A jog has ended by itself, or did not begin.
    JogEnded {
        /// The jog.
        jog: JogId,
        /// Why.
        why: JogEnd,
    },
    /// What a job does.
    Job {
        /// The job.
        job: JobId,
        /// What it does.
        news: JobNews,
    },
    /// Something happened: an event, and its fields.
    Event {
        /// Which.
        event: ArmEvent,
        /// What it is about.
        fields: Vec<(&'static str, Value)>,
    },
    /// The line to the arm broke, or is back.
    Link(bool),
}

/// What a job does.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobNews {
    /// Its program was read.
    Read {
        /// Its title.
        title: String,
        /// Steps of one loop.
        steps: u64,
        /// Where it begins, if it depends on that and it was not given, mm.
        start: Option<[f64; 3]>,
    },
    /// It burns, or may.
    Burns,
    /// It begins behind so many steps, over all loops.
    Starts(u64),
    /// It does something else now; with what a person is told for whom it pauses.
    State(JobState, Option<String>),
    /// How far it is.
    Progress(JobProgress),
    /// It is over.
    Over(Box<JobEnd>),
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JobEnd {
    /// `done`, `failed`, `stopped` or `interrupted`.
    pub state: &'static str,
    /// Why, where it failed.
    pub error: Option<RpcError>,
    /// Drawn and travelled, mm, where all was done.
    pub lengths: Option<[f64; 2]>,
    /// Notes of what it has left switched on, as clients see them.
    pub notes: Vec<Value>,
}

impl JobEnd {
    /// An end of this state, of which no more is known.
    #[must_use]
    pub const fn new(state: &'static str) -> Self {
        Self {
            state,
            error: None,
            lengths: None,
            notes: Vec::new(),
        }
    }
}

/// Why a jog that failed is over, by the name of its error's code.
pub(crate) fn jog_end(code: &str) -> JogEnd {
    let ends = [
        (ErrorCode::NotKept, JogEnd::NotKept),
        (ErrorCode::LineLost, JogEnd::Link),
        (ErrorCode::NoAnswer, JogEnd::Link),
        (ErrorCode::Fenced, JogEnd::Limit),
        (ErrorCode::OutOfReach, JogEnd::Limit),
        (ErrorCode::RunOver, JogEnd::Replaced),
    ];
    let end = { ends.iter() }.find(|(error, _)| error.name() == code);
    end.map_or(JogEnd::Stopped, |(_, end)| *end)
}

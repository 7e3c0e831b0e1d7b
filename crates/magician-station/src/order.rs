//! Orders from the station to an arm, and the reports that come back.
//!
//! This is the border between decision and execution. The station decides from messages and time
//! alone and emits an [`ArmOrder`]; an engine carries it out over the driver and answers with
//! [`ArmReport`]s. An order that belongs to a request names it, and the report [`ArmReport::Done`]
//! with the same id answers the client. Stops overtake all other orders.

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

/// Order to an arm. Orders run side by side, except that acts run one after the other. A stop
/// overtakes all others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmOrder {
    /// Read a value.
    Read {
        /// Request that is answered with the reading.
        request: RequestId,
        /// Value to read.
        read: ArmRead,
    },
    /// Carry out an action. Actions run one after the other.
    Act {
        /// Request that is answered when the action is done.
        request: RequestId,
        /// The action.
        act: Box<ArmAct>,
        /// True if the action may switch the laser on.
        laser: bool,
    },
    /// Start a jog.
    StartJog {
        /// Request that is answered when the jog has started.
        request: RequestId,
        /// Id of the jog.
        jog: JogId,
        /// Axis and direction.
        direction: JogDirection,
        /// Longest time between two `jog.keep` before the jog ends by itself.
        keep: Duration,
        /// Share of the set jog speed, percent. `None` leaves the speed as it is.
        percent: Option<f32>,
    },
    /// Keep a jog alive.
    KeepJog(JogId),
    /// End a jog.
    EndJog(JogId),
    /// Stop the arm and empty its queue.
    Stop {
        /// Request that is answered when the arm stands. `None` if the station stops the arm
        /// because a lease ended; jobs have their own order, [`ArmOrder::StopJob`].
        request: Option<RequestId>,
    },
    /// Switch off what has no end of its own, because the lease has ended: motor outputs that this
    /// station started, and the laser. While a job runs this waits for its pause or end.
    EndUnattended,
    /// Replace the fence at once.
    Fence {
        /// Request that is answered when the fence is in force, and the arm stands if it had to be
        /// stopped.
        request: RequestId,
        /// The new fence. `None` removes it.
        fence: Box<Option<Fence>>,
        /// True if current motion must end because it was checked against the earlier fence.
        stops: bool,
    },
    /// Report the pose whenever the arm's unlock key is released, or stop reporting it. Runs beside
    /// all other orders.
    Guide {
        /// Request that is answered when reporting has changed. `None` if the lease under which it
        /// ran has ended.
        request: Option<RequestId>,
        /// True to report.
        on: bool,
        /// True to report even if the arm is not known to be homed.
        unhomed: bool,
    },
    /// Cause an event in the world of a virtual arm, at once.
    World {
        /// Request that is answered when it has happened.
        request: RequestId,
        /// The event.
        act: WorldAct,
    },
    /// Check a program.
    CheckJob {
        /// Request that is answered with the report.
        request: RequestId,
        /// The program.
        source: Box<Source>,
        /// True to include a preview of the strokes.
        preview: bool,
    },
    /// Start a job once the actions ordered before it are done.
    StartJob(Box<JobStart>),
    /// Pause a job.
    PauseJob {
        /// Request that is answered when the job is paused.
        request: Option<RequestId>,
        /// The job.
        job: JobId,
        /// Reason of the pause.
        reason: PauseReason,
    },
    /// Resume a paused job.
    ResumeJob {
        /// Request that is answered when the job runs.
        request: RequestId,
        /// The job.
        job: JobId,
        /// True if the arm may have been moved during the pause, so that it has to approach the
        /// work again.
        approach: bool,
        /// `Err` if the job must not burn: the refusal that is sent if it would.
        laser: Result<(), Box<RpcError>>,
    },
    /// Stop a job and lift its pen.
    StopJob(JobId),
    /// Read the arm periodically from now on.
    Watch {
        /// Readings per second. `None` stops reading.
        rate: Option<u32>,
        /// Pins to include.
        pins: Vec<Pin>,
    },
}

/// Program and options of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JobOrder {
    /// The program.
    pub source: Source,
    /// Number of loops. `None` runs until stopped.
    pub loops: Option<u64>,
    /// First step, from 0, counted over all loops.
    pub from: u64,
    /// True to run after what is already in the arm's queue, instead of emptying it.
    pub keep: bool,
    /// True to refuse an arm that was not homed since it was switched on.
    pub require_homed: bool,
    /// True to run even if the arm is not known to be homed.
    pub unhomed: bool,
    /// Position at which the program starts, mm, if the program depends on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<[f64; 3]>,
    /// Digest of the program that was checked. The job is refused if its program has another
    /// digest. `None` accepts any program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

impl JobOrder {
    /// Creates an order that runs a plan this many times, from its first step. `None` runs it until
    /// stopped. `start` is the position at which it starts, if it depends on one.
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
            digest: None,
        }
    }
}

/// Start of a job.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JobStart {
    /// Id of the job.
    pub job: JobId,
    /// Program and options.
    pub order: JobOrder,
    /// True to continue where an earlier run of the same program ended.
    pub resumes: bool,
    /// Overlap of a resumed burn, mm along its line: it starts this far before the place where the
    /// laser went out.
    pub overlap: f64,
    /// `Err` if the job must not burn: the refusal that is sent if it would.
    pub laser: Result<(), Box<RpcError>>,
    /// `Err` if the job must not contain dangerous commands: the refusal that is sent if it does.
    pub danger: Result<(), Box<RpcError>>,
}

/// Value to read from an arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmRead {
    /// Identity of the arm.
    Info,
    /// Link lengths, limits and tool of the arm.
    Model,
    /// World around a virtual arm.
    World {
        /// Mark of the drawing that the client already has. Only what came after it is sent.
        mark: Option<String>,
    },
    /// Functions and levels of pins, sensors and steppers.
    Io,
    /// Active alarms.
    Alarms,
    /// Height of the work surface under the arm.
    Surface,
    /// State of the arm, as in a reading.
    State,
    /// State of the arm at rest: the answer waits until the arm stands.
    Stand,
    /// Pose of the arm at rest, as a step of a program.
    Capture {
        /// Kind of motion that leads to the step.
        by: Travel,
        /// True to accept an arm without a known homing.
        unhomed: bool,
    },
    /// Reply to a frame without a row in the protocol's table.
    Raw {
        /// Id of the command.
        id: u8,
        /// Parameters of the command.
        params: Vec<u8>,
    },
    /// Value of the protocol, by a get command.
    Get {
        /// Id of the command.
        id: u8,
        /// Parameters of the get command.
        params: Vec<u8>,
    },
}

/// Purpose of touching the work surface with the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchTarget {
    /// Height of the surface.
    Height {
        /// True to keep the touches taken before.
        adds: bool,
    },
    /// A corner of a sheet.
    Corner(SheetCorner),
}

/// Action of an arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmAct {
    /// Set command with immediate effect.
    Set(Set),
    /// Set command for the queue.
    Enqueue(Set),
    /// Frame without a row in the protocol's table.
    Raw {
        /// Id of the command.
        id: u8,
        /// Parameters of the command.
        params: Vec<u8>,
        /// True if the frame goes to the queue.
        queued: bool,
        /// True if the frame moves the arm.
        moves: bool,
    },
    /// Start the queue, if it is empty.
    StartEmptyQueue,
    /// Move.
    Move {
        /// Target: x, y, z, r in mm and degrees, or four joint angles in degrees.
        to: [f32; 4],
        /// Target on the rail, mm.
        rail: Option<f32>,
        /// Kind of motion.
        by: Travel,
        /// True if `to` holds joint angles.
        joints: bool,
        /// True if `to` is relative to the current pose.
        relative: bool,
        /// True if the action is done when the arm has arrived, false if the move is queued.
        wait: bool,
    },
    /// Home the arm.
    Home,
    /// Clear the alarms.
    ClearAlarms,
    /// Take a height or a corner from where the tool touches the work surface.
    Touch {
        /// Value to take.
        takes: TouchTarget,
        /// True to accept an arm without a known homing.
        unhomed: bool,
    },
    /// Forget all measurements of the work surface.
    ForgetSurface,
    /// Set the tool by the offset of its tip from the flange, mm.
    Tip(ToolBias),
    /// Switch a tool.
    Tool(Set),
    /// Set the velocity ratio of moves and jogs, percent of their set speeds.
    Speed(f32),
    /// Step along an axis, checked before it is sent.
    Step {
        /// Axis.
        axis: Axis,
        /// Distance with sign, mm or degrees.
        by: f32,
        /// True if x and y are rotated by the arm's r.
        turned: bool,
        /// Share of the set speeds, percent. `None` for the set speeds.
        percent: Option<f32>,
    },
}

/// Event in the world of a virtual arm, as caused by a person's hand.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum WorldAct {
    /// The key at the base is pressed. True for a long press.
    Press(bool),
    /// The unlock key is pressed (true) or released (false).
    Unlock(bool),
    /// The cable is plugged in (true) or pulled (false).
    Plug(bool),
    /// The arm is guided by hand to these joint angles, degrees. The answer is the resulting state.
    Guide([f64; 4]),
    /// An object is placed.
    Place {
        /// The object.
        name: String,
        /// Centre of its underside, mm.
        at: [f64; 3],
    },
    /// A new sheet of paper is laid down.
    Paper,
    /// An input changes its level.
    Input {
        /// EIO address.
        address: u8,
        /// True for an analog input.
        analog: bool,
        /// Level, or counts of the analog input.
        value: u16,
    },
    /// A fault occurs.
    Fault(Fault),
    /// The arm is switched off and on again in the world of this scenario.
    Scenario(String),
}

/// Fault of a virtual arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// The alarm with this code is raised.
    Alarm(u8),
    /// A joint slips (loses steps).
    Slip {
        /// Joint, 1 to 4 for J1 to J4.
        joint: u8,
        /// Angle with sign, degrees.
        degrees: f64,
    },
    /// The controller resets.
    Reset,
}

/// Result of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// This value.
    Value(Value),
    /// State of the arm, from the reading that was reported just before.
    State,
}

/// Report of an arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ArmReport {
    /// A request is done.
    Done {
        /// The request.
        request: RequestId,
        /// Outcome, as the answer to the request.
        outcome: Result<Outcome, RpcError>,
    },
    /// New reading of the arm.
    Reading(Box<ArmReading>),
    /// Tools or speed have changed since the last reading.
    Outputs {
        /// State of the tools.
        tool: ToolReading,
        /// Share of the set speed of moves, percent; `None` if not known.
        speed: Option<f32>,
    },
    /// A jog ended by itself, or did not start.
    JogEnded {
        /// The jog.
        jog: JogId,
        /// Reason.
        why: JogEnd,
    },
    /// News of a job.
    Job {
        /// The job.
        job: JobId,
        /// The update.
        update: JobUpdate,
    },
    /// Event of the arm.
    Event {
        /// Kind of the event.
        event: ArmEvent,
        /// Fields of the event.
        fields: Vec<(&'static str, Value)>,
    },
    /// What is known of the work surface has changed: the answer to `surface.get`.
    Surface(Value),
    /// The line to the arm is back (true) or broken (false).
    Link(bool),
}

/// News of a job.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JobUpdate {
    /// The program was read.
    Read {
        /// Title of the program.
        title: String,
        /// Steps of one loop.
        steps: u64,
        /// Start position, mm, if the program depends on it and it was not given.
        start: Option<[f64; 3]>,
        /// Digest of the program.
        digest: String,
    },
    /// The job burns, or may burn.
    Burns,
    /// The job starts after this many steps, counted over all loops.
    Starts(u64),
    /// The state changed. The text, if any, is for the person that a pause waits for.
    State(JobState, Option<String>),
    /// Progress.
    Progress(JobProgress),
    /// The job is over.
    Over(Box<JobEnd>),
}

/// End of a job.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JobEnd {
    /// `done`, `failed`, `stopped` or `interrupted`.
    pub state: &'static str,
    /// Error, if the job failed.
    pub error: Option<RpcError>,
    /// Length drawn and length travelled, mm, if the job ran to its end.
    pub lengths: Option<[f64; 2]>,
    /// Notes on outputs that the job left switched on, in the form sent to clients.
    pub notes: Vec<Value>,
}

impl JobEnd {
    /// Creates an end with this state and no details.
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

/// Returns the reason for the end of a jog that failed with this error code.
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
    // Any other error: the arm stopped, and the error itself is in the answer or the log.
    end.map_or(JogEnd::Stopped, |(_, end)| *end)
}

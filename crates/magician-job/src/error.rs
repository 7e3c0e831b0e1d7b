//! Why a job did not come to its end, and where it stands: as data, for each program to say in its own words.

use std::fmt;
use std::sync::Arc;

use magician::commands::Pose;
use magician::{AlarmSet, Error, Lifted, Message, message};
use magician_program::resume::{DoubtReason, ResumePoint, StepRange};
use magician_program::{Diagnostic, RemainingProgram, Report};

use crate::event::Done;
use crate::journal::JournalError;

/// The outcome of a job. All waiters get the same.
pub type JobOutcome = Result<Arc<Done>, Arc<JobError>>;

/// Why a job ended before its end.
#[derive(Debug)]
#[non_exhaustive]
pub enum Fault {
    /// A stop by [`JobHandle::stop`](crate::JobHandle::stop), by the end of the last handle, or by
    /// the announced end of the line ([`JobError::line_ends`]).
    Stopped {
        /// True if a second stop ended what the first one had begun to do.
        twice: bool,
    },
    /// An error of the arm or its line; also a stop that did not come through the job.
    Arm(Arc<Error>),
    /// A program that cannot be done from where the arm stands.
    Program(Diagnostic),
    /// Steps that the check refuses.
    Refused {
        /// Report of the check.
        report: Box<Report>,
        /// Rest of the program that was checked.
        rest: Box<RemainingProgram>,
    },
    /// No journal to resume from.
    Journal(JournalError),
    /// Nothing left to resume: all steps are done.
    AllDone,
    /// Uncertain progress of the last job.
    Doubt {
        /// Numbers of finished steps, at least and at most.
        span: StepRange,
        /// Reason of the doubt.
        why: DoubtReason,
    },
    /// Commands of the last job that wait in the arm's queue while nothing moves.
    Stands {
        /// Number of waiting commands.
        waiting: u32,
    },
    /// A program that depends on where the arm stood when it began, which is unknown.
    BeginsElsewhere,
}

/// Pose and progress of an arm that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stood {
    /// Pose of the arm.
    pub pose: Pose,
    /// Index of the command that it finished last.
    pub index: u64,
}

/// Place where a job goes on that ended before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Left {
    /// An unknown place, as the arm was not asked: it finishes what it has, and then tells how far it came.
    NotAsked,
    /// A place behind some steps.
    Known {
        /// Steps behind which it lies.
        resume_point: ResumePoint,
        /// True if the next step goes on where it was stopped.
        within: bool,
        /// Length that is burnt twice at most, mm: it is not known exactly where the light went out.
        burnt_twice: f64,
    },
    /// A range of places, as the arm has forgotten what it did: only what was seen to be finished is certain.
    Forgotten(StepRange),
}

/// Outcome of lifting the pen of a drawing.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum PenLift {
    /// Nothing to lift.
    #[default]
    None,
    /// A pen that stays where it is, as wanted.
    Stays,
    /// A pen that went up.
    Lifted(Lifted),
    /// A pen that was not lifted.
    Failed(Arc<Error>),
    /// A lift that took too long: the pen may not be up.
    Late,
}

/// Why a job did not come to its end, and what is known then.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobError {
    /// Cause of the end.
    pub fault: Fault,
    /// Place where it goes on. `None` if nothing was sent of it, or all of it is done.
    pub left: Option<Left>,
    /// Cause why nothing of its progress is kept, if that is so: a resumed job does not find `left`.
    pub unkept: Option<Arc<str>>,
    /// True if all steps were done.
    pub all_done: bool,
    /// True if it was stopped because the program at the other end of the line, a station, was
    /// about to end ([`EndNotice`](magician::EndNotice)). Without `pose` the arm had got nothing of
    /// the job, or did not say where it stands.
    pub line_ends: bool,
    /// Pose and progress of the arm when it was stopped, if it said so.
    pub stood: Option<Stood>,
    /// Pose now, after the lift.
    pub pose: Option<Pose>,
    /// Reason why it is not known whether the arm stands, if the arm gave one.
    pub unconfirmed: Option<Error>,
    /// Outcome of lifting the pen.
    pub lift: PenLift,
}

impl JobError {
    pub(crate) fn new(fault: Fault) -> Self {
        Self {
            fault,
            left: None,
            unkept: None,
            all_done: false,
            line_ends: false,
            stood: None,
            pose: None,
            unconfirmed: None,
            lift: PenLift::None,
        }
    }

    /// True if it was stopped on purpose, through the job.
    #[must_use]
    pub const fn is_stop(&self) -> bool {
        matches!(self.fault, Fault::Stopped { .. })
    }
}

impl From<Error> for JobError {
    fn from(error: Error) -> Self {
        Self::new(Fault::Arm(Arc::new(error)))
    }
}

impl From<Diagnostic> for JobError {
    fn from(problem: Diagnostic) -> Self {
        Self::new(Fault::Program(problem))
    }
}

impl JobError {
    /// Why, in a sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        match &self.fault {
            Fault::Stopped { .. } => message!("stopped"),
            Fault::Arm(error) => error.sentence().clone(),
            Fault::Program(problem) => problem.sentence(),
            Fault::Refused { report, .. } => match report.refused_steps.first() {
                Some(first) => {
                    let (step, cause) = (report.number(first.step), first.error.sentence());
                    message!("step {step} is refused: {cause}", step, cause)
                }
                None => message!("the check failed"),
            },
            Fault::Journal(JournalError::Nothing | JournalError::Others(_)) => {
                message!(
                    "nothing to resume: no journal says how far the job came; start it from the beginning"
                )
            }
            Fault::Journal(JournalError::Unreadable { place }) => {
                message!(
                    "the journal {place} cannot be read",
                    place = place.to_string()
                )
            }
            Fault::AllDone => message!("nothing to resume: all steps are done"),
            Fault::Doubt { span, why } => message!(
                "{least} steps are certainly done, and {most} at most: {why}",
                least = span.least,
                most = span.most,
                why = why.to_string()
            ),
            Fault::Stands { waiting } => message!(
                "{waiting} commands of the last job wait in the queue, and nothing moves",
                waiting
            ),
            Fault::BeginsElsewhere => {
                message!("the program depends on where the arm was when it began")
            }
        }
    }
}

/// For logs: what people read is made by the program that runs the job.
impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.fault {
            // With the command before it.
            Fault::Arm(error) => error.fmt(f),
            Fault::Program(problem) => problem.fmt(f),
            Fault::Refused { report, .. } if !report.refused_steps.is_empty() => {
                let first = &report.refused_steps[0];
                let step = report.number(first.step);
                write!(f, "step {step} is refused: {}", first.error)
            }
            _ => f.write_str(&self.sentence()),
        }
    }
}

impl std::error::Error for JobError {}

/// Why a job was not paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PauseError {
    /// All its steps are done, or it is being stopped.
    Ending,
    /// A job that is over.
    Ended,
}

impl fmt::Display for PauseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ending => "the job is ending",
            Self::Ended => "the job is over",
        })
    }
}

impl std::error::Error for PauseError {}

/// Why a job goes on as fast as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedError {
    /// A speed is 10 to 100 percent.
    Range,
    /// A job that burns: at another speed the same power burns deeper, or not as deep.
    Burns,
    /// All its steps are done, or it is being stopped.
    Ending,
    /// A job that is over.
    Ended,
}

impl fmt::Display for SpeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => "the speed must be 10 to 100 percent",
            Self::Burns => "the job burns: its power fits its speed only",
            Self::Ending => "the job is ending",
            Self::Ended => "the job is over",
        })
    }
}

impl std::error::Error for SpeedError {}

/// Why a job that is paused stays so.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ResumeError {
    /// A job that is not paused.
    NotPaused,
    /// The arm was reset meanwhile (alarm 0x00, a clock that began anew): home it first.
    Reset,
    /// The position of the arm, or of the paused job, is unknown: home the arm first.
    Unknown,
    /// Alarms that hold the arm.
    Alarms(AlarmSet),
    /// The arm moves, or commands of others wait in its queue.
    Busy,
    /// The arm or its line.
    Arm(Arc<Error>),
    /// The program cannot be gone on with from there.
    Program(Diagnostic),
    /// The check refuses steps: the first of them.
    Refused(Arc<Error>),
}

impl ResumeError {
    /// True if the arm has to be homed before the job can go on.
    #[must_use]
    pub const fn wants_homing(&self) -> bool {
        matches!(self, Self::Reset | Self::Unknown)
    }
}

impl fmt::Display for ResumeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPaused => f.write_str("the job is not paused"),
            Self::Reset => f.write_str("the arm was reset while the job was paused: home it first"),
            Self::Unknown => f.write_str("the arm's position is unknown: home it first"),
            Self::Alarms(alarms) => write!(f, "the arm is held by {alarms}"),
            Self::Busy => f.write_str("the arm moves, or commands wait in its queue"),
            Self::Arm(error) | Self::Refused(error) => error.fmt(f),
            Self::Program(problem) => problem.fmt(f),
        }
    }
}

impl std::error::Error for ResumeError {}

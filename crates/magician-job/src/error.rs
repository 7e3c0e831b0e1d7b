//! Errors and outcomes of a job, as data that each front end words itself.

use std::fmt;
use std::sync::Arc;

use magician::commands::Pose;
use magician::{AlarmSet, Error, LiftResult, Message, message};
use magician_program::resume::{DoubtReason, ResumePoint, StepRange};
use magician_program::{Diagnostic, RemainingProgram, Report};

use crate::event::JobSummary;
use crate::journal::JournalError;

/// Outcome of a job. All callers that wait get the same value.
pub type JobOutcome = Result<Arc<JobSummary>, Arc<JobError>>;

/// Reason why a job ended early.
#[derive(Debug)]
#[non_exhaustive]
pub enum Fault {
    /// A stop by [`JobHandle::stop`](crate::JobHandle::stop), by the drop of the last handle, or by
    /// the announced end of the line ([`JobError::stopped_by_line_end`]).
    Stopped {
        /// True if a second stop ended what the first one had begun to do.
        twice: bool,
    },
    /// An error of the arm or its line; also a stop that was not requested through the job.
    Arm(Arc<Error>),
    /// A program that cannot run from where the arm stands.
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
    /// All steps are done: nothing is left to resume.
    AllDone,
    /// Unknown progress of the last job.
    Doubt {
        /// Least and largest possible number of finished steps.
        span: StepRange,
        /// Cause of the doubt.
        why: DoubtReason,
    },
    /// Commands of the last job wait in the arm's queue while nothing moves.
    StuckQueue {
        /// Number of waiting commands.
        waiting: u32,
    },
    /// A program that depends on the arm's pose at its start, which is unknown.
    UnknownStartPose,
}

/// Pose and progress of an arm that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopPosition {
    /// Pose of the arm.
    pub pose: Pose,
    /// Index of the command that it finished last.
    pub index: u64,
}

/// Place where a job that ended early can be resumed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum ResumePlace {
    /// Not read from the arm: it finishes what it has received and can be asked afterwards.
    NotRead,
    /// Known place.
    Known {
        /// Steps after which the job resumes.
        resume_point: ResumePoint,
        /// True if the next step resumes where it was stopped.
        within: bool,
        /// Upper bound of the length burnt twice, mm: where the laser went out is not known
        /// exactly.
        burnt_twice: f64,
    },
    /// Range of places after a reset of the arm: only the steps seen as finished are certain.
    Forgotten(StepRange),
}

/// Outcome of lifting the pen of a drawing.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum PenLift {
    /// The pen needs no lift.
    #[default]
    None,
    /// The pen stays down on request.
    KeptDown,
    /// The pen was lifted.
    Lifted(LiftResult),
    /// The lift failed.
    Failed(Arc<Error>),
    /// The lift exceeded its deadline: the pen may still be down.
    TimedOut,
}

/// Error of a job, with everything known at its end.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobError {
    /// Cause of the end.
    pub fault: Fault,
    /// Place to resume at. `None` if nothing was sent, or everything is done.
    pub resume_place: Option<ResumePlace>,
    /// Why the progress was not stored, if so: a resumed job does not find `resume_place` then.
    pub storage_error: Option<Arc<str>>,
    /// True if all steps were done.
    pub all_done: bool,
    /// True if the job stopped because the program at the other end of the line, a station, was
    /// about to end ([`EndNotice`](magician::EndNotice)). Without `pose` the arm had received
    /// nothing of the job, or did not report where it stands.
    pub stopped_by_line_end: bool,
    /// Pose and progress of the arm when it was stopped, if it reported them.
    pub stopped_at: Option<StopPosition>,
    /// Pose now, after the lift; `None` if unknown.
    pub pose: Option<Pose>,
    /// Error that left it unconfirmed if the arm stands.
    pub unconfirmed: Option<Error>,
    /// Outcome of lifting the pen.
    pub lift: PenLift,
}

impl JobError {
    pub(crate) fn new(fault: Fault) -> Self {
        Self {
            fault,
            resume_place: None,
            storage_error: None,
            all_done: false,
            stopped_by_line_end: false,
            stopped_at: None,
            pose: None,
            unconfirmed: None,
            lift: PenLift::None,
        }
    }

    /// True if the job was stopped on purpose, through its handle.
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
    /// Cause in one sentence.
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
            Fault::Journal(JournalError::NotFound | JournalError::OtherPrograms(_)) => {
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
                why = why.sentence()
            ),
            Fault::StuckQueue { waiting } => message!(
                "{waiting} commands of the last job wait in the queue, and nothing moves",
                waiting
            ),
            Fault::UnknownStartPose => {
                message!("the program depends on where the arm was when it began")
            }
        }
    }
}

/// For logs only: each front end words errors for its users itself.
impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.fault {
            // Includes the name of the command, unlike [`JobError::sentence`].
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

/// Error of a pause request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PauseError {
    /// All steps are done, or the job is being stopped.
    Ending,
    /// The job is over.
    Ended,
}

impl PauseError {
    /// Cause in one sentence.
    #[must_use]
    pub fn sentence(self) -> Message {
        match self {
            Self::Ending => message!("the job is ending"),
            Self::Ended => message!("the job is over"),
        }
    }
}

impl fmt::Display for PauseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}

impl std::error::Error for PauseError {}

/// Error of a change of speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedError {
    /// The speed is outside 10 to 100 percent.
    Range,
    /// The job burns: at another speed the same power burns deeper or less deep.
    Burns,
    /// All steps are done, or the job is being stopped.
    Ending,
    /// The job is over.
    Ended,
}

impl SpeedError {
    /// Cause in one sentence.
    #[must_use]
    pub fn sentence(self) -> Message {
        match self {
            Self::Range => message!("the speed must be 10 to 100 percent"),
            Self::Burns => message!("the job burns: its power fits its speed only"),
            Self::Ending => message!("the job is ending"),
            Self::Ended => message!("the job is over"),
        }
    }
}

impl fmt::Display for SpeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}

impl std::error::Error for SpeedError {}

/// Error of a resume request; the job stays paused.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ResumeError {
    /// The job is not paused.
    NotPaused,
    /// The arm was reset meanwhile (alarm 0x00, or its clock restarted): home it first.
    Reset,
    /// The position of the arm or of the paused job is unknown: home the arm first.
    Unknown,
    /// Alarms that block motion.
    Alarms(AlarmSet),
    /// The arm moves, or foreign commands wait in its queue.
    Busy,
    /// An error of the arm or its line.
    Arm(Arc<Error>),
    /// The program cannot continue from there.
    Program(Diagnostic),
    /// The check refuses steps: the first one's error.
    Refused(Arc<Error>),
}

impl ResumeError {
    /// True if the arm has to be homed before the job can resume.
    #[must_use]
    pub const fn wants_homing(&self) -> bool {
        matches!(self, Self::Reset | Self::Unknown)
    }

    /// Cause in one sentence.
    #[must_use]
    pub fn sentence(&self) -> Message {
        match self {
            Self::NotPaused => message!("the job is not paused"),
            Self::Reset => {
                message!("the arm was reset while the job was paused: home it first")
            }
            Self::Unknown => message!("the arm's position is unknown: home it first"),
            Self::Alarms(alarms) => {
                message!("the arm is held by {alarms}", alarms = alarms.to_string())
            }
            Self::Busy => message!("the arm moves, or commands wait in its queue"),
            Self::Arm(error) | Self::Refused(error) => error.in_words(),
            Self::Program(problem) => problem.sentence(),
        }
    }
}

impl fmt::Display for ResumeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arm(error) | Self::Refused(error) => error.fmt(f),
            // Escapes control characters, unlike the sentence.
            Self::Program(problem) => problem.fmt(f),
            _ => f.write_str(&self.sentence()),
        }
    }
}

impl std::error::Error for ResumeError {}

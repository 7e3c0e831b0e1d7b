//! Job engine for programs on a Dobot Magician arm, shared by the command, the Python package,
//! teaching, the demonstration, and every server that runs programs.
//!
//! [`Job::start`] checks a [`Program`](magician_program::Program), runs it and counts finished
//! steps. A [`JobHandle`] pauses, resumes and stops the job from any task or thread. The job
//! restores the settings that it changes ([`SavedSettings`]) and keeps its progress in a
//! [`Journal`], so that a later job can resume it, even in another process.
//! ```
//! use magician::Arm;
//! use magician_job::{Job, JobSpec, NoJournal};
//! use magician_program::{Action, Origin, Plan, Program, Travel};
//!
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let arm = Arm::connect("sim").await?;
//! let mut plan = Plan::new("to and fro");
//! for y in [0.0, 40.0] {
//!     plan.push(Action::Move { to: [220.0, y, 20.0, 0.0], by: Travel::Line }, Origin::NONE);
//! }
//! let spec = JobSpec::new(Program::new(plan, Some(3)));
//! let job = Job::start(&arm, spec, NoJournal);
//! let done = job.outcome().await.expect("within reach");
//! assert_eq!(done.steps, 6);
//! # Ok(())
//! # }
//! ```
//!
//! # Phases of a job
//!
//! 1. Checking: nothing moves. To resume a run that burns, the job first switches the laser off and
//!    empties the queue. It then verifies that the arm is homed
//!    ([`Homing::check`](magician::Homing::check)), ready and dark, restores settings that dead
//!    processes left changed, finds the step to begin at, refuses foreign commands in the queue,
//!    and checks the program from the current pose.
//! 2. Running: the job saves the settings that it changes, and writes the journal before each step
//!    goes out.
//! 3. Ending: pen up, tool parked, settings restored, journal removed.
//!
//! After a stop or an error the job stops the arm and writes what it knows *before* anything moves.
//! Then it lifts the pen and restores the settings. [`StopRule`] decides which signals are a first
//! stop, and which are a second one, after which nothing moves.
//!
//! # Manual control
//!
//! [`jog`] models a teach pendant without its buttons, with the session that carries out its
//! orders. [`teach`] models a program that a person shows to the arm. Keys, pages and pictures are
//! built on these models. [`ObservedState`] evaluates an arm's readings: speed, freshness, and if
//! the arm stands, so that a point can be taken.
//!
//! # Recording
//!
//! With the feature `record` a `recording::Recorder` records what an arm does, moved by a job, by
//! hand or by another program: as readings, or as a program that repeats the motion.
//!
//! Errors and outcomes are data. No sentence in this crate contains a command to type: each front
//! end adds its own.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod background;
mod engine;
mod error;
mod event;
#[cfg(feature = "files")]
pub mod files;
mod handle;
#[cfg(feature = "files")]
mod homings;
pub mod jog;
mod journal;
mod observed;
#[cfg(feature = "settings")]
pub mod pens;
mod polled;
#[cfg(feature = "presets")]
pub mod presets;
#[cfg(feature = "record")]
pub mod recording;
#[cfg(feature = "report")]
pub mod report;
mod saved;
#[cfg(feature = "settings")]
pub mod settings;
mod signals;
mod spec;
pub mod teach;
mod touch;

pub use engine::{Job, MIN_REPORTED_OVERLAP};
pub use error::{
    Fault, JobError, JobOutcome, PauseError, PenLift, ResumeError, ResumePlace, SpeedError,
    StopPosition,
};
pub use event::{
    FinalState, JobEvent, JobEvents, JobProgress, JobState, JobSummary, JobWait, PauseReason,
    StartPlace,
};
pub use handle::JobHandle;
#[cfg(feature = "files")]
pub use homings::homings;
#[cfg(feature = "files")]
pub use journal::{FileJournal, InterruptedRun, interrupted_runs};
pub use journal::{InterruptedJob, Journal, JournalError, JournalKey, NoJournal};
#[cfg(feature = "files")]
pub use magician::dirs;
pub use observed::{ObservedState, Speeds};
pub use polled::Polled;
pub use saved::{Access, RecoveredSettings, SavedSettings};
pub use signals::{SECOND_STOP_DELAY, StopOrder, StopRule, StopSignal};
pub use spec::{JobSpec, Start};
pub use touch::{Touch, WorkSurface, sheet_stored_message, touch_off};
#[cfg(feature = "settings")]
pub use touch::{store_surface, stored_surface, surface_of};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

//! Programs run on a Dobot Magician arm: one engine for the command, the Python package, teaching, the
//! demonstration, and every server that runs programs.
//!
//! [`Job::start`] checks a [`Program`](magician_program::Program), runs it, counts what is done, and can be paused, resumed and
//! stopped from anywhere by a [`JobHandle`]. What a job changes of the arm's settings it restores ([`SavedSettings`]), and how
//! far it has come it keeps ([`Journal`]), so that another one can go on where it ended, also in another process.
//!
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
//! # What a job does, in this order
//!
//! 1. Checking: nothing moves. Of an earlier run that burnt the laser is switched off and the queue emptied, if it is resumed;
//!    the arm is known to be homed ([`Homing::check`](magician::Homing::check)), ready and dark; settings that ended processes have left changed are restored; the place to begin at is
//!    found; no foreign commands wait; the program is checked from where the arm stands.
//! 2. Running: the settings that it changes are saved, the journal is written before each step goes out.
//! 3. Ending: pen up, tool parked, settings restored, the journal removed.
//!
//! After a stop or an error the arm is stopped, what is known is kept *before* anything moves, then the pen goes up and the
//! settings are restored. Which signals are such a stop, and which a second one that moves nothing, is a [`StopRule`].
//!
//! # By hand
//!
//! [`jog`] is a teach pendant without its buttons, and the session that carries out its orders; [`teach`] is a program that a person
//! shows the arm. Both are models: keys, pages and pictures are made over them. [`ObservedState`] is what the readings of an arm
//! come to: whether it stands, so that a point can be taken of it.
//!
//! # On record
//!
//! With the feature `record` a `recording::Recorder` records what an arm does, moved by a job, by hand or by another program: readings, or a program that
//! repeats the motion.
//!
//! Errors and outcomes are data. No sentence in this crate tells a person what to type: each program has its own words.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod beside;
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

pub use engine::{Job, NOTICEABLE};
pub use error::{
    Fault, JobError, JobOutcome, Left, PauseError, PenLift, ResumeError, SpeedError, Stood,
};
pub use event::{
    Done, End, JobEvent, JobEvents, JobProgress, JobState, PauseReason, StartsAt, Waits,
};
pub use handle::JobHandle;
#[cfg(feature = "files")]
pub use homings::homings;
#[cfg(feature = "files")]
pub use journal::{FileJournal, LeftRun, left_runs};
pub use journal::{InterruptedJob, Journal, JournalError, JournalKey, NoJournal};
#[cfg(feature = "files")]
pub use magician::dirs;
pub use observed::{ObservedState, Speeds};
pub use polled::Polled;
pub use saved::{Access, SavedSettings, Settled};
pub use signals::{SECOND_STOP_DELAY, StopOrder, StopRule, StopSignal};
pub use spec::{JobSpec, Start};
pub use touch::{Touch, WorkSurface, sheet_counts, touch_off};
#[cfg(feature = "settings")]
pub use touch::{keep_surface, kept_surface, surface_of};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

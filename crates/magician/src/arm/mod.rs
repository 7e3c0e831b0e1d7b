//! The async handle [`Arm`] and its driver task.
//!
//! An arm's line is owned by one task (`driver`), which runs the protocol engine of `magician-host`
//! on it. Handles never touch the line: a call checks its command (`permission`, `fence`), sends a
//! message to the task and waits for the answer (`request`). What both sides know (the picture of
//! the arm, the jog gate, the counters of stops) is in `shared`. Everything a caller can do is a
//! method of [`Arm`] or of one of its parts, in a file each: motion in `run` and `perform`, jogs in
//! `jog` (the arm's own) and `bounded_jog` (short pieces), stops in `halt`, waits in `watch`, the
//! queue, laser, pins and homing in files of these names.

// First, so that its methods come first on the documentation page of `Arm`.
mod first_program;

mod bounded_jog;
mod connect;
mod disruptions;
mod driver;
mod end_notice;
mod events;
mod fence;
mod fenced_jog;
mod flow;
mod front_end;
mod gate;
mod halt;
mod homing;
mod jog;
mod known;
mod laser;
mod link;
mod options;
mod perform;
mod permission;
mod pins;
mod queue;
mod request;
mod retract;
mod run;
mod samples;
mod settings_backup;
mod shared;
mod state;
mod verbs;
mod watch;

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64};
use std::time::Duration;

use tokio::sync::mpsc;

use driver::Message;
pub(crate) use driver::SHUTDOWN;
pub use end_notice::EndNotice;
pub use events::{Event, Events};
use flow::Flow;
#[doc(hidden)]
pub use front_end::FrontEnd;
pub use gate::Motors;
pub use halt::Stopper;
pub use homing::{ArmIdentity, ClockRate, Homing, HomingRecord};
pub use jog::{Jog, JogOptions};
pub use laser::Laser;
pub use link::Link;
pub use options::Options;
#[doc(hidden)]
pub use permission::Permission;
pub use pins::Pins;
pub use queue::Queue;
pub use retract::LiftResult;
pub use run::{CommandSource, Feeder, Run, RunOptions, RunSummary, Streaming};
pub use samples::{Sample, Samples};
pub use settings_backup::SettingsBackup;
use shared::Shared;
pub use state::{StateOptions, StateWatch, Status};
pub use watch::Progress;

/// A connection to an arm, for async programs on tokio. [`blocking::Arm`](crate::blocking::Arm) is
/// the same for programs without a runtime.
///
/// | to | call |
/// |---|---|
/// | move, and wait for the end | [`home`](Self::home), [`move_to`](Self::move_to), [`line_to`](Self::line_to), [`run`](Self::run) |
/// | start without waiting | [`start`](Self::start), [`stream`](Self::stream), [`jog`](Self::jog) |
/// | stop | [`stop`](Self::stop), [`stopper`](Self::stopper) |
/// | read | [`pose`](Self::pose), [`alarms`](Self::alarms), [`outputs`](Self::outputs), [`state`](Self::state), [`events`](Self::events) |
/// | access its parts | [`queue`](Self::queue), [`laser`](Self::laser), [`homing`](Self::homing), [`pins`](Self::pins), [`motors`](Self::motors) |
/// | send a single command of the protocol | [`get`](Self::get), [`set`](Self::set), [`enqueue`](Self::enqueue) |
///
/// [`build`](crate::build) makes the commands for [`run`](Self::run) and
/// [`enqueue`](Self::enqueue).
///
/// Every call returns by its deadline, with an answer or an error. All methods take `&self`; a
/// [`stop`](Self::stop) from another task overtakes pending requests.
///
/// Clones are cheap, share the connection, and may be used from any task and thread. One task owns
/// the line and serves the requests of all clones in turn. When the *last* clone is dropped, the
/// arm stops every motion and motor output that this connection started and has not seen finished,
/// and switches the laser off if it was lit over this connection. After [`detach`](Self::detach)
/// the motion continues instead; [`close`](Self::close) ends the connection without waiting for the
/// last clone.
///
/// A line that breaks is reconnected ([`Options::reconnect`]); [`link`](Self::link) returns its
/// state.
///
/// ```
/// use magician::commands::{Pose, PtpCommonParams};
/// use magician::{Arm, build};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = Arm::connect("sim").await?;
/// arm.set(&PtpCommonParams { velocity_ratio: 80.0, acceleration_ratio: 80.0 }).await?;
/// arm.run(&[build::move_to(200.0, 50.0, 20.0, 0.0)]).await?;
/// let pose: Pose = arm.get().await?;
/// assert_eq!((pose.x, pose.y, pose.z), (200.0, 50.0, 20.0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Arm {
    inner: Arc<Inner>,
    /// True if calls of this handle may light the laser of a real arm.
    allows_laser: bool,
    /// True if calls of this handle may send a raw jog, which has no hold time.
    passes_jogs: bool,
    /// True for the handle that a bounded jog uses itself: its calls do not wait for the end of
    /// that jog.
    leads: bool,
    /// True if calls of this handle accept an arm not known to be homed.
    allows_unhomed: bool,
    /// Minimum timeout of calls of this handle, if longer than [`Options::timeout`].
    patience: Duration,
}

/// State shared by the clones of a handle.
#[derive(Debug)]
struct Inner {
    messages: mpsc::Sender<Message>,
    shared: Arc<Shared>,
    flow: tokio::sync::Mutex<Flow>,
    options: Options,
    /// The fence, if any, with the planned path it is checked against.
    held: fence::FenceState,
    /// True if the arm is a virtual one in this process.
    in_process: bool,
    /// The virtual arm in this process, if it is one.
    #[cfg(feature = "sim")]
    virtual_arm: Option<crate::VirtualArm>,
    /// [`Options::timeout`] as currently set, in microseconds.
    timeout: AtomicU64,
    /// Kind of programs for which the alarms were already read: [`homing::READ_WITHOUT_MOTION`]
    /// after a program without motion, [`homing::READ_FOR_MOTION`] after one with motion. 0 before
    /// the first.
    reset_asked: AtomicU8,
}

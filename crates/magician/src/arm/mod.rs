// First, so that its methods come first on the page of `Arm`.
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
pub use retract::Lifted;
pub use run::{CommandSource, Feeder, Ran, Run, RunOptions, Streaming};
pub use samples::{Sample, Samples};
pub use settings_backup::SettingsBackup;
use shared::Shared;
pub use state::{StateOptions, StateWatch, Status};
pub use watch::Progress;

/// An arm, for async programs on tokio. [`blocking::Arm`](crate::blocking::Arm) is the same for
/// programs without.
///
/// | to | call |
/// |---|---|
/// | move it, and wait until it is there | [`home`](Self::home), [`move_to`](Self::move_to), [`line_to`](Self::line_to), [`run`](Self::run) |
/// | begin without waiting | [`start`](Self::start), [`stream`](Self::stream), [`jog`](Self::jog) |
/// | stop it | [`stop`](Self::stop), [`stopper`](Self::stopper) |
/// | look | [`pose`](Self::pose), [`alarms`](Self::alarms), [`outputs`](Self::outputs), [`state`](Self::state), [`events`](Self::events) |
/// | reach its parts | [`queue`](Self::queue), [`laser`](Self::laser), [`homing`](Self::homing), [`pins`](Self::pins), [`motors`](Self::motors) |
/// | send one command of the protocol as it is | [`get`](Self::get), [`set`](Self::set), [`enqueue`](Self::enqueue) |
///
/// [`build`](crate::build) makes commands of intentions, for [`run`](Self::run) and [`enqueue`](Self::enqueue).
///
/// Every call ends: by its answer, or with an error by its deadline. All methods take `&self`;
/// a [`stop`](Self::stop) from another task overtakes whatever is going on.
///
/// Clones are cheap, share the connection, and may be used from any task and thread. One task owns the line; what
/// several clones ask takes turns on it. When the *last* clone is dropped, the arm stops what this connection set going
/// and has not seen finished, its motor outputs among it, and the laser goes out if it was switched on here.
/// [`detach`](Self::detach) lets it go on,
/// [`close`](Self::close) does not wait for the last clone.
///
/// A line that breaks is looked for again ([`Options::reconnect`]); [`link`](Self::link) says how it stands.
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
    /// Whether calls of this handle may light the laser of a real arm.
    allows_laser: bool,
    /// True if calls of this handle may send a jog that nothing holds.
    passes_jogs: bool,
    /// True for the handle of a jog in pieces: its calls do not wait for the end of that jog.
    leads: bool,
    /// Whether calls of this handle take an arm that is not known to be homed.
    allows_unhomed: bool,
    /// How long calls of this handle may take, if that is longer than [`Options::timeout`].
    patience: Duration,
}

/// What the clones of a handle share.
#[derive(Debug)]
struct Inner {
    messages: mpsc::Sender<Message>,
    shared: Arc<Shared>,
    flow: tokio::sync::Mutex<Flow>,
    options: Options,
    /// The fence, if there is one, with what is known of the arm's way.
    held: fence::Held,
    /// The arm is a virtual one in this process.
    in_process: bool,
    /// That arm.
    #[cfg(feature = "sim")]
    virtual_arm: Option<crate::VirtualArm>,
    /// [`Options::timeout`] as it is now, in microseconds.
    timeout: AtomicU64,
    /// For which programs the alarms were read before the first of them: [`homing::ASKED`] for one that moves nothing,
    /// [`homing::WARNED`] for all.
    reset_asked: AtomicU8,
}

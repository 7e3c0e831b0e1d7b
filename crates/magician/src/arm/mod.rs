mod connect;
mod driver;
mod exposure;
mod flow;
mod halt;
mod options;
mod queue;
mod request;
mod verbs;
mod watch;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use driver::Message;
use exposure::Exposure;
use flow::Flow;
pub use flow::{Ran, RunOptions};
pub use options::Options;
pub use watch::Progress;

/// What a handle and its task both know.
#[derive(Debug, Default)]
struct Shared {
    detached: AtomicBool,
    /// Stops so far. What was begun before the last one is over.
    stops: AtomicU64,
    exposure: Mutex<Exposure>,
    /// What nobody has been told yet.
    mishap: Mutex<Option<Mishap>>,
}

/// What befell the queue without a word from this handle.
#[derive(Clone, Copy, Debug)]
enum Mishap {
    /// The arm was reset; these indices had not finished.
    Reset(Option<(u64, u64)>),
    /// The arm gave these indices to commands that this handle did not send, or sent once.
    Unaccounted { from: u64, to: u64 },
}

impl Shared {
    /// Ends what is going on as a stop does; the next wait or run tells why.
    fn mishap(&self, mishap: Mishap) {
        *self.mishap.lock().unwrap_or_else(PoisonError::into_inner) = Some(mishap);
        self.stops.fetch_add(1, Ordering::SeqCst);
    }
}

/// An arm, for async programs on tokio. [`blocking::Arm`](crate::blocking::Arm) is the same for
/// programs without.
///
/// The three verbs are [`get`](Self::get), [`set`](Self::set) and [`enqueue`](Self::enqueue). They
/// send what they are given. [`words`](crate::words) makes commands from intentions, and
/// [`run`](Self::run) and [`perform`](Self::perform) keep any number of them flowing.
///
/// Every call ends: by its answer, or with an error by its deadline. All methods take `&self`;
/// a [`stop`](Self::stop) from another task overtakes whatever is going on.
///
/// When the handle is dropped, the arm stops what this handle set going and has not seen finished,
/// and the laser goes out if this handle switched it on. [`detach`](Self::detach) lets it go on.
///
/// ```
/// use magician::commands::{Pose, PtpCommonParams};
/// use magician::{Arm, words};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = Arm::connect(&"sim".parse()?).await?;
/// arm.set(&PtpCommonParams { velocity_ratio: 80.0, acceleration_ratio: 80.0 }).await?;
/// arm.perform(&[words::move_to(200.0, 50.0, 20.0, 0.0)]).await?;
/// let pose: Pose = arm.get().await?;
/// assert_eq!((pose.x, pose.y, pose.z), (200.0, 50.0, 20.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Arm {
    /// `None` only while the handle is being closed.
    messages: Option<mpsc::Sender<Message>>,
    task: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    flow: tokio::sync::Mutex<Flow>,
    own: Mutex<watch::Own>,
    options: Options,
    name: String,
    /// The warning that the arm may not be homed was given.
    warned: AtomicBool,
}

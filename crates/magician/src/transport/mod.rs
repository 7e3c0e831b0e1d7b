//! Transports: each moves bytes to an arm and back, and knows nothing of their meaning.
//!
//! A transport does not time out: deadlines are the connection's task. It reports that the other
//! end is gone, as far as the system knows: an unplugged adapter and a closed TCP connection are
//! noticed, a datagram without a receiver is not.

#[cfg(feature = "ble")]
mod ble;
#[cfg(feature = "faults")]
mod faulty;
#[cfg(feature = "lines")]
mod lines;
#[cfg(all(unix, feature = "lines"))]
mod read_gap;
mod route;
#[cfg(feature = "lines")]
mod search;
#[cfg(feature = "lines")]
mod serial;
#[cfg(feature = "sim")]
mod sim;
mod stream;
#[cfg(feature = "lines")]
mod tcp;
#[cfg(feature = "trace")]
mod traced;
#[cfg(feature = "lines")]
mod udp;

use std::io;
use std::task::{Context, Poll};
use std::time::Duration;

use crate::connection::Settings;

#[cfg(all(test, unix, feature = "lines"))]
pub(crate) use read_gap::ReadGap;
pub(crate) use route::Route;
#[cfg(feature = "sim")]
pub(crate) use sim::Sim;
pub(crate) use stream::Stream;
#[cfg(feature = "trace")]
pub use traced::{Tap, Tracer};

/// Step of an arm's clock where it follows the wall clock. Choice: a longer leap could skip the end
/// of an event.
pub(crate) const STEP: Duration = Duration::from_millis(10);

/// Line to the arm. Both methods are polled from one task; a pending one must wake it.
pub(crate) trait Transport: Send {
    /// Reads arrived bytes; 0 if the other end is gone. After a long time without reads the system
    /// is asked directly and not only the reactor (`read_gap.rs`): read until pending before acting on
    /// a timeout.
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>>;

    /// Makes the next read ask the system directly, however recent the last one was.
    fn ask(&mut self) {}

    /// Writes bytes from the front of one frame.
    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>>;

    /// Takes or returns control of the arm's clock: while taken, time passes only by
    /// [`leap`](Self::leap). Returns true if taken; only an arm in virtual time supports it.
    fn lead(&mut self, _leads: bool) -> bool {
        false
    }

    /// Lets up to `most` of the arm's time pass at once, less if bytes arrive or the event `to`
    /// comes first. Returns `None` if nothing passes, because the arm is at rest or bytes are
    /// delayed in wall-clock time.
    fn leap(&mut self, _most: Duration, _to: LeapTo) -> Option<Leap> {
        None
    }
}

/// Event that ends a leap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LeapTo {
    /// The arm comes to rest.
    Rest,
    /// The arm comes to rest, or a queued command ends.
    End,
    /// None: the time passes for an arm at rest, too.
    Instant,
}

/// Time that has passed for an arm in virtual time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leap {
    pub(crate) time: Duration,
    /// True if the leap ended with its event, or the arm has nothing left to do.
    pub(crate) news: bool,
}

/// Open line with its settings.
pub(crate) struct Line {
    pub(crate) transport: Box<dyn Transport>,
    pub(crate) settings: Settings,
    /// Name in messages.
    pub(crate) name: String,
    /// Attempt in words, for the message that nothing answers.
    pub(crate) tried: &'static str,
    /// True if it leads to a virtual arm in this process, where nothing burns.
    pub(crate) in_process: bool,
    /// The virtual arm in this process, if it is one.
    #[cfg(feature = "sim")]
    pub(crate) arm: Option<crate::VirtualArm>,
    /// True if others may talk to the arm while this line is open.
    pub(crate) is_shared: bool,
}

/// Opens a serial port at another baud rate than the arm's.
#[cfg(feature = "lines")]
pub(crate) fn serial_at(path: &str, baud: u32) -> crate::Result<Box<dyn Transport>> {
    Ok(Box::new(serial::open_at(path, baud)?))
}

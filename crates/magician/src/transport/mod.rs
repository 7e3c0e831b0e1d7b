//! Ways to an arm: each moves bytes and knows nothing of what they mean.
//!
//! None of them ends a wait for an answer: that is the connection's, by its deadlines. They tell
//! when the other end is gone, as far as the system knows: a pulled plug and a closed TCP
//! connection are noticed, a datagram without a receiver is not.

#[cfg(all(unix, feature = "lines"))]
mod away;
#[cfg(feature = "ble")]
mod ble;
#[cfg(feature = "faults")]
mod faulty;
#[cfg(feature = "lines")]
mod lines;
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
pub(crate) use away::Away;
pub(crate) use route::Route;
#[cfg(feature = "sim")]
pub(crate) use sim::Sim;
pub(crate) use stream::Stream;
#[cfg(feature = "trace")]
pub use traced::{Tap, Tracer};

/// How far the clock of an arm goes on at a time where it goes on by the wall: a leap that is longer is over what has an end.
pub(crate) const STEP: Duration = Duration::from_millis(10);

/// A line to the arm. Both methods are polled from one task; what one leaves pending must wake it.
pub(crate) trait Transport: Send {
    /// Bytes that have come; 0: the other end is gone. After a long time without reads the system is asked and not only the
    /// reactor (`away.rs`): read until it is pending before you act on a timeout.
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>>;

    /// The next read asks the system and not only the reactor, however recent the last one was.
    fn ask(&mut self) {}

    /// Takes bytes from the front of one frame.
    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>>;

    /// Has the arm's clock pass from now on only as [`leap`](Self::leap) says, or has it its own way again; whether it obeys.
    /// Only an arm in virtual time does.
    fn lead(&mut self, _leads: bool) -> bool {
        false
    }

    /// Lets so much of the arm's time pass at once, less if something comes or what it is to end at comes before. `None`: nothing
    /// passes, because the arm rests already or bytes are under way in wall time.
    fn leap(&mut self, _most: Duration, _to: LeapTo) -> Option<Leap> {
        None
    }
}

/// What a leap of an arm's time ends at, if not before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LeapTo {
    /// The arm comes to rest.
    Rest,
    /// The same, or the end of a queued command.
    End,
    /// Nothing: the time passes for an arm at rest, too.
    Instant,
}

/// Time of an arm in virtual time that has passed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leap {
    pub(crate) time: Duration,
    /// It ends with what was of interest, or the arm has nothing to do any more.
    pub(crate) news: bool,
}

/// An open line and how to treat it.
pub(crate) struct Line {
    pub(crate) transport: Box<dyn Transport>,
    pub(crate) settings: Settings,
    /// What to call it in messages.
    pub(crate) name: String,
    /// What was tried, for the message that nothing answers.
    pub(crate) tried: &'static str,
    /// It leads to a virtual arm in this process: nothing burns there.
    pub(crate) in_process: bool,
    /// That arm.
    #[cfg(feature = "sim")]
    pub(crate) arm: Option<crate::VirtualArm>,
    /// Others may speak to the arm as well while this line is open.
    pub(crate) is_shared: bool,
}

/// Opens a serial port at another speed than the arm's.
#[cfg(feature = "lines")]
pub(crate) fn serial_at(path: &str, baud: u32) -> crate::Result<Box<dyn Transport>> {
    Ok(Box::new(serial::open_at(path, baud)?))
}

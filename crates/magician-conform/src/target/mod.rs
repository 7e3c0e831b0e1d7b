//! Arms on which cases can be run.

mod line;
mod sim;

use std::future::Future;
use std::time::Duration;

use magician::Result;
use magician_sim::{ArmInstant, ExternalEvent, World};

use crate::step::Observable;
pub use line::{LINE_LOOK, LineTarget};
pub use sim::SimTarget;

/// Arm with its clock: bytes are exchanged, and time passes.
///
/// A target is *stepped* if its clock only advances on request, like that of an in-process virtual
/// arm. Otherwise it follows the wall clock, and bytes take their time.
pub trait Target {
    /// Sends bytes to the arm.
    fn send(&mut self, bytes: &[u8]) -> impl Future<Output = Result<()>>;

    /// Returns received bytes as soon as there are any; empty if none arrive in time.
    fn receive(&mut self, within: Duration) -> impl Future<Output = Result<Vec<u8>>>;

    /// Lets time pass.
    fn pass(&mut self, span: Duration) -> impl Future<Output = Result<()>>;

    /// Lets time pass until something may have changed, at most `at_most`. A stepped clock jumps to
    /// the next event.
    fn go_on(&mut self, at_most: Duration) -> impl Future<Output = Result<()>>;

    // The following needs more than a line to the arm, so a line target supports none of it.

    /// Returns the arm's clock if this target steps it.
    fn stepped(&self) -> Option<ArmInstant> {
        None
    }

    /// Replaces the arm by one just after power-up in this world; false if unsupported.
    fn power_up(&mut self, _: World) -> bool {
        false
    }

    /// Injects an external event; false if unsupported.
    fn happens(&mut self, _: ExternalEvent) -> bool {
        false
    }

    /// Returns an output seen from outside; `None` if unsupported.
    fn sees(&mut self, _: Observable) -> Option<f64> {
        None
    }

    /// Switches to another of the arm's links; false if it has none.
    fn select(&mut self, link: u8) -> bool {
        link == 0
    }
}

//! The arms that cases can be run on.

mod line;
mod sim;

use std::future::Future;
use std::time::Duration;

use magician::Result;
use magician_sim::{ArmInstant, ExternalEvent, World};

use crate::step::Observable;
pub use line::{LINE_LOOK, LineTarget};
pub use sim::SimTarget;

/// An arm and its clock. Bytes go to the arm and come back, and time passes.
///
/// A target is *stepped* when its clock stands still until it is told to go on, as that of a virtual arm inside this
/// program; otherwise the clock is the wall's and the bytes take their time.
pub trait Target {
    /// Sends bytes to the arm.
    fn send(&mut self, bytes: &[u8]) -> impl Future<Output = Result<()>>;

    /// The bytes that have come, as soon as there are any; nothing when none came within that time.
    fn receive(&mut self, within: Duration) -> impl Future<Output = Result<Vec<u8>>>;

    /// Lets time pass.
    fn pass(&mut self, span: Duration) -> impl Future<Output = Result<()>>;

    /// Lets time pass until something may have changed, at most that long. A stepped clock jumps to the next event.
    fn go_on(&mut self, at_most: Duration) -> impl Future<Output = Result<()>>;

    // What follows needs more than a line to the arm: a target at the end of one has none of it.

    /// The arm's clock, if this target steps it.
    fn stepped(&self) -> Option<ArmInstant> {
        None
    }

    /// Puts an arm there that has just been switched on, in this world; whether that can be done.
    fn power_up(&mut self, _: World) -> bool {
        false
    }

    /// Lets something happen to the arm from outside its protocol; whether that can be done.
    fn happens(&mut self, _: ExternalEvent) -> bool {
        false
    }

    /// A number that an observer of the arm sees, if there can be one.
    fn sees(&mut self, _: Observable) -> Option<f64> {
        None
    }

    /// Takes another of the arm's links from here on; whether there are any.
    fn select(&mut self, link: u8) -> bool {
        link == 0
    }
}

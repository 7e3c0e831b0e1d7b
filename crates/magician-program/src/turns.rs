//! Cooperative computation: long work yields between slices, so that even without threads the arm
//! is still served and a stop takes effect.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Steps of a plan processed between two yields: 10 to 20 ms in a browser.
pub(crate) const STEPS_PER_SLICE: usize = 8192;

/// Yield points of a long computation.
pub trait Turns: Sync {
    /// Yields once.
    fn give(&self) -> impl Future<Output = ()> + Send;
}

/// Never yields: the computation runs in one go.
#[derive(Clone, Copy, Debug, Default)]
pub struct AtOnce;

impl Turns for AtOnce {
    async fn give(&self) {}
}

/// Runs a computation to its end. The computation must never wait.
///
/// ```
/// use magician_program::turns::{AtOnce, Turns, at_once};
///
/// let sum = at_once(async {
///     AtOnce.give().await;
///     1 + 1
/// });
/// assert_eq!(sum, 2);
/// ```
pub fn at_once<T>(computing: impl Future<Output = T>) -> T {
    let mut computing = pin!(computing);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(done) = computing.as_mut().poll(&mut context) {
            return done;
        }
    }
}

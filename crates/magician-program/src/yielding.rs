//! Cooperative computation: long work yields between slices, so that even without threads the arm
//! is still served and a stop takes effect.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Steps of a plan processed between two yields: 10 to 20 ms in a browser.
pub(crate) const STEPS_PER_SLICE: usize = 8192;

/// Yield points of a long computation.
pub trait Yield: Sync {
    /// Yields once.
    fn yield_now(&self) -> impl Future<Output = ()> + Send;
}

/// Never yields: the computation runs in one go.
#[derive(Clone, Copy, Debug, Default)]
pub struct NeverYield;

impl Yield for NeverYield {
    async fn yield_now(&self) {}
}

/// Runs a computation to its end. The computation must never wait.
///
/// ```
/// use magician_program::yielding::{NeverYield, Yield, run_to_end};
///
/// let sum = run_to_end(async {
///     NeverYield.yield_now().await;
///     1 + 1
/// });
/// assert_eq!(sum, 2);
/// ```
pub fn run_to_end<T>(computing: impl Future<Output = T>) -> T {
    let mut computing = pin!(computing);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(done) = computing.as_mut().poll(&mut context) {
            return done;
        }
    }
}

//! Long computing that gives others a turn: where there are no threads, an arm is served and a stop is heard between two slices of it.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// So many steps of a plan are taken at a stretch: 10 to 20 ms in a browser.
pub(crate) const SLICE: usize = 8192;

/// Who gets a turn between the slices of something that takes long.
pub trait Turns: Sync {
    /// Gives them one.
    fn give(&self) -> impl Future<Output = ()> + Send;
}

/// Nobody: it is computed at one go.
#[derive(Clone, Copy, Debug, Default)]
pub struct AtOnce;

impl Turns for AtOnce {
    async fn give(&self) {}
}

/// What a computation comes to that waits for nobody.
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

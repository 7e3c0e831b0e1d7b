//! Long computations off the runtime's tasks: on a blocking thread, or in slices where threads do
//! not exist.

use std::future::Future;

use magician::Error;
use magician_program::yielding::Yield;

/// Yield points of a computation that runs by [`run_in_background`].
#[derive(Clone, Copy, Debug)]
pub struct BackgroundTurns;

#[cfg(not(any(target_family = "wasm", feature = "single-thread")))]
impl Yield for BackgroundTurns {
    async fn yield_now(&self) {}
}

#[cfg(any(target_family = "wasm", feature = "single-thread"))]
thread_local! {
    /// Wakes a computation that waits for its next slice, if the program drives this thread's
    /// runtime by hand.
    static NEXT: std::cell::OnceCell<std::sync::Arc<tokio::sync::Notify>> = const { std::cell::OnceCell::new() };
}

/// Advances the computations of [`run_in_background`] by one slice.
///
/// A program that drives its runtime by hand calls this at the end of each turn.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
pub fn next_turn() {
    NEXT.with(|next| next.get_or_init(Default::default).notify_waiters());
}

#[cfg(any(target_family = "wasm", feature = "single-thread"))]
impl Yield for BackgroundTurns {
    async fn yield_now(&self) {
        // A runtime driven by hand needs its own signal here. With a yield or a timer the runtime
        // would run as many slices between two checks for a stop as time has passed since the last
        // check, and that grows with every turn.
        match NEXT.with(|next| next.get().cloned()) {
            Some(next) => next.notified().await,
            None => tokio::task::yield_now().await,
        }
    }
}

/// Runs a computation that waits for nothing but its [`BackgroundTurns`] on a blocking thread.
///
/// # Errors
/// [`Closed`](magician::ErrorCode::Closed) if the runtime ends first.
#[cfg(not(any(target_family = "wasm", feature = "single-thread")))]
pub async fn run_in_background<T: Send + 'static>(
    computing: impl Future<Output = T> + Send + 'static,
) -> Result<T, Error> {
    let at_once = || magician_program::yielding::run_to_end(computing);
    let computed = tokio::task::spawn_blocking(at_once).await;
    computed.map_err(|error| Error::new(magician::ErrorCode::Closed, error.to_string()))
}

/// Runs a computation that waits for nothing but its [`BackgroundTurns`], in slices on this thread.
///
/// # Errors
/// Never fails: the signature is that of the threaded version.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
pub async fn run_in_background<T>(computing: impl Future<Output = T>) -> Result<T, Error> {
    tokio::task::yield_now().await;
    Ok(computing.await)
}

//! Long computations beside the tasks of the runtime: on a thread of their own, or in slices where threads do not exist.

use std::future::Future;

use magician::Error;
use magician_program::turns::Turns;

/// The turns of what is computed [`beside`].
#[derive(Clone, Copy, Debug)]
pub struct BesideTurns;

#[cfg(not(any(target_family = "wasm", feature = "single-thread")))]
impl Turns for BesideTurns {
    async fn give(&self) {}
}

#[cfg(any(target_family = "wasm", feature = "single-thread"))]
thread_local! {
    /// Wakes who waits for the next turn, where this thread's runtime is turned by hand.
    static NEXT: std::cell::OnceCell<std::sync::Arc<tokio::sync::Notify>> = const { std::cell::OnceCell::new() };
}

/// Lets computations [`beside`] the tasks advance by one slice. Call it at the end of each turn if the runtime is turned by hand.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
pub fn next_turn() {
    NEXT.with(|next| next.get_or_init(Default::default).notify_waiters());
}

#[cfg(any(target_family = "wasm", feature = "single-thread"))]
impl Turns for BesideTurns {
    async fn give(&self) {
        // Where somebody turns it, neither a yield nor a timer would do: as much runs between two looks for a stop as time has passed
        // since the last, and that is more each time.
        match NEXT.with(|next| next.get().cloned()) {
            Some(next) => next.notified().await,
            None => tokio::task::yield_now().await,
        }
    }
}

/// Computes what waits for nothing but its [`BesideTurns`].
///
/// # Errors
/// [`Closed`](magician::ErrorCode::Closed) where the runtime ends before.
#[cfg(not(any(target_family = "wasm", feature = "single-thread")))]
pub async fn beside<T: Send + 'static>(
    computing: impl Future<Output = T> + Send + 'static,
) -> Result<T, Error> {
    let at_once = || magician_program::turns::at_once(computing);
    let computed = tokio::task::spawn_blocking(at_once).await;
    computed.map_err(|error| Error::new(magician::ErrorCode::Closed, error.to_string()))
}

/// Computes what waits for nothing but its [`BesideTurns`].
///
/// # Errors
/// None.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
pub async fn beside<T>(computing: impl Future<Output = T>) -> Result<T, Error> {
    tokio::task::yield_now().await;
    Ok(computing.await)
}

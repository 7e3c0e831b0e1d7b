//! Long computing beside the tasks of the runtime: on a thread of its own, or in slices where there are none.

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

/// Who waits for the next turn.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
static NEXT: tokio::sync::Notify = tokio::sync::Notify::const_new();

/// Whoever turns the runtime by hand has done all else that was due: what is computed [`beside`] goes on by one slice.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
pub fn next_turn() {
    NEXT.notify_waiters();
}

/// Nobody turns it: it goes on by itself, after so long.
#[cfg(any(target_family = "wasm", feature = "single-thread"))]
const ALONE: std::time::Duration = std::time::Duration::from_secs(1);

#[cfg(any(target_family = "wasm", feature = "single-thread"))]
impl Turns for BesideTurns {
    async fn give(&self) {
        // Neither a yield nor a timer would do: as much runs between two looks for a stop as time has passed since the last, and that
        // is more each time.
        let _ = tokio::time::timeout(ALONE, NEXT.notified()).await;
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
    BesideTurns.give().await;
    Ok(computing.await)
}

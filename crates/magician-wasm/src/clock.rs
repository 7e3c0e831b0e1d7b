//! The module's clock, and the turns of its runtime.
//!
//! Driver, engine and station wait on tokio's timers. On wasm32-wasip1 tokio's clock reads
//! `clock_time_get`, and an idle runtime sleeps in `poll_oneoff`, which would block the worker. So
//! the clock is paused and advanced to the `now` of each turn, and the runtime's main future
//! only yields and never waits. At each yield the runtime polls its timers and does not park,
//! because tokio's scheduler parks only if nothing is woken and nothing is deferred. A turn
//! therefore takes only the time of its work and depends only on its inputs, and tests run the same
//! code without sleeping.

use std::time::Duration;

use tokio::task::yield_now;
use tokio::time::advance;

/// Step in which time advances: the granularity of tokio's timers.
const STEP: Duration = Duration::from_millis(1);
/// Largest number of steps per turn. After a page was suspended, the time beyond these steps passes
/// before them, in one leap.
const MAX_STEPS: u32 = 64;
/// Longest time that one turn lets pass.
const MAX_TURN_TIME: Duration = Duration::from_secs(3600);
/// Largest `now`, us: about 300 years.
const MAX_NOW: f64 = 1e16;
/// Rounds of the runtime per step. In each round it runs up to 61 woken tasks and polls its timers
/// once.
const ROUNDS_PER_STEP: u32 = 2;
/// Rounds at the end of a turn, in which chains of tasks that wake each other finish.
const FINAL_ROUNDS: u32 = 24;

/// Position of the module's clock.
#[derive(Debug, Default)]
pub(crate) struct TurnClock {
    /// `now` of the first turn, us.
    started_at: Option<f64>,
    passed: Duration,
}

impl TurnClock {
    /// Returns the current instant on the page's clock, us.
    pub(crate) fn now(&self) -> f64 {
        self.started_at.unwrap_or(0.0) + self.passed.as_micros() as f64
    }

    /// Advances to `now` and runs everything due on the way. A `now` in the past or not finite
    /// advances nothing.
    pub(crate) async fn advance(&mut self, now: f64) {
        let now = if now.is_finite() {
            now.clamp(0.0, MAX_NOW)
        } else {
            self.now()
        };
        let begun = *self.started_at.get_or_insert(now);
        let target = Duration::from_micros((now - begun).max(0.0) as u64);
        let mut left = target.saturating_sub(self.passed).min(MAX_TURN_TIME);
        self.passed += left;
        let leap = left.saturating_sub(STEP * MAX_STEPS);
        if !leap.is_zero() {
            // Timers that became due during the leap fire before the last steps pass one by one.
            advance(leap).await;
            rounds(FINAL_ROUNDS).await;
            left -= leap;
        }
        while !left.is_zero() {
            let step = left.min(STEP);
            advance(step).await;
            rounds(ROUNDS_PER_STEP).await;
            left -= step;
        }
    }
}

/// Runs woken tasks for a few rounds.
pub(crate) async fn settle() {
    rounds(FINAL_ROUNDS).await;
}

async fn rounds(count: u32) {
    for _ in 0..count {
        yield_now().await;
    }
}

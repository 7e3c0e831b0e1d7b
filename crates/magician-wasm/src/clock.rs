//! What time it is, and the turns of the runtime.
//!
//! The driver, the engine and the station wait by tokio's timers. On wasm32-wasip1 tokio's clock reads `clock_time_get`, and an idle runtime
//! sleeps in `poll_oneoff`, which stops the worker. Here the clock is paused and put forward to the `now` of each turn, and
//! the runtime is only asked while its main future yields: then it polls its timers and never parks (tokio's scheduler parks only
//! with nothing woken and nothing deferred). So a turn takes no time but that of its work, all of it follows from what was handed
//! in, and the tests turn the same code without sleeping.

use std::time::Duration;

use tokio::task::yield_now;
use tokio::time::advance;

/// How finely time passes: timers of tokio have no finer grain.
const STEP: Duration = Duration::from_millis(1);
/// So much of a turn's time passes in steps; what is more, behind a page that was asleep, in one leap before.
const STEPS: u32 = 64;
/// A turn lets no more time than this pass.
const LONGEST: Duration = Duration::from_secs(3600);
/// `now` does not go beyond this, us: 300 years.
const LAST: f64 = 1e16;
/// Rounds of the runtime for each step of time: in a round it runs what is woken, up to 61 tasks, and polls its timers once.
const ROUNDS: u32 = 2;
/// Rounds at the end of a turn: a chain of tasks that wake each other comes to its end here.
const LAST_ROUNDS: u32 = 24;

/// How far the clock was put forward.
#[derive(Debug, Default)]
pub(crate) struct TurnClock {
    /// `now` of the first turn, us.
    begun: Option<f64>,
    passed: Duration,
}

impl TurnClock {
    /// The present instant by the clock of the page, us.
    pub(crate) fn now(&self) -> f64 {
        self.begun.unwrap_or(0.0) + self.passed.as_micros() as f64
    }

    /// Lets time pass to `now`, with what is due on the way. One that goes back, or is no number, lets none pass.
    pub(crate) async fn pass(&mut self, now: f64) {
        let now = if now.is_finite() {
            now.clamp(0.0, LAST)
        } else {
            self.now()
        };
        let begun = *self.begun.get_or_insert(now);
        let target = Duration::from_micros((now - begun).max(0.0) as u64);
        let mut left = target.saturating_sub(self.passed).min(LONGEST);
        self.passed += left;
        let leap = left.saturating_sub(STEP * STEPS);
        if !leap.is_zero() {
            advance(leap).await;
            rounds(LAST_ROUNDS).await;
            left -= leap;
        }
        while !left.is_zero() {
            let step = left.min(STEP);
            advance(step).await;
            rounds(ROUNDS).await;
            left -= step;
        }
    }
}

/// What is woken runs, as far as it comes in a few rounds.
pub(crate) async fn settle() {
    rounds(LAST_ROUNDS).await;
}

async fn rounds(count: u32) {
    for _ in 0..count {
        yield_now().await;
    }
}

//! Timed reads of an arm.

use std::time::Duration;

use magician::connection::Stats;
use magician::{Arm, Result};
use magician_protocol::{NoArgs, Readable};
use tokio::time::Instant;

use crate::Timings;

/// Number of events and the time in which they happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rate {
    /// Number of events.
    pub count: u64,
    /// Time in which they happened.
    pub took: Duration,
}

impl Rate {
    /// Returns the rate per second; 0 for no time.
    #[must_use]
    pub fn per_second(self) -> f64 {
        if self.took.is_zero() {
            0.0
        } else {
            self.count as f64 / self.took.as_secs_f64()
        }
    }
}

/// Latencies of answers, with the faults of the line during the measurement.
#[derive(Clone, Debug, Default)]
pub struct Timed {
    /// Times from the call to its answer.
    pub times: Timings,
    /// Retransmitted requests.
    pub resent: u64,
    /// Answers that came too late.
    pub late: u64,
    /// Damaged frames and runs of foreign bytes.
    pub noise: u64,
    /// Unsolicited frames.
    pub unsolicited: u64,
}

impl Timed {
    /// True if every answer came, in time and undamaged.
    #[must_use]
    pub fn clean(&self) -> bool {
        self.resent + self.late + self.noise + self.unsolicited == 0
    }

    fn since(times: Vec<Duration>, before: Stats, after: Stats) -> Self {
        Self {
            times: Timings::from(times),
            resent: after.resent - before.resent,
            late: after.late - before.late,
            noise: after.noise - before.noise,
            unsolicited: after.unsolicited - before.unsolicited,
        }
    }
}

/// Reads a value `count` times in a row. `tick` is called after each with the number done.
///
/// # Errors
/// Same as [`Arm::get`]; a retransmitted request is no error.
pub async fn round_trips<T: Readable<Query = NoArgs>>(
    arm: &Arm,
    count: u64,
    mut tick: impl FnMut(u64),
) -> Result<Timed> {
    // Differences, because the counters run since the connection began.
    let (before, _) = arm.stats().await?;
    let mut times = Vec::new();
    for done in 1..=count {
        let begun = Instant::now();
        arm.get::<T>().await?;
        times.push(begun.elapsed());
        tick(done);
    }
    let (after, _) = arm.stats().await?;
    Ok(Timed::since(times, before, after))
}

/// Reads a value repeatedly for a time.
///
/// # Errors
/// Same as [`Arm::get`].
pub async fn reads<T: Readable<Query = NoArgs>>(arm: &Arm, time: Duration) -> Result<Rate> {
    let begun = Instant::now();
    let mut rate = Rate::default();
    while rate.took < time {
        arm.get::<T>().await?;
        rate.count += 1;
        rate.took = begun.elapsed();
    }
    Ok(rate)
}

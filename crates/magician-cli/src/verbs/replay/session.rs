//! Pace of a replay, and its interruption.

use std::future::Future;
use std::time::Duration;

use magician_record::replay::Replay;
use magician_sim::Speed;
use tokio::time::{Instant, sleep_until};

use crate::failure::Failure;
use crate::interrupt::Signals;
use crate::progress::announce_wait;

/// Packets between two checks for signals. A choice.
const SIGNAL_CHECK_PACKETS: u64 = 256;

/// Delays packets so that the trace replays at a factor of real time, or without delay.
pub(super) struct Pace {
    times: Option<f64>,
    begin: u64,
    begun: Option<Instant>,
    packets: u64,
}

impl Pace {
    pub(super) fn new(speed: Speed, replay: &Replay<'_>) -> Self {
        Self {
            times: match speed {
                Speed::Max => None,
                Speed::Times(times) => Some(times),
            },
            begin: replay.packets().first().map_or(0, |packet| packet.time),
            begun: None,
            packets: 0,
        }
    }

    /// True if findings shall be shown before the next packet.
    pub(super) fn is_slow(&self) -> bool {
        self.times.is_some()
    }

    /// Waits until a packet is due.
    pub(super) async fn wait(&mut self, time: u64) {
        self.packets += 1;
        let Some(times) = self.times else {
            // Without delays nothing else yields to the runtime, so signals would not be seen.
            if self.packets.is_multiple_of(SIGNAL_CHECK_PACKETS) {
                tokio::task::yield_now().await;
            }
            return;
        };
        let begun = *self.begun.get_or_insert_with(Instant::now);
        let since = time.saturating_sub(self.begin) as f64 / 1e6 / times;
        let due = Duration::try_from_secs_f64(since).unwrap_or(Duration::MAX);
        match begun.checked_add(due) {
            Some(due) => sleep_until(due).await,
            // A time beyond the range of the clock never comes.
            None => std::future::pending().await,
        }
    }
}

/// Runs the work until it ends or a signal comes.
pub(super) async fn attend(
    signals: &mut Signals,
    quiet: bool,
    what: &str,
    work: impl Future<Output = Result<(), Failure>>,
) -> Result<(), Failure> {
    tokio::select! {
        biased;
        _ = signals.next() => Err(Failure::interrupted()),
        done = announce_wait(quiet, what, work) => done,
    }
}

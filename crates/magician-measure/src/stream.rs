//! Throughput of a stream of segments, with other load on the line.

use std::cell::Cell;
use std::time::Duration;

use magician::{Arm, Result};
use magician_protocol::commands::{Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use tokio::time::{Instant, MissedTickBehavior, interval, sleep};

use crate::{Rate, Ring};

/// Load besides a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Reads of the pose per second.
    pub poses: f64,
    /// Reads of the current index and of the left space per second, each.
    pub queue: f64,
    /// Duration of a pause of the host once a second.
    pub pause: Duration,
}

/// Results of a stream of segments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StreamResult {
    /// Rate of segments that the arm accepted after the warm-up.
    pub rate: Rate,
    /// True if the indices of all commands are consecutive.
    pub in_a_row: bool,
    /// Fewest commands that a reading found in the queue after the warm-up; `None` if there was no
    /// reading.
    pub fewest: Option<u32>,
    /// Places in the queue.
    pub capacity: u32,
    /// Readings that found an empty queue.
    pub dry: u64,
    /// Number of readings.
    pub looks: u64,
    /// Processor time of this process during the run; `None` if the system does not report it.
    pub processor: Option<Duration>,
    /// Time of the whole run, from the first segment until the arm is at rest.
    pub took: Duration,
}

/// Share of the time that counts as warm-up. Choice.
const WARM_UP: f64 = 0.25;

/// Times at which the driver fetched the segments.
struct Supply {
    begun: Instant,
    time: Duration,
    warm: Cell<Option<Instant>>,
    last: Cell<Option<Instant>>,
    count: Cell<u64>,
}

impl Supply {
    fn over(&self) -> bool {
        self.begun.elapsed() >= self.time
    }

    fn fetched(&self) {
        let now = Instant::now();
        if self.warm.get().is_some() {
            self.count.set(self.count.get() + 1);
            self.last.set(Some(now));
        } else if now - self.begun >= self.time.mul_f64(WARM_UP) {
            // This segment only starts the measurement; the rate counts those after it.
            self.warm.set(Some(now));
        }
    }

    fn rate(&self) -> Rate {
        let took = self.warm.get().zip(self.last.get());
        Rate {
            count: self.count.get(),
            took: took.map_or(Duration::ZERO, |(from, to)| to - from),
        }
    }

    /// True after the warm-up and before the end.
    fn counts(&self) -> bool {
        self.warm.get().is_some() && !self.over()
    }
}

/// Readings of the queue during the stream.
#[derive(Default)]
struct Looks {
    fewest: Cell<Option<u32>>,
    dry: Cell<u64>,
    count: Cell<u64>,
}

impl Looks {
    fn note(&self, waiting: u32) {
        let fewest = self
            .fewest
            .get()
            .map_or(waiting, |least| least.min(waiting));
        self.fewest.set(Some(fewest));
        self.count.set(self.count.get() + 1);
        self.dry.set(self.dry.get() + u64::from(waiting == 0));
    }
}

/// Draws a ring for a time, as fast as the line and the arm allow, with other load. The caller sets
/// the path speeds before ([`Ring::speeds`]), and restores them.
///
/// `pause` blocks the thread for the given time.
///
/// # Errors
/// Same as [`Arm::run`].
pub async fn streamed(
    arm: &Arm,
    ring: Ring,
    time: Duration,
    load: Load,
    mut pause: impl AsyncFnMut(Duration),
) -> Result<StreamResult> {
    let supply = Supply {
        begun: Instant::now(),
        time,
        warm: Cell::default(),
        last: Cell::default(),
        count: Cell::default(),
    };
    let looks = Looks::default();
    let processor = crate::processor_time();
    let segments = ring
        .segments()
        .take_while(|_| !supply.over())
        .inspect(|_| supply.fetched());
    let capacity = arm.stats().await?.1;
    let beside = async {
        tokio::try_join!(
            poses(arm, load.poses),
            queue(arm, load.queue, capacity, &supply, &looks),
            pauses(arm, load.pause, capacity, &supply, &looks, &mut pause),
        )
    };
    let mut run = arm.start(segments);
    let ran = tokio::select! {
        ran = run.wait(|_| {}) => ran?,
        // The load never ends by itself, only by an error.
        broken = beside => return Err(broken.err().unwrap_or_else(magician::Error::closed)),
    };
    let in_a_row = match (ran.first, ran.last) {
        (Some(first), Some(last)) => last.0.wrapping_sub(first.0) + 1 == ran.commands,
        _ => ran.commands == 0,
    };
    Ok(StreamResult {
        rate: supply.rate(),
        in_a_row,
        fewest: looks.fewest.get(),
        capacity,
        dry: looks.dry.get(),
        looks: looks.count.get(),
        processor: (crate::processor_time().zip(processor)).map(|(after, before)| after - before),
        took: supply.begun.elapsed(),
    })
}

/// Calls `act` at a rate per second, or never.
async fn rounds(rate: f64, mut act: impl AsyncFnMut() -> Result<()>) -> Result<()> {
    if rate <= 0.0 {
        // Pending and not done: a load that ends would count as an error.
        return std::future::pending().await;
    }
    let mut ticks = interval(Duration::from_secs_f64(1.0 / rate));
    // A slow line gets fewer reads, not a burst of late ones.
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        ticks.tick().await;
        act().await?;
    }
}

async fn poses(arm: &Arm, rate: f64) -> Result<()> {
    rounds(rate, async || arm.get::<Pose>().await.map(drop)).await
}

async fn queue(arm: &Arm, rate: f64, capacity: u32, supply: &Supply, looks: &Looks) -> Result<()> {
    rounds(rate, async || {
        // This read is only load; the read in `look` gives the result.
        arm.get::<QueuedCmdCurrentIndex>().await?;
        look(arm, capacity, supply, looks).await
    })
    .await
}

async fn look(arm: &Arm, capacity: u32, supply: &Supply, looks: &Looks) -> Result<()> {
    let counts = supply.counts();
    let left = arm.get::<QueuedCmdLeftSpace>().await?.left_space;
    // Checked before and after the read: the stream may have ended while it was in flight.
    if counts && supply.counts() {
        looks.note(capacity.saturating_sub(left));
    }
    Ok(())
}

/// Pauses the host once a second, and reads the queue after each pause.
async fn pauses(
    arm: &Arm,
    time: Duration,
    capacity: u32,
    supply: &Supply,
    looks: &Looks,
    pause: &mut impl AsyncFnMut(Duration),
) -> Result<()> {
    if time.is_zero() {
        return std::future::pending().await;
    }
    loop {
        sleep(Duration::from_secs(1)).await;
        pause(time).await;
        look(arm, capacity, supply, looks).await?;
    }
}

use std::cell::Cell;
use std::time::Duration;

use magician::{Arm, Result};
use magician_protocol::commands::{Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use tokio::time::{Instant, MissedTickBehavior, interval, sleep};

use crate::{Rate, Ring};

/// What goes on beside a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Reads of the pose a second.
    pub poses: f64,
    /// Reads of the current index and of the left space a second, each.
    pub queue: f64,
    /// For how long the host does nothing at all once a second.
    pub pause: Duration,
}

/// What a stream of segments came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Streamed {
    /// Segments that the arm took, after the stream was under way.
    pub rate: Rate,
    /// Whether the indices of all that was sent are in one row.
    pub in_a_row: bool,
    /// Fewest commands that a look found in the queue, once the stream was under way; `None` when it was not sampled.
    pub fewest: Option<u32>,
    /// Places in the queue.
    pub capacity: u32,
    /// Looks that found no command in the queue.
    pub dry: u64,
    /// All looks.
    pub looks: u64,
    /// Processor time that this process used for all of it, where the system tells.
    pub processor: Option<Duration>,
    /// What the whole run took, from the first segment to the arm's standstill.
    pub took: Duration,
}

/// Share of the time after which a stream is under way.
const WARM_UP: f64 = 0.25;

/// The segments as the driver fetches them, and when.
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

    /// Under way, and not yet at its end.
    fn counts(&self) -> bool {
        self.warm.get().is_some() && !self.over()
    }
}

/// Looks at the queue while the stream runs.
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

/// Draws a ring for a time, as fast as the line and the arm go, with other work beside it. The speeds of continuous
/// paths are the caller's to set before ([`Ring::speeds`]) and to give back.
///
/// `pause` keeps the thread from everything for so long.
///
/// # Errors
/// As [`Arm::run`].
pub async fn streamed(
    arm: &Arm,
    ring: Ring,
    time: Duration,
    load: Load,
    mut pause: impl AsyncFnMut(Duration),
) -> Result<Streamed> {
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
        broken = beside => return Err(broken.err().unwrap_or_else(magician::Error::closed)),
    };
    let in_a_row = match (ran.first, ran.last) {
        (Some(first), Some(last)) => last.0.wrapping_sub(first.0) + 1 == ran.commands,
        _ => ran.commands == 0,
    };
    Ok(Streamed {
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

/// Does something so often a second, or never.
async fn rounds(rate: f64, mut act: impl AsyncFnMut() -> Result<()>) -> Result<()> {
    if rate <= 0.0 {
        return std::future::pending().await;
    }
    let mut ticks = interval(Duration::from_secs_f64(1.0 / rate));
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
        arm.get::<QueuedCmdCurrentIndex>().await?;
        look(arm, capacity, supply, looks).await
    })
    .await
}

async fn look(arm: &Arm, capacity: u32, supply: &Supply, looks: &Looks) -> Result<()> {
    let counts = supply.counts();
    let left = arm.get::<QueuedCmdLeftSpace>().await?.left_space;
    if counts && supply.counts() {
        looks.note(capacity.saturating_sub(left));
    }
    Ok(())
}

/// Once a second the host does nothing, and then looks what that did.
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

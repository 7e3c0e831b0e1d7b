//! Measurements that only read, or need no arm.

use magician::Arm;
use magician::commands::{Pose, QueuedCmdCurrentIndex};
use magician_measure::{LineSpeed, reads, round_trips};

use super::figures::{AddedFigures, Figures};
use super::{Bench, Measurement};
use crate::failure::Failure;
use crate::progress::{Bar, announce_wait};

/// Round trips timed for the turnaround, for each of two kinds of requests.
const TURNAROUND_SAMPLES: u64 = 100;

pub(super) async fn measure(
    arm: &Arm,
    bench: &Bench,
    quiet: bool,
    figures: &mut Figures,
) -> Result<(), Failure> {
    let bar = Bar::begin(quiet, "timing replies", 2 * TURNAROUND_SAMPLES);
    let pose = round_trips::<Pose>(arm, TURNAROUND_SAMPLES, |done| bar.at(done)).await?;
    let index = round_trips::<QueuedCmdCurrentIndex>(arm, TURNAROUND_SAMPLES, |done| {
        bar.at(TURNAROUND_SAMPLES + done)
    });
    let index = index.await?;
    drop(bar);
    if let Some(line) = LineSpeed::of(&pose, &index) {
        figures.line(line, bench.turnaround);
    }
    if bench.includes(Measurement::H1) {
        let work = reads::<Pose>(arm, bench.seconds);
        let poses = announce_wait(quiet, "reading the pose", work).await?;
        let work = reads::<QueuedCmdCurrentIndex>(arm, bench.seconds);
        let indices = announce_wait(quiet, "reading the current index", work).await?;
        figures.reads(poses.per_second(), indices.per_second());
    }
    Ok(())
}

/// Measures the latency that the driver adds to a round trip.
#[cfg(unix)]
pub(super) async fn measure_driver_latency(quiet: bool) -> Result<Option<AddedFigures>, Failure> {
    /// Enough samples for a 99th percentile.
    const LATENCY_SAMPLES: usize = 5000;
    let bar = Bar::begin(quiet, "round trips", LATENCY_SAMPLES as u64);
    let added =
        magician_measure::added_latency(LATENCY_SAMPLES, |done| bar.at(done as u64)).await?;
    Ok(added
        .at(50)
        .zip(added.at(99))
        .map(|at| AddedFigures::new(&added, at)))
}

/// Not measured: there are no pseudo-terminals on this system.
#[cfg(not(unix))]
pub(super) async fn measure_driver_latency(_: bool) -> Result<Option<AddedFigures>, Failure> {
    Ok(None)
}

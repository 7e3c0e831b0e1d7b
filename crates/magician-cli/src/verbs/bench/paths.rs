//! Measurements for which the arm draws.

use std::time::Duration;

use magician::commands::CpParams;
use magician::{Arm, Options, Target};
use magician_measure::{Load, Ring, Stops, StreamResult, streamed};

use super::figures::{Figures, POLL_RATE};
use super::{Bench, Measurement};
use crate::failure::Failure;
use crate::progress::{Bar, announce_wait};
use crate::saved::SavedSettings;

/// Segments shorter than any line can deliver in time: length in mm, speed in mm/s.
const SHORT_SEGMENTS: (f64, f32) = (0.05, 100.0);
/// Segments of 0.2 mm at 90 mm/s: 450 a second.
const DENSE_SEGMENTS: (f64, f32) = (0.2, 90.0);
/// Segments of 0.5 mm at 100 mm/s: 200 a second.
const FAST_SEGMENTS: (f64, f32) = (0.5, 100.0);

/// Draws for a given time beside a load.
struct Drawing<'a> {
    arm: &'a Arm,
    quiet: bool,
    time: Duration,
    /// Same circle for all measurements, so that the arm stays in one place.
    ring: Ring,
}

impl Drawing<'_> {
    async fn draw(
        &self,
        what: &str,
        (length, speed): (f64, f32),
        load: Load,
    ) -> Result<StreamResult, Failure> {
        let ring = self.ring.cut(length, speed);
        self.arm.set(&ring.speeds()).await?;
        // Blocks the whole thread, as a scheduler that runs other programs would.
        let pause = async |time| std::thread::sleep(time);
        let work = streamed(self.arm, ring, self.time, load, pause);
        Ok(announce_wait(self.quiet, what, work).await?)
    }
}

pub(super) async fn measure(
    arm: &Arm,
    bench: &Bench,
    quiet: bool,
    saved: &SavedSettings,
    figures: &mut Figures,
) -> Result<(Ring, CpParams), Failure> {
    let (_, capacity) = arm.stats().await?;
    // Commands of other programs would falsify the figures, and must not be dropped without
    // consent.
    if arm.queue().left_space().await? < capacity {
        let message = "commands of another program are in the arm's queue";
        return Err(Failure::invalid(message).hint(
            "let them finish, or drop them with `magician stop`; without --yes only reads \
                are measured",
        ));
    }
    let ring = Ring::here(arm, DENSE_SEGMENTS.0, DENSE_SEGMENTS.1).await?;
    let speeds = arm.get::<CpParams>().await?;
    saved.save(arm, speeds).await;
    let drawing = Drawing {
        arm,
        quiet,
        time: bench.seconds,
        ring,
    };
    let polls = Load {
        poses: POLL_RATE,
        queue: POLL_RATE,
        ..Load::default()
    };
    if bench.includes(Measurement::H1) {
        let alone = drawing.draw("segments alone", SHORT_SEGMENTS, Load::default());
        figures.segments(&alone.await?);
    }
    if bench.includes(Measurement::H1) || bench.includes(Measurement::H2) {
        let polled = drawing.draw("h1, h2: segments and polls", SHORT_SEGMENTS, polls);
        figures.polled_segments(&polled.await?);
    }
    if bench.includes(Measurement::H3) {
        let pausing = |milliseconds| Load {
            pause: Duration::from_millis(milliseconds),
            queue: POLL_RATE,
            ..Load::default()
        };
        let dense = drawing.draw(
            "0.2 mm segments, pauses of 10 ms",
            DENSE_SEGMENTS,
            pausing(10),
        );
        let dense = dense.await?;
        let fast = drawing.draw(
            "0.5 mm segments, pauses of 50 ms",
            FAST_SEGMENTS,
            pausing(50),
        );
        figures.starvation(&dense, &fast.await?);
    }
    if bench.includes(Measurement::H5) {
        let load = Load {
            poses: 50.0,
            ..Load::default()
        };
        let busy = drawing.draw("processor time", DENSE_SEGMENTS, load).await?;
        figures.processor(&busy);
    }
    if bench.draws() {
        arm.start([ring.back()]).wait(|_| {}).await?;
    }
    saved.restore(arm).await?;
    Ok((ring, speeds))
}

/// Times stops of a stream, each over its own connection.
pub(super) async fn stops(
    target: &Target,
    options: Options,
    paced: bool,
    ring: Ring,
    count: u32,
    quiet: bool,
) -> Result<Stops, Failure> {
    let bar = Bar::begin(quiet, "stopping a stream", u64::from(count));
    let tick = |done| bar.at(u64::from(done));
    Ok(magician_measure::stops(target, options, paced, ring, count, tick).await?)
}

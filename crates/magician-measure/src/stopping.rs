//! Latency of a stop while a stream fills the line.

use std::time::Duration;

use magician::{Arm, Error, ErrorCode, ErrorKind, Options, Result, Target};
use tokio::time::{Instant, sleep};

use crate::tap::StopTap;
use crate::{Ring, Timings};

/// Latencies of stops while a stream of segments fills the line.
#[derive(Clone, Debug, Default)]
pub struct Stops {
    /// Times from the call to the first byte on the line. Bytes already handed to a line of 115200
    /// baud count with their wire time.
    pub on_the_line: Timings,
    /// Times from the call to the arm's answer.
    pub answered: Timings,
}

/// Shortest and longest time of the stream before the stop. Choice.
const STREAM_TIME: [Duration; 2] = [Duration::from_millis(80), Duration::from_millis(120)];
/// Spreads the times of the stops evenly over that interval, whatever their number (golden ratio).
const GOLDEN_RATIO_FRACTION: f64 = 0.618_033_988_749_895;

/// Draws a ring and stops it `count` times over a separate connection, then returns to the start of
/// the ring.
///
/// `paced` is true if the line transmits at 115200 baud. The arm is at rest after each stop, and
/// the path speeds are restored at the end. `tick` is called after each stop with the number done.
///
/// # Errors
/// Same as [`Arm::connect`], [`Arm::run`] and [`Arm::stop`].
pub async fn stops(
    target: &Target,
    options: Options,
    paced: bool,
    ring: Ring,
    count: u32,
    mut tick: impl FnMut(u32),
) -> Result<Stops> {
    let tap = StopTap::new(paced)?;
    let tracer = options.trace.clone().unwrap_or_default();
    let options = options.trace(tracer.tap(tap.clone()));
    let arm = Arm::connect_with(target, options).await?;
    let speeds = arm.get::<magician_protocol::commands::CpParams>().await?;
    arm.set(&ring.speeds()).await?;
    let mut times = Times::default();
    let outcome = async {
        for done in 1..=count {
            stop_once(&arm, ring, done, &tap, &mut times).await?;
            tick(done);
        }
        arm.start([ring.back()]).wait(|_| {}).await?;
        Ok::<_, Error>(())
    }
    .await;
    // Restored after an error as well, so `outcome` is examined later.
    let restored = arm.set(&speeds).await;
    arm.close().await;
    outcome.and(restored)?;
    Ok(Stops {
        on_the_line: Timings::from(times.on_the_line),
        answered: Timings::from(times.answered),
    })
}

#[derive(Default)]
struct Times {
    on_the_line: Vec<Duration>,
    answered: Vec<Duration>,
}

async fn stop_once(
    arm: &Arm,
    ring: Ring,
    number: u32,
    tap: &StopTap,
    times: &mut Times,
) -> Result<()> {
    let [least, most] = STREAM_TIME;
    let wait = least + (most - least).mul_f64((f64::from(number) * GOLDEN_RATIO_FRACTION).fract());
    let mut stream = arm.start(ring.segments());
    let stream = stream.wait(|_| {});
    let stop = async {
        sleep(wait).await;
        tap.forget();
        let begun = Instant::now();
        arm.stop().await?;
        let seen = tap.seen();
        let missed = || Error::new(ErrorCode::BadAnswer, "the stop was not seen on the line");
        times
            .on_the_line
            .push(seen.sent.ok_or_else(missed)? - begun);
        times
            .answered
            .push(seen.answered.ok_or_else(missed)? - begun);
        Ok::<_, Error>(())
    };
    let (streamed, stopped) = tokio::join!(stream, stop);
    stopped?;
    match streamed {
        // The regular end: the stop ended the stream.
        Err(error) if error.kind() == ErrorKind::Closed => Ok(()),
        Err(error) => Err(error),
        Ok(_) => Err(Error::new(ErrorCode::BadAnswer, "an endless stream ended")),
    }
}

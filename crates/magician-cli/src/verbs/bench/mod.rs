//! `bench`: measures rates and latencies of line and driver on an arm, and compares them with
//! computed ones.

mod figures;
mod paths;
mod reads;
mod show;

use std::time::Duration;

use clap::{Args, ValueEnum};
use magician::{SimSpeed, Target};

use crate::context::{Context, Sim, StopPolicy, VirtualArmUse};
use crate::failure::Failure;
use crate::options::seconds;
use figures::Figures;

/// Measure the line and the driver, and compare with computed rates
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician bench --port /dev/ttyUSB0                 reads only
  magician bench --port /dev/ttyUSB0 --yes           also measurements with motion
  magician bench --port ./arm --window 4 --yes --seconds 60 --only h2,h3

h1  replies per second to GetPose and to the current index; path segments (17-byte CP) per second, \
alone and with pose, current index and free space read 20 times a second; each next to the rate \
computed from the turnaround
h2  segments per second with those reads, with a window of 4 or more
h3  queue underruns: 0.2 mm segments at 450 per second with pauses of 10 ms, 0.5 mm segments at 100 \
mm/s with pauses of 50 ms
h4  time from a stop to its first byte on the line and to its reply, while segments saturate the line
h5  CPU time of this process at 450 segments and 50 poses per second
h7  latency that the driver adds to a bare round trip over a pseudo-terminal; needs no arm

For h2 to h5 and the segments of h1 the arm draws rings of 20 mm through its current position, away \
from the limits of its reach, at up to 100 mm/s. A real arm does so only with --yes: keep its \
surroundings clear. Its path speeds are restored at the end. `sim` needs no --yes, but h5 then \
includes the CPU time of the virtual arm. Values that were not measured are null.

If the arm's acceleration and queue allow fewer than 450 segments per second, h3 and h5 remain \
undecided; a virtual arm reaches more with `magician sim --speed 1.5`.")]
pub(crate) struct Bench {
    /// Duration of each measurement, in seconds
    #[arg(long, value_name = "N", default_value = "3", value_parser = seconds)]
    seconds: Duration,
    /// Turnaround of the arm in ms, without the transmission time of the bytes [default: measured]
    #[arg(long, value_name = "MS", value_parser = milliseconds)]
    turnaround: Option<Duration>,
    /// Number of stops to time for h4, 1 to 10000
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    stops: u32,
    /// Run only these measurements, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    only: Vec<Measurement>,
}

/// Measurement that `--only` can select, as numbered in the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Measurement {
    H1,
    H2,
    H3,
    H4,
    H5,
    H7,
}

/// Parses milliseconds, 0 allowed.
fn milliseconds(text: &str) -> Result<Duration, String> {
    let wrong = || "expected milliseconds from 0 on, such as 2.5".to_owned();
    let number = text.strip_suffix("ms").unwrap_or(text).trim();
    let value: f64 = number.parse().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(value / 1e3).map_err(|_| wrong())
}

impl Bench {
    fn includes(&self, which: Measurement) -> bool {
        self.only.is_empty() || self.only.contains(&which)
    }

    /// True if a selected measurement draws over the connection of this verb; h4 opens its own.
    fn draws(&self) -> bool {
        let drawn = [
            Measurement::H1,
            Measurement::H2,
            Measurement::H3,
            Measurement::H5,
        ];
        drawn.into_iter().any(|which| self.includes(which))
    }

    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let sim = Sim {
            speed: SimSpeed::Times(1.0),
            condition: VirtualArmUse::Named,
        };
        let target = context.target(Some(sim))?;
        let allowed = context.global.yes || matches!(target, Target::Sim(_));
        let draws = allowed && (self.draws() || self.includes(Measurement::H4));
        let quiet = context.global.json;
        let options = context.options()?;
        let mut figures = Figures::new(&target, options.window, self.seconds);
        let saved = context.saved.clone();
        let ring = context.arm_or(sim, StopPolicy::Move, async |arm, _| {
            reads::measure(arm, &self, quiet, &mut figures).await?;
            Ok(if draws {
                Some(paths::measure(arm, &self, quiet, &saved, &mut figures).await?)
            } else {
                None
            })
        })?;
        if let (Some((ring, speeds)), true) = (ring, self.includes(Measurement::H4)) {
            let paced = figures.paced();
            let stops = context.run_with_own_line(async |_| {
                paths::stops(&target, options, paced, ring, self.stops, quiet).await
            });
            if stops.is_err() {
                // The measurement restores the speeds itself, except if it is interrupted.
                let _ = context.arm(StopPolicy::Order, async |arm, _| {
                    Ok(arm.set(&speeds).await?)
                });
            }
            figures.stops(&stops?);
        }
        if self.includes(Measurement::H7) {
            let added =
                context.run_with_own_line(async |_| reads::measure_driver_latency(quiet).await)?;
            figures.set_driver_latency(&added);
        }
        figures.set_drawing_allowed(allowed);
        context.show(&figures, |out| show::write(&figures, out))
    }
}

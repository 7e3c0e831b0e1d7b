//! Cost and feel of each kind of jog, as a table:
//! `cargo test -p magician --test arm jog_figures -- --ignored --nocapture`. The results are in
//! docs/evidence/MEASUREMENTS.md.

use std::time::Duration;

use magician::build::{Axis, JogDirection};
use magician::sim::Controller;
use magician::{Fence, JogOptions, Options};
use tokio::time::{Instant, sleep};

use crate::desk::Desk;

const KEEP: Duration = Duration::from_millis(250);
const PERIOD: Duration = Duration::from_millis(20);
/// Jogs per row, started at as many phases of the controller's period.
const RUNS: u64 = 40;

fn place(arm: &Controller, axis: Axis) -> f64 {
    let state = arm.state();
    match axis {
        Axis::J1 => state.joints.j1,
        _ => state.pose.x,
    }
}

#[derive(Default)]
struct Figures {
    /// From the call to the first motion, and from the release to rest, ms.
    start: Vec<f64>,
    stop: Vec<f64>,
    /// From the release to rest, mm or degrees.
    overrun: Vec<f64>,
    /// Speed in the middle of the jog: lowest of a period, and mean.
    least: Vec<f64>,
    mean: Vec<f64>,
    /// Requests per second.
    frames: Vec<f64>,
    failed: u32,
}

fn at(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let nth = (values.len() as f64 * share) as usize;
    values
        .get(nth.min(values.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

impl Figures {
    /// Performs one jog; `None` if it failed before its end.
    async fn jog(
        &mut self,
        desk: &Desk,
        options: Options,
        direction: JogDirection,
        (percent, turnaround, phase): (f32, u64, u64),
    ) -> Option<()> {
        let axis = direction.axis;
        let at = move |desk: &Desk| desk.with(|arm| place(arm, axis));
        desk.answers_after(Duration::from_millis(turnaround));
        let arm = desk.connect(options).await;
        let ratio = magician::commands::JogCommonParams {
            velocity_ratio: percent,
            acceleration_ratio: 100.0,
        };
        arm.set(&ratio).await.ok()?;
        sleep(Duration::from_millis(100) + Duration::from_micros(phase * 20_000 / RUNS)).await;
        let (begun, from) = (Instant::now(), at(desk));
        let starter = arm.clone();
        let options = JogOptions::default().keep(KEEP);
        let start = tokio::spawn(async move { starter.jog_with(direction, options).await });
        while at(desk) == from {
            sleep(Duration::from_millis(1)).await;
            if begun.elapsed() > Duration::from_secs(3) {
                return None;
            }
        }
        self.start.push(begun.elapsed().as_secs_f64() * 1e3);
        let jog = start.await.ok()?.ok()?;
        while begun.elapsed() < Duration::from_millis(1400) {
            jog.keep().ok()?;
            sleep(Duration::from_millis(60)).await;
        }
        desk.heard();
        let (mut least, mut way) = (f64::INFINITY, 0.0);
        for _ in 0..25 {
            let before = at(desk);
            sleep(PERIOD).await;
            let gone = (at(desk) - before).abs();
            least = least.min(gone / 0.02);
            way += gone;
            jog.keep().ok()?;
        }
        self.frames.push(desk.heard().len() as f64 / 0.5);
        self.least.push(least);
        self.mean.push(way / 0.5);
        let (released, from) = (Instant::now(), at(desk));
        drop(jog);
        while desk.moves() {
            sleep(Duration::from_millis(1)).await;
        }
        self.stop.push(released.elapsed().as_secs_f64() * 1e3);
        self.overrun.push((at(desk) - from).abs());
        arm.close().await;
        Some(())
    }
}

#[tokio::test(start_paused = true)]
#[ignore = "prints a table"]
async fn figures_of_each_kind_of_jog() {
    println!(
        "| jog | axis | speed | L | lost | start p50, p99 | stop p50, p99 | overrun p50, p99 | least, mean speed | requests/s | failed |"
    );
    let fence = Fence::default().with_floor(-100.0).unwrap();
    let kinds = [
        ("own", Options::default()),
        ("fenced", Options::default().fence(Some(fence))),
        ("pieces", Options::default().bounded_jogs(true)),
    ];
    for direction in [Axis::X.minus(), Axis::J1.plus()] {
        for percent in [1.0, 30.0, 100.0] {
            for (turnaround, lost) in [(0, 0), (4, 0), (16, 0), (4, 10)] {
                for (kind, options) in &kinds {
                    let mut figures = Figures::default();
                    for phase in 0..RUNS {
                        let desk = match lost {
                            0 => Desk::new(),
                            lost => Desk::lossy(phase + 1, lost),
                        };
                        let with = (percent, turnaround, phase);
                        let jogged = figures.jog(&desk, options.clone(), direction, with).await;
                        figures.failed += u32::from(jogged.is_none());
                    }
                    let Figures {
                        mut start,
                        mut stop,
                        mut overrun,
                        mut least,
                        mean,
                        frames,
                        failed,
                    } = figures;
                    let average = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
                    println!(
                        "| {kind} | {} | {percent} % | {turnaround} ms | {lost} | {:.0}, {:.0} ms | {:.0}, {:.0} ms | {:.2}, {:.2} | {:.2}, {:.2} | {:.0} | {failed} |",
                        direction.axis.name(),
                        at(&mut start, 0.5),
                        at(&mut start, 0.99),
                        at(&mut stop, 0.5),
                        at(&mut stop, 0.99),
                        at(&mut overrun, 0.5),
                        at(&mut overrun, 0.99),
                        at(&mut least, 0.0),
                        average(&mean),
                        average(&frames),
                    );
                }
            }
        }
    }
}

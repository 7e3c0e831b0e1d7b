//! S1 and S2: arm-seconds that one core simulates per second, bytes in and bytes out.

use std::error::Error;

use magician_protocol::{Ctrl, FrameBuf, Writable};
use magician_sim::{ArmInstant, Controller};

use super::figure::{Figure, rate};
use super::program::{arm, frame, hatching, pick_and_place, plotter, ring, stream};

/// Commands per round.
const COMMANDS: usize = 100_000;
/// Commands per round if the pose is read every millisecond.
const POLLED_COMMANDS: usize = 1_000;

/// Interval of reading the pose, µs.
const POLL_INTERVAL_US: u64 = 1_000;

/// Returns this many frames by repeating the commands.
fn repeated_frames<T: Writable>(commands: &[T], count: usize) -> Vec<FrameBuf> {
    let frames = commands.iter().map(|command| frame(Ctrl::QUEUED, command));
    let once: Vec<FrameBuf> = frames.collect();
    once.into_iter().cycle().take(count).collect()
}

/// Returns the duration of the frames in arm-seconds, simulated by events alone.
fn simulate_by_events(arm: &mut Controller, frames: &[FrameBuf]) -> f64 {
    let began = arm.now();
    stream(arm, frames, |_, _| ());
    (arm.now() - began).as_secs_f64()
}

/// Returns the duration of the frames in arm-seconds, reading the pose every millisecond.
fn simulate_with_polls(arm: &mut Controller, frames: &[FrameBuf]) -> f64 {
    let began = arm.now();
    stream(arm, frames, |arm, at| {
        let mut look =
            arm.now().as_micros() / POLL_INTERVAL_US * POLL_INTERVAL_US + POLL_INTERVAL_US;
        while look < at.as_micros() {
            arm.advance(ArmInstant::from_micros(look));
            std::hint::black_box(arm.state());
            look += POLL_INTERVAL_US;
        }
    });
    (arm.now() - began).as_secs_f64()
}

/// Function that runs frames on an arm and returns their duration by the arm's clock, s.
type Work = fn(&mut Controller, &[FrameBuf]) -> f64;

fn figure(name: &str, mut arm: Controller, frames: &[FrameBuf], work: Work) -> Figure {
    let mut lasted = 0.0;
    let (median, best) = rate(|| {
        lasted = work(&mut arm, frames);
        lasted
    });
    assert!(arm.state().alarms.is_empty(), "{name}: {:?}", arm.state());
    let commands = frames.len() as f64;
    Figure::new(name, median, "arm-seconds/s")
        .with("best", best)
        .with("commands/s", commands * median / lasted)
        .with("ms of arm time a command", lasted / commands * 1e3)
}

/// Measures S1, point to point.
pub(super) fn ptp() -> Result<Vec<Figure>, Box<dyn Error>> {
    let frames = repeated_frames(&pick_and_place(), COMMANDS);
    let figure = figure("S1 ptp", arm(), &frames, simulate_by_events);
    Ok(vec![figure.at_least(1e6)])
}

/// Measures S1, continuous path: with the settings of power-up, and with those of a drawing.
pub(super) fn cp() -> Result<Vec<Figure>, Box<dyn Error>> {
    let mut figures = Vec::new();
    for (name, commands) in [("ring", ring()), ("hatching", hatching())] {
        let frames = repeated_frames(&commands, COMMANDS);
        for speed in [100.0, 200.0] {
            let name = format!("S1 cp 1 mm {name} {speed}/{speed}");
            let figure = figure(&name, plotter(speed, speed), &frames, simulate_by_events);
            figures.push(figure.at_least(1e4));
        }
    }
    Ok(figures)
}

/// Measures S2.
pub(super) fn polled() -> Result<Vec<Figure>, Box<dyn Error>> {
    let moves = repeated_frames(&pick_and_place(), POLLED_COMMANDS);
    let segments = repeated_frames(&ring(), 20 * POLLED_COMMANDS);
    let plotter = plotter(100.0, 100.0);
    Ok(vec![
        figure("S2 ptp at 1 kHz", arm(), &moves, simulate_with_polls).at_least(1e3),
        figure(
            "S2 cp 1 mm ring at 1 kHz",
            plotter,
            &segments,
            simulate_with_polls,
        )
        .at_least(1e3),
    ])
}

/// Returns the best rate in arm-seconds per second, point to point, for comparisons.
pub(super) fn ptp_rate() -> f64 {
    let (mut arm, frames) = (arm(), repeated_frames(&pick_and_place(), COMMANDS));
    rate(|| simulate_by_events(&mut arm, &frames)).1
}

/// Returns the same for a path with the settings of power-up.
pub(super) fn cp_rate() -> f64 {
    let (mut arm, frames) = (plotter(100.0, 100.0), repeated_frames(&ring(), COMMANDS));
    rate(|| simulate_by_events(&mut arm, &frames)).1
}

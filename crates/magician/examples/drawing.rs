//! Streams a drawing of any number of short segments through the arm's queue, which holds 32.
//!
//! `cargo run --release -p magician --example drawing -- PORT [SEGMENTS [WINDOW]]`
//!
//! The arm draws a ring of 20 mm through its current position, in segments of 0.05 mm, so the line
//! to the arm is the bottleneck, not the arm. The driver reads the room in the queue as rarely as
//! possible, and accounts for every segment by its index. A WINDOW above 1 sends that many segments
//! before the first is answered; `magician doctor` finds out what an arm supports. The last line of
//! the output is an object with the seconds it took.

use std::env::args;
use std::time::Instant;

use magician::commands::{CpCmd, CpParams, Pose};
use magician::preflight::Preflight;
use magician::protocol::{CpMode, Flag};
use magician::{Options, Set, blocking::Arm};

/// Radius of the ring and length of a segment, mm.
const RADIUS: f32 = 10.0;
const SEGMENT: f32 = 0.05;

/// Returns the position of the pen after `count` segments.
fn point(start: &Pose, count: u32) -> CpCmd {
    let angle = count as f32 * SEGMENT / RADIUS;
    CpCmd {
        cp_mode: CpMode::Absolute,
        x: start.x - RADIUS + RADIUS * angle.cos(),
        y: start.y + RADIUS * angle.sin(),
        z: start.z,
        velocity_or_power: 0.0,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = args().nth(1).unwrap_or_else(|| "sim".to_owned());
    let segments = args().nth(2).map_or(Ok(1000), |text| text.parse())?;
    let window = args().nth(3).map_or(Ok(1), |text| text.parse())?;

    let arm = Arm::connect_with(port, Options::default().window(window))?;
    let before = arm.get::<CpParams>()?;
    arm.set(&CpParams {
        plan_acc: 1000.0,
        junction_vel: 100.0,
        acc_or_period: 1000.0,
        real_time_track: Flag::OFF,
    })?;
    let start = arm.get::<Pose>()?;
    let here: Preflight = arm.preflight()?;
    let mut check = here.clone();
    for count in 1..=segments {
        check.check(&point(&start, count).into())?;
    }

    let begun = Instant::now();
    let path = (1..=segments).map(|count| Set::from(point(&start, count)));
    let ran = arm.start(path).along(here).wait(|_| {})?;
    let seconds = begun.elapsed().as_secs_f64();
    arm.set(&before)?;

    let rate = f64::from(segments) / seconds;
    println!(
        r#"{{"segments":{},"window":{window},"seconds":{seconds:.6},"per_s":{rate:.1}}}"#,
        ran.commands
    );
    Ok(())
}

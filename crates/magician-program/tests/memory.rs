//! Memory taken by a large drawing. A separate process, because its peak is measured.
#![cfg(target_os = "linux")]

use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_program::{Artwork, Content, Format, Origin, Program, Setup, Stroke, Surface};

const STROKES: u32 = 600;
const POINTS_PER_STROKE: u32 = 400;
/// Largest number of bytes per point of a drawing: its steps take 56, and its points 16 in each
/// place that keeps them.
const MAX_BYTES_PER_POINT: u64 = 230;

/// Value in bytes of a line in the status of the process.
fn status_bytes(what: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("readable");
    let line = status.lines().find(|line| line.starts_with(what));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    1024 * number
        .and_then(|number| number.parse::<u64>().ok())
        .expect("a number")
}

/// Peak memory of the process without its code, which includes embedded data.
fn peak() -> u64 {
    status_bytes("VmHWM:") - status_bytes("RssFile:")
}

#[test]
fn large_drawing_is_fitted_and_checked_within_the_memory_limit() {
    let before = peak();
    let stroke = |nth: u32| {
        let [x, y] = [nth % 30, nth / 30].map(|at| 12.0 * f64::from(at));
        let points = (0..POINTS_PER_STROKE).map(|at| {
            let (sin, cos) = (f64::from(at) * 0.1).sin_cos();
            let radius = 1.0 + f64::from(at) * 0.01;
            [x + radius * cos, y + radius * sin]
        });
        Stroke::new(points.collect(), Origin::NONE)
    };
    let artwork = Artwork {
        strokes: (0..STROKES).map(stroke).collect(),
        ..Artwork::default()
    };
    let mut setup = Setup::default();
    setup.surface = Some(Surface::level(-60.0));
    setup.placement.fit = true;
    // Keep every point.
    setup.tidy.simplify = 0.0;
    let made = setup.plan(Format::Svg, Content::Artwork(artwork));
    let made = made.expect("it is made to fit");
    assert!(made.misfit.is_none() && made.plan.steps.len() > 200_000);
    let program = Program::new(made.plan, Some(1));
    assert!(program.kinds().len() < 10);
    let start = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let rest = program.remaining(0, start).expect("it can be done");
    assert!(rest.check().is_good());
    let each = (peak() - before) / u64::from(STROKES * POINTS_PER_STROKE);
    assert!(each <= MAX_BYTES_PER_POINT, "{each} bytes");
}

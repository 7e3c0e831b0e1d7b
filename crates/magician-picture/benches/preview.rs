//! Cost of the preview of a large plan, compared with its check.

use divan::Bencher;
use magician::preflight::Preflight;
use magician::{JointAngles, ToolBias};
use magician_picture::{Preview, PreviewOptions};
use magician_program::{Action, Origin, Plan, Surface, Tool, Travel, check};

const PAPER: f32 = -60.0;

fn main() {
    divan::main();
}

/// Returns a spiral of short segments, no two of which are collinear, so that nothing can be
/// simplified.
fn spiral(segments: u32) -> Plan {
    let mut plan = Plan::new("spiral");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER.into()));
    let at = |nth: u32| {
        let t = nth as f32 / segments as f32;
        let (sin, cos) = (t * 150.0 * std::f32::consts::TAU).sin_cos();
        let wobble = 1.0 + 0.02 * (t * 9000.0).sin();
        [240.0 + 45.0 * t * wobble * cos, 45.0 * t * wobble * sin]
    };
    let [x, y] = at(0);
    let (to, by) = ([x, y, PAPER, 0.0], Travel::Line);
    plan.push(Action::Move { to, by }, Origin::NONE);
    for nth in 1..=segments {
        let [x, y] = at(nth);
        plan.push(Action::Path { to: [x, y, PAPER] }, Origin::NONE);
    }
    plan
}

fn start() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::PEN)
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 5)]
fn preview_alone(bencher: Bencher, segments: u32) {
    let plan = spiral(segments);
    let report = check(&plan, &start());
    bencher.bench(|| Preview::new(&plan, &report, &start(), &PreviewOptions::default()));
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 5)]
fn check_alone(bencher: Bencher, segments: u32) {
    let plan = spiral(segments);
    bencher.bench(|| check(&plan, &start()));
}

#[divan::bench(args = [1_000_000], sample_count = 5)]
fn to_png(bencher: Bencher, segments: u32) {
    let plan = spiral(segments);
    let report = check(&plan, &start());
    let preview = Preview::new(&plan, &report, &start(), &PreviewOptions::default());
    println!("{} bytes of SVG", preview.to_svg().len());
    bencher.bench(|| preview.to_png(4.0));
}

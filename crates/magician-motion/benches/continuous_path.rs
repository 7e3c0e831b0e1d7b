//! Benchmarks of continuous paths: `cargo bench -p magician-motion --bench continuous_path`.

use std::cell::Cell;
use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use magician_motion::{
    ArmModel, ArmState, CpSegment, Geometry, Jog, JogAxis, KinematicLimits, LookAhead, Planner,
    Pose, ToolBias,
};

const ARM: Geometry = Geometry::magician(ToolBias::SUCTION);

fn main() {
    divan::main();
}

fn planner() -> Planner {
    Planner {
        geometry: ARM,
        ..Planner::default()
    }
}

/// Points on a circle of 40 mm, `step` mm apart, going round repeatedly.
fn circle(count: usize, step: f64) -> Vec<[f64; 3]> {
    (0..count)
        .map(|n| {
            let angle = n as f64 * step / 40.0;
            [250.0 + 40.0 * angle.cos(), 40.0 * angle.sin(), 0.0]
        })
        .collect()
}

fn segments(points: &[[f64; 3]]) -> Vec<CpSegment> {
    points
        .windows(2)
        .map(|ends| CpSegment::between(ends[0], ends[1]))
        .collect()
}

/// Exit speed of the running segment with 32 queued. They are so short that all of them are
/// examined.
#[divan::bench]
fn look_ahead_over_32(bencher: Bencher) {
    let look_ahead = LookAhead::new(
        &ArmModel::MAGICIAN.cp_speeds(),
        &ArmModel::MAGICIAN.ceilings,
        ArmModel::MAGICIAN.law,
    )
    .expect("speeds");
    let segments = segments(&circle(1024 + 34, 0.2));
    let at = Cell::new(0);
    bencher.bench_local(|| {
        let first = at.get();
        at.set((first + 1) % 1024);
        let window = &segments[first..first + 33];
        black_box(look_ahead.exit_speed(&window[0], &window[1..]))
    });
}

/// A million segments of 0.2 mm, from rest to rest.
#[divan::bench]
fn times_of_a_million(bencher: Bencher) {
    let look_ahead = LookAhead::new(
        &ArmModel::MAGICIAN.cp_speeds(),
        &ArmModel::MAGICIAN.ceilings,
        ArmModel::MAGICIAN.law,
    )
    .expect("speeds");
    let segments = segments(&circle(1_000_001, 0.2));
    let mut room = vec![0.0; segments.len()];
    bencher
        .counter(ItemsCount::new(segments.len()))
        .bench_local(|| look_ahead.times(&segments, &mut room).sum::<u64>());
}

fn starts(points: &[[f64; 3]]) -> Vec<ArmState> {
    points
        .iter()
        .map(|[x, y, z]| {
            let planner = planner();
            let pose = Pose::new(*x, *y, *z, 0.0);
            ArmState::at_pose(&ARM, &pose, &planner.limits).expect("in reach")
        })
        .collect()
}

const RATES: KinematicLimits = KinematicLimits {
    velocity: 100.0,
    acceleration: 100.0,
};

#[divan::bench]
fn plan_segment(bencher: Bencher) {
    let planner = planner();
    let points = circle(1025, 1.0);
    let starts = starts(&points);
    let at = Cell::new(0);
    bencher.bench_local(|| {
        let first = at.get();
        at.set((first + 1) % 1024);
        black_box(planner.segment(&starts[first], points[first + 1], 20.0, 22.0, RATES))
    });
}

#[divan::bench]
fn plan_rest_of_segment(bencher: Bencher) {
    let planner = planner();
    let points = circle(2, 1.0);
    let starts = starts(&points);
    let running = planner
        .segment(&starts[0], points[1], 20.0, 0.0, RATES)
        .expect("in reach")
        .trajectory;
    bencher
        .bench_local(|| black_box(planner.segment_rest(black_box(&running), 20_000, 22.0, RATES)));
}

#[divan::bench]
fn sample_segment(bencher: Bencher) {
    let planner = planner();
    let points = circle(2, 1.0);
    let starts = starts(&points);
    let running = planner
        .segment(&starts[0], points[1], 20.0, 0.0, RATES)
        .expect("in reach")
        .trajectory;
    let at = Cell::new(0);
    bencher.bench_local(|| {
        at.set((at.get() + 17) % running.duration_us());
        black_box(running.sample(at.get()))
    });
}

#[divan::bench(args = [JogAxis::J1, JogAxis::X])]
fn plan_jog(bencher: Bencher, axis: JogAxis) {
    let planner = planner();
    let start = starts(&circle(1, 1.0))[0];
    let jog = Jog {
        axis,
        positive: true,
    };
    bencher.bench_local(|| black_box(planner.jog(black_box(&start), jog, RATES, 0.0)));
}

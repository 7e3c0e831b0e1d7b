//! Benchmarks of the mathematics: `cargo bench -p magician-motion`.
//!
//! Each figure is for one call, on inputs that vary from call to call.

use std::cell::Cell;
use std::hint::black_box;

use divan::Bencher;
use magician_motion::{
    ArmModel, ArmState, Geometry, JointAngles, Move, MoveKind, Planner, Pose, Target, ToolBias,
    Transfer,
};

const ARM: Geometry = Geometry::magician(ToolBias::SUCTION);

fn main() {
    divan::main();
}

/// 1024 joint angles spread over the middle of the workspace.
fn spread() -> Vec<JointAngles> {
    (0..1024u32)
        .map(|n| {
            let part = |salt: u32| {
                f64::from(n.wrapping_mul(2_654_435_761).rotate_left(salt) >> 8)
                    / f64::from(1u32 << 24)
            };
            JointAngles::new(
                part(0) * 120.0 - 60.0,
                20.0 + part(7) * 40.0,
                30.0 + part(13) * 30.0,
                part(19) * 120.0 - 60.0,
            )
        })
        .collect()
}

/// Cycles through a list.
struct Round<T> {
    items: Vec<T>,
    next: Cell<usize>,
}

impl<T> Round<T> {
    fn new(items: Vec<T>) -> Self {
        Self {
            items,
            next: Cell::new(0),
        }
    }

    fn next(&self) -> &T {
        let index = self.next.get();
        self.next.set(index + 1);
        &self.items[index % self.items.len()]
    }
}

#[divan::bench]
fn forward(bencher: Bencher) {
    let joints = Round::new(spread());
    bencher.bench_local(|| ARM.forward(black_box(joints.next())));
}

#[divan::bench]
fn inverse(bencher: Bencher) {
    let poses = Round::new(spread().iter().map(|joints| ARM.forward(joints)).collect());
    bencher.bench_local(|| ARM.inverse(black_box(poses.next())));
}

#[divan::bench]
fn inverse_within_limits(bencher: Bencher) {
    let poses = Round::new(spread().iter().map(|joints| ARM.forward(joints)).collect());
    bencher.bench_local(|| ARM.inverse_within(black_box(poses.next()), &ArmModel::MAGICIAN.limits));
}

fn planner() -> Planner {
    Planner {
        geometry: ARM,
        ..Planner::default()
    }
}

fn plan(bencher: Bencher, kind: MoveKind) {
    let planner = planner();
    let states: Vec<ArmState> = spread()
        .iter()
        .map(|joints| ArmState::at_joints(&ARM, joints))
        .collect();
    let pairs: Vec<(ArmState, Move)> = states
        .windows(2)
        .map(|pair| {
            (
                pair[0],
                Move {
                    target: Target::Pose(pair[1].pose),
                    kind,
                },
            )
        })
        .filter(|(from, request)| planner.plan(from, request).is_ok())
        .collect();
    let pairs = Round::new(pairs);
    bencher.bench_local(|| {
        let (from, request) = pairs.next();
        black_box(planner.plan(black_box(from), black_box(request)))
    });
}

#[divan::bench]
fn plan_joint(bencher: Bencher) {
    plan(bencher, MoveKind::Joint);
}

#[divan::bench]
fn plan_line(bencher: Bencher) {
    plan(bencher, MoveKind::Line);
}

#[divan::bench]
fn plan_arc(bencher: Bencher) {
    let planner = planner();
    let states: Vec<ArmState> = spread()
        .iter()
        .map(|joints| ArmState::at_joints(&ARM, joints))
        .collect();
    // Through a point near the middle between both ends, like arcs in drawings.
    let arcs: Vec<(ArmState, Pose, Pose)> = states
        .windows(2)
        .map(|pair| {
            let (from, to) = (pair[0], pair[1].pose);
            let mut via = from.pose;
            via.x += 0.5 * (to.x - via.x) + 0.1 * (to.y - via.y);
            via.y += 0.5 * (to.y - via.y) - 0.1 * (to.x - from.pose.x);
            via.z += 0.5 * (to.z - via.z);
            (from, via, to)
        })
        .filter(|(from, via, to)| planner.arc(from, via, to).is_ok())
        .collect();
    let arcs = Round::new(arcs);
    bencher.bench_local(|| {
        let (from, via, to) = arcs.next();
        black_box(planner.arc(black_box(from), black_box(via), black_box(to)))
    });
}

#[divan::bench]
fn plan_jump(bencher: Bencher) {
    plan(
        bencher,
        MoveKind::Jump(ArmModel::MAGICIAN.power_up.jump(), Transfer::Joint),
    );
}

fn sample(bencher: Bencher, kind: MoveKind) {
    let from = ArmState::at_joints(&ARM, &JointAngles::new(-20.0, 40.0, 45.0, 0.0));
    let target = Target::Pose(Pose::new(240.0, 60.0, 20.0, 30.0));
    let motion = planner()
        .plan(&from, &Move { target, kind })
        .expect("reachable")
        .trajectory;
    let step = motion.duration_us() / 1024;
    let times = Round::new((0..1024u64).map(|n| n * step).collect());
    bencher.bench_local(|| motion.sample(black_box(*times.next())));
}

#[divan::bench]
fn sample_joint(bencher: Bencher) {
    sample(bencher, MoveKind::Joint);
}

#[divan::bench]
fn sample_line(bencher: Bencher) {
    sample(bencher, MoveKind::Line);
}

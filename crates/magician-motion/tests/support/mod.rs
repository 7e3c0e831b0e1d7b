//! What several test files start from.
#![allow(dead_code)]

use magician_motion::{
    ArmState, Geometry, JointAngles, Limits, Move, MoveKind, Planner, Pose, Range, Speeds, Target,
    ToolBias,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

pub(crate) const WITHOUT_LIMITS: Limits = {
    let all = Range::new(f64::NEG_INFINITY, f64::INFINITY);
    Limits {
        j1: all,
        j2: all,
        j3: all,
        j4: all,
        j2_minus_j3: all,
    }
};

pub(crate) fn full_speed() -> Speeds {
    Speeds {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
        ..Speeds::POWER_UP
    }
}

pub(crate) fn state(planner: &Planner, joints: [f64; 4]) -> ArmState {
    ArmState::at_joints(&planner.geometry, &joints.into())
}

pub(crate) fn joint_move(target: Target) -> Move {
    Move {
        target,
        kind: MoveKind::Joint,
    }
}

pub(crate) fn line(target: Target) -> Move {
    Move {
        target,
        kind: MoveKind::Line,
    }
}

/// Joint angles within the controller's limits.
pub(crate) fn reachable() -> impl Strategy<Value = JointAngles> {
    (-135.0..135.0, -5.0..90.0, -15.0..90.0, -150.0..150.0)
        .prop_map(|(j1, j2, j3, j4)| JointAngles::new(j1, j2, j3, j4))
        .prop_filter("within limits", |joints| {
            Limits::CONTROLLER.check(joints).is_ok()
        })
}

pub(crate) fn bias() -> impl Strategy<Value = ToolBias> {
    prop_oneof![
        Just(ToolBias::NONE),
        Just(ToolBias::SUCTION),
        Just(ToolBias::PEN),
        (0.0..120.0, -45.0..45.0, -60.0..120.0).prop_map(|(x, y, z)| ToolBias::new(x, y, z)),
    ]
}

pub(crate) fn speeds() -> impl Strategy<Value = Speeds> {
    let rate = || 5.0..600.0f64;
    (
        [rate(), rate(), rate(), rate()],
        [rate(), rate(), rate(), rate()],
        [rate(), rate(), rate(), rate()],
        1.0..120.0f64,
        1.0..120.0f64,
    )
        .prop_map(|(joint_velocity, joint_acceleration, rest, v, a)| Speeds {
            joint_velocity,
            joint_acceleration,
            linear_velocity: rest[0],
            linear_acceleration: rest[1],
            rotation_velocity: rest[2],
            rotation_acceleration: rest[3],
            velocity_ratio: v,
            acceleration_ratio: a,
        })
}

pub(crate) fn planner() -> impl Strategy<Value = Planner> {
    (bias(), speeds()).prop_map(|(tool, speeds)| Planner {
        geometry: Geometry::magician(tool),
        limits: Limits::CONTROLLER,
        speeds,
    })
}

pub(crate) fn as_f32(pose: &Pose) -> [f32; 4] {
    pose.to_array().map(|value| value as f32)
}

/// So many cases, the same in every run unless `PROPTEST_RNG_SEED` asks for others.
pub(crate) fn cases(count: u32) -> ProptestConfig {
    let config = ProptestConfig::default();
    ProptestConfig {
        cases: count,
        failure_persistence: None,
        rng_seed: match config.rng_seed {
            RngSeed::Random => RngSeed::Fixed(1),
            fixed => fixed,
        },
        ..config
    }
}

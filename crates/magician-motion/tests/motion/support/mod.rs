//! Strategies and helpers shared by the tests.
#![allow(dead_code)]

use magician_motion::{
    ArmModel, ArmState, Bound, Ceilings, Geometry, JointAngles, LIMIT_TOLERANCE, Limits,
    MotionError, MotionLaw, Move, MoveKind, Plan, Planner, Pose, Range, Speeds, Target, ToolBias,
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
        ..ArmModel::MAGICIAN.power_up.speeds()
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
            ArmModel::MAGICIAN.limits.check(joints).is_ok()
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
    (bias(), speeds(), law()).prop_map(|(tool, speeds, law)| Planner {
        geometry: Geometry::magician(tool),
        limits: ArmModel::MAGICIAN.limits,
        ceilings: Ceilings::default(),
        law,
        speeds,
    })
}

/// A planner in continuous time, for which closed forms hold.
pub(crate) fn continuous() -> Planner {
    Planner {
        law: MotionLaw::CONTINUOUS,
        ..Planner::default()
    }
}

/// Any planner in continuous time, for properties that hold at every microsecond.
pub(crate) fn continuous_planner() -> impl Strategy<Value = Planner> {
    planner().prop_map(|planner| Planner {
        law: MotionLaw::CONTINUOUS,
        ..planner
    })
}

/// Continuous time or periods.
pub(crate) fn law() -> impl Strategy<Value = MotionLaw> {
    prop_oneof![Just(MotionLaw::CONTINUOUS), Just(MotionLaw::MAGICIAN)]
}

pub(crate) fn as_f32(pose: &Pose) -> [f32; 4] {
    pose.to_array().map(|value| value as f32)
}

/// This many cases, the same in every run. With `PROPTEST_CASES`, that many, different in every
/// run.
pub(crate) fn cases(count: u32) -> ProptestConfig {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => config,
        None => ProptestConfig {
            cases: count,
            rng_seed: RngSeed::Fixed(1),
            ..config
        },
    }
}

/// Excess over the worst bound, degrees; infinite out of reach.
fn excess(planner: &Planner, limits: &Limits, state: &ArmState, straight: bool) -> f64 {
    let joints = if straight {
        match planner.geometry.inverse(&state.pose) {
            Ok(joints) => joints,
            Err(_) => return f64::INFINITY,
        }
    } else {
        state.joints
    };
    let over = |bound: Bound| {
        let beyond = bound.value(&joints) - limits.at(bound);
        if bound.is_upper() { beyond } else { -beyond }
    };
    Bound::ALL
        .into_iter()
        .map(over)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Samples the same motion without limits and compares.
pub(crate) fn agrees_with_sampling(
    planner: &Planner,
    straight: bool,
    plan: impl Fn(&Planner) -> Result<Plan, MotionError>,
) -> Result<bool, TestCaseError> {
    const SAMPLES: u64 = 4_000;
    let unlimited = Planner {
        limits: WITHOUT_LIMITS,
        ..*planner
    };
    let unlimited = plan(&unlimited).expect("planned");
    let whole = unlimited.trajectory;
    let crossing = match plan(planner) {
        Ok(plan) => plan.crossing,
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    let at = |t: u64| excess(planner, &planner.limits, &whole.sample(t), straight);
    let time = |sample: u64| {
        (u128::from(whole.duration_us()) * u128::from(sample) / u128::from(SAMPLES)) as u64
    };
    let seen = (1..SAMPLES).map(time).find(|t| at(*t) > LIMIT_TOLERANCE);
    match (seen, crossing) {
        (None, None) => {}
        (Some(t), None) => prop_assert!(false, "outside by {} at {t}, not found", at(t)),
        // The edge of reach, where the motion without limits ends, too.
        (None, Some(found)) if Some(found) == unlimited.crossing => {}
        (seen, Some(found)) => {
            // Samples before it are within, and just after it one is beyond.
            if let Some(t) = seen {
                let seen = planner.law.period_end(t);
                prop_assert!(found.at_us <= seen + 1, "seen {t}, found {found:?}");
            }
            let gap = whole.duration_us() / SAMPLES + 2;
            let period_us = u64::from(planner.law.period_us());
            let before = found.at_us.saturating_sub(period_us.max(2));
            prop_assert!(at(before) < 1e-6, "{} before {found:?}", at(before));
            if period_us > 0 {
                // Between two periods the curve may touch a bound that no reported pose exceeds.
                return Ok(true);
            }
            let just_after = (1..=400).map(|part| at(found.at_us + (gap * part / 400).max(1)));
            // An excursion shorter than the distance of samples has its peak close by.
            prop_assert!(
                just_after.fold(f64::NEG_INFINITY, f64::max) > 0.0,
                "nothing after {found:?} of {}",
                whole.duration_us()
            );
        }
    }
    Ok(crossing.is_some())
}

/// Limits just wider than some poses need, so that many paths between them touch the limits.
pub(crate) fn drawn_in(limits: &Limits, places: &[JointAngles], closer: f64) -> Limits {
    let draw = |bound: Bound| {
        let needed = places.iter().map(|joints| bound.value(joints));
        let ends = if bound.is_upper() {
            needed.fold(f64::NEG_INFINITY, f64::max)
        } else {
            needed.fold(f64::INFINITY, f64::min)
        };
        ends + (limits.at(bound) - ends) * (1.0 - closer) * 0.2
    };
    let range = |min, max| Range::new(draw(min), draw(max));
    Limits {
        j1: range(Bound::J1Min, Bound::J1Max),
        j2: range(Bound::J2Min, Bound::J2Max),
        j3: range(Bound::J3Min, Bound::J3Max),
        j4: range(Bound::J4Min, Bound::J4Max),
        j2_minus_j3: range(Bound::J23Min, Bound::J23Max),
    }
}

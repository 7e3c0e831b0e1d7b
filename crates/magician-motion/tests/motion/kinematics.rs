//! Forward and inverse kinematics, compared with poses reported by real arms and with each other.

use super::support::cases;
use magician_motion::{
    ArmModel, Bound, Geometry, JointAngles, Limits, MotionError, Pose, ToolBias, Unreachable,
};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Poses {
    pose: Vec<Reported>,
}

#[derive(Deserialize)]
struct Reported {
    id: String,
    xyzr: [f64; 4],
    joints_deg: [f64; 4],
    end_effector_bias: [f64; 3],
    printed_resolution: f64,
}

fn reported() -> Vec<Reported> {
    let poses: Poses = toml::from_str(include_str!("../data/poses.toml")).expect("valid test data");
    assert_eq!(poses.pose.len(), 12);
    poses.pose
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    ((a.x - b.x).powi(2) + (a.y - b.y).powi(2) + (a.z - b.z).powi(2)).sqrt()
}

fn largest_difference(a: &Pose, b: &Pose) -> f64 {
    let pairs = [(a.x, b.x), (a.y, b.y), (a.z, b.z)];
    pairs
        .map(|(a, b)| (a - b).abs())
        .into_iter()
        .fold(0.0, f64::max)
}

fn angular(a: &JointAngles, b: &JointAngles) -> f64 {
    let pairs = a.to_array().into_iter().zip(b.to_array());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn poses_of_real_arms_are_met() {
    for row in reported() {
        let [x, y, z] = row.end_effector_bias;
        let arm = Geometry::magician(ToolBias::new(x, y, z));
        let (joints, pose) = (JointAngles::from(row.joints_deg), Pose::from(row.xyzr));
        let forward = arm.forward(&joints);
        let inverse = arm
            .inverse_within(&pose, &ArmModel::MAGICIAN.limits)
            .expect(&row.id);
        let full_precision = row.printed_resolution < 1e-4;
        // The joints of hm01 are the documented home, not a printout; its pose is accurate to the
        // same 0.03 mm.
        let (mm, deg) = if full_precision {
            (2e-5, 2e-5)
        } else {
            (0.03, 0.01)
        };
        assert!(
            largest_difference(&forward, &pose) < mm,
            "{}: {forward:?}",
            row.id
        );
        assert!(angular(&inverse, &joints) < deg, "{}: {inverse:?}", row.id);
        assert!((forward.r - pose.r).abs() < 0.011, "{}", row.id);
    }
}

/// Joint angles within the controller's limits, corners and edges included.
fn reachable() -> impl Strategy<Value = JointAngles> {
    let edge = |min: f64, max: f64| prop_oneof![1 => Just(min), 1 => Just(max), 6 => min..=max];
    (
        edge(-135.0, 135.0),
        edge(-5.0, 90.0),
        edge(-70.0, 55.0),
        edge(-15.0, 90.0),
        edge(-150.0, 150.0),
        any::<bool>(),
    )
        .prop_map(|(j1, j2, coupled, j3, j4, on_coupling)| {
            let j3 = if on_coupling { j2 - coupled } else { j3 };
            JointAngles::new(j1, j2, j3, j4)
        })
        .prop_filter("within limits", |joints| {
            ArmModel::MAGICIAN.limits.check(joints).is_ok()
        })
}

fn bias() -> impl Strategy<Value = ToolBias> {
    prop_oneof![
        Just(ToolBias::NONE),
        Just(ToolBias::SUCTION),
        Just(ToolBias::PEN),
        Just(ToolBias::LASER),
        (0.0..120.0, -45.0..45.0, -60.0..120.0).prop_map(|(x, y, z)| ToolBias::new(x, y, z)),
    ]
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<f64>(), -500.0..500.0]
}

proptest! {
    #![proptest_config(cases(5_000))]

    #[test]
    fn inverse_undoes_forward(joints in reachable(), tool in bias()) {
        let arm = Geometry::magician(tool);
        let pose = arm.forward(&joints);
        let back = arm.inverse_within(&pose, &ArmModel::MAGICIAN.limits).expect("reachable");
        prop_assert!(angular(&back, &joints) < 1e-9, "{joints:?} {back:?}");
        prop_assert!(distance(&arm.forward(&back), &pose) < 1e-9);
    }

    #[test]
    fn whatever_is_solved_is_there(x in -400.0..400.0, y in -400.0..400.0, z in -300.0..300.0, tool in bias()) {
        let arm = Geometry::magician(tool);
        let pose = Pose::new(x, y, z, 10.0);
        match arm.inverse(&pose) {
            Ok(joints) => prop_assert!(distance(&arm.forward(&joints), &pose) < 1e-9),
            Err(error) => prop_assert!(matches!(error, MotionError::Unreachable(_))),
        }
    }

    #[test]
    fn nothing_panics(a in [any_number(), any_number(), any_number(), any_number()],
                      b in [any_number(), any_number(), any_number()]) {
        let arm = Geometry::magician(ToolBias::new(b[0], b[1], b[2]));
        if let Ok(joints) = arm.inverse(&Pose::from(a)) {
            prop_assert!(joints.is_finite());
        }
        let _ = arm.inverse_within(&arm.forward(&JointAngles::from(a)), &ArmModel::MAGICIAN.guaranteed);
        let _ = ArmModel::MAGICIAN.limits.check(&JointAngles::from(a));
    }
}

#[test]
fn out_of_reach_says_which_way() {
    let arm = Geometry::default();
    let at = |x, y, z| arm.inverse(&Pose::new(x, y, z, 0.0));
    assert_eq!(
        at(300.0, 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::TooFar {
            distance: 300.0,
            limit: 282.0
        }))
    );
    assert_eq!(
        at(5.0, 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::TooNear {
            distance: 5.0,
            limit: 12.0
        }))
    );
    assert!(matches!(
        at(0.0, 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::TooNear { .. }))
    ));
    assert!(matches!(
        at(1e200, 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::TooFar { .. }))
    ));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..4 {
            let mut pose = [200.0, 0.0, 0.0, 0.0];
            pose[axis] = bad;
            assert_eq!(
                arm.inverse(&pose.into()),
                Err(MotionError::Unreachable(Unreachable::NotFinite))
            );
        }
    }
    let sideways = Geometry::magician(ToolBias::new(0.0, 50.0, 0.0));
    assert_eq!(
        sideways.inverse(&Pose::new(30.0, 0.0, 0.0, 0.0)),
        Err(MotionError::Unreachable(Unreachable::TooNear {
            distance: 30.0,
            limit: 50.0
        }))
    );
}

#[test]
fn every_bound_is_named_with_both_values() {
    let limits = ArmModel::MAGICIAN.guaranteed;
    let cases = [
        (
            [-90.5, 45.0, 45.0, 0.0],
            Bound::J1Min,
            "joint 1 would be at -90.5 deg, limit -90.0 deg",
        ),
        (
            [90.5, 45.0, 45.0, 0.0],
            Bound::J1Max,
            "joint 1 would be at 90.5 deg, limit 90.0 deg",
        ),
        (
            [0.0, -1.0, 45.0, 0.0],
            Bound::J2Min,
            "joint 2 would be at -1.0 deg, limit 0.0 deg",
        ),
        (
            [0.0, 91.3, 45.0, 0.0],
            Bound::J2Max,
            "joint 2 would be at 91.3 deg, limit 85.0 deg",
        ),
        (
            [0.0, 10.0, -11.0, 0.0],
            Bound::J3Min,
            "joint 3 would be at -11.0 deg, limit -10.0 deg",
        ),
        (
            [0.0, 45.0, 90.1, 0.0],
            Bound::J3Max,
            "joint 3 would be at 90.1 deg, limit 90.0 deg",
        ),
        (
            [0.0, 45.0, 45.0, -100.0],
            Bound::J4Min,
            "joint 4 would be at -100.0 deg, limit -90.0 deg",
        ),
        (
            [0.0, 45.0, 45.0, 100.0],
            Bound::J4Max,
            "joint 4 would be at 100.0 deg, limit 90.0 deg",
        ),
        (
            [0.0, 10.0, 85.0, 0.0],
            Bound::J23Min,
            "joint 2 minus joint 3 would be at -75.0 deg, limit -70.0 deg",
        ),
        (
            [0.0, 80.0, 20.0, 0.0],
            Bound::J23Max,
            "joint 2 minus joint 3 would be at 60.0 deg, limit 55.0 deg",
        ),
    ];
    for (joints, expected, message) in cases {
        let joints = JointAngles::from(joints);
        let error = limits.check(&joints).expect_err(message);
        assert!(matches!(error, MotionError::Limit { bound, .. } if bound == expected));
        assert_eq!(error.to_string(), message);
        assert_eq!(limits.violations(&joints).collect::<Vec<_>>(), [expected]);
    }
    assert_eq!(Limits::default(), ArmModel::MAGICIAN.limits);
    assert!(limits.check(&JointAngles::HOME).is_ok());
}

#[test]
fn tools_are_known_by_name() {
    assert_eq!(
        ToolBias::named("Suction"),
        Some(ToolBias::new(59.7, 0.0, 0.0))
    );
    assert_eq!(ToolBias::named("gripper"), Some(ToolBias::GRIPPER));
    assert_eq!(ToolBias::named("pen").map(|tool| tool.x), Some(61.0));
    assert_eq!(ToolBias::named("laser").map(|tool| tool.x), Some(70.0));
    assert_eq!(ToolBias::named("none"), Some(ToolBias::default()));
    assert_eq!(ToolBias::named("spoon"), None);
}

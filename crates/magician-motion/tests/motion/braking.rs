//! The forced stop of a running motion.

use super::support::*;
use magician_motion::{
    ArmState, Bound, Geometry, JointAngles, Planner, Pose, Speeds, Target, ToolBias,
};
use proptest::prelude::*;

#[test]
fn a_base_at_full_speed_stops_in_the_time_of_the_law() {
    let planner = Planner {
        speeds: full_speed(),
        ..continuous()
    };
    let from = state(&planner, [-130.0, 45.0, 45.0, 0.0]);
    let request = joint_move(Target::JointIncrement(JointAngles::new(
        250.0, 0.0, 0.0, 0.0,
    )));
    let motion = planner.plan(&from, &request).expect("planned").trajectory;
    let plan = planner.brake(&motion, motion.duration_us() / 2, 2.0);
    let braked = plan.trajectory;
    // From 200 deg/s at 400 deg/s2: half a second, 50 degrees.
    assert_eq!(braked.duration_us(), 500_000);
    assert!((braked.start().joints.j1 + 5.0).abs() < 1e-9);
    assert!((braked.end().joints.j1 - 45.0).abs() < 1e-9);
    assert!((braked.joint_velocities(250_000)[0] - 100.0).abs() < 1e-9);
    assert_eq!(plan.crossing, None);
    // At rest, before and after the motion, there is nothing to brake.
    for t in [0, motion.duration_us(), u64::MAX] {
        let still = planner.brake(&motion, t, 2.0).trajectory;
        assert_eq!(still.duration_us(), 0);
        assert_eq!(still.sample(0), motion.sample(t));
    }
    // The factor scales the deceleration; an invalid one stops the arm at once.
    for (factor, us) in [
        (1.0, 1_000_000),
        (8.0, 125_000),
        (0.0, 0),
        (-1.0, 0),
        (f64::NAN, 0),
    ] {
        let plan = planner.brake(&motion, motion.duration_us() / 2, factor);
        assert_eq!(plan.trajectory.duration_us(), us, "{factor}");
    }
    // An invalid acceleration stops it at once, too.
    let none = Planner {
        speeds: Speeds {
            joint_acceleration: [0.0; 4],
            ..planner.speeds
        },
        ..planner
    };
    let dead = none.brake(&motion, 1_000_000, 2.0).trajectory;
    assert_eq!(
        (dead.duration_us(), *dead.end()),
        (0, motion.sample(1_000_000))
    );
}

/// Lines tangent to the circle around the base axis whose radius is the sideways offset of the
/// tool. At that point a joint velocity is infinite or NaN.
#[test]
fn brake_at_singular_pose_stops_at_once() {
    for tenths in 1..=600 {
        let before = f64::from(tenths) * 0.1;
        let planner = Planner {
            geometry: Geometry::magician(ToolBias::new(-100.0, 20.0, 0.0)),
            // The arm reaches the circle after a second.
            speeds: Speeds {
                linear_velocity: 300.0,
                linear_acceleration: 2.0 * before,
                ..full_speed()
            },
            ..continuous()
        };
        let pose = Pose::new(20.0, -before, 0.0, 0.0);
        let joints = planner.geometry.inverse(&pose).expect("in reach");
        let from = ArmState { joints, pose };
        let to = Target::Pose(Pose::new(20.0, 1.5 * before, 0.0, 0.0));
        let motion = planner.plan(&from, &line(to)).expect("planned").trajectory;
        for t in [999_999, 1_000_000, 1_000_001] {
            let braked = planner.brake(&motion, t, 2.0).trajectory;
            assert!(braked.duration_us() < 1_000_000_000, "{before} {t}");
            for state in [braked.sample(0), *braked.end()] {
                assert!(state.joints.is_finite(), "{before} {t}: {state:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn stops_together_without_reversal_within_twice_the_acceleration(
        from in reachable(), to in reachable(), planner in continuous_planner(), straight in any::<bool>(), share in 0.0..1.0f64,
    ) {
        let from = ArmState::at_joints(&planner.geometry, &from);
        let target = Target::Pose(planner.geometry.forward(&to));
        let request = if straight { line(target) } else { joint_move(target) };
        let motion = planner.plan(&from, &request).expect("planned").trajectory;
        let t = (motion.duration_us() as f64 * share) as u64;
        let plan = planner.brake(&motion, t, 2.0);
        let braked = plan.trajectory;
        prop_assert_eq!(braked.sample(0), motion.sample(t));
        let before = motion.joint_velocities(t);
        let speeds = planner.speeds;
        let limit = |joint: usize| 2.0 * speeds.joint_acceleration[joint].min(300.0)
            * speeds.acceleration_ratio.min(100.0) / 100.0;
        let needed = (0..3).map(|joint| before[joint].abs() / limit(joint)).fold(0.0, f64::max);
        if plan.crossing.is_none() {
            prop_assert!((braked.duration_us() as f64 / 1e6 - needed).abs() <= 2e-6);
        }
        prop_assert_eq!(braked.joint_velocities(0)[3], 0.0);
        for step in 0..50u64 {
            let now = braked.joint_velocities(braked.duration_us() * step / 50);
            for joint in 0..3 {
                let seconds = braked.duration_us() as f64 * step as f64 / 50.0 / 1e6;
                // Never reversed, never faster, never harder than the limit.
                prop_assert!(now[joint] * before[joint] >= 0.0);
                prop_assert!(now[joint].abs() <= before[joint].abs());
                prop_assert!((before[joint] - now[joint]).abs() <= limit(joint) * seconds * (1.0 + 1e-6) + 1e-9);
            }
        }
        // At a limit it stops.
        for bound in Bound::ALL {
            let side = if bound.is_upper() { 1.0 } else { -1.0 };
            let end = braked.end().joints;
            prop_assert!(side * (bound.value(&end) - planner.limits.at(bound)) < 1e-6);
        }
    }
}

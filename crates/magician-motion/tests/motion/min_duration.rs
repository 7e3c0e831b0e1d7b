//! Motions with a minimum duration.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, LIMIT_TOLERANCE, Move, MoveKind, Planner, Pose, Target, Trajectory,
    Transfer,
};
use proptest::prelude::*;

fn kind() -> impl Strategy<Value = MoveKind> {
    prop_oneof![
        Just(MoveKind::Joint),
        Just(MoveKind::Line),
        Just(MoveKind::Jump(
            ArmModel::MAGICIAN.power_up.jump(),
            Transfer::Joint
        )),
        Just(MoveKind::Jump(
            ArmModel::MAGICIAN.power_up.jump(),
            Transfer::Line
        )),
    ]
}

#[test]
fn a_quick_motion_waits_and_a_slow_one_does_not() {
    let planner = continuous();
    let from = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    // 100 mm at 100 mm/s and 100 mm/s2: 2 s.
    let sideways = line(Target::PoseIncrement(Pose::new(0.0, 100.0, 0.0, 0.0)));
    let lasting = |least_us| {
        planner
            .plan_with_min_duration(&from, &sideways, least_us)
            .expect("planned")
    };
    let plain = planner.plan(&from, &sideways).expect("planned");
    for least_us in [0, 1, 1_999_999, 2_000_000] {
        assert_eq!(lasting(least_us), plain);
    }
    for least_us in [2_000_001, 2_345_678, 3_000_000, 60_000_000, u64::MAX] {
        let motion = lasting(least_us).trajectory;
        assert_eq!(motion.duration_us(), least_us);
        assert_eq!(motion.end(), plain.trajectory.end());
    }
    // Half of the distance after half of the time, at 2 s / T if all of it is ramps.
    let motion = lasting(4_000_000).trajectory;
    assert!((motion.progress(2_000_000) - 0.5).abs() < 1e-12);
    assert!((motion.progress(1_000_000) - 0.125).abs() < 1e-12);
}

#[test]
fn the_law_of_the_model_stretches_a_motion_that_cruises() {
    let planner = continuous();
    let from = state(&planner, [-100.0, 45.0, 45.0, 0.0]);
    // 180 degrees at 100 deg/s and 100 deg/s2 take 2.8 s. In 3 s it still cruises, with ramps of
    // 1.2 s.
    let turn = joint_move(Target::JointIncrement([180.0, 0.0, 0.0, 0.0].into()));
    let motion = planner
        .plan_with_min_duration(&from, &turn, 3_000_000)
        .expect("planned")
        .trajectory;
    assert_eq!(motion.duration_us(), 3_000_000);
    for (t, velocity) in [
        (600_000, 50.0),
        (1_200_000, 100.0),
        (1_800_000, 100.0),
        (2_400_000, 50.0),
    ] {
        assert!(
            (motion.joint_velocities(t)[0] - velocity).abs() < 1e-6,
            "{t}"
        );
    }
    // In 4 s it does not cruise.
    let motion = planner
        .plan_with_min_duration(&from, &turn, 4_000_000)
        .expect("planned")
        .trajectory;
    assert!((motion.joint_velocities(2_000_000)[0] - 90.0).abs() < 1e-6);
}

#[test]
fn no_motion_takes_no_time() {
    let planner = continuous();
    let from = state(&planner, [10.0, 45.0, 45.0, 0.0]);
    for request in [
        line(Target::Pose(from.pose)),
        joint_move(Target::Joints(from.joints)),
    ] {
        let plan = planner
            .plan_with_min_duration(&from, &request, 5_000_000)
            .expect("planned");
        assert_eq!((plan.trajectory.duration_us(), plan.crossing), (0, None));
    }
}

proptest! {
    #![proptest_config(cases(600))]

    #[test]
    fn every_leg_is_stretched_by_the_same_factor(
        from in reachable(), to in reachable(), planner in planner(), kind in kind(), factor in 1.0..6.0f64,
    ) {
        let from = ArmState::at_joints(&planner.geometry, &from);
        let request = Move { target: Target::Pose(planner.geometry.forward(&to)), kind };
        let free = Planner { limits: WITHOUT_LIMITS, ..planner };
        let Ok(plain) = free.plan(&from, &request) else {
            return Ok(());
        };
        prop_assume!(plain.crossing.is_none());
        let plain = plain.trajectory;
        let least_us = (plain.duration_us() as f64 * factor) as u64 + 1;
        let motion = free.plan_with_min_duration(&from, &request, least_us).expect("planned").trajectory;
        prop_assert_eq!(motion.duration_us(), planner.law.period_end(least_us));
        let least_us = motion.duration_us();
        prop_assert_eq!(motion.end(), plain.end());
        prop_assert_eq!(motion.sample(0), plain.sample(0));
        let factor = least_us as f64 / plain.duration_us() as f64;
        // Leg by leg, the shares done differ by no more than those of a trapezoid and a triangle.
        for step in 0..=100u64 {
            let t = plain.duration_us() * step / 100;
            let later = (t as f64 * factor) as u64;
            let period = 2.0 * f64::from(planner.law.period_us()) / plain.duration_us() as f64;
            prop_assert!((plain.progress(t) - motion.progress(later)).abs() < 0.126 + 2.0 * period);
        }
        match kind {
            // The path is unchanged.
            MoveKind::Line if planner.law.is_continuous() => for share in [0.1, 0.35, 0.5, 0.8] {
                let place = |motion: &Trajectory| motion.sample(motion.time_at_progress(share).expect("reached")).pose;
                prop_assert!(place(&plain).distance_to(&place(&motion)) < 1e-3);
            },
            // No joint is faster than before, and the slowest one starts and ends with the others.
            MoveKind::Joint => {
                let fastest = |motion: &Trajectory| {
                    (0..400u64).map(|step| motion.joint_velocities(motion.duration_us() * step / 400))
                        .fold([0.0f64; 4], |most, now| [0, 1, 2, 3].map(|joint| most[joint].max(now[joint].abs())))
                };
                let (quick, slow) = (fastest(&plain), fastest(&motion));
                for joint in 0..4 {
                    prop_assert!(slow[joint] <= quick[joint] * 1.01 + 1e-6);
                    let moves = motion.joint_velocities(least_us - 1)[joint].abs() > 0.0;
                    prop_assert!(moves || quick[joint] < 1e-6 || least_us == u64::from(planner.law.period_us()));
                }
            }
            MoveKind::Line | MoveKind::Jump(..) => {}
        }
    }

    #[test]
    fn limits_on_the_way_still_end_it(from in reachable(), to in reachable(), planner in planner()) {
        let from = ArmState::at_joints(&planner.geometry, &from);
        let request = line(Target::Pose(planner.geometry.forward(&to)));
        let plain = planner.plan(&from, &request).expect("planned");
        let whole = Planner { limits: WITHOUT_LIMITS, ..planner }.plan(&from, &request).expect("planned").trajectory;
        let slow = planner.plan_with_min_duration(&from, &request, whole.duration_us() * 3).expect("planned");
        // r has another profile then, and so has J4; the other joints cross at the same position.
        let Some(crossing) = plain.crossing else {
            return Ok(());
        };
        let motion = slow.trajectory;
        let end = motion.duration_us();
        for step in 0..=200u64 {
            let joints = motion.sample(end * step / 200).joints;
            for bound in planner.limits.violations(&joints) {
                let side = if bound.is_upper() { 1.0 } else { -1.0 };
                prop_assert!(side * (bound.value(&joints) - planner.limits.at(bound)) < 1e-3 + LIMIT_TOLERANCE, "{crossing:?}");
            }
        }
    }
}

//! Crossings of motions with limits and the edge of reach: the analytic answer against dense
//! sampling.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Bound, Geometry, Jog, JogAxis, JointAngles, KinematicLimits, Limits,
    MotionError, Planner, Pose, Target, ToolBias, Unreachable,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(750))]

    #[test]
    fn on_lines(from in reachable(), to in reachable(), planner in planner()) {
        let from = ArmState::at_joints(&planner.geometry, &from);
        let to = planner.geometry.forward(&to);
        agrees_with_sampling(&planner, true, |planner| planner.plan(&from, &line(Target::Pose(to))))?;
    }

    #[test]
    fn on_lines_that_graze(from in reachable(), to in reachable(), planner in planner(), closer in 0.5..1.0f64) {
        // Limits just wider than the ends need, so that many lines touch them.
        let planner = Planner {
            limits: drawn_in(&planner.limits, &[from, to], closer),
            ..planner
        };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let to = planner.geometry.forward(&to);
        agrees_with_sampling(&planner, true, |planner| planner.plan(&from, &line(Target::Pose(to))))?;
    }

    #[test]
    fn on_lines_through_the_base_axis(
        from in reachable(),
        aside in prop::sample::select(vec![0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.02, 1.0]),
        tool in 0.0..90.0f64,
    ) {
        let planner = ArmModel::MAGICIAN.planner(ToolBias { x: tool, y: 0.0, z: 0.0 }, ArmModel::MAGICIAN.power_up.speeds());
        let mut from = ArmState::at_joints(&planner.geometry, &JointAngles { j1: 0.0, ..from });
        from.pose.y = aside;
        let Ok(joints) = planner.geometry.inverse(&from.pose) else {
            return Ok(());
        };
        let from = ArmState::at_joints(&planner.geometry, &joints);
        let inwards = Jog { axis: JogAxis::X, positive: from.pose.x < 0.0 };
        let rates = KinematicLimits { velocity: 50.0, acceleration: 200.0 };
        agrees_with_sampling(&planner, true, |planner| planner.jog(&from, inwards, rates, 0.0))?;
    }

    #[test]
    fn of_joint_four_alone(from in reachable(), to in reachable(), planner in planner(), share in 0.0..1.0f64) {
        let (low, high) = (from.j4.min(to.j4), from.j4.max(to.j4));
        let planner = Planner {
            limits: Limits { j4: magician_motion::Range::new(low - 10.0 * share, high + 10.0 * share), ..WITHOUT_LIMITS },
            ..planner
        };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let to = planner.geometry.forward(&to);
        // The cut of `atan2` behind the base is beyond any limit of J1.
        if from.pose.x <= 0.0 || to.x <= 0.0 {
            return Ok(());
        }
        agrees_with_sampling(&planner, true, |planner| planner.plan(&from, &line(Target::Pose(to))))?;
    }

    #[test]
    fn on_joint_motions(from in reachable(), to in reachable(), planner in planner(), beyond in 0.8..1.6f64) {
        let target = JointAngles::from(to.to_array().map(|angle| angle * beyond));
        let from = ArmState::at_joints(&planner.geometry, &from);
        agrees_with_sampling(&planner, false, |planner| planner.plan(&from, &joint_move(Target::Joints(target))))?;
    }

    #[test]
    fn from_outside_inwards_only(from in reachable(), to in reachable(), planner in planner(), shrink in 0.3..1.0f64) {
        // The start may be outside of these limits; the target is inside.
        let tight = Limits {
            j1: magician_motion::Range::new(-135.0 * shrink, 135.0 * shrink),
            j2: magician_motion::Range::new(-5.0, 90.0 * shrink),
            ..ArmModel::MAGICIAN.limits
        };
        if tight.check(&to).is_err() {
            return Ok(());
        }
        let planner = Planner { limits: tight, ..planner };
        let start = ArmState::at_joints(&planner.geometry, &from);
        let request = line(Target::Pose(planner.geometry.forward(&to)));
        let plan = planner.plan(&start, &request).expect("planned");
        let outside: Vec<Bound> = tight.violations(&from).collect();
        // On the planned path no bound is violated by more than at the start.
        let motion = plan.trajectory;
        for step in 0..=500u64 {
            let joints = motion.sample(motion.duration_us() * step / 500).joints;
            for bound in tight.violations(&joints) {
                let side = if bound.is_upper() { 1.0 } else { -1.0 };
                let further = side * (bound.value(&joints) - bound.value(&from));
                // The time of a crossing is exact to a microsecond.
                prop_assert!(outside.contains(&bound) && further < 1e-3 || side * (bound.value(&joints) - tight.at(bound)) < 1e-3,
                    "{bound:?} {joints:?} from {from:?}");
            }
        }
    }
}

#[test]
fn samples_are_found_to_cross_often_enough_to_prove_something() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let mut crossed = 0;
    for _ in 0..500 {
        let mut draw = || {
            reachable()
                .new_tree(&mut runner)
                .expect("a value")
                .current()
        };
        let planner = continuous();
        let from = ArmState::at_joints(&planner.geometry, &draw());
        let to = planner.geometry.forward(&draw());
        let request = line(Target::Pose(to));
        crossed += usize::from(
            planner
                .plan(&from, &request)
                .expect("planned")
                .crossing
                .is_some(),
        );
    }
    assert!((50..450).contains(&crossed), "{crossed}");
}

#[test]
fn a_line_past_the_base_leaves_the_workspace() {
    let planner = continuous();
    let from = state(&planner, [-80.0, 45.0, 45.0, 80.0]);
    let to = planner
        .geometry
        .forward(&JointAngles::new(80.0, 45.0, 45.0, -80.0));
    let plan = planner
        .plan(&from, &line(Target::Pose(to)))
        .expect("planned");
    let crossing = plan.crossing.expect("too near the base");
    // The wrist comes too close: J2 - J3 = -70 at a distance d with d^2 = 135^2 + 147^2 - 2 * 135 *
    // 147 * sin(70), which the line reaches in closed form.
    let MotionError::Limit { bound, .. } = crossing.cause else {
        panic!("{crossing:?}")
    };
    let stopped = plan.trajectory.end();
    assert!((bound.value(&stopped.joints) - planner.limits.at(bound)).abs() < 1e-9);
    assert_eq!(plan.trajectory.sample(crossing.at_us), *stopped);
    assert!((plan.trajectory.progress(crossing.at_us) - crossing.progress).abs() < 1e-12);
}

#[test]
fn without_limits_the_end_of_reach_is_the_end() {
    let planner = Planner {
        limits: WITHOUT_LIMITS,
        ..continuous()
    };
    let from = state(&planner, [0.0, 20.0, 80.0, 0.0]);
    let to = Pose {
        x: -from.pose.x,
        ..from.pose
    };
    let through_the_base = planner
        .plan(&from, &line(Target::Pose(to)))
        .expect("planned");
    let low = from.pose.z.abs() < 12.0;
    assert_eq!(through_the_base.crossing.is_some(), low);
    let sideways = Planner {
        geometry: Geometry::magician(ToolBias::new(0.0, 40.0, 0.0)),
        ..planner
    };
    let from = state(&sideways, [0.0, 20.0, 80.0, 0.0]);
    let to = Pose {
        x: -from.pose.x,
        y: -from.pose.y,
        ..from.pose
    };
    let plan = sideways
        .plan(&from, &line(Target::Pose(to)))
        .expect("planned");
    assert!(matches!(
        plan.crossing
            .expect("passes the axis nearer than the bias")
            .cause,
        MotionError::Unreachable(Unreachable::TooNear { .. })
    ));
    let end = plan.trajectory.end().pose;
    assert!((end.x.hypot(end.y) - 40.0).abs() < 1e-6);
}

#[test]
fn joint_motions_run_to_the_limit_exactly() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let cases = [
        ([170.0, 45.0, 45.0, 0.0], Bound::J1Max, 170.0),
        ([-1e30, 45.0, 45.0, 0.0], Bound::J1Min, -1e9),
        ([0.0, 95.0, 80.0, 0.0], Bound::J2Max, 95.0),
        ([0.0, 45.0, 92.0, 0.0], Bound::J3Max, 92.0),
        ([0.0, 45.0, 45.0, -151.0], Bound::J4Min, -151.0),
        ([0.0, 85.0, 20.0, 0.0], Bound::J23Max, 65.0),
        ([0.0, 10.0, 85.0, 0.0], Bound::J23Min, -75.0),
    ];
    for (target, expected, value) in cases {
        let request = joint_move(Target::Joints(target.into()));
        let plan = planner.plan(&home, &request).expect("not refused");
        let crossing = plan.crossing.expect("beyond a limit");
        let limit = planner.limits.at(expected);
        assert_eq!(
            crossing.cause,
            MotionError::Limit {
                bound: expected,
                value,
                limit
            }
        );
        let stopped = plan.trajectory.sample(u64::MAX).joints;
        assert!((expected.value(&stopped) - limit).abs() < 1e-9);
        assert!(planner.limits.check(&stopped).is_ok());
        // From there, further out is refused at once and back in is not.
        let there = *plan.trajectory.end();
        let again = planner.plan(&there, &request).expect("not refused");
        assert_eq!(again.crossing.map(|crossing| crossing.at_us), Some(0));
        assert_eq!(*again.trajectory.end(), there);
        let back = joint_move(Target::Joints(JointAngles::HOME));
        assert_eq!(planner.plan(&there, &back).expect("planned").crossing, None);
    }
}

#[test]
fn from_beyond_a_limit_the_way_is_back_in() {
    let planner = continuous();
    let beyond = state(&planner, [140.0, 45.0, 45.0, 0.0]);
    let by = |j1, j2| joint_move(Target::JointIncrement(JointAngles::new(j1, j2, 0.0, 0.0)));
    let plan = |request| planner.plan(&beyond, &request).expect("planned");
    assert_eq!(
        plan(by(2.0, 0.0)).crossing.map(|crossing| crossing.at_us),
        Some(0)
    );
    assert_eq!(plan(by(-2.0, 0.0)).crossing, None);
    assert_eq!(plan(by(-20.0, 0.0)).crossing, None);
    // A motion of another joint leads no further out.
    assert_eq!(plan(by(0.0, 5.0)).crossing, None);
    let inwards = plan(by(-300.0, 0.0)).crossing.expect("the other side");
    assert!(matches!(
        inwards.cause,
        MotionError::Limit {
            bound: Bound::J1Min,
            ..
        }
    ));
    let out = line(Target::Pose(planner.geometry.forward(&JointAngles::HOME)));
    let far_out = state(&planner, [0.0, 93.0, 60.0, 0.0]);
    assert_eq!(
        planner.plan(&far_out, &out).expect("planned").crossing,
        None
    );
}

/// The base starts beyond its bound, comes back within on a circle, and would leave again at the
/// far end of the turn. The bound that was widened for the start applies again as soon as it was
/// kept.
#[test]
fn a_motion_that_has_come_back_within_a_bound_stops_where_it_would_leave_it_again() {
    let limits = Limits {
        j1: magician_motion::Range::new(-135.0, 50.0),
        ..ArmModel::MAGICIAN.limits
    };
    let planner = Planner {
        limits,
        ..continuous()
    };
    // Around a centre at 43 degrees; seen from the base the circle spans 31 to 55 degrees. It
    // starts where it has just begun to lead inwards.
    let (distance, centre) = (200.0, 43.0_f64.to_radians());
    let radius = distance * 12.0_f64.to_radians().sin();
    let at = |angle: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        Pose::new(
            distance * centre.cos() + radius * cos,
            distance * centre.sin() + radius * sin,
            0.0,
            45.0,
        )
    };
    let from = ArmState::at_pose(&planner.geometry, &at(155.0), &ArmModel::MAGICIAN.limits)
        .expect("there");
    assert_eq!(
        limits.violations(&from.joints).collect::<Vec<_>>(),
        [Bound::J1Max]
    );
    let plan = planner
        .circle(&from, &at(275.0), &at(35.0), 1)
        .expect("planned");
    let crossing = plan.crossing.expect("it leaves the limits again");
    assert!(matches!(
        crossing.cause,
        MotionError::Limit {
            bound: Bound::J1Max,
            ..
        }
    ));
    let motion = plan.trajectory;
    let (half, end) = (motion.duration_us() / 2, motion.duration_us());
    assert!(motion.sample(half).joints.j1 < 49.0, "it was within");
    let end = motion.sample(end).joints.j1;
    assert!((end - 50.0).abs() < 1e-3, "{end}");
}

/// A pose whose wrist is slightly behind the base axis belongs to other joints, a degree away. A
/// path in space cannot start there.
#[test]
fn joints_a_degree_from_those_of_their_pose_begin_no_line() {
    let joints = JointAngles::HOME;
    let wrist = Geometry::default().forward(&joints).x;
    for behind in [0.01, 1.0, 5.0] {
        let geometry = Geometry::magician(ToolBias::new(-wrist - behind, 100.0, 0.0));
        let planner = Planner {
            geometry,
            ..continuous()
        };
        let from = ArmState::at_joints(&geometry, &joints);
        let solved = geometry.inverse(&from.pose).expect("joints");
        let apart = solved.to_array().into_iter().zip(joints.to_array());
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!((1e-3..10.0).contains(&apart), "{apart}");
        let request = line(Target::PoseIncrement(Pose::new(0.0, 0.0, -5.0, 0.0)));
        let error = planner
            .plan(&from, &request)
            .expect_err("no line begins there");
        assert!(
            matches!(error, MotionError::Unreachable(Unreachable::TooNear { .. })),
            "{error:?}"
        );
    }
}

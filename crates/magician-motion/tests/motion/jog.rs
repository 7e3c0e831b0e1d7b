//! Jogs: to the limits, to a stop, and back.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Bound, Geometry, Jog, JogAxis, KinematicLimits, LIMIT_TOLERANCE, Limits,
    MotionError, Planner, Pose, Range, SpeedQuantity, Speeds, ToolBias,
};
use proptest::prelude::*;

const AXES: [JogAxis; 8] = [
    JogAxis::J1,
    JogAxis::J2,
    JogAxis::J3,
    JogAxis::J4,
    JogAxis::X,
    JogAxis::Y,
    JogAxis::Z,
    JogAxis::R,
];

fn jogs() -> impl Strategy<Value = Jog> {
    (proptest::sample::select(&AXES[..]), any::<bool>())
        .prop_map(|(axis, positive)| Jog { axis, positive })
}

fn rates() -> impl Strategy<Value = KinematicLimits> {
    (2.0..300.0f64, 5.0..300.0f64).prop_map(|(velocity, acceleration)| KinematicLimits {
        velocity,
        acceleration,
    })
}

fn is_straight(axis: JogAxis) -> bool {
    matches!(axis, JogAxis::X | JogAxis::Y | JogAxis::Z)
}

fn sign(jog: Jog) -> f64 {
    if jog.positive { 1.0 } else { -1.0 }
}

/// Value that a jog changes.
fn value(axis: JogAxis, state: &ArmState) -> f64 {
    match axis {
        JogAxis::J1 => state.joints.j1,
        JogAxis::J2 => state.joints.j2,
        JogAxis::J3 => state.joints.j3,
        JogAxis::J4 => state.joints.j4,
        JogAxis::X => state.pose.x,
        JogAxis::Y => state.pose.y,
        JogAxis::Z => state.pose.z,
        JogAxis::R => state.pose.r,
    }
}

/// Checks that only the jogged axis moves.
fn check_only_axis_moves(
    axis: JogAxis,
    from: &ArmState,
    now: &ArmState,
) -> Result<(), TestCaseError> {
    if is_straight(axis) {
        let (before, after) = (from.pose.to_array(), now.pose.to_array());
        for (place, name) in [JogAxis::X, JogAxis::Y, JogAxis::Z, JogAxis::R]
            .iter()
            .enumerate()
        {
            if *name != axis {
                prop_assert_eq!(before[place], after[place]);
            }
        }
        prop_assert!((now.joints.j1 + now.joints.j4 - from.pose.r).abs() < 1e-9);
    } else {
        let (before, after) = (from.joints.to_array(), now.joints.to_array());
        let moving = match axis {
            JogAxis::J1 => 0,
            JogAxis::J2 => 1,
            JogAxis::J3 => 2,
            _ => 3,
        };
        for joint in (0..4).filter(|joint| *joint != moving) {
            prop_assert!((before[joint] - after[joint]).abs() < 1e-12);
        }
    }
    Ok(())
}

fn excess(limits: &Limits, state: &ArmState) -> f64 {
    let over = |bound: Bound| {
        let beyond = bound.value(&state.joints) - limits.at(bound);
        if bound.is_upper() { beyond } else { -beyond }
    };
    Bound::ALL
        .into_iter()
        .map(over)
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn joint_jog_reaches_its_limit_in_the_computed_time() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let rates = KinematicLimits {
        velocity: 15.0,
        acceleration: 50.0,
    };
    let jog = |axis, positive| {
        planner
            .jog(&home, Jog { axis, positive }, rates, 0.0)
            .expect("planned")
    };
    let plan = jog(JogAxis::J1, true);
    // 0.3 s and 2.25 degrees to reach 15 deg/s, then constant speed.
    let expected = 0.3 + (135.0 - 2.25) / 15.0;
    assert_eq!(plan.trajectory.duration_us(), (expected * 1e6) as u64);
    assert_eq!(plan.trajectory.end().joints.j1, 135.0);
    assert_eq!(plan.trajectory.velocity_along(JogAxis::J1, 5_000_000), 15.0);
    let bounds = [
        (JogAxis::J1, false, Bound::J1Min),
        (JogAxis::J2, true, Bound::J2Max),
        (JogAxis::J2, false, Bound::J2Min),
        (JogAxis::J3, true, Bound::J3Max),
        (JogAxis::J3, false, Bound::J23Max),
        (JogAxis::J4, true, Bound::J4Max),
        (JogAxis::R, false, Bound::J4Min),
    ];
    for (axis, positive, expected) in bounds {
        let plan = jog(axis, positive);
        let crossing = plan.crossing.expect("there is a limit");
        let MotionError::Limit { bound, limit, .. } = crossing.cause else {
            panic!("{crossing:?}")
        };
        assert_eq!(bound, expected);
        let end = bound.value(&plan.trajectory.end().joints);
        assert!((end - limit).abs() < 1e-12, "{bound:?} at {end}");
    }
}

#[test]
fn zero_negative_and_nan_rates_are_refused() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let refused = |axis, velocity, acceleration, entry| {
        let rates = KinematicLimits {
            velocity,
            acceleration,
        };
        let jog = Jog {
            axis,
            positive: true,
        };
        match planner.jog(&home, jog, rates, entry) {
            Err(MotionError::Speed { quantity, .. }) => quantity,
            other => panic!("{other:?}"),
        }
    };
    let (velocity, acceleration) = (
        SpeedQuantity::JointVelocity(2),
        SpeedQuantity::JointAcceleration(2),
    );
    for invalid in [0.0, -1.0, f64::NAN] {
        assert_eq!(refused(JogAxis::J2, invalid, 50.0, 0.0), velocity);
        assert_eq!(refused(JogAxis::J2, 15.0, invalid, 0.0), acceleration);
        let linear = SpeedQuantity::LinearVelocity;
        assert_eq!(refused(JogAxis::Z, invalid, 50.0, 0.0), linear);
    }
    assert_eq!(refused(JogAxis::J2, 15.0, 50.0, f64::NAN), velocity);
    assert_eq!(refused(JogAxis::J2, 15.0, 50.0, f64::INFINITY), velocity);
    let settings = Speeds {
        linear_velocity: 1000.0,
        velocity_ratio: 50.0,
        ..ArmModel::MAGICIAN.power_up.speeds()
    };
    // The ceiling applies before the ratio.
    let rates = settings
        .jog(JogAxis::X, &ArmModel::MAGICIAN.ceilings)
        .expect("speeds");
    assert_eq!(rates.velocity, 150.0);
}

#[test]
fn without_limits_a_joint_never_stops_and_a_line_ends_at_reach() {
    let planner = Planner {
        limits: WITHOUT_LIMITS,
        ..continuous()
    };
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let rates = KinematicLimits {
        velocity: 20.0,
        acceleration: 50.0,
    };
    let jog_forwards = |axis| {
        let jog = Jog {
            axis,
            positive: true,
        };
        planner.jog(&home, jog, rates, 0.0).expect("planned")
    };
    let base = jog_forwards(JogAxis::J1);
    assert_eq!(base.crossing, None);
    assert!(base.trajectory.duration_us() > 10_000_000_000_000);
    let out = jog_forwards(JogAxis::X);
    assert!(matches!(
        out.crossing.expect("the end of reach").cause,
        MotionError::Unreachable(_)
    ));
    let joints = out.trajectory.end().joints;
    assert!((joints.j2 - joints.j3 - 90.0).abs() < 1e-3, "{joints:?}");
}

#[test]
fn jog_at_or_beyond_a_limit_moves_only_inwards() {
    let planner = continuous();
    let rates = KinematicLimits {
        velocity: 20.0,
        acceleration: 50.0,
    };
    for j1 in [135.0, 135.0 + 0.5 * LIMIT_TOLERANCE, 140.0] {
        let from = state(&planner, [j1, 45.0, 45.0, 0.0]);
        let jog_j1 = |positive| {
            let axis = JogAxis::J1;
            planner
                .jog(&from, Jog { axis, positive }, rates, 0.0)
                .expect("planned")
        };
        let out = jog_j1(true);
        assert_eq!(out.crossing.map(|crossing| crossing.at_us), Some(0));
        assert_eq!(
            (out.trajectory.duration_us(), *out.trajectory.end()),
            (0, from)
        );
        let back = jog_j1(false);
        assert_eq!(back.trajectory.end().joints.j1, -135.0);
    }
    // A straight jog forwards with the rear arm leaning back, at J2 = -8 degrees, is possible.
    let high = state(&planner, [0.0, -8.0, 0.0, 0.0]);
    let lower = Jog {
        axis: JogAxis::X,
        positive: true,
    };
    let plan = planner.jog(&high, lower, rates, 0.0).expect("planned");
    assert!(plan.trajectory.duration_us() > 100_000);
}

#[test]
fn stop_of_another_motion_brakes_each_joint() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let request = line(magician_motion::Target::PoseIncrement(Pose::new(
        0.0, 80.0, 0.0, 30.0,
    )));
    let motion = planner.plan(&home, &request).expect("planned").trajectory;
    let at_us = motion.duration_us() / 2;
    let stop = planner.jog_stop(&motion, at_us, 100.0).trajectory;
    assert_eq!(stop.sample(0), motion.sample(at_us));
    assert!(stop.duration_us() > 0);
    for deceleration in [0.0, -1.0, f64::NAN] {
        let immediate = planner.jog_stop(&motion, at_us, deceleration).trajectory;
        assert_eq!(
            (immediate.duration_us(), *immediate.end()),
            (0, motion.sample(at_us))
        );
    }
}

proptest! {
    #![proptest_config(cases(750))]

    #[test]
    fn every_axis_runs_to_a_limit_and_never_beyond(
        from in reachable(), tool in bias(), jog in jogs(), rates in rates(),
    ) {
        let planner = Planner { geometry: Geometry::magician(tool), ..continuous() };
        let from = ArmState::at_joints(&planner.geometry, &from);
        // If the bias is larger than the distance of the wrist, the pose has other joints than
        // these.
        let again = planner.geometry.inverse(&from.pose);
        if is_straight(jog.axis) && again.is_ok_and(|joints| (joints.j1 - from.joints.j1).abs() > 1e-6) {
            return Ok(());
        }
        let plan = planner.jog(&from, jog, rates, 0.0).expect("planned");
        let motion = plan.trajectory;
        let crossing = plan.crossing.expect("there is a limit");
        prop_assert_eq!(crossing.at_us, motion.duration_us());
        prop_assert_eq!(motion.sample(0), if motion.duration_us() > 0 { from } else { *motion.end() });
        let end = *motion.end();
        match crossing.cause {
            MotionError::Limit { bound, limit, .. } => {
                let angle = bound.value(&end.joints);
                let exact = if is_straight(jog.axis) { 1e-9 } else { 1e-12 };
                prop_assert!((angle - limit).abs() < exact || motion.duration_us() == 0, "{bound:?} at {angle}");
            }
            // A sideways tool may reach the base axis before any joint reaches its limit.
            _ => prop_assert!(tool.y != 0.0 || tool.x > 60.0, "{crossing:?}"),
        }
        let mut before = sign(jog) * value(jog.axis, &from);
        for step in 0..=200u64 {
            let t = motion.duration_us() * step / 200;
            let now = motion.sample(t);
            prop_assert!(excess(&planner.limits, &now) <= 1e-7, "{now:?}");
            check_only_axis_moves(jog.axis, &from, &now)?;
            let place = sign(jog) * value(jog.axis, &now);
            prop_assert!(place >= before - 1e-9);
            before = place;
            if t < motion.duration_us() {
                let seconds = t as f64 / 1e6;
                let velocity = sign(jog) * motion.velocity_along(jog.axis, t);
                let expected = rates.velocity.min(rates.acceleration * seconds);
                prop_assert!((velocity - expected).abs() < 1e-6, "{velocity} {expected}");
            }
        }
        // At the limit a jog further out takes no time.
        let further = planner.jog(&end, jog, rates, 0.0).expect("planned");
        prop_assert_eq!((further.trajectory.duration_us(), *further.trajectory.end()), (0, end));
        prop_assert!(further.crossing.is_some());
    }

    #[test]
    fn stop_brakes_along_the_path_of_the_jog(
        from in reachable(), tool in bias(), jog in jogs(), rates in rates(), share in 0.0..1.0f64, deceleration in 5.0..300.0f64,
    ) {
        let planner = Planner { geometry: Geometry::magician(tool), ..continuous() };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let motion = planner.jog(&from, jog, rates, 0.0).expect("planned").trajectory;
        let at_us = (motion.duration_us() as f64 * share) as u64;
        let velocity = motion.velocity_along(jog.axis, at_us);
        let plan = planner.jog_stop(&motion, at_us, deceleration);
        let stop = plan.trajectory;
        let start = motion.sample(at_us);
        prop_assert_eq!(*stop.start(), start);
        if plan.crossing.is_none() {
            prop_assert!((stop.duration_us() as f64 / 1e6 - velocity.abs() / deceleration).abs() <= 1e-6);
            let travel = sign(jog) * (value(jog.axis, stop.end()) - value(jog.axis, &start));
            let expected = velocity * velocity / (2.0 * deceleration);
            prop_assert!((travel - expected).abs() < 1e-9, "{travel} {expected}");
        } else {
            prop_assert!(excess(&planner.limits, stop.end()) > -1e-5);
        }
        for step in 0..=100u64 {
            let t = stop.duration_us() * step / 100;
            let now = stop.sample(t);
            check_only_axis_moves(jog.axis, &start, &now)?;
            prop_assert!(excess(&planner.limits, &now) <= 1e-7);
            if t < stop.duration_us() {
                let expected = velocity - sign(jog) * deceleration * t as f64 / 1e6;
                prop_assert!((stop.velocity_along(jog.axis, t) - expected).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_reversal_passes_through_rest_continuously(
        from in reachable(), tool in bias(), jog in jogs(), rates in rates(), back in rates(), share in 0.0..1.0f64, same in any::<bool>(),
    ) {
        let planner = Planner { geometry: Geometry::magician(tool), ..continuous() };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let motion = planner.jog(&from, jog, rates, 0.0).expect("planned").trajectory;
        let at_us = (motion.duration_us() as f64 * share) as u64;
        let entry = motion.velocity_along(jog.axis, at_us);
        let start = motion.sample(at_us);
        // The second jog goes on in the same direction at another speed, or back.
        let next = Jog { positive: jog.positive == same, ..jog };
        let plan = planner.jog(&start, next, back, entry).expect("planned");
        let second = plan.trajectory;
        prop_assert!(plan.crossing.is_some());
        if second.duration_us() == 0 {
            return Ok(());
        }
        prop_assert_eq!(second.sample(0), start);
        prop_assert!((second.velocity_along(jog.axis, 0) - entry).abs() < 1e-9);
        let (mut velocity, mut place) = (entry, value(jog.axis, &start));
        let mut before = 0;
        let turned = (entry.abs() / back.acceleration * 2e6) as u64;
        let times = (1..=100).map(|step| turned * step / 100).chain((1..100).map(|step| second.duration_us() * step / 100));
        let mut times: Vec<u64> = times.filter(|t| *t < second.duration_us()).collect();
        times.sort_unstable();
        for t in times {
            let step = (t - before) as f64 / 1e6;
            let now = second.sample(t);
            check_only_axis_moves(jog.axis, &start, &now)?;
            prop_assert!(excess(&planner.limits, &now) <= 1e-7);
            let faster = second.velocity_along(jog.axis, t);
            prop_assert!((faster - velocity).abs() <= back.acceleration * (step + 2e-6) + 1e-7);
            let travelled = value(jog.axis, &now) - place;
            let fastest = entry.abs().max(back.velocity);
            prop_assert!(travelled.abs() <= fastest * step + 1e-6);
            // Trapezoidal rule for a constant acceleration, or one with a single change.
            let error = (travelled - 0.5 * (velocity + faster) * step).abs();
            prop_assert!(error <= 0.25 * back.acceleration * (step + 1e-6) * (step + 1e-6) + 1e-6, "{error}");
            (velocity, place, before) = (faster, value(jog.axis, &now), t);
        }
        // The jog ends at full speed in the new direction, unless a limit or lack of room ends it
        // before.
        let last = second.velocity_along(jog.axis, second.duration_us() - 1);
        let room = (value(jog.axis, second.end()) - value(jog.axis, &start)).abs();
        if room > (entry * entry + back.velocity * back.velocity) / back.acceleration {
            prop_assert!((last - sign(next) * back.velocity).abs() < 1e-3, "{last}");
        }
    }
}

#[test]
fn limits_of_any_width_end_a_jog() {
    let narrow = |min: f64, max: f64| Limits {
        j1: Range::new(min, max),
        ..ArmModel::MAGICIAN.limits
    };
    let rates = KinematicLimits {
        velocity: 300.0,
        acceleration: 5.0,
    };
    for limits in [
        narrow(-0.001, 0.001),
        narrow(0.0, 0.0),
        narrow(f64::NAN, f64::NAN),
        narrow(-1e12, 1e12),
    ] {
        let planner = Planner {
            limits,
            geometry: Geometry::magician(ToolBias::SUCTION),
            ..continuous()
        };
        let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
        for axis in AXES {
            for positive in [false, true] {
                for entry in [0.0, 320.0, -320.0] {
                    let plan = planner
                        .jog(&home, Jog { axis, positive }, rates, entry)
                        .expect("planned");
                    let end = plan.trajectory.end();
                    assert!(end.joints.is_finite() && end.pose.is_finite());
                    let stop = planner.jog_stop(&plan.trajectory, 1_000, 5.0);
                    assert!(stop.trajectory.end().joints.is_finite());
                }
            }
        }
    }
}

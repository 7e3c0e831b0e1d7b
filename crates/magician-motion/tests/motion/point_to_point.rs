//! Point-to-point motions: times, profiles, ends and straightness.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Bound, Geometry, JointAngles, MotionError, MoveKind, Planner, Pose,
    SpeedQuantity, Speeds, Target, ToolBias, Unreachable,
};
use proptest::prelude::*;

fn seconds(planner: &Planner, from: [f64; 4], request: magician_motion::Move) -> f64 {
    let plan = planner
        .plan(&state(planner, from), &request)
        .expect("planned");
    assert_eq!(plan.crossing, None);
    plan.trajectory.duration_us() as f64 / 1e6
}

#[test]
fn durations_match_the_model() {
    let half = continuous();
    let full = Planner {
        speeds: full_speed(),
        ..half
    };
    let home = [0.0, 45.0, 45.0, 0.0];
    let sideways = line(Target::PoseIncrement(Pose::new(0.0, 100.0, 0.0, 0.0)));
    assert_eq!(seconds(&half, home, sideways), 2.0);
    assert!((seconds(&full, home, sideways) - 2.0f64.sqrt()).abs() < 1e-6);
    let quarter = joint_move(Target::JointIncrement(JointAngles::new(
        90.0, 0.0, 0.0, 0.0,
    )));
    assert!((seconds(&half, home, quarter) - 2.0 * 0.9f64.sqrt()).abs() < 1e-6);
    assert!((seconds(&full, home, quarter) - 2.0 * 0.45f64.sqrt()).abs() < 1e-6);
    // Ratios above 100 count as 100.
    let more = Planner {
        speeds: Speeds {
            velocity_ratio: 250.0,
            acceleration_ratio: f64::INFINITY,
            ..full.speeds
        },
        ..full
    };
    assert_eq!(seconds(&more, home, quarter), seconds(&full, home, quarter));
    // Long enough to cruise: 120 degrees at 20 deg/s and 20 deg/s2 take 6 s plus 1 s.
    let slow = Planner {
        speeds: Speeds {
            joint_velocity: [20.0; 4],
            joint_acceleration: [20.0; 4],
            ..full.speeds
        },
        ..full
    };
    let far = joint_move(Target::JointIncrement(JointAngles::new(
        120.0, 0.0, 0.0, 0.0,
    )));
    assert_eq!(seconds(&slow, home, far), 7.0);
}

#[test]
fn settings_above_the_ceilings_count_as_the_ceilings() {
    let planner = Planner {
        speeds: Speeds {
            joint_velocity: [1e6; 4],
            joint_acceleration: [1e6; 4],
            linear_velocity: 1e6,
            linear_acceleration: f64::INFINITY,
            rotation_velocity: 1e6,
            rotation_acceleration: 1e6,
            ..full_speed()
        },
        ..continuous()
    };
    let from = [-130.0, 45.0, 45.0, -140.0];
    let j1 = joint_move(Target::JointIncrement(JointAngles::new(
        260.0, 0.0, 0.0, 0.0,
    )));
    let law = |s: f64, v: f64, a: f64| {
        if s > v * v / a {
            s / v + v / a
        } else {
            2.0 * (s / a).sqrt()
        }
    };
    assert!((seconds(&planner, from, j1) - law(260.0, 320.0, 300.0)).abs() < 1e-6);
    let up = line(Target::PoseIncrement(Pose::new(0.0, 0.0, 90.0, 0.0)));
    assert!((seconds(&planner, from, up) - law(90.0, 300.0, 400.0)).abs() < 1e-6);
    let turn = line(Target::PoseIncrement(Pose::new(0.0, 0.0, 0.0, 270.0)));
    assert!((seconds(&planner, from, turn) - law(270.0, 480.0, 300.0)).abs() < 1e-6);
}

#[test]
fn invalid_speed_is_refused_only_if_the_motion_needs_it() {
    let home = state(&continuous(), [0.0, 45.0, 45.0, 0.0]);
    let turn_base = joint_move(Target::JointIncrement(JointAngles::new(
        10.0, 0.0, 0.0, 0.0,
    )));
    let up = line(Target::PoseIncrement(Pose::new(0.0, 0.0, 10.0, 0.0)));
    for invalid in [0.0, -5.0, f64::NAN, f64::NEG_INFINITY] {
        let mut speeds = ArmModel::MAGICIAN.power_up.speeds();
        speeds.joint_velocity[0] = invalid;
        speeds.rotation_acceleration = invalid;
        let planner = Planner {
            speeds,
            ..continuous()
        };
        let error = planner.plan(&home, &turn_base).expect_err("refused");
        assert!(matches!(
            error,
            MotionError::Speed {
                quantity: SpeedQuantity::JointVelocity(1),
                ..
            }
        ));
        // The line needs neither r nor joint 1, whose settings are invalid.
        assert!(planner.plan(&home, &up).is_ok());
        speeds.velocity_ratio = invalid;
        let planner = Planner {
            speeds,
            ..continuous()
        };
        let error = planner.plan(&home, &up).expect_err("refused");
        assert!(matches!(
            error,
            MotionError::Speed {
                quantity: SpeedQuantity::VelocityRatio,
                ..
            }
        ));
    }
    let error = MotionError::Speed {
        quantity: SpeedQuantity::JointVelocity(3),
        value: -1.0,
    };
    assert_eq!(
        error.to_string(),
        "velocity of joint 3 is -1 deg/s, it must be above 0 deg/s"
    );
}

#[test]
fn invalid_target_error_names_the_cause() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let refused = |request| planner.plan(&home, &request).expect_err("refused");
    for kind in [joint_move as fn(Target) -> _, line] {
        let far = Target::Pose(Pose::new(400.0, 0.0, 0.0, 0.0));
        assert!(matches!(
            refused(kind(far)),
            MotionError::Unreachable(Unreachable::TooFar { .. })
        ));
        let bent = Target::Pose(Pose::new(0.0, 200.0, 0.0, 300.0));
        assert!(matches!(
            refused(kind(bent)),
            MotionError::Limit {
                bound: Bound::J4Max,
                ..
            }
        ));
        for invalid in [f64::NAN, f64::INFINITY] {
            for axis in 0..4 {
                let mut numbers = [0.0; 4];
                numbers[axis] = invalid;
                for target in [
                    Target::Pose(numbers.into()),
                    Target::Joints(numbers.into()),
                    Target::PoseIncrement(numbers.into()),
                    Target::JointIncrement(numbers.into()),
                ] {
                    assert_eq!(
                        refused(kind(target)),
                        MotionError::Unreachable(Unreachable::NotFinite)
                    );
                }
            }
        }
    }
    let to_joints = Target::Joints(JointAngles::new(0.0, 95.0, 45.0, 0.0));
    assert!(matches!(
        refused(line(to_joints)),
        MotionError::Limit {
            bound: Bound::J2Max,
            ..
        }
    ));
}

#[test]
fn motion_below_the_minimum_takes_no_time_and_arrives() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 0.0]);
    let target = Pose {
        x: home.pose.x + 5e-5,
        ..home.pose
    };
    for request in [joint_move(Target::Pose(target)), line(Target::Pose(target))] {
        let plan = planner.plan(&home, &request).expect("planned");
        assert_eq!(plan.trajectory.duration_us(), 0);
        assert_eq!(plan.trajectory.sample(0).pose, target);
    }
    let beyond = state(&planner, [0.0, 95.0, 45.0, 0.0]);
    let stay = joint_move(Target::JointIncrement(JointAngles::default()));
    let plan = planner.plan(&beyond, &stay).expect("planned");
    assert_eq!((plan.trajectory.duration_us(), plan.crossing), (0, None));
    assert_eq!(*plan.trajectory.end(), beyond);
}

/// Any target with any kind of motion except jumps.
fn request() -> impl Strategy<Value = magician_motion::Move> {
    (reachable(), 0..3, bias()).prop_map(|(joints, target_kind, _)| match target_kind {
        0 => joint_move(Target::Joints(joints)),
        1 => joint_move(Target::Pose(
            Geometry::magician(ToolBias::SUCTION).forward(&joints),
        )),
        _ => line(Target::Pose(
            Geometry::magician(ToolBias::SUCTION).forward(&joints),
        )),
    })
}

fn with_suction(speeds: Speeds) -> Planner {
    Planner {
        geometry: Geometry::magician(ToolBias::SUCTION),
        speeds,
        ..continuous()
    }
}

/// Largest velocity and acceleration of a quantity sampled at 10 kHz, from differences.
fn extremes(samples: &[f64]) -> (f64, f64) {
    let rates: Vec<f64> = samples.windows(2).map(|w| (w[1] - w[0]) / 1e-4).collect();
    let fastest = rates.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let hardest = rates
        .windows(2)
        .fold(0.0, |most: f64, w| most.max((w[1] - w[0]).abs() / 1e-4));
    (fastest, hardest)
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_end_is_exactly_the_target(from in reachable(), request in request(), speeds in speeds()) {
        let planner = with_suction(speeds);
        let from = ArmState::at_joints(&planner.geometry, &from);
        let plan = planner.plan(&from, &request).expect("planned");
        if plan.crossing.is_some() {
            return Ok(());
        }
        let motion = plan.trajectory;
        prop_assert_eq!(motion.sample(0), from);
        for delay_us in [0, 1, 1_000_000, u64::MAX - motion.duration_us()] {
            let end = motion.sample(motion.duration_us() + delay_us);
            prop_assert_eq!(end, *motion.end());
            prop_assert_eq!(motion.joint_velocities(motion.duration_us() + delay_us), [0.0; 4]);
            match request.target {
                Target::Pose(pose) => {
                    prop_assert_eq!(end.pose, pose);
                    prop_assert_eq!(as_f32(&end.pose), as_f32(&pose));
                }
                Target::Joints(joints) => prop_assert_eq!(end.joints, joints),
                _ => unreachable!("not asked for"),
            }
        }
    }

    #[test]
    fn every_axis_keeps_to_its_speed(from in reachable(), request in request(), speeds in speeds()) {
        let planner = with_suction(speeds);
        let from = ArmState::at_joints(&planner.geometry, &from);
        let plan = planner.plan(&from, &request).expect("planned");
        let motion = plan.trajectory;
        if plan.crossing.is_some() || motion.duration_us() > 20_000_000 {
            return Ok(());
        }
        let states: Vec<ArmState> = (0..=motion.duration_us() / 100 + 1)
            .map(|step| motion.sample(step * 100))
            .collect();
        let ratio = |percent: f64| percent.min(100.0) / 100.0;
        let (rv, ra) = (ratio(speeds.velocity_ratio), ratio(speeds.acceleration_ratio));
        // Tolerance of differences over 0.1 ms: a millionth, plus the rounding error of the
        // difference.
        let check = |samples: Vec<f64>, v: f64, a: f64| {
            let (fastest, hardest) = extremes(&samples);
            prop_assert!(fastest <= v * rv * (1.0 + 1e-6) + 1e-8, "{fastest} {}", v * rv);
            prop_assert!(hardest <= a * ra * (1.0 + 1e-6) + 1e-4, "{hardest} {}", a * ra);
            Ok(())
        };
        if request.kind == MoveKind::Joint {
            for joint in 0..4 {
                let samples = states.iter().map(|state| state.joints.to_array()[joint]).collect();
                check(samples, speeds.joint_velocity[joint], speeds.joint_acceleration[joint])?;
            }
        } else {
            let along = states.iter().map(|state| from.pose.distance_to(&state.pose)).collect();
            check(along, speeds.linear_velocity, speeds.linear_acceleration)?;
            let turned = states.iter().map(|state| state.pose.r).collect();
            check(turned, speeds.rotation_velocity, speeds.rotation_acceleration)?;
        }
    }

    #[test]
    fn all_axes_move_until_the_last_instant(from in reachable(), to in reachable(), speeds in speeds()) {
        let planner = with_suction(speeds);
        let from = ArmState::at_joints(&planner.geometry, &from);
        let plan = planner.plan(&from, &joint_move(Target::Joints(to))).expect("planned");
        if plan.crossing.is_some() {
            return Ok(());
        }
        let motion = plan.trajectory;
        let just_after = motion.joint_velocities(motion.duration_us() / 1000);
        let just_before = motion.joint_velocities(motion.duration_us() - motion.duration_us() / 1000);
        for joint in 0..4 {
            prop_assert!(just_after[joint] != 0.0 && just_before[joint] != 0.0);
        }
    }

    #[test]
    fn a_line_is_straight(from in reachable(), to in reachable(), planner in planner()) {
        let from = ArmState::at_joints(&planner.geometry, &from);
        let to = planner.geometry.forward(&to);
        let plan = planner.plan(&from, &line(Target::Pose(to))).expect("planned");
        let motion = plan.trajectory;
        let a = from.pose;
        let length = a.distance_to(&to);
        let along = [(to.x - a.x) / length, (to.y - a.y) / length, (to.z - a.z) / length];
        let step = (motion.duration_us() / 5_000).max(1_000);
        for t in (0..motion.duration_us()).step_by(step as usize) {
            let sample = motion.sample(t);
            // The straightness is that of the tool's position computed from the joints.
            let there = planner.geometry.forward(&sample.joints);
            prop_assert!(there.distance_to(&sample.pose) < 1e-6);
            let offset = [there.x - a.x, there.y - a.y, there.z - a.z];
            let done: f64 = offset.iter().zip(along).map(|(w, u)| w * u).sum();
            let off: f64 = offset.iter().zip(along).map(|(w, u)| (w - done * u).powi(2)).sum();
            prop_assert!(off.sqrt() < 0.01);
            prop_assert!((there.r - sample.pose.r).abs() < 1e-9);
        }
    }

    #[test]
    fn joint_velocities_are_the_slope_of_the_joints(from in reachable(), request in request(), speeds in speeds(), share in 0.05..0.95f64) {
        let planner = with_suction(speeds);
        let from = ArmState::at_joints(&planner.geometry, &from);
        let motion = planner.plan(&from, &request).expect("planned").trajectory;
        if motion.duration_us() < 100_000 {
            return Ok(());
        }
        let t = (motion.duration_us() as f64 * share) as u64;
        let (before, after) = (motion.sample(t - 50).joints.to_array(), motion.sample(t + 50).joints.to_array());
        let velocities = motion.joint_velocities(t);
        for joint in 0..4 {
            let slope = (after[joint] - before[joint]) / 1e-4;
            prop_assert!((slope - velocities[joint]).abs() < 0.05 + 1e-3 * slope.abs(), "{slope} {velocities:?}");
        }
    }

    #[test]
    fn time_at_progress_is_the_inverse_of_progress(from in reachable(), request in request(), speeds in speeds(), share in 0.001..0.999f64) {
        let planner = with_suction(speeds);
        let from = ArmState::at_joints(&planner.geometry, &from);
        let plan = planner.plan(&from, &request).expect("planned");
        let motion = plan.trajectory;
        match motion.time_at_progress(share) {
            Some(t) => prop_assert!((motion.progress(t) - share).abs() < 1e-4),
            None => prop_assert!(plan.crossing.expect("cut short").progress <= share + 1e-4),
        }
        if plan.crossing.is_none() {
            prop_assert_eq!(motion.progress(motion.duration_us()), 1.0);
            prop_assert_eq!(motion.time_at_progress(1.0), Some(motion.duration_us()));
        }
    }
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => any::<f64>(),
        2 => any::<f32>().prop_map(f64::from),
        4 => -400.0..400.0f64,
        1 => Just(0.0),
    ]
}

fn any_four() -> impl Strategy<Value = [f64; 4]> {
    [any_number(), any_number(), any_number(), any_number()]
}

proptest! {
    #![proptest_config(cases(1_000))]

    #[test]
    fn no_request_panics(start in any_four(), to in any_four(), v in any_four(), a in any_four(),
                         rest in any_four(), target_kind in 0..4, move_kind in 0..4, t in any::<u64>(), tame in any::<bool>()) {
        let speeds = Speeds {
            joint_velocity: v,
            joint_acceleration: a,
            linear_velocity: rest[0],
            linear_acceleration: rest[1],
            rotation_velocity: rest[2],
            rotation_acceleration: rest[3],
            ..full_speed()
        };
        let tool = if tame { ToolBias::SUCTION } else { ToolBias::new(rest[0], rest[1], rest[2]) };
        let planner = Planner {
            geometry: Geometry::magician(tool),
            speeds: if tame { full_speed() } else { speeds },
            ..continuous()
        };
        let target = match target_kind {
            0 => Target::Pose(to.into()),
            1 => Target::Joints(to.into()),
            2 => Target::PoseIncrement(to.into()),
            _ => Target::JointIncrement(to.into()),
        };
        let heights = magician_motion::JumpHeights { start: rest[0], end: rest[3], z_limit: rest[1] };
        let kind = match move_kind {
            0 => MoveKind::Joint,
            1 => MoveKind::Line,
            2 => MoveKind::Jump(heights, magician_motion::Transfer::Joint),
            _ => MoveKind::Jump(magician_motion::ArmModel::MAGICIAN.power_up.jump(), magician_motion::Transfer::Line),
        };
        let from = ArmState::at_joints(&planner.geometry, &start.into());
        if let Ok(plan) = planner.plan(&from, &magician_motion::Move { target, kind }) {
            let motion = plan.trajectory;
            for t in [0, t, t % motion.duration_us().max(1), motion.duration_us()] {
                let _ = (motion.sample(t), motion.joint_velocities(t), motion.progress(t));
                let _ = planner.brake(&motion, t, 2.0).trajectory.sample(t);
            }
            let _ = motion.time_at_progress(rest[2]);
        }
    }
}

//! Jumps: heights, corners and ends.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Geometry, JointAngles, JumpHeights, MotionError, Move, MoveKind, Planner,
    Pose, Target, ToolBias, Trajectory, Transfer, Unreachable,
};
use proptest::prelude::*;

fn jump(target: Target, heights: JumpHeights, transfer: Transfer) -> Move {
    Move {
        target,
        kind: MoveKind::Jump(heights, transfer),
    }
}

fn suction() -> Planner {
    Planner {
        geometry: Geometry::magician(ToolBias::SUCTION),
        ..continuous()
    }
}

fn at(planner: &Planner, x: f64, y: f64, z: f64, r: f64) -> ArmState {
    ArmState::at_pose(&planner.geometry, &Pose::new(x, y, z, r), &planner.limits)
        .expect("reachable")
}

/// Poses in which the motion rests: where all joints stand still.
fn stops(motion: &Trajectory) -> Vec<Pose> {
    let mut stops = Vec::new();
    let mut slowest = (f64::INFINITY, 0);
    let speed = |t| {
        motion
            .joint_velocities(t)
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()))
    };
    for t in (0..motion.duration_us()).step_by(10) {
        let now = speed(t);
        if now < 0.01 && now < slowest.0 {
            slowest = (now, t);
        } else if now > 0.01 && slowest.0 < 0.01 {
            stops.push(motion.sample(slowest.1).pose);
            slowest = (f64::INFINITY, 0);
        }
    }
    stops.push(motion.end().pose);
    stops
}

#[test]
fn both_corners_are_above_the_higher_end_and_r_turns_between_them() {
    let planner = suction();
    let from = at(&planner, 250.0, -50.0, -20.0, 5.0);
    let to = Pose::new(230.0, 80.0, 10.0, 40.0);
    for transfer in [Transfer::Joint, Transfer::Line] {
        let request = jump(
            Target::Pose(to),
            ArmModel::MAGICIAN.power_up.jump(),
            transfer,
        );
        let plan = planner.plan(&from, &request).expect("planned");
        assert_eq!(plan.crossing, None);
        let stops = stops(&plan.trajectory);
        let expected = [
            from.pose,
            Pose {
                z: 30.0,
                ..from.pose
            },
            Pose { z: 30.0, ..to },
            to,
        ];
        assert_eq!(stops.len(), 4, "{stops:?}");
        for (stop, expected) in stops.iter().zip(expected) {
            assert!(stop.distance_to(&expected) < 1e-3, "{stop:?}");
            assert!((stop.r - expected.r).abs() < 1e-3);
        }
        assert_eq!(plan.trajectory.end().pose, to);
    }
}

#[test]
fn the_corners_follow_the_heights() {
    let planner = suction();
    let top = |z0: f64, z1: f64, heights: JumpHeights| {
        let from = at(&planner, 250.0, -50.0, z0, 0.0);
        let request = jump(
            Target::Pose(Pose::new(250.0, 50.0, z1, 0.0)),
            heights,
            Transfer::Line,
        );
        let stops = stops(&planner.plan(&from, &request).expect("planned").trajectory);
        let z = |stop: Option<&Pose>| (stop.expect("a stop").z * 1e3).round() / 1e3;
        // A leg of zero length adds no stop, so count corners from both ends.
        let lift = if stops.len() > 1 { z(stops.get(1)) } else { z0 };
        let descent = if stops.len() == 4 {
            z(stops.get(2))
        } else {
            z1
        };
        (lift, descent)
    };
    let even = JumpHeights::even;
    let uneven = |start, end, z_limit| JumpHeights {
        start,
        end,
        z_limit,
    };
    assert_eq!(top(0.0, 30.0, even(20.0, 100.0)), (50.0, 50.0));
    assert_eq!(top(0.0, 30.0, even(20.0, 40.0)), (40.0, 40.0));
    // Already above the limit: no higher than the higher end.
    assert_eq!(top(0.0, 60.0, even(20.0, 40.0)), (60.0, 60.0));
    assert_eq!(top(0.0, 30.0, uneven(25.0, 10.0, 100.0)), (25.0, 40.0));
    assert_eq!(top(0.0, 30.0, uneven(50.0, 60.0, 45.0)), (45.0, 45.0));
    assert_eq!(top(0.0, 60.0, uneven(10.0, 20.0, 45.0)), (10.0, 60.0));
}

#[test]
fn lift_and_descent_are_straight_when_outstretched() {
    let planner = suction();
    // The threshold is forearm plus tool bias: 147 + 59.7 = 206.7 mm.
    for (x, straight) in [(206.0, false), (207.5, true)] {
        let from = at(&planner, x, 0.0, -20.0, 0.0);
        let to = Pose {
            y: 60.0,
            ..from.pose
        };
        let request = jump(
            Target::Pose(to),
            JumpHeights::even(60.0, 100.0),
            Transfer::Joint,
        );
        let motion = planner.plan(&from, &request).expect("planned").trajectory;
        let lift = (0..100).map(|step| motion.sample(step * 5_000).pose);
        let aside = lift
            .filter(|pose| pose.y == 0.0)
            .fold(0.0, |most: f64, pose| most.max((pose.x - x).abs()));
        assert_eq!(aside < 1e-9, straight, "{aside}");
    }
}

#[test]
fn targets_and_corners_are_checked_before_moving() {
    let planner = suction();
    let from = at(&planner, 250.0, -50.0, -20.0, 0.0);
    let plan = |x, z, heights| {
        let target = Target::Pose(Pose::new(x, 50.0, z, 0.0));
        planner.plan(&from, &jump(target, heights, Transfer::Line))
    };
    assert!(plan(250.0, 0.0, ArmModel::MAGICIAN.power_up.jump()).is_ok());
    assert!(matches!(
        plan(400.0, 0.0, ArmModel::MAGICIAN.power_up.jump()),
        Err(MotionError::Unreachable(Unreachable::TooFar { .. }))
    ));
    // The target is in reach, the corner above it is not.
    assert!(matches!(
        plan(310.0, 60.0, JumpHeights::even(60.0, 300.0)),
        Err(MotionError::Limit { .. } | MotionError::Unreachable(_))
    ));
    for bad in [f64::NAN, f64::INFINITY] {
        let heights = JumpHeights {
            start: bad,
            ..ArmModel::MAGICIAN.power_up.jump()
        };
        assert_eq!(
            plan(250.0, 0.0, heights),
            Err(MotionError::Unreachable(Unreachable::NotFinite))
        );
    }
}

#[test]
fn a_jump_across_the_base_is_stopped_on_its_way() {
    let planner = suction();
    let from = at(&planner, 60.0, -220.0, 0.0, -74.0);
    let to = Pose::new(60.0, 220.0, 0.0, 74.0);
    let straight = jump(
        Target::Pose(to),
        ArmModel::MAGICIAN.power_up.jump(),
        Transfer::Line,
    );
    let plan = planner.plan(&from, &straight).expect("planned");
    let crossing = plan.crossing.expect("too near the base");
    let lift_us = 894_428; // 20 mm at 100 mm/s2: twice the root of 0.2 s
    assert!(crossing.at_us > lift_us);
    assert!((plan.trajectory.end().pose.z - 20.0).abs() < 1e-9);
    assert!((0.1..0.5).contains(&crossing.progress));
    let around = jump(
        Target::Pose(to),
        ArmModel::MAGICIAN.power_up.jump(),
        Transfer::Joint,
    );
    assert_eq!(
        planner.plan(&from, &around).expect("planned").crossing,
        None
    );
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn a_straight_transfer_is_never_above_the_ceiling(
        from in reachable(), to in reachable(), planner in planner(),
        start in 0.0..80.0f64, end in 0.0..80.0f64, even in any::<bool>(), z_limit in -60.0..140.0f64,
    ) {
        let heights = JumpHeights { start, end: if even { start } else { end }, z_limit };
        stays_below(&planner, from, to, heights, Transfer::Line)?;
    }

    /// A joint transfer swings the tool above its corners, by at most 19 mm as far as searches have
    /// found. With 20 mm between the ends and the ceiling the corners can always be lowered enough.
    #[test]
    fn a_joint_transfer_is_never_above_the_ceiling(
        from in reachable(), to in reachable(), planner in planner(),
        start in 0.0..80.0f64, end in 0.0..80.0f64, even in any::<bool>(), room in 20.0..60.0f64,
    ) {
        let (z0, z1) = (planner.geometry.forward(&from).z, planner.geometry.forward(&to).z);
        let heights = JumpHeights {
            start,
            end: if even { start } else { end },
            z_limit: z0.max(z1) + room,
        };
        stays_below(&planner, from, to, heights, Transfer::Joint)?;
    }
}

/// Jumps with one end just below the ceiling, and with the base on the line between the corners:
/// only the other corner can be lowered, and must be lowered far enough for both.
#[test]
fn corner_is_lowered_for_both_if_other_cannot_be() {
    let planner = suction();
    let jumps = [
        (
            [189.6, 23.6, 92.07, -51.6],
            [-133.9, -251.7, 67.3, -241.6],
            42.3,
            3.89,
        ),
        (
            [246.6, 168.3, -54.4, 15.2],
            [-25.4, -197.4, 55.98, -12.8],
            53.3,
            3.63,
        ),
        (
            [-113.9, 149.4, 77.35, -3.0],
            [248.8, -170.6, 13.8, -62.3],
            42.0,
            5.77,
        ),
    ];
    for (from, to, height, room) in jumps {
        let [x, y, z, r] = from;
        let ceiling = f64::max(z, to[2]) + room;
        let request = jump(
            Target::Pose(to.into()),
            JumpHeights::even(height, ceiling),
            Transfer::Joint,
        );
        let plan = planner.plan(&at(&planner, x, y, z, r), &request);
        let motion = plan.expect("planned").trajectory;
        let heights =
            (0..5_000).map(|step| motion.sample(motion.duration_us() * step / 5_000).pose.z);
        let top = heights.fold(f64::MIN, f64::max);
        assert!(top <= ceiling + 2e-6, "{top} above {ceiling}");
    }
}

fn stays_below(
    planner: &Planner,
    from: JointAngles,
    to: JointAngles,
    heights: JumpHeights,
    transfer: Transfer,
) -> Result<(), TestCaseError> {
    let from = ArmState::at_joints(&planner.geometry, &from);
    let to = planner.geometry.forward(&to);
    let request = jump(Target::Pose(to), heights, transfer);
    let Ok(plan) = planner.plan(&from, &request) else {
        return Ok(());
    };
    let ceiling = heights.z_limit.max(from.pose.z).max(to.z);
    let motion = plan.trajectory;
    for step in 0..=2_000u64 {
        let t = (motion.duration_us() as f64 / 2_000.0 * step as f64) as u64;
        let state = motion.sample(t);
        let z = planner.geometry.forward(&state.joints).z;
        // The summit is known to about a nanometre.
        prop_assert!(z <= ceiling + 1e-5, "{z} above {ceiling}");
    }
    if plan.crossing.is_none() {
        prop_assert_eq!(as_f32(&motion.end().pose), as_f32(&to));
    }
    Ok(())
}

#[test]
fn corners_are_lowered_only_if_the_ceiling_would_be_exceeded() {
    let planner = suction();
    let from = at(&planner, 210.0, 0.0, 70.0, 0.0);
    let target = Target::Pose(Pose::new(300.0, 60.0, 60.0, 0.0));
    let top = |z_limit, transfer| {
        let request = jump(target, JumpHeights::even(20.0, z_limit), transfer);
        let motion = planner.plan(&from, &request).expect("planned").trajectory;
        let samples =
            (0..5_000).map(|step| motion.sample(motion.duration_us() * step / 5_000).pose.z);
        (stops(&motion)[1].z, samples.fold(f64::MIN, f64::max))
    };
    // Under a high ceiling the joints swing the tool some millimetres above its corners.
    let (corner, free) = top(150.0, Transfer::Joint);
    assert!(
        (corner - 90.0).abs() < 1e-3 && free > 92.0,
        "{corner} {free}"
    );
    // Under a low ceiling the corners are lowered and the tool nearly reaches the ceiling.
    let (corner, capped) = top(90.0, Transfer::Joint);
    assert!(
        corner < 88.0 && capped <= 90.0 && capped > 89.0,
        "{corner} {capped}"
    );
    let (corner, straight) = top(90.0, Transfer::Line);
    assert!((corner - 90.0).abs() < 1e-3 && straight <= 90.0);
}

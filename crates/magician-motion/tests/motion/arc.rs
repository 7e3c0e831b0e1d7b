//! Arcs and circles: shape, times, velocity profiles, ends and errors.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Ceilings, Geometry, JointAngles, Limits, MotionError, MotionLaw, Planner,
    Pose, Range, SpeedQuantity, Speeds, ToolBias, Unreachable,
};
use proptest::prelude::*;

/// Arc settings at power-up (model section 6): 200 each, ratios of 100.
const ARC_SET: Speeds = Speeds {
    linear_velocity: 200.0,
    linear_acceleration: 200.0,
    rotation_velocity: 200.0,
    rotation_acceleration: 200.0,
    velocity_ratio: 100.0,
    acceleration_ratio: 100.0,
    ..ArmModel::MAGICIAN.power_up.speeds()
};

fn at(planner: &Planner, pose: &Pose) -> ArmState {
    ArmState::at_pose(&planner.geometry, pose, &planner.limits).expect("within")
}

/// Shortest time by the formula of model section 7.
fn law(s: f64, v: f64, a: f64) -> f64 {
    if s > v * v / a {
        s / v + v / a
    } else {
        2.0 * (s / a).sqrt()
    }
}

/// A circle in any plane, implemented independently of the planner.
#[derive(Clone, Copy, Debug)]
struct Ring {
    centre: [f64; 3],
    axis: [f64; 3],
    zero: [f64; 3],
    quarter: [f64; 3],
    radius: f64,
}

impl Ring {
    /// A ring tilted by `tilt` degrees towards `heading`.
    fn new(centre: [f64; 3], tilt: f64, heading: f64, radius: f64) -> Self {
        let (st, ct) = tilt.to_radians().sin_cos();
        let (sh, ch) = heading.to_radians().sin_cos();
        Self {
            centre,
            axis: [st * ch, st * sh, ct],
            zero: [ct * ch, ct * sh, -st],
            quarter: [-sh, ch, 0.0],
            radius,
        }
    }

    fn pose(&self, degrees: f64, r: f64) -> Pose {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [x, y, z] = [0, 1, 2].map(|axis| {
            self.centre[axis] + self.radius * (cos * self.zero[axis] + sin * self.quarter[axis])
        });
        Pose::new(x, y, z, r)
    }

    /// Angle on the ring, -180 to 180 degrees, distance from its axis, and height above its plane.
    fn seen(&self, pose: &Pose) -> (f64, f64, f64) {
        let offset = [
            pose.x - self.centre[0],
            pose.y - self.centre[1],
            pose.z - self.centre[2],
        ];
        let part = |of: &[f64; 3]| -> f64 { offset.iter().zip(of).map(|(a, b)| a * b).sum() };
        let (a, b) = (part(&self.zero), part(&self.quarter));
        (b.atan2(a).to_degrees(), a.hypot(b), part(&self.axis))
    }
}

fn level_ring(radius: f64) -> Ring {
    Ring::new([220.0, 0.0, 10.0], 0.0, 0.0, radius)
}

fn arc_planner() -> Planner {
    Planner {
        speeds: ARC_SET,
        ..continuous()
    }
}

#[test]
fn the_times_follow_from_the_length_of_the_arc() {
    let planner = arc_planner();
    let ring = level_ring(30.0);
    let from = at(&planner, &ring.pose(0.0, 10.0));
    let time = |planner: &Planner, via: f64, to: f64, r: f64| {
        let plan = planner
            .arc(&from, &ring.pose(via, -99.0), &ring.pose(to, r))
            .expect("planned");
        assert_eq!(plan.crossing, None);
        plan.trajectory.duration_us() as f64 / 1e6
    };
    let length = |sweep: f64| 30.0 * sweep.to_radians();
    assert!((time(&planner, 90.0, 180.0, 10.0) - law(length(180.0), 200.0, 200.0)).abs() < 1.1e-6);
    // The same three points in the other sense cover the rest of the circle.
    assert!((time(&planner, 270.0, 90.0, 10.0) - law(length(270.0), 200.0, 200.0)).abs() < 1.1e-6);
    // An arc that cruises, with its own settings and ratios.
    let slow = Planner {
        speeds: Speeds {
            linear_velocity: 40.0,
            linear_acceleration: 80.0,
            velocity_ratio: 50.0,
            ..ARC_SET
        },
        ..planner
    };
    assert!((time(&slow, 200.0, 359.0, 10.0) - law(length(359.0), 20.0, 80.0)).abs() < 1.1e-6);
    // If r takes longer, it determines the time.
    assert!((time(&planner, 45.0, 90.0, 130.0) - law(120.0, 200.0, 200.0)).abs() < 1.1e-6);
}

#[test]
fn r_goes_alongside_by_its_own_law_from_end_to_end() {
    let planner = arc_planner();
    let ring = level_ring(40.0);
    let from = at(&planner, &ring.pose(-90.0, -20.0));
    // 188.5 mm at 200 mm/s is a triangle. 60 degrees are stretched to it, and r passes 10 at half
    // of the arc.
    let to = ring.pose(180.0, 40.0);
    let plan = planner
        .arc(&from, &ring.pose(0.0, 170.0), &to)
        .expect("planned");
    assert_eq!(plan.crossing, None);
    let motion = plan.trajectory;
    let middle = motion.sample(motion.duration_us() / 2).pose;
    assert!((middle.r - 10.0).abs() < 1e-3);
    assert!((ring.seen(&middle).0 - 45.0).abs() < 1e-3);
    let quarter = motion.sample(motion.duration_us() / 4).pose;
    assert!((quarter.r - (-20.0 + 60.0 / 8.0)).abs() < 1e-3);
    assert_eq!(*motion.end(), at(&planner, &to));
}

#[test]
fn circles_turn_so_often_and_come_back_exactly() {
    let planner = arc_planner();
    let ring = level_ring(25.0);
    let from = at(&planner, &ring.pose(30.0, 15.0));
    // Clockwise, with rotations that are ignored.
    let (via, to) = (ring.pose(-60.0, f64::NAN), ring.pose(-150.0, 500.0));
    for count in [1, 2, 7] {
        let plan = planner.circle(&from, &via, &to, count).expect("planned");
        assert_eq!(plan.crossing, None);
        let motion = plan.trajectory;
        let length = 25.0 * (360.0 * f64::from(count)).to_radians();
        let expected = law(length, 200.0, 200.0);
        assert!((motion.duration_us() as f64 / 1e6 - expected).abs() < 1.1e-6);
        assert_eq!(*motion.end(), from);
        // After each share of the turns it is at the start again, and opposite in between; r is
        // constant.
        for turn in 0..count {
            let share = |part: f64| {
                let progress = (f64::from(turn) + part) / f64::from(count);
                motion.sample(motion.time_at_progress(progress).expect("reached"))
            };
            for (part, angle) in [(0.0, 30.0), (0.25, -60.0), (0.75, 120.0)] {
                let state = share(part);
                let (seen, radius, height) = ring.seen(&state.pose);
                assert!((seen - angle).abs() < 1e-3, "{seen} for {angle}");
                assert!((radius - 25.0).abs() < 1e-9 && height.abs() < 1e-9);
                assert!((state.pose.r - 15.0).abs() < 1e-12);
            }
        }
    }
    // A count of 0 is no motion, whatever the points.
    let none = planner.circle(&from, &from.pose, &via, 0).expect("nothing");
    assert_eq!((none.trajectory.duration_us(), none.crossing), (0, None));
    assert_eq!(none.trajectory.sample(0), from);
    // The largest count still gives a circle.
    let many = planner.circle(&from, &via, &to, u32::MAX).expect("planned");
    let state = many.trajectory.sample(many.trajectory.duration_us() / 3);
    assert!((ring.seen(&state.pose).1 - 25.0).abs() < 1e-9);
    assert_eq!(*many.trajectory.end(), from);
}

#[test]
fn points_that_make_no_circle_are_refused() {
    let planner = arc_planner();
    let start = Pose::new(200.0, 0.0, 20.0, 0.0);
    let from = at(&planner, &start);
    let place = |dx: f64, dy: f64, dz: f64| Pose::new(200.0 + dx, dy, 20.0 + dz, 0.0);
    let both = |via: &Pose, to: &Pose| {
        let arc = planner.arc(&from, via, to).map(|_| ());
        assert_eq!(arc, planner.circle(&from, via, to, 1).map(|_| ()));
        arc.expect_err("refused")
    };
    let aside = place(0.0, 30.0, 0.0);
    for (via, to) in [
        (start, aside),
        (aside, start),
        (aside, aside),
        (place(5e-5, 0.0, 0.0), aside),
        (aside, place(0.0, 30.0, -9e-5)),
        (start, start),
    ] {
        assert_eq!(both(&via, &to), MotionError::Coincident);
    }
    for (via, to) in [
        (place(0.0, 15.0, 0.0), aside),
        (aside, place(0.0, 15.0, 0.0)),
        (place(0.0, -15.0, 0.0), aside),
        (place(10.0, 10.0, 10.0), place(30.0, 30.0, 30.0)),
        (place(5e-5, 15.0, 0.0), aside),
    ] {
        assert_eq!(both(&via, &to), MotionError::Collinear);
    }
    // Points that are straight to the precision of binary32 count as straight.
    let on_line = |share: f64| {
        Pose::from(
            [200.0 + 31.7 * share, 57.3 * share, 20.0 - 13.9 * share, 0.0]
                .map(|value| f64::from(value as f32)),
        )
    };
    assert_eq!(both(&on_line(0.37), &on_line(1.0)), MotionError::Collinear);
    // A bend ten times as large is an arc, and hardly leaves the line.
    let plan = planner
        .arc(&from, &place(1e-3, 15.0, 0.0), &aside)
        .expect("an arc");
    let middle = plan
        .trajectory
        .sample(plan.trajectory.duration_us() / 2)
        .pose;
    assert!((middle.x - 200.001).abs() < 1e-9 && (middle.y - 15.0).abs() < 1e-3);

    let not_finite = MotionError::Unreachable(Unreachable::NotFinite);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut broken = aside.to_array();
            broken[axis] = bad;
            let broken = Pose::from(broken);
            assert_eq!(both(&broken, &aside), not_finite);
            assert_eq!(both(&aside, &broken), not_finite);
        }
        let to = Pose {
            r: bad,
            ..place(20.0, 20.0, 0.0)
        };
        assert_eq!(
            planner.arc(&from, &aside, &to).expect_err("refused"),
            not_finite
        );
    }
    assert_eq!(
        MotionError::Coincident.to_string(),
        "two of the three points of the arc are the same"
    );
    assert_eq!(
        MotionError::Collinear.to_string(),
        "the three points of the arc are on a straight line"
    );
}

#[test]
fn points_where_the_arm_cannot_be_are_refused_before_anything_moves() {
    let planner = arc_planner();
    let from = at(&planner, &Pose::new(200.0, 0.0, 20.0, 0.0));
    let good = Pose::new(200.0, 60.0, 20.0, 0.0);
    let far = Pose::new(400.0, 20.0, 20.0, 0.0);
    let low = Pose::new(200.0, 20.0, -180.0, 0.0);
    for (via, to) in [(far, good), (good, far)] {
        assert!(matches!(
            planner.arc(&from, &via, &to),
            Err(MotionError::Unreachable(Unreachable::TooFar { .. }))
        ));
        assert!(matches!(
            planner.circle(&from, &via, &to, 3),
            Err(MotionError::Unreachable(Unreachable::TooFar { .. }))
        ));
    }
    for (via, to) in [(low, good), (good, low)] {
        assert!(matches!(
            planner.arc(&from, &via, &to),
            Err(MotionError::Limit { .. })
        ));
    }
    // J4 is checked at the target only: the arc has no separate rotation at `via`.
    let turned = |pose: Pose| Pose { r: 200.0, ..pose };
    let other = Pose::new(220.0, 30.0, 20.0, 0.0);
    assert!(matches!(
        planner.arc(&from, &other, &turned(good)),
        Err(MotionError::Limit { .. })
    ));
    assert!(planner.arc(&from, &turned(other), &good).is_ok());
    assert!(
        planner
            .circle(&from, &turned(other), &turned(good), 1)
            .is_ok()
    );
    let still = Planner {
        speeds: Speeds {
            linear_velocity: 0.0,
            rotation_velocity: 0.0,
            ..ARC_SET
        },
        ..planner
    };
    assert!(matches!(
        still.arc(&from, &other, &good),
        Err(MotionError::Speed {
            quantity: SpeedQuantity::LinearVelocity,
            ..
        })
    ));
}

/// A ring in the middle of the workspace, in any plane.
fn ring() -> impl Strategy<Value = Ring> {
    (
        -180.0..180.0f64,
        0.0..180.0f64,
        -180.0..180.0f64,
        prop_oneof![0.01..1.0f64, 1.0..35.0f64],
        150.0..220.0f64,
        -20.0..60.0f64,
    )
        .prop_map(|(azimuth, tilt, heading, radius, distance, z)| {
            let (sin, cos) = (azimuth / 2.0).to_radians().sin_cos();
            Ring::new([distance * cos, distance * sin, z], tilt, heading, radius)
        })
}

fn free_planner() -> impl Strategy<Value = Planner> {
    continuous_planner().prop_map(|planner| Planner {
        geometry: Geometry::magician(ToolBias {
            x: planner.geometry.tool.x / 4.0,
            ..planner.geometry.tool
        }),
        limits: Limits {
            j1: Range::new(-200.0, 200.0),
            ..WITHOUT_LIMITS
        },
        ..planner
    })
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn arcs_are_round_and_end_exactly(
        ring in ring(), planner in free_planner(), start in -180.0..180.0f64,
        sweep in prop_oneof![1.0..359.0f64, 359.0..359.99f64], via in 0.05..0.95f64, clockwise in any::<bool>(),
        r in (-60.0..60.0f64, -60.0..60.0f64), as_sent in any::<bool>(),
    ) {
        let sense = if clockwise { -1.0 } else { 1.0 };
        let pose = |share: f64, r: f64| ring.pose(start + sense * sweep * share, r);
        let joints = planner.geometry.inverse(&pose(0.0, r.0));
        prop_assume!(joints.is_ok());
        let from = ArmState { joints: joints.expect("in reach"), pose: pose(0.0, r.0) };
        let exact = pose(1.0, r.1);
        let to = if as_sent { Pose::from(as_f32(&exact).map(f64::from)) } else { exact };
        let plan = planner.arc(&from, &pose(via, 0.0), &to);
        prop_assume!(!matches!(plan, Err(MotionError::Unreachable(_) | MotionError::Coincident | MotionError::Collinear)));
        let plan = plan.expect("planned");
        prop_assume!(plan.crossing.is_none());
        let motion = plan.trajectory;
        prop_assert_eq!(motion.sample(0), from);
        prop_assert_eq!(motion.end().pose, to);
        prop_assert_eq!(motion.sample(motion.duration_us()).pose, to);
        prop_assert_eq!(as_f32(&motion.end().pose), as_f32(&to));
        prop_assert!((motion.end().pose.distance_to(&motion.sample(motion.duration_us() - 1).pose)) < 1e-3);
        if as_sent {
            // Rounding the target changes the circle.
            return Ok(());
        }
        // A sample per millisecond, but at most 2000.
        let samples = (motion.duration_us() / 1000).clamp(10, 2000);
        for step in 1..samples {
            let t = (u128::from(motion.duration_us()) * u128::from(step) / u128::from(samples)) as u64;
            let state = motion.sample(t);
            let (angle, radius, height) = ring.seen(&state.pose);
            prop_assert!((radius - ring.radius).abs() < 1e-9, "{radius} for {}", ring.radius);
            prop_assert!(height.abs() < 1e-9, "{height}");
            // The angle passed agrees with the profile, in the sense of the three points.
            let ahead = sense * (angle - start) - sweep * motion.progress(t);
            let ahead = (ahead + 180.0).rem_euclid(360.0) - 180.0;
            prop_assert!(ahead.abs() < 1e-6 * (1.0 + 1.0 / ring.radius), "{ahead} of {sweep}");
            // Joints and pose are consistent.
            let again = planner.geometry.forward(&state.joints);
            prop_assert!(again.distance_to(&state.pose) < 1e-8);
            prop_assert!((again.r - state.pose.r).abs() < 1e-9);
        }
    }

    /// The circle is computed from the three points themselves, so only rounding errors remain.
    #[test]
    fn arcs_are_round_to_the_rounding_error(
        ring in ring(), planner in free_planner(), start in -180.0..180.0f64, sweep in 20.0..340.0f64, via in 0.2..0.8f64,
    ) {
        let pose = |share: f64| ring.pose(start + sweep * share, 0.0);
        let joints = planner.geometry.inverse(&pose(0.0));
        prop_assume!(joints.is_ok());
        let from = ArmState { joints: joints.expect("in reach"), pose: pose(0.0) };
        let plan = planner.arc(&from, &pose(via), &pose(1.0));
        prop_assume!(plan.is_ok_and(|plan| plan.crossing.is_none()));
        let motion = plan.expect("planned").trajectory;
        for step in 0..=200u64 {
            let state = motion.sample((u128::from(motion.duration_us()) * u128::from(step) / 200) as u64);
            let (_, radius, height) = ring.seen(&state.pose);
            prop_assert!((radius - ring.radius).abs() < 1e-10 && height.abs() < 1e-10, "{radius} {height}");
        }
        let passing = motion.sample(motion.time_at_progress(via).expect("reached")).pose;
        let speed = planner.speeds.linear_velocity.min(300.0);
        prop_assert!(passing.distance_to(&pose(via)) < speed * 1e-6 + 1e-9);
    }

    #[test]
    fn the_set_speeds_hold_at_ten_kilohertz(
        ring in ring(), planner in free_planner(), sweep in 5.0..359.0f64, via in 0.1..0.9f64, r in -90.0..90.0f64,
        from_share in 0.0..1.0f64,
    ) {
        let pose = |share: f64| ring.pose(sweep * share, r * share);
        let joints = planner.geometry.inverse(&pose(0.0));
        prop_assume!(joints.is_ok());
        let from = ArmState { joints: joints.expect("in reach"), pose: pose(0.0) };
        let plan = planner.arc(&from, &pose(via), &pose(1.0));
        prop_assume!(plan.is_ok_and(|plan| plan.crossing.is_none()));
        let motion = plan.expect("planned").trajectory;
        let speeds = planner.speeds;
        let (vr, ar) = (speeds.velocity_ratio.min(100.0) / 100.0, speeds.acceleration_ratio.min(100.0) / 100.0);
        let v = speeds.linear_velocity.min(300.0) * vr;
        let a = speeds.linear_acceleration.min(400.0) * ar;
        let (rv, ra) = (speeds.rotation_velocity.min(480.0) * vr, speeds.rotation_acceleration.min(300.0) * ar);
        let dt = 1e-4;
        let whole = ring.radius * sweep.to_radians();
        // A step within the motion, and both of its ends.
        let last = motion.duration_us() / 100;
        let middle = (last as f64 * from_share) as u64;
        for first in [0, middle, last.saturating_sub(300)] {
            for step in first..(first + 300).min(last.saturating_sub(2)) {
                let way = |step: u64| (motion.progress(step * 100) * whole, motion.sample(step * 100).pose);
                let ((s0, p0), (s1, p1), (s2, p2)) = (way(step), way(step + 1), way(step + 2));
                // Rounding errors of positions, divided by the square of the interval.
                let noise = 1e-12 * (1.0 + whole) / (dt * dt) * 1e-2;
                prop_assert!(p0.distance_to(&p1) <= v * dt * (1.0 + 1e-6) + 1e-10);
                prop_assert!((s1 - s0).abs() <= v * dt * (1.0 + 1e-6) + 1e-10);
                prop_assert!((s2 - 2.0 * s1 + s0).abs() / (dt * dt) <= a * (1.0 + 1e-6) + noise);
                prop_assert!((p1.r - p0.r).abs() <= rv * dt * (1.0 + 1e-6) + 1e-10);
                prop_assert!((p2.r - 2.0 * p1.r + p0.r).abs() / (dt * dt) <= ra * (1.0 + 1e-6) + noise + 1e-5);
            }
        }
    }

    #[test]
    fn velocities_are_the_slope_of_the_joints_and_a_stop_follows_from_them(
        ring in ring(), planner in continuous_planner(), sweep in 20.0..340.0f64, r in -60.0..60.0f64, share in 0.05..0.95f64,
    ) {
        let pose = |share: f64| ring.pose(sweep * share, r * share);
        let Ok(from) = ArmState::at_pose(&planner.geometry, &pose(0.0), &planner.limits) else {
            return Ok(());
        };
        let Ok(plan) = planner.arc(&from, &pose(0.4), &pose(1.0)) else {
            return Ok(());
        };
        let motion = plan.trajectory;
        let t = (motion.duration_us() as f64 * share) as u64;
        let step = 200;
        prop_assume!(t > step && t + step < motion.duration_us());
        let (before, after) = (motion.sample(t - step).joints.to_array(), motion.sample(t + step).joints.to_array());
        let now = motion.joint_velocities(t);
        let fastest = now.iter().fold(1.0f64, |most, velocity| most.max(velocity.abs()));
        for joint in 0..4 {
            let slope = (after[joint] - before[joint]) / (2.0 * step as f64 * 1e-6);
            // The acceleration may jump within the interval.
            prop_assert!((slope - now[joint]).abs() < 0.02 * fastest + 0.5, "{joint}: {slope} {}", now[joint]);
        }
        let braked = planner.brake(&motion, t, 2.0).trajectory;
        prop_assert_eq!(braked.sample(0), motion.sample(t));
        prop_assert_eq!(braked.joint_velocities(0)[3], 0.0);
        if braked.duration_us() > 0 {
            for (at_first, now) in braked.joint_velocities(0).iter().zip(now).take(3) {
                prop_assert!((at_first - now).abs() < 1e-9 * fastest);
            }
        }
        // `progress` and `time_at_progress` are inverse to each other.
        let done = motion.progress(t);
        let again = motion.time_at_progress(done).expect("reached");
        prop_assert!(again.abs_diff(t) <= 1, "{again} {t}");
    }

    /// No input makes the planner fail or take long.
    #[test]
    fn any_numbers_are_answered(
        from in prop_oneof![reachable(), any::<[f64; 4]>().prop_map(JointAngles::from)],
        via in any::<[f64; 4]>(), to in any::<[f64; 4]>(), scale in prop_oneof![Just(0.0), -320.0..320.0f64, Just(1e6), Just(1e30), Just(f64::NAN)],
        tool in any::<[f64; 3]>(), plain in any::<bool>(), count in any::<u32>(),
    ) {
        let geometry = if plain { Geometry::default() } else { Geometry::magician(ToolBias::new(tool[0], tool[1], tool[2])) };
        let squeezed = |pose: [f64; 4]| Pose::from(if scale == 0.0 { pose } else { pose.map(|value| value.to_bits() as f64 / u64::MAX as f64 * scale) });
        let (via, to) = (squeezed(via), squeezed(to));
        for limits in [ArmModel::MAGICIAN.limits, WITHOUT_LIMITS] {
            let planner = Planner { geometry, limits, ceilings: Ceilings::default(), law: MotionLaw::MAGICIAN, speeds: ArmModel::MAGICIAN.power_up.speeds() };
            let from = ArmState::at_joints(&geometry, &from);
            for plan in [planner.arc(&from, &via, &to), planner.circle(&from, &via, &to, count)].into_iter().flatten() {
                let motion = plan.trajectory;
                for share in 0..4u64 {
                    let t = motion.duration_us() / 3 * share;
                    let _ = (motion.sample(t), motion.joint_velocities(t), motion.progress(t));
                    let _ = planner.brake(&motion, t, 2.0);
                }
            }
        }
    }
}

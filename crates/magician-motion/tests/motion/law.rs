//! The law of motion in periods of 20 ms, compared with recordings of real arms and with speeds
//! that are summed period by period.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Geometry, Jog, JogAxis, JointAngles, KinematicLimits, MotionLaw, Move,
    MoveKind, Planner, Pose, Target, ToolBias, Trajectory, VelocityProfile,
};
use proptest::prelude::*;

const PERIOD_US: u64 = 20_000;
const PERIOD: f64 = 0.02;

/// Positions of a controller that adds up period by period: speed first, then position.
fn summed_positions(speeds: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut place = 0.0;
    let places = speeds.into_iter().map(|speed| {
        place += speed * PERIOD;
        place
    });
    [0.0].into_iter().chain(places).collect()
}

/// Speeds of a jog that ramps to a target, period by period.
fn jog_speeds(mut speed: f64, target: f64, acceleration: f64) -> impl Iterator<Item = f64> {
    std::iter::repeat_with(move || {
        let most = acceleration * PERIOD;
        speed += (target - speed).clamp(-most, most);
        speed
    })
}

fn at(profile: &VelocityProfile, step: usize) -> f64 {
    profile.position(step as f64 * PERIOD)
}

fn limits() -> impl Strategy<Value = KinematicLimits> {
    (1.0..300.0f64, 1.0..400.0f64).prop_map(|(velocity, acceleration)| KinematicLimits {
        velocity,
        acceleration,
    })
}

/// A MOVJ in the log of a ROS 2 driver: 0.07200 and 0.43201 degrees after 3 and 8 periods at 30
/// deg/s2.
#[test]
fn joint_move_matches_recording_of_a_real_arm() {
    let limits = KinematicLimits {
        velocity: 60.0,
        acceleration: 30.0,
    };
    let profile = MotionLaw::MAGICIAN.rest_to_rest(45.0, &limits);
    assert!((at(&profile, 3) - 0.072).abs() < 1e-9);
    assert!((at(&profile, 8) - 0.432).abs() < 1e-9);
}

proptest! {
    #![proptest_config(cases(1_000))]

    /// The vendor's controller uses the speed of the trapezoid at the end of each period; the last
    /// period goes to the target.
    #[test]
    fn rest_to_rest_profile_sums_the_trapezoid_speeds(length in 0.001..500.0f64, limits in limits()) {
        let trapezoid = VelocityProfile::trapezoid(length, &limits);
        let profile = MotionLaw::MAGICIAN.rest_to_rest(length, &limits);
        let count = (trapezoid.duration() / PERIOD - 1e-7).ceil() as usize;
        prop_assert!((profile.duration() - count as f64 * PERIOD).abs() < 1e-9);
        let places = summed_positions((1..count).map(|step| trapezoid.velocity(step as f64 * PERIOD)));
        for (step, place) in places.iter().enumerate() {
            prop_assert!((at(&profile, step) - place).abs() < 1e-9 * (1.0 + length), "{step}: {} {place}", at(&profile, step));
        }
        prop_assert_eq!(at(&profile, count), length);
        // The curve between the positions never goes back, and `time_at` is its inverse.
        for nth in 0..100 {
            let t = profile.duration() * f64::from(nth) / 100.0;
            let place = profile.position(t);
            prop_assert!(place <= profile.position(t + 1e-3) + 1e-12, "{place} at {t} of {}: {:?} {}", profile.duration(), profile, profile.position(t+1e-3));
            prop_assert!((profile.position(profile.time_at(place)) - place).abs() < 1e-9 * (1.0 + length));
        }
    }

    #[test]
    fn stop_profile_sums_speeds_until_zero(speed in 0.0..400.0f64, acceleration in 1.0..400.0f64) {
        let profile = MotionLaw::MAGICIAN.stop(speed, acceleration);
        let places = summed_positions(jog_speeds(speed, 0.0, acceleration).take_while(|speed| *speed > 0.0));
        for (step, place) in places.iter().enumerate() {
            prop_assert!((at(&profile, step) - place).abs() < 1e-9 * (1.0 + place));
        }
        let length = places.last().copied().unwrap_or(0.0);
        prop_assert!((profile.length() - length).abs() < 1e-9 * (1.0 + length));
        prop_assert!(profile.duration() <= (places.len() as f64) * PERIOD + 1e-9);
    }

    /// From any initial speed, of either sign.
    #[test]
    fn jog_ramps_to_its_speed_at_the_acceleration(
        entry in -300.0..300.0f64, velocity in 1.0..300.0f64, acceleration in 5.0..400.0f64, backwards in any::<bool>(),
    ) {
        let planner = Planner { limits: WITHOUT_LIMITS, ..ArmModel::MAGICIAN.planner(ToolBias::NONE, full_speed()) };
        let from = ArmState::at_joints(&planner.geometry, &JointAngles::HOME);
        let jog = Jog { axis: JogAxis::J1, positive: !backwards };
        let plan = planner.jog(&from, jog, KinematicLimits { velocity, acceleration: acceleration.min(300.0) }, entry);
        let motion = plan.expect("planned").trajectory;
        let target = if backwards { -velocity } else { velocity };
        let speeds: Vec<f64> = jog_speeds(entry, target, acceleration.min(300.0)).take(200).collect();
        for (step, place) in summed_positions(speeds.iter().copied()).iter().enumerate() {
            let at_us = step as u64 * PERIOD_US;
            let turned = motion.sample(at_us).joints.j1 - from.joints.j1;
            prop_assert!((turned - place).abs() < 1e-9 * (1.0 + place.abs()), "{step}: {turned} {place}");
            let speed = if step == 0 { entry } else { speeds[step - 1] };
            prop_assert!((motion.velocity_along(JogAxis::J1, at_us + 7_000) - speed).abs() < 1e-8, "{step}");
        }
    }

    #[test]
    fn poses_stand_still_between_periods_and_all_ends_are_exact(
        from in reachable(), to in reachable(), planner in planner(), straight in any::<bool>(), share in 0.0..1.0f64,
    ) {
        let planner = Planner { law: MotionLaw::MAGICIAN, ..planner };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let target = Target::Pose(planner.geometry.forward(&to));
        let request = if straight { line(target) } else { joint_move(target) };
        let plan = planner.plan(&from, &request).expect("planned");
        let motion = plan.trajectory;
        prop_assert_eq!(motion.duration_us() % PERIOD_US, 0);
        let t = (motion.duration_us() as f64 * share) as u64;
        prop_assert_eq!(motion.sample(t), motion.sample(t - t % PERIOD_US));
        for bound in planner.limits.violations(&motion.sample(t).joints) {
            let side = if bound.is_upper() { 1.0 } else { -1.0 };
            let over = side * (bound.value(&motion.sample(t).joints) - planner.limits.at(bound));
            prop_assert!(over < 1e-6, "{over} beyond {bound:?}");
        }
        let braked = planner.brake(&motion, t, 2.0).trajectory;
        prop_assert_eq!(braked.sample(0), motion.sample(t));
        prop_assert_eq!(braked.duration_us() % PERIOD_US, 0);
    }

    /// A segment takes the nearest whole number of periods, exceeds its limits only as far as that
    /// requires, and ends exactly at its length and exit speed.
    #[test]
    fn a_segment_takes_the_nearest_whole_number_of_periods(
        length in 0.01..50.0f64, entry in 0.0..100.0f64, exit in 0.0..100.0f64, limits in limits(),
    ) {
        let exact = VelocityProfile::between(length, entry, exit, &limits);
        let profile = MotionLaw::MAGICIAN.segment(length, entry, exit, &limits);
        let count = profile.duration() / PERIOD;
        prop_assert!((count - count.round()).abs() < 1e-9 && count.round() >= 1.0);
        // The rounding of its ends to binary32, 0.00006 mm, decides a tie and nothing else.
        let half = 0.5 * PERIOD + 6e-5 / limits.velocity + 1e-9;
        let off = profile.duration() - exact.duration();
        prop_assert!(off.abs() <= half || count.round() == 1.0 && off > 0.0, "{off}");
        prop_assert_eq!((profile.position(0.0), profile.position(profile.duration())), (0.0, length));
        prop_assert_eq!(profile.exit(), exact.exit());
        // Shortened to `share` of the time, a cruise is faster by the factor 1 / `share`, and even
        // faster because it also makes up for the ramps.
        let share = (profile.duration() / exact.duration()).min(1.0);
        let highest = limits.velocity.max(entry).max(exact.exit()) * (1.0 + 1e-9);
        let highest = highest * (2.0 - share) / share;
        for nth in 0..100 {
            let t = profile.duration() * f64::from(nth) / 100.0;
            prop_assert!(profile.velocity(t) <= highest, "{} of {highest}", profile.velocity(t));
            let travelled = profile.position(t + 1e-4) - profile.position(t);
            prop_assert!(travelled >= 0.0 && travelled <= 1e-4 * highest + 1e-12, "{travelled}");
        }
    }
}

#[test]
fn segments_at_one_speed_take_the_nearest_number_of_periods() {
    let limits = |velocity| KinematicLimits {
        velocity,
        acceleration: 100.0,
    };
    for (length, velocity, periods) in [
        // 1.67, 1.33 and 2.33 periods at the speed of the path.
        (1.0, 30.0, 2),
        (0.8, 30.0, 1),
        (1.4, 30.0, 2),
        // A tie, however binary32 rounds both ends.
        (3.0, 100.0, 2),
        (3.0 - 5e-5, 100.0, 2),
        (3.0 + 5e-5, 100.0, 2),
        // At least one period.
        (0.1, 30.0, 1),
    ] {
        let profile = MotionLaw::MAGICIAN.segment(length, velocity, velocity, &limits(velocity));
        let duration = f64::from(periods) * PERIOD;
        assert!(
            (profile.duration() - duration).abs() < 1e-9,
            "{length} mm at {velocity} mm/s: {} s",
            profile.duration()
        );
        // Constant speed.
        let middle = profile.position(0.5 * duration);
        assert!((middle - 0.5 * length).abs() < 1e-9, "{length}: {middle}");
    }
}

fn pose_of(motion: &Trajectory, step: u64) -> Pose {
    motion.sample(step * PERIOD_US).pose
}

#[test]
fn a_line_of_a_real_arm_takes_one_period_more_at_most() {
    let model = ArmModel::MAGICIAN;
    let planner = model.planner(ToolBias::SUCTION, model.power_up.speeds());
    let from = ArmState::at_joints(&planner.geometry, &JointAngles::HOME);
    let request = Move {
        target: Target::PoseIncrement(Pose::new(0.0, 100.0, 0.0, 0.0)),
        kind: MoveKind::Line,
    };
    let motion = planner.plan(&from, &request).unwrap().trajectory;
    // 2 s in continuous time, which is a whole number of periods.
    assert_eq!(motion.duration_us(), 2_000_000);
    // Each period covers 0.04 mm more than the one before: 100 mm/s2.
    let travelled = |step| pose_of(&motion, step).y - from.pose.y;
    for (step, mm) in [(1, 0.04), (2, 0.12), (5, 0.6), (10, 2.2)] {
        assert!(
            (travelled(step) - mm).abs() < 1e-9,
            "{step}: {}",
            travelled(step)
        );
    }
    assert_eq!(motion.end().pose.y, from.pose.y + 100.0);
    let _: Geometry = planner.geometry;
}

//! Velocity profiles between any two speeds.

use super::support::cases;
use magician_motion::{KinematicLimits, VelocityProfile};
use proptest::prelude::*;

fn limits() -> impl Strategy<Value = KinematicLimits> {
    (1.0..300.0f64, 1.0..400.0f64).prop_map(|(velocity, acceleration)| KinematicLimits {
        velocity,
        acceleration,
    })
}

#[test]
fn profile_matches_closed_forms() {
    let limits = KinematicLimits {
        velocity: 100.0,
        acceleration: 200.0,
    };
    // Half a second of ramp over 25 mm, 50 mm of cruise, half a second of ramp.
    let whole = VelocityProfile::between(100.0, 0.0, 0.0, &limits);
    assert!((whole.duration() - 1.5).abs() < 1e-12);
    assert_eq!(whole.corners()[..2], [0.5, 1.0]);
    // Too short to reach the exit speed: the square of the speed grows by 2 a s.
    let short = VelocityProfile::between(1.0, 0.0, 90.0, &limits);
    assert!((short.exit() - 20.0).abs() < 1e-12);
    assert!((short.duration() - 0.1).abs() < 1e-12);
    // Too short to brake: mean speed over the length.
    let hard = VelocityProfile::between(1.0, 90.0, 10.0, &limits);
    assert!((hard.duration() - 0.02).abs() < 1e-12);
    assert!((hard.acceleration(0.01) + 4000.0).abs() < 1e-6);
    assert_eq!(hard.exit(), 10.0);
    // Enters too fast by 50 mm/s, which is lost over 31.25 mm.
    let fast = VelocityProfile::between(100.0, 150.0, 100.0, &limits);
    assert!((fast.corners()[0] - 0.25).abs() < 1e-12);
    assert!((fast.duration() - 0.25 - 0.6875).abs() < 1e-12);
    let stop = VelocityProfile::stopping(50.0, 100.0);
    assert_eq!((stop.length(), stop.duration()), (12.5, 0.5));
    assert_eq!(stop.velocity(0.25), 25.0);
    assert_eq!(VelocityProfile::stopping(0.0, 100.0).duration(), 0.0);
}

proptest! {
    #![proptest_config(cases(1_000))]

    #[test]
    fn is_its_own_integral_and_keeps_its_limits(
        length in 0.001..500.0f64, entry in 0.0..400.0f64, exit in 0.0..400.0f64, limits in limits(),
    ) {
        let profile = VelocityProfile::between(length, entry, exit, &limits);
        let forced = entry.powi(2) - exit.min(limits.velocity).powi(2) > 2.0 * limits.acceleration * length;
        prop_assert_eq!(profile.position(0.0), 0.0);
        prop_assert_eq!(profile.position(profile.duration()), length);
        prop_assert_eq!(profile.velocity(0.0), entry);
        prop_assert_eq!(profile.velocity(profile.duration()), profile.exit());
        let gained = (entry.powi(2) + 2.0 * limits.acceleration * length).sqrt();
        let expected = exit.min(limits.velocity).min(gained);
        prop_assert!((profile.exit() - expected).abs() < 1e-9);
        const STEPS: u32 = 400;
        let step = profile.duration() / f64::from(STEPS);
        for n in 0..STEPS {
            let (a, b) = (f64::from(n) * step, f64::from(n + 1) * step);
            let (before, after) = (profile.velocity(a), profile.velocity(b));
            prop_assert!(before <= limits.velocity.max(entry) * (1.0 + 1e-12));
            if !forced {
                let change = (after - before).abs();
                prop_assert!(change <= limits.acceleration * step * (1.0 + 1e-6) + 1e-9, "{change}");
            }
            // The velocity is linear except at two corners, so elsewhere the mean speed is that of
            // the middle.
            let corner = profile.corners().iter().any(|corner| (a..=b).contains(corner));
            let gone = profile.position(b) - profile.position(a);
            let mean = profile.velocity(0.5 * (a + b));
            prop_assert!(gone >= 0.0);
            if !corner {
                prop_assert!((gone - mean * step).abs() < 1e-9, "{gone} {}", mean * step);
                let slope = profile.acceleration(0.5 * (a + b));
                prop_assert!((after - before - slope * step).abs() < 1e-7);
            } else {
                let (low, high) = (before.min(after), before.max(after).max(profile.velocity(profile.corners()[0])));
                prop_assert!(gone >= low * step - 1e-9 && gone <= high * step + 1e-9);
            }
        }
        for n in 0..=20 {
            let distance = length * f64::from(n) / 20.0;
            prop_assert!((profile.position(profile.time_at(distance)) - distance).abs() < 1e-9);
        }
    }

    #[test]
    fn from_rest_to_rest_is_a_trapezoid(length in 0.001..500.0f64, limits in limits(), share in 0.0..1.0f64) {
        let (general, trapezoid) = (VelocityProfile::between(length, 0.0, 0.0, &limits), VelocityProfile::trapezoid(length, &limits));
        prop_assert!((general.duration() - limits.least_time(length)).abs() < 1e-12 * general.duration().max(1.0));
        let t = share * general.duration();
        prop_assert!((general.position(t) - trapezoid.position(t)).abs() < 1e-9);
        prop_assert!((general.velocity(t) - trapezoid.velocity(t)).abs() < 1e-9);
        prop_assert!((general.time_at(share * length) - trapezoid.time_at(share * length)).abs() < 1e-7);
    }

    #[test]
    fn stopping_takes_the_time_that_is_asked_for(speed in 0.0..400.0f64, duration in 0.0..10.0f64, share in 0.0..1.0f64) {
        let profile = VelocityProfile::stopping_in(speed, duration);
        prop_assert_eq!((profile.duration(), profile.exit()), (duration, 0.0));
        let t = share * duration;
        prop_assert!((profile.velocity(t) - speed * (1.0 - share)).abs() < 1e-9);
        prop_assert!((profile.position(t) - speed * t * (1.0 - 0.5 * share)).abs() < 1e-9);
    }
}

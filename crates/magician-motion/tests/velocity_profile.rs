//! The speed law between any two speeds.

mod support;

use magician_motion::{KinematicLimits, Trapezoid, VelocityProfile};
use proptest::prelude::*;
use support::cases;

fn rates() -> impl Strategy<Value = KinematicLimits> {
    (1.0..300.0f64, 1.0..400.0f64).prop_map(|(velocity, acceleration)| KinematicLimits {
        velocity,
        acceleration,
    })
}

#[test]
fn the_closed_forms() {
    let rates = KinematicLimits {
        velocity: 100.0,
        acceleration: 200.0,
    };
    // Half a second up over 25 mm, 50 mm held, half a second down.
    let whole = VelocityProfile::between(100.0, 0.0, 0.0, &rates);
    assert!((whole.duration() - 1.5).abs() < 1e-12);
    assert_eq!(whole.corners(), [0.5, 1.0]);
    // Too short for what it is to gain: the square of the speed grows by 2 a s.
    let short = VelocityProfile::between(1.0, 0.0, 90.0, &rates);
    assert!((short.exit() - 20.0).abs() < 1e-12);
    assert!((short.duration() - 0.1).abs() < 1e-12);
    // Too short for what it is to lose: at the mean speed over the length.
    let hard = VelocityProfile::between(1.0, 90.0, 10.0, &rates);
    assert!((hard.duration() - 0.02).abs() < 1e-12);
    assert!((hard.acceleration(0.01) + 4000.0).abs() < 1e-6);
    assert_eq!(hard.exit(), 10.0);
    // Faster than allowed at first: 50 mm/s too much, lost over 31.25 mm.
    let fast = VelocityProfile::between(100.0, 150.0, 100.0, &rates);
    assert!((fast.corners()[0] - 0.25).abs() < 1e-12);
    assert!((fast.duration() - 0.25 - 0.6875).abs() < 1e-12);
    let stop = VelocityProfile::stopping(50.0, 100.0);
    assert_eq!((stop.length(), stop.duration()), (12.5, 0.5));
    assert_eq!(stop.velocity(0.25), 25.0);
    assert_eq!(VelocityProfile::stopping(0.0, 100.0).duration(), 0.0);
}

proptest! {
    #![proptest_config(cases(4_000))]

    #[test]
    fn is_its_own_integral_and_keeps_its_rates(
        length in 0.001..500.0f64, entry in 0.0..400.0f64, exit in 0.0..400.0f64, rates in rates(),
    ) {
        let law = VelocityProfile::between(length, entry, exit, &rates);
        let forced = entry.powi(2) - exit.min(rates.velocity).powi(2) > 2.0 * rates.acceleration * length;
        prop_assert_eq!(law.position(0.0), 0.0);
        prop_assert_eq!(law.position(law.duration()), length);
        prop_assert_eq!(law.velocity(0.0), entry);
        prop_assert_eq!(law.velocity(law.duration()), law.exit());
        let gained = (entry.powi(2) + 2.0 * rates.acceleration * length).sqrt();
        let expected = exit.min(rates.velocity).min(gained);
        prop_assert!((law.exit() - expected).abs() < 1e-9);
        const STEPS: u32 = 400;
        let step = law.duration() / f64::from(STEPS);
        for n in 0..STEPS {
            let (a, b) = (f64::from(n) * step, f64::from(n + 1) * step);
            let (before, after) = (law.velocity(a), law.velocity(b));
            prop_assert!(before <= rates.velocity.max(entry) * (1.0 + 1e-12));
            if !forced {
                let change = (after - before).abs();
                prop_assert!(change <= rates.acceleration * step * (1.0 + 1e-6) + 1e-9, "{change}");
            }
            // The law is linear but for two corners: elsewhere the mean speed is that of the middle.
            let corner = law.corners().iter().any(|corner| (a..=b).contains(corner));
            let gone = law.position(b) - law.position(a);
            let mean = law.velocity(0.5 * (a + b));
            prop_assert!(gone >= 0.0);
            if !corner {
                prop_assert!((gone - mean * step).abs() < 1e-9, "{gone} {}", mean * step);
                let slope = law.acceleration(0.5 * (a + b));
                prop_assert!((after - before - slope * step).abs() < 1e-7);
            } else {
                let (low, high) = (before.min(after), before.max(after).max(law.velocity(law.corners()[0])));
                prop_assert!(gone >= low * step - 1e-9 && gone <= high * step + 1e-9);
            }
        }
        for n in 0..=20 {
            let distance = length * f64::from(n) / 20.0;
            prop_assert!((law.position(law.time_at(distance)) - distance).abs() < 1e-9);
        }
    }

    #[test]
    fn from_rest_to_rest_is_the_point_to_point_law(length in 0.001..500.0f64, rates in rates(), share in 0.0..1.0f64) {
        let (law, profile) = (VelocityProfile::between(length, 0.0, 0.0, &rates), Trapezoid::fastest(length, &rates));
        prop_assert!((law.duration() - rates.least_time(length)).abs() < 1e-12 * law.duration().max(1.0));
        let same = VelocityProfile::from(profile);
        let t = share * law.duration();
        for law in [law, same] {
            prop_assert!((law.position(t) - profile.position(t)).abs() < 1e-9);
            prop_assert!((law.velocity(t) - profile.velocity(t)).abs() < 1e-9);
            prop_assert!((law.time_at(share * length) - profile.time_at(share * length)).abs() < 1e-7);
        }
    }
}

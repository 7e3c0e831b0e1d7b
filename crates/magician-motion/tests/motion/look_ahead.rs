//! Speeds of continuous paths at corners, computed by hand (model section 8).

use magician_motion::{
    ArmModel, CpSegment, CpSpeeds, LookAhead, MotionError, MotionLaw, SpeedQuantity,
};

#[test]
fn corner_speed_matches_closed_form() {
    let look_ahead = LookAhead::new(
        &ArmModel::MAGICIAN.cp_speeds(),
        &ArmModel::MAGICIAN.ceilings,
        MotionLaw::CONTINUOUS,
    )
    .expect("speeds");
    let along = CpSegment::between([0.0; 3], [50.0, 0.0, 0.0]);
    let turned = |degrees: f64| {
        let angle = degrees.to_radians();
        CpSegment::between(
            [50.0, 0.0, 0.0],
            [50.0 + 50.0 * angle.cos(), 50.0 * angle.sin(), 0.0],
        )
    };
    for degrees in [5.0, 30.0, 60.0, 90.0f64] {
        let next = turned(degrees);
        let expected: f64 = 0.5 * 100.0 * 0.02 / (degrees.to_radians() / 2.0).sin();
        assert!((look_ahead.exit_speed(&along, [&next]) - expected).abs() < 1e-9);
    }
    let (square, back) = (turned(90.0), turned(180.0));
    let speed = look_ahead.exit_speed(&along, [&square]);
    assert!((look_ahead.exit_speed(&along, [&back]) - speed).abs() < 1e-12);
    // Without a corner only the stop at the end of the queue limits the speed: 50 mm at 100 mm/s2
    // allow 100 mm/s.
    let on = turned(0.0);
    assert_eq!(look_ahead.exit_speed(&along, [&on]), 100.0);
    let short = CpSegment::between([50.0, 0.0, 0.0], [50.5, 0.0, 0.0]);
    assert!((look_ahead.exit_speed(&along, [&short]) - 10.0).abs() < 1e-12);
    assert_eq!(look_ahead.exit_speed(&along, []), 0.0);
    // A segment below the minimum length adds neither a corner nor a distance.
    let speck = CpSegment::between([50.0, 0.0, 0.0], [50.0, 5e-5, 0.0]);
    assert!(speck.is_empty());
    assert_eq!(look_ahead.exit_speed(&along, [&speck, &on]), 100.0);
    assert_eq!(look_ahead.exit_speed(&along, [&speck]), 0.0);
    let nowhere = CpSegment::between([1.0; 3], [1.0; 3]);
    let mut scratch = [0.0; 4];
    let path = [along, speck, nowhere, on];
    let times: Vec<u64> = look_ahead.times(&path, &mut scratch).collect();
    assert_eq!(times, [1_000_000, 0, 0, 1_000_000]);
}

#[test]
fn in_real_time_a_segment_takes_a_period() {
    let settings = CpSpeeds {
        plan_acceleration: 400.0,
        junction_velocity: 300.0,
        period_s: 0.05,
        real_time: true,
    };
    let look_ahead = LookAhead::new(
        &settings,
        &ArmModel::MAGICIAN.ceilings,
        MotionLaw::CONTINUOUS,
    )
    .expect("speeds");
    let piece = |from: f64, to: f64| CpSegment::between([from, 0.0, 0.0], [to, 0.0, 0.0]);
    let path: Vec<CpSegment> = (0..40u32)
        .map(|n| piece(f64::from(n), f64::from(n + 1)))
        .collect();
    assert_eq!(look_ahead.rates(&path[0]).velocity, 20.0);
    // The speed of the path limits long segments.
    assert_eq!(look_ahead.rates(&piece(0.0, 100.0)).velocity, 300.0);
    let mut scratch = vec![0.0; 40];
    let times: Vec<u64> = look_ahead.times(&path, &mut scratch).collect();
    assert!(times[5..35].iter().all(|us| *us == 50_000), "{times:?}");
    // No limit at corners.
    let aside = CpSegment::between([1.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
    assert_eq!(look_ahead.exit_speed(&path[0], [&aside]), 20.0);
    // Without `real_time` a segment still takes whole periods, but corners limit the speed.
    let look_ahead = LookAhead::new(
        &CpSpeeds {
            real_time: false,
            ..settings
        },
        &ArmModel::MAGICIAN.ceilings,
        MotionLaw::with_period_us(50_000),
    )
    .expect("speeds");
    assert_eq!(look_ahead.rates(&path[0]).velocity, 20.0);
    assert!(look_ahead.exit_speed(&path[0], [&aside]) < 20.0);
}

#[test]
fn zero_negative_and_nan_settings_are_refused() {
    let refused = |settings| match LookAhead::new(
        &settings,
        &ArmModel::MAGICIAN.ceilings,
        MotionLaw::CONTINUOUS,
    ) {
        Err(MotionError::Speed { quantity, .. }) => quantity,
        other => panic!("{other:?}"),
    };
    for bad in [0.0, -1.0, f64::NAN] {
        let settings = ArmModel::MAGICIAN.cp_speeds();
        assert_eq!(
            refused(CpSpeeds {
                plan_acceleration: bad,
                ..settings
            }),
            SpeedQuantity::LinearAcceleration
        );
        assert_eq!(
            refused(CpSpeeds {
                junction_velocity: bad,
                ..settings
            }),
            SpeedQuantity::LinearVelocity
        );
        assert_eq!(
            refused(CpSpeeds {
                period_s: bad,
                ..settings
            }),
            SpeedQuantity::Period
        );
    }
    let error = MotionError::Speed {
        quantity: SpeedQuantity::Period,
        value: 0.0,
    };
    assert_eq!(error.to_string(), "period is 0 s, it must be above 0 s");
    // Ceilings of the arm.
    let fast = LookAhead::new(
        &CpSpeeds {
            plan_acceleration: 1e9,
            junction_velocity: 1e9,
            ..ArmModel::MAGICIAN.cp_speeds()
        },
        &ArmModel::MAGICIAN.ceilings,
        MotionLaw::CONTINUOUS,
    )
    .expect("speeds");
    let rates = fast.rates(&CpSegment::between([0.0; 3], [1.0; 3]));
    assert_eq!((rates.velocity, rates.acceleration), (300.0, 400.0));
}

//! Commands made by builders, and their effect on the virtual arm.

use std::time::Duration;

use magician::Set;
use magician::build::{self, Color, Output, Sensed};
use magician::commands::{ColorSensor, EMotor, EMotorS, IrSwitch, Pose, PoseL, PtpPoWithLCmd};
use magician::preflight::Preflight;
use magician::protocol::{Flag, IoFunction, Port, PtpMode, RailVersion, SensorVersion, Stepper};

use crate::bench::LoneArm;

#[test]
fn the_belt_goes_as_far_as_it_is_told() {
    for (mm, mm_per_s) in [(100.0f32, 50.0f32), (-40.0, 20.0), (40.0, -20.0)] {
        let mut bench = LoneArm::new();
        bench.start();
        let belt = build::conveyor_by(Stepper::Stepper2, mm, mm_per_s);
        let time = Preflight::new(&bench.readings()).estimate(&[belt]).unwrap();
        let took = bench.run(&belt);
        let [_, motor] = bench.arm.steppers();
        let moved = motor.pulses / build::CONVEYOR_PULSES_PER_MM;
        assert!((moved - f64::from(mm)).abs() < 0.01, "{moved}");
        assert_eq!(u128::from(took), time.as_micros());
        let expected = f64::from(mm / mm_per_s).abs();
        assert!((took as f64 / 1e6 - expected).abs() < 0.01, "{took}");
    }
    let Set::EMotor(EMotor {
        is_enabled, speed, ..
    }) = build::conveyor(Stepper::Stepper1, -10.0)
    else {
        panic!("a motor");
    };
    assert_eq!((is_enabled, speed), (Flag::ON, -1498));
    assert_eq!(
        build::conveyor(Stepper::Stepper1, f32::NAN),
        build::conveyor(Stepper::Stepper1, 0.0)
    );
    let Set::EMotorS(EMotorS { speed, .. }) =
        build::conveyor_by(Stepper::Stepper1, 1.0, f32::INFINITY)
    else {
        panic!("a motor");
    };
    assert_eq!(speed, 1_000_000);
}

#[test]
fn the_rail_goes_with_the_arm_and_alone() {
    let mut bench = LoneArm::new();
    bench.start();
    bench.run(&build::rail(true, RailVersion::V1));
    bench.run(&build::rail_speed(200.0, 200.0));
    let jump = build::with_rail(build::jump_to(200.0, 50.0, 20.0, 0.0), 300.0).unwrap();
    bench.run(&jump);
    assert_eq!(bench.get::<PoseL>().pose_l, 300.0);
    let before = bench.get::<Pose>();
    bench.run(&build::rail_by(-100.0));
    bench.run(&build::rail_to(120.0, &before));
    let after = bench.get::<Pose>();
    assert_eq!(bench.get::<PoseL>().pose_l, 120.0);
    assert_eq!(after.joint_angle, before.joint_angle);
    assert!(!bench.alarmed());
}

#[test]
fn a_move_switches_outputs_on_its_way_with_or_without_the_rail() {
    let outputs = [(10, true), (90, false)].map(|(percent, high)| Output {
        percent,
        address: 4,
        high,
    });
    let line = build::line_by(0.0, 10.0, 0.0, 0.0);
    let first = build::with_outputs(line, &outputs).unwrap();
    let both = build::with_rail(first, 5.0).unwrap();
    let rail = build::with_rail(line, 5.0).unwrap();
    assert_eq!(both, build::with_outputs(rail, &outputs).unwrap());
    let Set::PtpPoWithLCmd(PtpPoWithLCmd {
        ptp_mode, l, po, ..
    }) = both
    else {
        panic!("with both");
    };
    assert_eq!(
        (ptp_mode, l, po.as_slice().len()),
        (PtpMode::MovlXyzInc, 5.0, 2)
    );
    let many = [outputs[0]; 57];
    let full = build::with_outputs(line, &many).unwrap();
    assert!(build::with_rail(full, 5.0).is_err() && build::with_outputs(rail, &many).is_err());
    assert!(build::with_outputs(line, &[outputs[0]; 58]).is_err());
    assert!(build::with_outputs(build::home(), &outputs).is_err());

    let mut bench = LoneArm::new();
    bench.start();
    bench.run(&build::multiplex(4, IoFunction::DigitalOutput));
    bench.enqueue(&first);
    bench.pass();
    let level = |bench: &LoneArm| {
        bench
            .arm
            .pins()
            .iter()
            .any(|pin| pin.address == 4 && pin.level)
    };
    assert!(level(&bench), "a tenth of the way");
    while bench.pass() {}
    assert!(!level(&bench), "nine tenths of the way");
}

#[test]
fn triggers_say_what_they_compare() {
    use magician::protocol::TriggerCondition::{Above, AtLeast, DifferentOrAtMost, EqualOrBelow};
    let conditions = [
        build::wait_below(12, 5),
        build::wait_at_most(12, 5),
        build::wait_at_least(12, 5),
        build::wait_above(12, 5),
    ]
    .map(|command| match command {
        Set::TrigCmd(trigger) => trigger.condition,
        _ => panic!("a trigger"),
    });
    assert_eq!(
        conditions,
        [EqualOrBelow, DifferentOrAtMost, AtLeast, Above]
    );
    // The input is 0, so two of them are satisfied.
    let mut bench = LoneArm::new();
    bench.start();
    assert_eq!(bench.run(&build::wait_below(12, 5)), 0);
    assert_eq!(bench.run(&build::wait_at_most(12, 0)), 0);
    bench.run(&build::wait_above(12, 5));
    assert_eq!(bench.arm.state().awaits_input, Some(12));
}

#[test]
fn sensors_say_what_they_see() {
    let mut bench = LoneArm::new();
    bench.start();
    bench.run(&build::color_sensor(Port::Gp2, true, SensorVersion::V2));
    bench.run(&build::infrared(Port::Gp4, true, SensorVersion::V1));
    assert_eq!(
        bench
            .get_with::<ColorSensor>(&build::color_at(Port::Gp2))
            .sensed(),
        None
    );
    assert!(
        !bench
            .get_with::<IrSwitch>(&build::infrared_at(Port::Gp4))
            .sensed()
    );
    let color = |r, g, b| ColorSensor { r, g, b }.sensed();
    assert_eq!(color(1, 0, 0), Some(Color::Red));
    assert_eq!(color(20, 19, 250), Some(Color::Blue));
    assert_eq!(color(9, 9, 1), None);
}

#[test]
fn a_servo_gets_its_pulses() {
    let half = build::servo(8, 1.5);
    assert_eq!(half, build::pwm(8, 50.0, 7.5));
    let check = Preflight::at(magician::JointAngles::HOME, magician::ToolBias::NONE);
    assert_eq!(check.estimate(&[half]).unwrap(), Duration::ZERO);
    assert!(check.estimate(&[build::servo(8, 21.0)]).is_err());
}

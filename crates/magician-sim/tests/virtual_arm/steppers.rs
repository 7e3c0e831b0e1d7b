//! Stepper outputs (document 1.15.6, errata E41).

use super::arm;
use super::arm::{SECOND, TestArm, arm, at, running_arm, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Flag, Port, Stepper};
use magician_sim::{CONVEYOR_PULSES_PER_MM, Event, ExternalEvent};

fn steady(index: u8, enabled: bool, speed: i32) -> EMotor {
    EMotor {
        index: Stepper::from(index),
        is_enabled: Flag::from(enabled),
        speed,
    }
}

fn counted(index: u8, speed: i32, distance: u32) -> EMotorS {
    EMotorS {
        index: Stepper::from(index),
        is_enabled: Flag::ON,
        speed,
        distance,
    }
}

#[track_caller]
fn turns(bench: &TestArm, index: usize, rate: f64, pulses: f64) {
    let stepper = bench.arm.steppers()[index];
    assert_eq!(stepper.pulses_per_second, rate);
    assert!(
        (stepper.pulses - pulses).abs() < 1e-6,
        "{} pulses, not {pulses}",
        stepper.pulses
    );
}

#[test]
fn a_motor_turns_until_it_is_told_otherwise() {
    let mut bench = running_arm();
    let index = bench.enqueue(&steady(0, true, 2000));
    assert_eq!(bench.current_index(), index, "finished at once");
    assert_eq!(bench.arm.poll_timeout(), None);
    bench.pass(10 * SECOND);
    turns(&bench, 0, 2000.0, 20_000.0);
    turns(&bench, 1, 0.0, 0.0);
    bench.set(&steady(0, true, -500));
    bench.pass(4 * SECOND);
    turns(&bench, 0, -500.0, 18_000.0);
    // A disabled output is at rest at any speed.
    bench.set(&steady(0, false, 700));
    bench.pass(SECOND);
    turns(&bench, 0, 0.0, 18_000.0);
    bench.set(&steady(1, true, 3));
    bench.pass(SECOND);
    turns(&bench, 1, 3.0, 3.0);
}

#[test]
fn a_number_of_pulses_ends_to_the_microsecond() {
    let mut bench = arm();
    bench.set(&counted(1, -3000, 1000));
    assert_eq!(bench.arm.poll_timeout(), Some(at(333_333)));
    assert_eq!(bench.arm.steppers()[1].ends, Some(at(333_333)));
    bench.pass(333_332);
    assert_eq!(bench.arm.steppers()[1].pulses_per_second, -3000.0);
    bench.pass(1);
    assert_eq!(bench.arm.steppers()[1].pulses, -1000.0);
    turns(&bench, 1, 0.0, -1000.0);
    assert_eq!(bench.arm.poll_timeout(), None);
}

#[test]
fn in_the_queue_it_has_finished_when_the_motor_has() {
    let mut bench = running_arm();
    let index = bench.enqueue(&counted(0, 1000, 500));
    let next = bench.enqueue(&wait(100));
    bench.pass(499_999);
    assert_eq!(bench.state().queue.running, Some(index));
    bench.pass(1);
    assert_eq!(bench.current_index(), index);
    assert_eq!(bench.arm.poll_timeout(), Some(at(600_000)));
    bench.rest();
    assert_eq!(bench.current_index(), next);
}

#[test]
fn two_motors_turn_at_the_same_time() {
    let mut bench = running_arm();
    bench.enqueue(&steady(0, true, 100));
    bench.enqueue(&counted(1, 1000, 1000));
    bench.rest();
    turns(&bench, 0, 100.0, 100.0);
    turns(&bench, 1, 0.0, 1000.0);
}

#[test]
fn another_order_for_the_motor_finishes_a_queued_run() {
    let mut bench = running_arm();
    let index = bench.enqueue(&counted(0, 1000, 5000));
    bench.pass(SECOND);
    bench.set(&steady(1, true, 50));
    assert_eq!(bench.state().queue.running, Some(index), "another motor");
    bench.set(&steady(0, true, 200));
    assert_eq!(bench.current_index(), index);
    bench.pass(SECOND);
    turns(&bench, 0, 200.0, 1200.0);
    // An immediate counted run replaces the constant rate.
    bench.set(&counted(0, -100, 100));
    bench.rest();
    turns(&bench, 0, 0.0, 1100.0);
}

#[test]
fn stop_lets_a_run_finish_and_force_stop_ends_it() {
    let mut bench = running_arm();
    let index = bench.enqueue(&counted(0, 1000, 5000));
    bench.set(&steady(1, true, 10));
    bench.pass(SECOND);
    bench.set(&QueuedCmdStopExec {});
    assert_eq!(bench.state().queue.running, Some(index));
    bench.set(&QueuedCmdForceStopExec {});
    assert_eq!(bench.current_index(), index);
    turns(&bench, 0, 0.0, 1000.0);
    // An output without a queued command keeps turning.
    turns(&bench, 1, 10.0, 10.0);
}

#[test]
fn no_way_and_no_speed_finish_at_once() {
    let mut bench = running_arm();
    bench.set(&steady(0, true, 100));
    for order in [counted(0, 1000, 0), counted(0, 0, 1000)] {
        let index = bench.enqueue(&order);
        assert_eq!(bench.current_index(), index);
        turns(&bench, 0, 0.0, 0.0);
    }
    let disabled = EMotorS {
        is_enabled: Flag::OFF,
        ..counted(0, 1000, 1000)
    };
    let index = bench.enqueue(&disabled);
    assert_eq!(bench.current_index(), index);
    turns(&bench, 0, 0.0, 0.0);
}

#[test]
fn a_speed_written_as_a_float_is_read_as_one() {
    let mut bench = arm();
    bench.set(&steady(0, true, 1500.5f32.to_bits() as i32));
    turns(&bench, 0, 1500.5, 0.0);
    bench.set(&steady(0, true, (-1e30f32).to_bits() as i32));
    turns(&bench, 0, -1e6, 0.0);
}

#[test]
fn outputs_that_there_are_not_are_refused() {
    let mut bench = running_arm();
    bench.events();
    let index = bench.enqueue(&steady(2, true, 100));
    bench.enqueue(&counted(255, 100, 100));
    assert_eq!(bench.current_index(), index + 1);
    let events = bench.events();
    let refused = |event: &&Event| matches!(event, Event::Refused { .. });
    assert_eq!(events.iter().filter(refused).count(), 2);
    // Four bytes, as in a post of the vendor's staff: the rest of the speed is zero (errata E11).
    bench.frame(135, Ctrl::SET, &[0, 1, 0x10, 0x27]);
    turns(&bench, 0, 10_000.0, 0.0);
}

#[test]
fn a_reset_stops_the_motors() {
    let mut bench = arm();
    bench.set(&steady(0, true, 100));
    bench.pass(SECOND);
    bench.arm.inject(ExternalEvent::Reset);
    bench.pass(SECOND);
    turns(&bench, 0, 0.0, 0.0);
}

/// A belt with a cube, a light barrier 100 mm further on, and a colour sensor above the start of
/// the cube.
const BELT: &str = r#"
[conveyor]
start = [260, -300]
direction = 90
length = 600
width = 80
height = -30
stepper = 0

[[object]]
name = "cube"
size = [20, 20, 20]
at = [260, -200]
on = "belt"
color = "red"

[[sensor]]
kind = "infrared"
port = "GP2"
belt_at = 210

[[sensor]]
kind = "color"
port = "GP4"
belt_at = 100
"#;

fn sees(bench: &mut TestArm, port: Option<Port>) -> bool {
    let seen: IrSwitch = bench.get_with(&GetIrSwitch { port });
    seen.state.is_on()
}

#[test]
fn a_distance_run_takes_the_belt_to_the_light_barrier() {
    let mut bench = arm::arm_in(BELT);
    bench.set(&SetIrSwitch {
        is_enabled: Flag::ON,
        port: Port::Gp2,
        version: None,
    });
    // Before the barrier, in it, and beyond.
    let pulses = |mm: f64| (mm * CONVEYOR_PULSES_PER_MM).round() as u32;
    for (mm, seen) in [(95.0, false), (10.0, true), (40.0, false)] {
        bench.enqueue(&counted(0, 10_000, pulses(mm)));
        bench.rest();
        assert_eq!(sees(&mut bench, None), seen, "{mm}");
        assert_eq!(sees(&mut bench, Some(Port::Gp2)), seen, "{mm}");
    }
    bench.enqueue(&counted(0, -10_000, pulses(40.0)));
    bench.rest();
    assert!(sees(&mut bench, None), "back again");
    assert!(!sees(&mut bench, Some(Port::Gp1)), "not enabled there");
    bench.set(&SetIrSwitch {
        is_enabled: Flag::OFF,
        port: Port::Gp2,
        version: None,
    });
    assert!(!sees(&mut bench, None), "off");
}

#[test]
fn a_colour_sensor_sees_while_it_is_on() {
    let mut bench = arm::arm_in(BELT);
    let color = |bench: &mut TestArm, port| {
        let ColorSensor { r, g, b } = bench.get_with(&GetColorSensor { port });
        [r, g, b]
    };
    assert_eq!(color(&mut bench, Some(Port::Gp4)), [0; 3]);
    for (enabled, port) in [(true, Port::Gp4), (true, Port::Gp1)] {
        bench.set(&SetColorSensor {
            is_enabled: Flag::from(enabled),
            port,
            version: None,
        });
    }
    let [r, g, b] = color(&mut bench, Some(Port::Gp4));
    assert!(r > 200 && g < 60 && b < 60, "red: {r} {g} {b}");
    assert_eq!(color(&mut bench, None), [0; 3], "the port set last");
}

#[test]
fn the_conveyor_runs_a_millimetre_on_149_8_pulses() {
    assert!((CONVEYOR_PULSES_PER_MM - 149.8).abs() < 0.01);
}

//! Pins: outputs, inputs, and the tools driven by them (model section 13).

use super::arm::{TestArm, arm, arm_with, grip, joints_to, multiplex, output, running_arm, suck};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Flag, IoFunction, PoCmd, PoList, Port, PtpMode};
use magician_sim::{Event, Refusal, Signal};

fn signal(bench: &TestArm, address: u8) -> Signal {
    bench.arm.pins()[usize::from(address) - 1].signal
}

fn pwm(bench: &mut TestArm, address: u8, frequency: f32, duty_cycle: f32) {
    bench.set(&IoPwm {
        address,
        frequency,
        duty_cycle,
    });
}

fn level(bench: &mut TestArm, address: u8) -> bool {
    let query = GetIoDi {
        address: Some(address),
    };
    bench.get_with::<IoDi>(&query).level.is_on()
}

fn counts(bench: &mut TestArm, address: u8) -> u16 {
    let query = GetIoAdc {
        address: Some(address),
    };
    bench.get_with::<IoAdc>(&query).value
}

#[test]
fn pins_are_listed_by_address_and_start_undriven() {
    let pins = arm().arm.pins();
    for (at, pin) in pins.iter().enumerate() {
        assert_eq!(usize::from(pin.address), at + 1);
        assert_eq!(pin.function, IoFunction::None);
        assert!(pin.able && !pin.level && !pin.input);
        assert_eq!((pin.signal, pin.analog), (Signal::Undriven, 0));
    }
}

#[test]
fn an_output_shows_only_while_the_pin_is_one() {
    let mut bench = arm();
    output(&mut bench, 10, true);
    let query = GetIoDo { address: Some(10) };
    assert!(bench.get_with::<IoDo>(&query).level.is_on(), "stored");
    assert_eq!(signal(&bench, 10), Signal::Undriven);
    multiplex(&mut bench, 10, IoFunction::DigitalOutput);
    assert_eq!(signal(&bench, 10), Signal::Level(true));
    output(&mut bench, 10, false);
    assert_eq!(signal(&bench, 10), Signal::Level(false));
    output(&mut bench, 10, true);
    multiplex(&mut bench, 10, IoFunction::None);
    assert_eq!(signal(&bench, 10), Signal::Undriven);
    assert!(bench.arm.pins()[9].level, "still set");
}

#[test]
fn a_function_that_the_pin_lacks_puts_out_and_reads_nothing() {
    let mut bench = arm();
    multiplex(&mut bench, 10, IoFunction::Pwm);
    pwm(&mut bench, 10, 1000.0, 50.0);
    let pin = bench.arm.pins()[9];
    assert!(!pin.able && pin.function == IoFunction::Pwm);
    assert_eq!(pin.signal, Signal::Undriven);
    multiplex(&mut bench, 10, IoFunction::DigitalInputPullUp);
    assert!(!level(&mut bench, 10));
    multiplex(&mut bench, 2, IoFunction::AnalogInput);
    assert!(bench.arm.set_analog(2, 1000));
    assert_eq!(counts(&mut bench, 2), 0);
    multiplex(&mut bench, 3, IoFunction::Unknown(7));
    assert!(!bench.arm.pins()[2].able);
}

#[test]
fn pulses_are_bounded_and_read_back_as_sent() {
    let mut bench = arm();
    multiplex(&mut bench, 8, IoFunction::Pwm);
    for (sent, shown) in [
        ([50.0, 7.5], [50.0, 7.5]),
        ([10.0, 0.0], [10.0, 0.0]),
        ([1e6, 100.0], [1e6, 100.0]),
        ([9.0, -1.0], [10.0, 0.0]),
        ([2e6, 101.0], [1e6, 100.0]),
        ([f32::INFINITY, f32::NEG_INFINITY], [1e6, 0.0]),
    ] {
        let [frequency, duty_cycle] = sent;
        pwm(&mut bench, 8, frequency, duty_cycle);
        let query = GetIoPwm { address: Some(8) };
        let read = bench.get_with::<IoPwm>(&query);
        assert_eq!([read.frequency, read.duty_cycle], sent);
        let [frequency, duty_cycle] = shown;
        let pulses = Signal::Pulses {
            frequency,
            duty_cycle,
        };
        assert_eq!(signal(&bench, 8), pulses);
    }
    pwm(&mut bench, 8, f32::NAN, 50.0);
    assert_eq!(signal(&bench, 8), Signal::Level(false));
    pwm(&mut bench, 8, 50.0, f32::NAN);
    assert_eq!(signal(&bench, 8), Signal::Level(false));
}

#[test]
fn an_open_input_reads_what_its_resistor_pulls_it_to() {
    let mut bench = arm();
    for (function, open) in [
        (IoFunction::None, false),
        (IoFunction::DigitalInput, false),
        (IoFunction::DigitalInputPullUp, true),
        (IoFunction::DigitalInputPullDown, false),
        (IoFunction::AnalogInput, false),
    ] {
        multiplex(&mut bench, 9, function);
        assert_eq!(level(&mut bench, 9), open, "{function:?}");
        assert_eq!(counts(&mut bench, 9), 0);
    }
}

#[test]
fn a_driven_input_reads_what_drives_it() {
    let mut bench = arm();
    for function in [
        IoFunction::DigitalInput,
        IoFunction::DigitalInputPullUp,
        IoFunction::DigitalInputPullDown,
    ] {
        multiplex(&mut bench, 15, function);
        for high in [true, false] {
            assert!(bench.arm.set_input(15, high));
            assert_eq!(level(&mut bench, 15), high);
            assert_eq!(bench.arm.pins()[14].input, high);
        }
    }
    // A pin reads low unless it is an input, whatever drives it.
    bench.arm.set_input(15, true);
    multiplex(&mut bench, 15, IoFunction::DigitalOutput);
    assert!(!level(&mut bench, 15));
    multiplex(&mut bench, 1, IoFunction::AnalogInput);
    for (set, read) in [(0, 0), (1234, 1234), (4095, 4095), (u16::MAX, 4095)] {
        assert!(bench.arm.set_analog(1, set));
        assert_eq!(counts(&mut bench, 1), read);
    }
    assert_eq!(bench.arm.pins()[0].analog, 4095);
}

#[test]
fn a_voltage_is_a_level_and_a_level_a_voltage() {
    let mut bench = arm();
    multiplex(&mut bench, 9, IoFunction::DigitalInputPullUp);
    bench.arm.set_analog(9, 2047);
    assert!(!level(&mut bench, 9));
    bench.arm.set_analog(9, 2048);
    assert!(level(&mut bench, 9));
    multiplex(&mut bench, 1, IoFunction::AnalogInput);
    bench.arm.set_input(1, true);
    assert_eq!(counts(&mut bench, 1), 4095);
}

#[test]
fn addresses_that_there_are_not_are_refused() {
    let mut bench = arm();
    for address in [0, 21, 255] {
        assert!(!bench.arm.set_input(address, true));
        assert!(!bench.arm.set_analog(address, 1));
        assert!(!level(&mut bench, address));
        bench.events();
        multiplex(&mut bench, address, IoFunction::DigitalOutput);
        pwm(&mut bench, address, 50.0, 50.0);
        let refused = bench.events();
        let pin = |event: &Event| {
            matches!(
                event,
                Event::Refused {
                    reason: Refusal::Pin,
                    ..
                }
            )
        };
        assert_eq!(refused.iter().filter(|event| pin(event)).count(), 2);
    }
}

#[test]
fn suction_cup_and_gripper_share_one_pump() {
    let mut bench = arm();
    bench.set(&suck(true));
    bench.pass(300_000);
    assert!(bench.state().suction.reached);
    bench.set(&grip(true));
    let state = bench.state();
    assert!(!state.suction.commanded && state.gripper.commanded);
    assert!(bench.get::<EndEffectorSuctionCup>().is_sucked.is_on());
    bench.pass(300_000);
    assert!(!bench.state().suction.reached && !bench.state().gripper.reached);
    bench.pass(200_000);
    assert!(bench.state().gripper.reached);
    // Switching the pump off for one tool switches it off for the other.
    bench.set(&SetEndEffectorSuctionCup {
        enable_ctrl: Flag::OFF,
        suck: Flag::ON,
    });
    bench.pass(500_000);
    assert!(!bench.state().gripper.reached && !bench.state().suction.reached);
}

#[test]
fn valve_and_pump_can_be_worked_as_pins() {
    let mut bench = arm();
    // Without the output function the levels have no effect.
    output(&mut bench, 16, true);
    output(&mut bench, 17, true);
    assert!(!bench.state().suction.commanded);
    multiplex(&mut bench, 16, IoFunction::DigitalOutput);
    multiplex(&mut bench, 17, IoFunction::DigitalOutput);
    assert!(bench.state().suction.commanded);
    bench.pass(300_000);
    assert!(bench.state().suction.reached);
    for address in [16, 17] {
        output(&mut bench, address, false);
        assert!(!bench.state().suction.commanded, "{address}");
        output(&mut bench, address, true);
        assert!(bench.state().suction.commanded);
    }
    // Pins override the commands of the tools.
    bench.set(&suck(false));
    assert!(bench.state().suction.commanded);
    multiplex(&mut bench, 16, IoFunction::None);
    assert!(!bench.state().suction.commanded, "the valve's own");
    bench.set(&suck(true));
    assert!(bench.state().suction.commanded);
    output(&mut bench, 17, false);
    assert!(!bench.state().suction.commanded, "the pump's pin");
}

#[test]
fn pins_work_the_gripper_after_a_command_for_it() {
    let mut bench = arm();
    bench.set(&SetEndEffectorGripper {
        enable_ctrl: Flag::OFF,
        grip: Flag::OFF,
    });
    for address in [16, 17] {
        multiplex(&mut bench, address, IoFunction::DigitalOutput);
        output(&mut bench, address, true);
    }
    let state = bench.state();
    assert!(state.gripper.commanded && !state.suction.commanded);
}

#[test]
fn the_laser_burns_for_its_command_or_its_pins() {
    let mut bench = arm();
    let laser = |on| SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::from(on),
    };
    bench.set(&laser(true));
    assert!(bench.state().laser);
    assert_eq!(bench.state().laser_power, 100.0);
    bench.set(&laser(false));
    assert!(!bench.state().laser);
    pwm(&mut bench, 4, 40_000.0, 35.0);
    multiplex(&mut bench, 4, IoFunction::Pwm);
    assert!(!bench.state().laser, "no supply");
    multiplex(&mut bench, 2, IoFunction::DigitalOutput);
    assert!(!bench.state().laser);
    output(&mut bench, 2, true);
    assert_eq!(bench.state().laser_power, 35.0);
    pwm(&mut bench, 4, 40_000.0, 0.0);
    assert!(!bench.state().laser);
    multiplex(&mut bench, 4, IoFunction::DigitalOutput);
    output(&mut bench, 4, true);
    assert_eq!(bench.state().laser_power, 100.0);
    output(&mut bench, 2, false);
    assert!(!bench.state().laser);
    // A command cannot override a supply that its pin holds off.
    bench.set(&laser(true));
    assert!(!bench.state().laser);
    multiplex(&mut bench, 2, IoFunction::None);
    assert!(bench.state().laser);
}

#[test]
fn a_move_switches_the_pump_on_its_way() {
    let mut bench = running_arm();
    bench.set(&suck(true));
    multiplex(&mut bench, 17, IoFunction::DigitalOutput);
    bench.full_speed();
    let halfway = PoCmd {
        ratio: 50,
        address: 17,
        level: 1,
    };
    let po = PoList::new(&[halfway]).unwrap();
    bench.enqueue(&PtpPoCmd {
        ptp_mode: PtpMode::MovjAngle,
        x: 90.0,
        y: 45.0,
        z: 45.0,
        r: 0.0,
        po,
    });
    let lasting = 1_341_641;
    bench.pass(lasting / 2);
    assert!(!bench.state().suction.commanded);
    bench.pass(1);
    assert!(bench.state().suction.commanded && bench.state().moving);
    bench.pass(300_000);
    assert!(bench.state().suction.reached && bench.state().moving);
}

#[test]
fn a_queued_output_waits_for_its_turn() {
    let mut bench = running_arm();
    multiplex(&mut bench, 18, IoFunction::DigitalOutput);
    bench.enqueue(&joints_to([10.0, 45.0, 45.0, 0.0]));
    let level = Flag::ON;
    let index = bench.enqueue(&IoDo { address: 18, level });
    assert_eq!(signal(&bench, 18), Signal::Level(false));
    bench.rest();
    assert_eq!(signal(&bench, 18), Signal::Level(true));
    assert_eq!(bench.current_index(), index);
}

#[test]
fn a_strict_profile_refuses_what_the_pin_lacks() {
    let mut bench = arm_with(|profile| profile.io.strict = true);
    multiplex(&mut bench, 16, IoFunction::DigitalOutput);
    multiplex(&mut bench, 16, IoFunction::DigitalInput);
    assert_eq!(bench.arm.pins()[15].function, IoFunction::DigitalOutput);
}

#[test]
fn sensors_see_nothing_and_unknown_connectors_are_refused() {
    let mut bench = arm();
    for port in [Port::Gp1, Port::Gp2, Port::Gp4, Port::Gp5] {
        bench.set(&SetColorSensor {
            is_enabled: Flag::ON,
            port,
            version: None,
        });
        bench.set(&SetIrSwitch {
            is_enabled: Flag::ON,
            port,
            version: None,
        });
        let seen = bench.get_with::<IrSwitch>(&GetIrSwitch { port: Some(port) });
        assert!(!seen.state.is_on());
        let ColorSensor { r, g, b } = bench.get_with(&GetColorSensor { port: None });
        assert_eq!([r, g, b], [0; 3]);
    }
    bench.events();
    bench.frame(137, Ctrl::SET, &[1, 4, 1]);
    bench.frame(138, Ctrl::SET, &[1, 200]);
    assert_eq!(bench.frame(138, Ctrl::GET, &[200]).frame().params(), [0]);
    assert_eq!(bench.frame(137, Ctrl::GET, &[4]).frame().params(), [0; 3]);
    let refused = bench.events();
    assert_eq!(
        refused
            .iter()
            .filter(|event| matches!(event, Event::Refused { .. }))
            .count(),
        2
    );
}

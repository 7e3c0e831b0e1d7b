//! The sliding rail (model sections 7, 10 and 12).

use super::arm;
use super::arm::{
    Micros, SECOND, TestArm, arm_with, at as instant, home, joints_to, multiplex, running_arm,
};
use magician_protocol::commands::*;
use magician_protocol::{Flag, IoFunction, JogCommand, PoCmd, PoList, PtpMode};
use magician_sim::{Event, ExternalEvent, Signal};

const HOME: [f32; 4] = [0.0, 45.0, 45.0, 0.0];

fn with_l(on: bool) -> SetDeviceWithL {
    SetDeviceWithL {
        with_l: Flag::from(on),
        version: None,
    }
}

/// An arm on a rail with a started queue and ratios of 100 %: 100 mm/s and 100 mm/s2 on the rail.
fn on_rail() -> TestArm {
    let mut bench = running_arm();
    bench.set(&with_l(true));
    bench.full_speed();
    bench
}

fn to(mode: u8, [x, y, z, r]: [f32; 4], l: f32) -> PtpWithLCmd {
    PtpWithLCmd {
        ptp_mode: PtpMode::from(mode),
        x,
        y,
        z,
        r,
        l,
    }
}

fn rail_to(l: f32) -> PtpWithLCmd {
    to(4, HOME, l)
}

fn place(bench: &mut TestArm) -> f32 {
    bench.get::<PoseL>().pose_l
}

#[track_caller]
fn near(value: f32, wanted: f32) {
    assert!((value - wanted).abs() < 1e-3, "{value}, not {wanted}");
}

fn jog(bench: &mut TestArm, cmd: JogCommand) {
    bench.set(&JogCmd {
        is_joint: Flag::OFF,
        cmd,
    });
}

#[test]
fn without_the_rail_its_number_is_ignored() {
    let mut bench = running_arm();
    assert_eq!(bench.state().rail, None);
    for l in [500.0, f32::NAN, -1e30] {
        let index = bench.enqueue(&to(4, [l.clamp(0.0, 20.0).max(0.0), 45.0, 45.0, 0.0], l));
        bench.rest();
        assert_eq!(bench.current_index(), index);
        assert_eq!(place(&mut bench), 0.0);
    }
    jog(&mut bench, JogCommand::RailPlus);
    assert!(!bench.state().moving);
    assert_eq!(bench.state().not_simulated, 0);
}

#[test]
fn the_carriage_moves_alone_by_the_law_of_the_axes() {
    let mut bench = on_rail();
    assert_eq!(bench.state().rail, Some(0.0));
    let index = bench.enqueue(&rail_to(300.0));
    // Two ramps of a second each, and two seconds between: 50 + 200 + 50 mm.
    assert_eq!(bench.arm.poll_timeout(), Some(instant(4 * SECOND)));
    for (at, there) in [
        (0.0, 0.0),
        (0.5, 12.5),
        (1.0, 50.0),
        (2.0, 150.0),
        (3.5, 287.5),
    ] {
        bench.arm.advance(instant((at * 1e6) as Micros));
        near(place(&mut bench), there);
        assert!(bench.state().moving);
        assert_eq!(bench.joints(), HOME);
    }
    bench.rest();
    assert_eq!(place(&mut bench), 300.0);
    assert_eq!(bench.current_index(), index);
    assert_eq!(bench.get::<QueuedCmdMotionFinish>().is_finish, Flag::ON);
}

#[test]
fn ratios_and_parameters_set_its_speed() {
    let mut bench = on_rail();
    bench.set(&PtpCommonParams {
        velocity_ratio: 50.0,
        acceleration_ratio: 25.0,
    });
    bench.enqueue(&rail_to(300.0));
    // 50 mm/s and 25 mm/s2: 300 / 50 + 50 / 25.
    assert_eq!(bench.rest(), 8 * SECOND);
    bench.set(&PtpCommonParams {
        velocity_ratio: 1000.0,
        acceleration_ratio: 1000.0,
    });
    bench.set(&PtpLParams {
        velocity: 200.0,
        acceleration: 400.0,
    });
    bench.enqueue(&rail_to(100.0));
    assert_eq!(bench.rest(), SECOND + SECOND / 2);
}

#[test]
fn arm_and_carriage_begin_and_end_together() {
    // The carriage takes longer.
    let mut bench = on_rail();
    bench.enqueue(&to(4, [90.0, 45.0, 45.0, 0.0], 300.0));
    assert_eq!(bench.arm.poll_timeout(), Some(instant(4 * SECOND)));
    bench.pass(2 * SECOND);
    near(bench.joints()[0], 45.0);
    near(place(&mut bench), 150.0);
    bench.pass(2 * SECOND - 10_000);
    assert!(bench.joints()[0] < 90.0 && place(&mut bench) < 300.0);
    bench.pass(10_000);
    assert_eq!((bench.joints()[0], place(&mut bench)), (90.0, 300.0));
    // The arm takes longer.
    bench.enqueue(&to(4, [-90.0, 45.0, 45.0, 0.0], 310.0));
    let end = bench.arm.poll_timeout().unwrap();
    let lasting = end.micros_since(bench.arm.now());
    // 180 deg at 200 deg/s2, a triangle.
    assert_eq!(lasting, 1_897_367);
    bench.pass(lasting / 2);
    near(bench.joints()[0], 0.0);
    near(place(&mut bench), 305.0);
    bench.pass(lasting - lasting / 2);
    assert_eq!((bench.joints()[0], place(&mut bench)), (-90.0, 310.0));
}

#[test]
fn every_mode_takes_the_carriage_along() {
    for mode in 0..10u8 {
        let mut bench = on_rail();
        bench.enqueue(&rail_to(100.0));
        bench.rest();
        let [x, y, z, r] = bench.pose();
        let (target, l) = match mode {
            3..=5 => ([20.0, 40.0, 50.0, 5.0], 250.0),
            6..=8 => ([5.0, 4.0, 3.0, 2.0], 150.0),
            _ => ([x + 20.0, y + 10.0, z - 5.0, r], 250.0),
        };
        bench.enqueue(&to(mode, target, l));
        assert_eq!(bench.rest(), 2_500_000, "mode {mode}");
        assert_eq!(place(&mut bench), 250.0, "mode {mode}");
        assert_eq!(bench.alarms(), [0u8; 0]);
    }
}

#[test]
fn the_ends_bound_it_without_an_alarm() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(5000.0));
    bench.rest();
    assert_eq!(place(&mut bench), 1000.0);
    bench.enqueue(&to(6, [0.0; 4], 1.0));
    assert_eq!(bench.rest(), 0, "there already");
    bench.enqueue(&rail_to(-3.0));
    bench.rest();
    assert_eq!(place(&mut bench), 0.0);
    assert_eq!(bench.alarms(), [0u8; 0]);
    let mut short = arm_with(|profile| profile.rail.length = 400.0);
    short.start();
    short.set(&with_l(true));
    short.enqueue(&rail_to(500.0));
    short.rest();
    assert_eq!(place(&mut short), 400.0);
}

#[test]
fn a_place_that_is_no_number_refuses_the_move() {
    for l in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut bench = on_rail();
        let index = bench.enqueue(&to(4, [10.0, 45.0, 45.0, 0.0], l));
        assert_eq!(bench.current_index(), index);
        assert_eq!(bench.alarms(), [0x11]);
        assert_eq!((bench.joints(), place(&mut bench)), (HOME, 0.0));
    }
}

#[test]
fn a_speed_that_is_none_refuses_what_needs_it() {
    for (velocity, acceleration) in [(0.0, 1.0), (-1.0, 1.0), (1.0, f32::NAN), (1.0, 0.0)] {
        let mut bench = on_rail();
        bench.set(&PtpLParams {
            velocity,
            acceleration,
        });
        bench.enqueue(&to(4, [10.0, 45.0, 45.0, 0.0], 0.0));
        bench.rest();
        assert_eq!(bench.joints()[0], 10.0, "the carriage need not move");
        bench.enqueue(&to(4, [20.0, 45.0, 45.0, 0.0], 1.0));
        assert_eq!(bench.alarms(), [0x1A]);
        assert_eq!(bench.joints()[0], 10.0);
    }
    let mut bench = on_rail();
    bench.set(&PtpLParams {
        velocity: f32::INFINITY,
        acceleration: f32::INFINITY,
    });
    bench.enqueue(&rail_to(10.0));
    assert_eq!(place(&mut bench), 10.0);
}

#[test]
fn an_arm_that_cannot_be_planned_keeps_the_carriage() {
    let mut bench = on_rail();
    bench.enqueue(&to(1, [900.0, 0.0, 0.0, 0.0], 100.0));
    assert_eq!(bench.alarms(), [0x11]);
    assert!(!bench.state().moving);
    assert_eq!(place(&mut bench), 0.0);
}

#[test]
fn a_slow_arm_that_a_limit_stops_leaves_the_carriage_on_its_way() {
    let mut bench = on_rail();
    // The arm alone would need far longer than the carriage; 135 of 240 degrees are past the
    // middle.
    bench.enqueue(&to(4, [240.0, 45.0, 45.0, 0.0], 20.0));
    bench.rest();
    assert_eq!(bench.joints()[0], 135.0);
    let at = place(&mut bench);
    assert!((10.0..16.0).contains(&at), "{at} of 20 mm");
}

#[test]
fn a_limit_on_the_arms_way_stops_the_carriage_with_it() {
    let mut bench = on_rail();
    bench.enqueue(&to(4, [180.0, 45.0, 45.0, 0.0], 300.0));
    let lasting = bench.rest();
    assert!(lasting < 4 * SECOND);
    near(bench.joints()[0], 135.0);
    let there = place(&mut bench);
    // The limit is at 3/4 of the arm's path: after 2.586 s of a triangular profile of 4 s.
    near(there, 208.5786);
    assert_eq!(bench.alarms(), [0x40]);
}

#[test]
fn outputs_count_the_carriages_way_where_the_arm_rests() {
    let mut bench = on_rail();
    multiplex(&mut bench, 18, IoFunction::DigitalOutput);
    let high = |bench: &TestArm| bench.arm.pins()[17].signal == Signal::Level(true);
    let command = |joint: f32, l| {
        let half = PoCmd {
            ratio: 50,
            address: 18,
            level: 1,
        };
        PtpPoWithLCmd {
            ptp_mode: PtpMode::MovjAngle,
            x: joint,
            y: 45.0,
            z: 45.0,
            r: 0.0,
            l,
            po: PoList::new(&[half]).unwrap(),
        }
    };
    for (joint, l) in [(0.0, 300.0), (30.0, 600.0)] {
        arm::output(&mut bench, 18, false);
        bench.enqueue(&command(joint, l));
        bench.pass(2 * SECOND - 1);
        assert!(!high(&bench), "{joint}");
        bench.pass(1);
        assert!(high(&bench) && bench.state().moving, "{joint}");
        bench.rest();
    }
    // Nothing moves, so the output switches at once.
    arm::output(&mut bench, 18, false);
    bench.enqueue(&command(30.0, 600.0));
    assert!(high(&bench));
}

#[test]
fn a_force_stop_brakes_the_carriage_at_twice_its_acceleration() {
    let mut bench = on_rail();
    let index = bench.enqueue(&rail_to(500.0));
    bench.pass(2 * SECOND);
    near(place(&mut bench), 150.0);
    bench.set(&QueuedCmdForceStopExec {});
    assert!(bench.state().moving);
    assert_eq!(bench.state().queue.running, Some(index));
    // 100 mm/s at 200 mm/s2: half a second, 25 mm.
    assert_eq!(bench.rest(), SECOND / 2);
    near(place(&mut bench), 175.0);
    assert_eq!(bench.current_index(), index);
    assert!(!bench.state().queue.started);
}

#[test]
fn a_force_stop_waits_for_the_slower_of_both() {
    let mut bench = on_rail();
    bench.enqueue(&to(4, [90.0, 45.0, 45.0, 0.0], 300.0));
    bench.pass(2 * SECOND);
    bench.set(&QueuedCmdForceStopExec {});
    bench.pass(SECOND / 4);
    let stands = bench.joints();
    assert!(
        bench.state().moving,
        "the arm stands, the carriage does not"
    );
    assert_eq!(bench.rest(), SECOND / 4);
    assert_eq!(bench.joints(), stands);
    near(place(&mut bench), 175.0);
}

#[test]
fn stop_lets_it_finish() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(500.0));
    bench.pass(SECOND);
    bench.set(&QueuedCmdStopExec {});
    bench.rest();
    assert_eq!(place(&mut bench), 500.0);
}

#[test]
fn a_motion_at_once_replaces_it_where_it_is() {
    let mut bench = on_rail();
    let index = bench.enqueue(&rail_to(500.0));
    bench.pass(2 * SECOND);
    bench.set(&joints_to([10.0, 45.0, 45.0, 0.0]));
    assert_eq!(bench.current_index(), index);
    bench.rest();
    near(place(&mut bench), 150.0);
    bench.set(&rail_to(140.0));
    bench.rest();
    assert_eq!(place(&mut bench), 140.0);
}

#[test]
fn switching_the_rail_off_leaves_a_carriage_on_its_way() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(300.0));
    bench.pass(SECOND);
    bench.set(&with_l(false));
    bench.rest();
    assert_eq!(place(&mut bench), 300.0);
    bench.enqueue(&rail_to(400.0));
    bench.rest();
    assert_eq!(place(&mut bench), 300.0);
}

#[test]
fn a_jog_runs_until_it_is_stopped() {
    let mut bench = on_rail();
    bench.set(&JogCommonParams {
        velocity_ratio: 50.0,
        acceleration_ratio: 1.0,
    });
    jog(&mut bench, JogCommand::RailPlus);
    // 50 mm/s at 100 mm/s2: the ratio of the acceleration does not apply.
    bench.pass(SECOND / 2);
    near(place(&mut bench), 12.5);
    bench.pass(SECOND);
    near(place(&mut bench), 62.5);
    jog(&mut bench, JogCommand::RailPlus);
    bench.pass(SECOND);
    near(place(&mut bench), 112.5);
    jog(&mut bench, JogCommand::Stop);
    assert_eq!(bench.rest(), SECOND / 2);
    near(place(&mut bench), 125.0);
    jog(&mut bench, JogCommand::Stop);
    assert!(!bench.state().moving);
}

#[test]
fn a_jog_comes_to_rest_at_the_ends() {
    let mut bench = on_rail();
    bench.set(&JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    });
    jog(&mut bench, JogCommand::RailPlus);
    assert_eq!(bench.rest(), 11 * SECOND);
    assert_eq!(place(&mut bench), 1000.0);
    jog(&mut bench, JogCommand::RailPlus);
    assert!(!bench.state().moving);
    jog(&mut bench, JogCommand::RailMinus);
    bench.pass(10 * SECOND + SECOND / 2);
    // The carriage is already slowing down; a stop takes it no further than the end.
    jog(&mut bench, JogCommand::Stop);
    bench.rest();
    near(place(&mut bench), 0.0);
    assert!(place(&mut bench) >= 0.0);
    assert_eq!(bench.alarms(), [0u8; 0]);
}

#[test]
fn the_other_way_goes_through_rest() {
    let mut bench = on_rail();
    bench.set(&JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    });
    jog(&mut bench, JogCommand::RailPlus);
    bench.pass(2 * SECOND);
    near(place(&mut bench), 150.0);
    jog(&mut bench, JogCommand::RailMinus);
    bench.pass(SECOND / 2);
    near(place(&mut bench), 187.5);
    bench.pass(SECOND / 2);
    near(place(&mut bench), 200.0);
    bench.pass(SECOND);
    near(place(&mut bench), 150.0);
    bench.rest();
    assert_eq!(place(&mut bench), 0.0);
}

#[test]
fn slower_braking_than_the_rail_allows_is_not_done() {
    let mut bench = on_rail();
    bench.set(&JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    });
    jog(&mut bench, JogCommand::RailPlus);
    bench.pass(10 * SECOND);
    near(place(&mut bench), 950.0);
    bench.set(&JogLParams {
        velocity: 100.0,
        acceleration: 1.0,
    });
    jog(&mut bench, JogCommand::Stop);
    assert_eq!(bench.rest(), SECOND);
    near(place(&mut bench), 1000.0);
}

#[test]
fn a_force_stop_brakes_a_jog_and_a_queued_jog_has_finished_at_once() {
    let mut bench = on_rail();
    let index = bench.enqueue(&JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::RailPlus,
    });
    assert_eq!(bench.current_index(), index);
    bench.pass(2 * SECOND);
    bench.set(&QueuedCmdForceStopExec {});
    // 50 mm/s at 200 mm/s2.
    assert_eq!(bench.rest(), SECOND / 4);
    assert!(!bench.state().moving);
}

#[test]
fn a_jog_without_a_speed_is_refused() {
    let mut bench = on_rail();
    bench.set(&JogLParams {
        velocity: f32::NAN,
        acceleration: 100.0,
    });
    bench.events();
    jog(&mut bench, JogCommand::RailPlus);
    assert_eq!(bench.alarms(), [0x1A]);
    let refused = |event: &Event| matches!(event, Event::Refused { id: 73, .. });
    assert!(bench.events().iter().any(refused));
}

#[test]
fn homing_takes_the_carriage_to_its_end() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(300.0));
    bench.rest();
    bench.enqueue(&home());
    bench.pass(4 * SECOND - 1);
    assert!(place(&mut bench) > 0.0);
    bench.pass(1);
    assert_eq!(place(&mut bench), 0.0);
    bench.rest();
    assert!(bench.state().homed);
    // A base that reaches its switch first waits there for the carriage.
    let mut bench = on_rail();
    bench.enqueue(&to(4, [-130.0, 45.0, 45.0, 0.0], 600.0));
    bench.rest();
    bench.enqueue(&home());
    bench.pass(7 * SECOND - 1);
    assert_eq!(bench.joints()[0], -135.0);
    assert!(bench.state().moving && !bench.state().homed);
    let searched = arm::homing_lasts(-130.0) - arm::trapezoid(5.0, 20.0, 30.0) + 7.0;
    let lasting = (bench.rest() + 7 * SECOND - 1) as f64 / 1e6;
    assert!(
        (lasting - searched).abs() < 1e-4,
        "{lasting}, not {searched}"
    );
    assert!(bench.state().homed);
    // With the rail switched off the carriage does not move.
    let mut bench = on_rail();
    bench.enqueue(&rail_to(300.0));
    bench.rest();
    bench.set(&with_l(false));
    bench.enqueue(&home());
    bench.rest();
    assert_eq!(place(&mut bench), 300.0);
}

#[test]
fn a_force_stop_brakes_base_and_carriage_while_they_home() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(600.0));
    bench.rest();
    let index = bench.enqueue(&home());
    bench.pass(2 * SECOND);
    near(place(&mut bench), 450.0);
    bench.set(&QueuedCmdForceStopExec {});
    assert_eq!(bench.rest(), SECOND / 2);
    near(place(&mut bench), 425.0);
    assert_eq!(bench.current_index(), index);
    assert!(!bench.state().homed);
}

#[test]
fn a_jog_of_the_arm_waits_for_the_carriage_and_the_other_way_round() {
    let mut bench = on_rail();
    bench.set(&JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    });
    let base = JogCmd {
        is_joint: Flag::ON,
        cmd: JogCommand::Axis1Plus,
    };
    jog(&mut bench, JogCommand::RailPlus);
    assert!(bench.arm.jogging());
    bench.pass(2 * SECOND);
    bench.set(&base);
    bench.pass(SECOND);
    near(place(&mut bench), 200.0);
    assert_eq!(bench.joints()[0], 0.0);
    // 15 deg/s at 50 deg/s2.
    bench.pass(SECOND);
    near(bench.joints()[0], 15.0 - 2.25);
    jog(&mut bench, JogCommand::RailMinus);
    bench.pass(3 * SECOND / 10);
    near(bench.joints()[0], 15.0);
    assert_eq!(place(&mut bench), 200.0);
    bench.pass(SECOND);
    near(place(&mut bench), 150.0);
    // The continuation can be cancelled while the carriage slows down.
    bench.set(&base);
    bench.pass(SECOND / 2);
    jog(&mut bench, JogCommand::Stop);
    assert_eq!(bench.rest(), SECOND / 2);
    near(place(&mut bench), 100.0);
    near(bench.joints()[0], 15.0);
    assert!(!bench.arm.jogging());
}

#[test]
fn queued_jogs_do_not_hold_each_other_back() {
    let mut bench = on_rail();
    for (cmd, pause) in [(JogCommand::RailPlus, 500), (JogCommand::Stop, 0)] {
        bench.enqueue(&JogCmd {
            is_joint: Flag::OFF,
            cmd,
        });
        bench.enqueue(&arm::wait(pause));
    }
    let last = bench.enqueue(&rail_to(0.0));
    bench.pass(SECOND / 2);
    assert!(bench.state().moving && bench.current_index() >= 3);
    bench.rest();
    assert_eq!(bench.current_index(), last);
    assert_eq!(place(&mut bench), 0.0);
}

#[test]
fn power_finds_the_carriage_at_0_and_homing_finds_out_where_it_is() {
    let mut bench = on_rail();
    bench.enqueue(&rail_to(600.0));
    bench.rest();
    bench.arm.inject(ExternalEvent::Reset);
    bench.set(&ClearAlarmsState {});
    assert_eq!(bench.state().rail, None);
    assert_eq!(place(&mut bench), 0.0);
    bench.set(&with_l(true));
    bench.start();
    bench.enqueue(&home());
    assert_eq!(place(&mut bench), 600.0);
    bench.pass(7 * SECOND);
    assert_eq!(place(&mut bench), 0.0);
}

//! TRIG: waiting for an input (document 1.14, errata E35).

use super::arm;
use super::arm::{SECOND, TestArm, at, multiplex, running_arm, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, IoFunction, TriggerCondition, TriggerMode};
use magician_sim::world::Press;
use magician_sim::{Event, ExternalEvent, Refusal};

fn trig(address: u8, mode: u8, condition: u8, threshold: u16) -> TrigCmd {
    TrigCmd {
        address,
        mode: TriggerMode::from(mode),
        condition: TriggerCondition::from(condition),
        threshold,
    }
}

/// An arm with pin 9 as an input of this kind.
fn with_input(function: IoFunction) -> TestArm {
    let mut bench = running_arm();
    multiplex(&mut bench, 9, function);
    bench
}

#[track_caller]
fn blocks(bench: &mut TestArm, index: u64) {
    let state = bench.state();
    assert_eq!(state.queue.running, Some(index));
    assert_eq!(state.awaits_input, Some(9));
    assert_eq!(bench.arm.poll_timeout(), None, "nothing is scheduled");
}

#[test]
fn a_level_lets_it_go_at_once_or_as_soon_as_it_comes() {
    let mut bench = with_input(IoFunction::DigitalInput);
    let first = bench.enqueue(&trig(9, 0, 0, 0));
    assert_eq!(bench.current_index(), first, "low is what it is");
    let index = bench.enqueue(&trig(9, 0, 0, 1));
    blocks(&mut bench, index);
    bench.pass(3600 * SECOND);
    blocks(&mut bench, index);
    assert_eq!(bench.left_space(), 31);
    bench.arm.set_input(9, true);
    assert_eq!(bench.current_index(), index);
    assert_eq!(bench.state().awaits_input, None);
    assert_eq!(bench.arm.now(), at(3600 * SECOND));
}

#[test]
fn levels_compare_equal_or_not() {
    for (condition, threshold, level) in [(0, 1, true), (0, 0, false), (1, 1, false), (1, 0, true)]
    {
        let mut bench = with_input(IoFunction::DigitalInput);
        bench.arm.set_input(9, !level);
        let index = bench.enqueue(&trig(9, 0, condition, threshold));
        blocks(&mut bench, index);
        bench.arm.set_input(9, !level);
        blocks(&mut bench, index);
        bench.arm.set_input(9, level);
        assert_eq!(bench.current_index(), index, "{condition} {threshold}");
    }
}

#[test]
fn values_compare_in_four_ways() {
    for (condition, [at_499, at_500, at_501]) in [
        (0, [true, false, false]),
        (1, [true, true, false]),
        (2, [false, true, true]),
        (3, [false, false, true]),
    ] {
        for (value, met) in [(499, at_499), (500, at_500), (501, at_501)] {
            let mut bench = with_input(IoFunction::AnalogInput);
            bench
                .arm
                .set_analog(9, if condition < 2 { 4095 } else { 0 });
            let index = bench.enqueue(&trig(9, 1, condition, 500));
            blocks(&mut bench, index);
            bench.arm.set_analog(9, value);
            let finished = bench.current_index() == index;
            assert_eq!(finished, met, "{value}, condition {condition}");
        }
    }
}

#[test]
fn what_follows_begins_when_it_is_met() {
    let mut bench = with_input(IoFunction::DigitalInputPullUp);
    bench.enqueue(&trig(9, 0, 0, 0));
    let last = bench.enqueue(&wait(100));
    bench.pass(SECOND);
    bench.arm.set_input(9, false);
    assert_eq!(bench.arm.poll_timeout(), Some(at(1_100_000)));
    bench.rest();
    assert_eq!(bench.current_index(), last);
}

#[test]
fn multiplexing_is_a_change_of_input_too() {
    let mut bench = running_arm();
    bench.arm.set_input(9, true);
    let index = bench.enqueue(&trig(9, 0, 0, 1));
    blocks(&mut bench, index);
    multiplex(&mut bench, 9, IoFunction::DigitalInput);
    assert_eq!(bench.current_index(), index);
}

#[test]
fn an_input_that_the_scenario_changes_is_seen_to_the_microsecond() {
    let mut bench = arm::arm_in(
        "[[input]]\naddress = 9\nlevel = 0\n\
         [[input]]\naddress = 9\nlevel = 1\nat = 3.2\n",
    );
    multiplex(&mut bench, 9, IoFunction::DigitalInputPullUp);
    let index = bench.enqueue(&trig(9, 0, 0, 1));
    assert_eq!(bench.arm.poll_timeout(), Some(at(3_200_000)));
    bench.pass(3_199_999);
    assert_eq!(bench.state().queue.running, Some(index));
    bench.pass(1);
    assert_eq!(bench.current_index(), index);
}

#[test]
fn both_stops_cut_it_short_and_the_queue_goes_on_when_started() {
    for force in [false, true] {
        let mut bench = with_input(IoFunction::DigitalInput);
        let index = bench.enqueue(&trig(9, 0, 0, 1));
        let next = bench.enqueue(&wait(10));
        if force {
            bench.set(&QueuedCmdForceStopExec {});
        } else {
            bench.set(&QueuedCmdStopExec {});
        }
        assert_eq!(bench.current_index(), index);
        assert_eq!(bench.state().queue.running, None);
        bench.start();
        bench.rest();
        assert_eq!(bench.current_index(), next);
    }
}

#[test]
fn in_a_program_the_base_key_ends_it() {
    let mut bench = with_input(IoFunction::DigitalInput);
    bench.set(&QueuedCmdStartDownload {
        total_loop: 1,
        line_per_loop: 2,
    });
    bench.enqueue(&trig(9, 0, 0, 1));
    bench.enqueue(&wait(10));
    bench.set(&QueuedCmdStopDownload {});
    bench.arm.press(Press::Short);
    let state = bench.state();
    assert!(state.program && state.queue.running.is_none());
    assert_eq!(state.awaits_input, Some(9));
    bench.arm.press(Press::Short);
    assert!(!bench.state().program);
    // Once more; this time the condition is met.
    bench.arm.press(Press::Short);
    bench.arm.set_input(9, true);
    assert_eq!(bench.state().awaits_input, None);
    assert_eq!(bench.rest(), 10_000);
    assert!(!bench.state().program);
}

#[test]
fn clear_drops_what_waits_behind_it() {
    let mut bench = with_input(IoFunction::DigitalInput);
    let index = bench.enqueue(&trig(9, 0, 0, 1));
    bench.enqueue(&wait(10));
    bench.set(&QueuedCmdClear {});
    blocks(&mut bench, index);
    bench.arm.set_input(9, true);
    assert_eq!(bench.current_index(), index);
}

#[test]
fn at_once_it_holds_nothing_back() {
    let mut bench = with_input(IoFunction::DigitalInput);
    bench.set(&trig(9, 0, 0, 1));
    assert_eq!(bench.state().queue.running, None);
    assert_eq!(bench.state().not_simulated, 0);
}

#[test]
fn one_without_sense_is_refused_and_finishes() {
    let mut bench = running_arm();
    bench.events();
    for (address, mode, condition) in [
        (0, 0, 0),
        (21, 0, 0),
        (255, 1, 0),
        (9, 2, 0),
        (9, 0, 2),
        (9, 0, 3),
        (9, 1, 4),
    ] {
        let index = bench.enqueue(&trig(address, mode, condition, 1));
        assert_eq!(bench.current_index(), index);
        let refused = bench.events().into_iter().any(|event| {
            let reason = Refusal::Trigger;
            matches!(event, Event::Refused { id: 120, reason: told } if told == reason)
        });
        assert!(refused, "{address} {mode} {condition}");
    }
    // Four bytes, the document's wrong count, are not a trigger.
    let reply = bench.frame(120, Ctrl::QUEUED, &[9, 0, 0, 1]);
    assert_eq!(reply.frame().params().len(), 8);
    assert_eq!(bench.state().queue.running, None);
}

#[test]
fn an_alarm_meanwhile_holds_what_comes_after_it() {
    let mut bench = with_input(IoFunction::DigitalInput);
    let index = bench.enqueue(&trig(9, 0, 0, 1));
    bench.enqueue(&wait(10));
    bench.arm.inject(ExternalEvent::Alarm(0x40));
    bench.arm.set_input(9, true);
    assert_eq!(bench.current_index(), index);
    assert!(bench.state().queue.held && bench.state().queue.waiting == 1);
}

//! Stops, clears and withdrawals: what they overtake, and what is never sent after them.

use magician_protocol::commands::{
    JogCommonParams, QueuedCmdForceStopExec, SetEndEffectorLaser, WaitCmd,
};
use magician_protocol::{Ctrl, JogCommand, Row, Writable};

use super::{SECOND, ready, wait};
use crate::connection::{Failure, Priority, Request, Settings};
use crate::pair::index_of;

#[test]
fn after_a_clear_nothing_is_queued_until_the_motion_has_ended_and_doubts_are_settled() {
    let mut pair = ready(Settings::ORDERED, 7);
    for ms in [3_000, 100, 100] {
        pair.ask(wait(ms), SECOND).unwrap();
    }
    let clear = Row::find("QueuedCmdClear").unwrap().id;
    pair.ask(Request::raw(clear, Ctrl::SET, &[]).unwrap(), SECOND)
        .unwrap();
    let before = pair.now;
    assert_eq!(index_of(&pair.ask(wait(500), 10 * SECOND).unwrap()), 4);
    assert!(
        pair.now - before > 2 * SECOND,
        "the first command ran to its end"
    );
    pair.mute = true;
    let deadline = pair.now + 5 * SECOND;
    let ticket = pair.host.submit(wait(1).deadline(deadline));
    let soon = pair.now + 50_000;
    pair.run_until(soon);
    pair.mute = false;
    assert_eq!(index_of(&pair.finish(ticket, deadline).unwrap()), 5);
    assert_eq!(pair.accepted.len(), 5);
}

#[test]
fn a_stop_overtakes_everything() {
    let mut pair = ready(Settings::ORDERED, 10);
    let deadline = pair.now + 9 * SECOND;
    let streamed: Vec<_> = (0..20)
        .map(|_| pair.host.submit(wait(50).deadline(deadline)))
        .collect();
    let out = pair.now + 500;
    pair.run_until(out);
    let before = pair.heard.len();
    let stop = Request::set(&QueuedCmdForceStopExec {}).unwrap();
    let stop = pair
        .host
        .submit(stop.priority(Priority::Stop).deadline(deadline));
    pair.finish(stop, deadline).unwrap();
    let order: Vec<u8> = pair.heard[before..]
        .iter()
        .map(|frame| frame.frame().id())
        .collect();
    assert_eq!(order, [WaitCmd::ROW.id, QueuedCmdForceStopExec::ROW.id]);
    let later = pair.now + SECOND;
    pair.run_until(later);
    let stopped = streamed
        .iter()
        .filter(|ticket| pair.results[ticket] == Err(Failure::Stopped));
    assert_eq!(stopped.count(), 19);
}

#[test]
pub(super) fn what_was_lost_before_a_stop_is_not_sent_after_it() {
    for only_the_first in [true, false] {
        let mut pair = ready(Settings::ORDERED, 18);
        pair.ask(wait(0), SECOND).unwrap();
        let deadline = pair.now + 20 * SECOND;
        pair.lose_next_request();
        let lost = pair.host.submit(wait(7).deadline(deadline));
        let soon = pair.now + 1_500;
        pair.run_until(soon);
        let halt = Request::halt().unwrap();
        let halt = &halt[..if only_the_first { 1 } else { 3 }];
        let stops: Vec<_> = (halt.iter())
            .map(|request| pair.host.submit(request.deadline(deadline)))
            .collect();
        for stop in stops {
            pair.finish(stop, deadline).unwrap();
        }
        let fate = pair.finish(lost, deadline);
        assert!(fate.is_err(), "{fate:?}");
        let later = pair.now + 5 * SECOND;
        pair.run_until(later);
        let sent = (pair.heard.iter()).any(|frame| frame.frame().params() == 7u32.to_le_bytes());
        assert!(!sent, "it was sent although a stop had come");
    }
}

#[test]
pub(super) fn a_clear_that_goes_out_again_finds_nothing_that_was_accepted_meanwhile() {
    // Over datagrams, because on an ordered link the reading after a Clear shows that the reply was
    // lost.
    let mut pair = ready(Settings::DATAGRAMS, 19);
    let deadline = pair.now + 20 * SECOND;
    let clear = magician_protocol::commands::QueuedCmdClear {};
    let clear = Request::set(&clear).unwrap().priority(Priority::Stop);
    pair.lose_next_reply();
    let clear = pair.host.submit(clear.deadline(deadline));
    let soon = pair.now + 500;
    pair.run_until(soon);
    let after = pair.host.submit(wait(400).deadline(deadline));
    pair.finish(clear, deadline).unwrap();
    pair.finish(after, deadline).unwrap();
    let order: Vec<u8> = pair.heard.iter().map(|frame| frame.frame().id()).collect();
    let last_clear = order.iter().rposition(|id| *id == 245).unwrap();
    let command = order.iter().position(|id| *id == WaitCmd::ROW.id).unwrap();
    assert!(last_clear < command, "{order:?}");
    assert_eq!(order.iter().filter(|id| **id == 245).count(), 2);
}

#[test]
fn what_is_withdrawn_before_it_went_out_never_goes_out() {
    let mut pair = ready(Settings::ORDERED, 20);
    pair.ask(wait(0), SECOND).unwrap();
    let deadline = pair.now + 9 * SECOND;
    let first = pair.host.submit(wait(3).deadline(deadline));
    let second = pair.host.submit(wait(4).deadline(deadline));
    pair.lose_next_request();
    let soon = pair.now + 1_500;
    pair.run_until(soon);
    pair.host.cancel(second);
    pair.host.cancel(first);
    assert_eq!(pair.finish(second, deadline), Err(Failure::Stopped));
    assert_eq!(pair.finish(first, deadline), Err(Failure::Stopped));
    let later = pair.now + 5 * SECOND;
    pair.run_until(later);
    assert_eq!(pair.accepted.len(), 1, "neither was sent again");
    assert_eq!(index_of(&pair.ask(wait(5), SECOND).unwrap()), 2);
}

#[test]
fn jog_stop_keeps_pending_sets() {
    let mut pair = ready(Settings::ORDERED, 23);
    let deadline = pair.now + 9 * SECOND;
    let jog = |cmd| {
        let is_joint = magician_protocol::Flag::ON;
        let jog = magician_protocol::commands::JogCmd { is_joint, cmd };
        Request::set(&jog).unwrap().deadline(deadline)
    };
    let speed = JogCommonParams {
        velocity_ratio: 20.0,
        acceleration_ratio: 20.0,
    };
    let laser = SetEndEffectorLaser {
        enable_ctrl: magician_protocol::Flag::ON,
        on: magician_protocol::Flag::ON,
    };
    for (stop, spared) in [
        (jog(JogCommand::Stop), true),
        (Request::set(&QueuedCmdForceStopExec {}).unwrap(), false),
    ] {
        // A request in flight runs to its end.
        pair.host.submit(wait(1).deadline(deadline));
        let speed = pair
            .host
            .submit(Request::set(&speed).unwrap().deadline(deadline));
        let others = [
            jog(JogCommand::Axis1Plus),
            wait(2),
            Request::set(&laser).unwrap(),
        ];
        let others = others.map(|other| pair.host.submit(other.deadline(deadline)));
        let stop = pair
            .host
            .submit(stop.priority(Priority::Stop).deadline(deadline));
        pair.finish(stop, deadline).unwrap();
        assert_eq!(pair.finish(speed, deadline).is_ok(), spared);
        for other in others {
            assert_eq!(pair.finish(other, deadline), Err(Failure::Stopped));
        }
    }
}

#[test]
pub(super) fn a_stop_is_not_confirmed_by_the_answer_to_what_it_stops() {
    let mut pair = ready(Settings::ORDERED, 22);
    let jog = |cmd| {
        Request::set(&magician_protocol::commands::JogCmd {
            is_joint: magician_protocol::Flag::ON,
            cmd,
        })
        .unwrap()
    };
    pair.delay_replies(400_000);
    let start = pair.ask(jog(JogCommand::Axis1Plus), 200_000);
    assert!(matches!(start, Err(Failure::Uncertain { .. })), "{start:?}");
    // The stop is lost; the frame that comes back is the late reply to the start.
    pair.lose_next_request();
    let stop = jog(JogCommand::Stop).priority(Priority::Stop);
    let stop = pair.ask(stop, 300_000);
    assert!(stop.is_err(), "the arm still jogs: {stop:?}");
}

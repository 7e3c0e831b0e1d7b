//! Lost and restored lines, and resets of the controller.

use magician_protocol::NoArgs;
use magician_protocol::commands::{DeviceTime, Pose, QueuedCmdCurrentIndex};

use super::{SECOND, lawful, ready, shared, wait};
use crate::connection::{Failure, Request, Settings, Ticket};
use crate::pair::{Pair, index_of};

/// Sends a command and pulls the cable before its reply arrives, with or without the arm taking it.
fn pulled(taken: bool) -> (Pair, Ticket, u64) {
    let mut pair = ready(Settings::ORDERED, 1);
    for ms in [5_000, 0] {
        pair.ask(wait(ms), SECOND).unwrap();
    }
    pair.ask(Request::get::<DeviceTime>(&NoArgs).unwrap(), SECOND)
        .unwrap();
    let deadline = pair.now + 20 * SECOND;
    if !taken {
        pair.lose_next_request();
    }
    let ticket = pair.host.submit(wait(7).deadline(deadline));
    let sent = pair.now + 1_500;
    pair.run_until(sent);
    pair.pull_cable();
    assert_eq!(pair.accepted.len(), if taken { 3 } else { 2 });
    (pair, ticket, deadline)
}

#[test]
fn a_command_that_was_taken_before_the_cable_was_pulled_ends_with_its_index() {
    let (mut pair, ticket, deadline) = pulled(true);
    let later = pair.now + 2 * SECOND;
    pair.run_until(later);
    assert!(pair.results.is_empty(), "it is still in doubt");
    let heard = pair.heard.len();
    pair.put_cable_back();
    let after = pair.host.submit(wait(8).deadline(deadline));
    assert_eq!(index_of(&pair.finish(ticket, deadline).unwrap()), 3);
    assert_eq!(index_of(&pair.finish(after, deadline).unwrap()), 4);
    let ids = pair.heard[heard..].iter().map(|frame| frame.frame().id());
    let ids: Vec<u8> = ids.collect();
    assert_eq!(ids, [4, 246, 247, 246, 247, 110]);
    assert_eq!(pair.accepted.len(), 4, "each once");
    assert_eq!(pair.resets, 0);
}

#[test]
fn a_command_that_went_nowhere_is_not_sent_on_another_line() {
    let (mut pair, ticket, deadline) = pulled(false);
    pair.put_cable_back();
    assert_eq!(pair.finish(ticket, deadline), Err(Failure::Lost));
    assert_eq!(pair.accepted.len(), 2);
    assert_eq!(index_of(&pair.ask(wait(8), SECOND).unwrap()), 3);
}

#[test]
fn an_arm_that_was_switched_off_meanwhile_is_noticed_by_its_clock() {
    let (mut pair, ticket, deadline) = pulled(true);
    let later = pair.now + 3 * SECOND;
    pair.run_until(later);
    pair.power_cycle();
    pair.put_cable_back();
    let after = pair.host.submit(wait(8).deadline(deadline));
    let interval = Failure::Uncertain {
        from: Some(3),
        to: Some(3),
    };
    assert_eq!(pair.finish(ticket, deadline), Err(interval));
    assert_eq!(pair.finish(after, deadline), Err(Failure::Stopped));
    assert_eq!(pair.resets, 1);
    assert_eq!(pair.accepted.len(), 3, "nothing is replayed");
}

#[test]
fn an_arm_whose_clock_was_never_read_may_have_been_switched_off_meanwhile() {
    let mut pair = ready(Settings::ORDERED, 7);
    assert_eq!(index_of(&pair.ask(wait(60_000), SECOND).unwrap()), 1);
    pair.pull_cable();
    pair.power_cycle();
    pair.put_cable_back();
    // The first index after the power cycle equals the last one before it.
    assert_eq!(index_of(&pair.ask(wait(60_000), SECOND).unwrap()), 1);
    assert_eq!(index_of(&pair.ask(wait(60_000), SECOND).unwrap()), 2);
}

#[test]
fn a_doubt_does_not_outlive_its_deadline() {
    let (mut pair, ticket, deadline) = pulled(true);
    let interval = Failure::Uncertain {
        from: Some(3),
        to: Some(3),
    };
    assert_eq!(pair.finish(ticket, deadline), Err(interval));
    assert_eq!(pair.now, deadline);
}

#[test]
fn cable_pull_fails_waiting_requests_and_leaves_the_window_uncertain() {
    let mut pair = lawful(4, 3);
    let deadline = pair.now + 20 * SECOND;
    // Three commands and the read are in flight.
    let tickets: Vec<_> = (0..10)
        .map(|_| pair.host.submit(shared(1).deadline(deadline)))
        .collect();
    let read = Request::get::<Pose>(&NoArgs).unwrap();
    let read = pair.host.submit(read.deadline(deadline));
    let sent = pair.now + 500;
    pair.run_until(sent);
    pair.pull_cable();
    pair.put_cable_back();
    let later = pair.now + SECOND;
    pair.run_until(later);
    let interval = Failure::Uncertain {
        from: Some(5),
        to: Some(7),
    };
    for (at, ticket) in tickets.iter().enumerate() {
        let fate = if at < 3 { interval } else { Failure::Lost };
        assert_eq!(pair.results[ticket], Err(fate), "{at}");
    }
    assert_eq!(pair.results[&read], Err(Failure::Lost));
    assert_eq!(pair.results.len(), 11, "nothing else is told");
    assert!(pair.accepted.len() <= 4 + 3);
}

#[test]
fn without_a_line_nothing_goes_out_and_deadlines_hold() {
    let mut pair = ready(Settings::ORDERED, 4);
    pair.pull_cable();
    let heard = pair.heard.len();
    let fate = pair.ask(Request::get::<Pose>(&NoArgs).unwrap(), SECOND);
    assert_eq!(fate, Err(Failure::Timeout { sent: 0 }));
    assert_eq!(pair.heard.len(), heard);
    pair.put_cable_back();
    pair.ask(Request::get::<Pose>(&NoArgs).unwrap(), SECOND)
        .unwrap();
}

#[test]
fn a_reset_shows_in_the_clock_as_well_as_in_the_index() {
    for by_index_too in [false, true] {
        let mut pair = ready(Settings::ORDERED, 5);
        let later = pair.now + 10 * SECOND;
        pair.run_until(later);
        let clock = Request::get::<DeviceTime>(&NoArgs).unwrap();
        let index = Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap();
        for _ in 0..2 {
            pair.ask(wait(0), SECOND).unwrap();
            pair.ask(clock, SECOND).unwrap();
            pair.ask(index, SECOND).unwrap();
        }
        pair.power_cycle();
        if by_index_too {
            pair.ask(index, SECOND).unwrap();
        }
        pair.ask(clock, SECOND).unwrap();
        pair.ask(index, SECOND).unwrap();
        pair.ask(clock, SECOND).unwrap();
        assert_eq!(pair.resets, 1, "told once");
        assert_eq!(pair.host.last_index(), None);
    }
}

#[test]
fn a_line_that_broke_many_times_is_settled_at_once_when_it_is_good() {
    let mut pair = ready(Settings::ORDERED, 6);
    pair.ask(wait(0), SECOND).unwrap();
    let pose = Request::get::<Pose>(&NoArgs).unwrap();
    // Requests stay unanswered, and the line is lost and restored before their timeout: in the end
    // a reply is outstanding for every read that could serve as a fence.
    pair.mute = true;
    for _ in 0..30 {
        let soon = pair.now + 300_000;
        pair.host.submit(pose.deadline(soon));
        pair.run_until(soon);
        pair.pull_cable();
        pair.put_cable_back();
    }
    pair.mute = false;
    pair.ask(pose, 100_000).unwrap();
    assert_eq!(index_of(&pair.ask(wait(1), 100_000).unwrap()), 2);
}

//! Loss, delay and duplication on a network that is otherwise fast.

use magician_protocol::commands::{
    DeviceTime, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, QueuedCmdStartExec,
    QueuedCmdStopExec,
};
use magician_protocol::{FrameBuf, NoArgs, Readable};

use super::{SECOND, ready, wait};
use crate::connection::{Failure, Micros, Request, Settings};
use crate::pair::{Faults, Pair, index_of};

/// A pair with a few measured round trips.
fn quick(seed: u64) -> Pair {
    let mut pair = ready(Settings::DATAGRAMS, seed);
    for _ in 0..3 {
        pair.ask(wait(0), SECOND).unwrap();
    }
    let later = pair.now + 3 * SECOND;
    pair.run_until(later);
    pair.accepted.clear();
    pair
}

fn get<T: Readable<Query = NoArgs>>() -> Request {
    Request::get::<T>(&NoArgs).unwrap()
}

/// Duration of a request.
fn time(pair: &mut Pair, act: impl FnOnce(&mut Pair)) -> Micros {
    let begun = pair.now;
    act(pair);
    pair.now - begun
}

#[test]
fn a_lost_datagram_costs_no_more_than_it_may_be_under_way() {
    for lose in [Pair::lose_next_request, Pair::lose_next_reply] {
        let mut pair = quick(1);
        assert_eq!(pair.host.lifetime(), SECOND / 5);
        // The same request follows at once.
        lose(&mut pair);
        let took = time(&mut pair, |pair| {
            for _ in 0..3 {
                pair.ask(get::<QueuedCmdCurrentIndex>(), 3 * SECOND)
                    .unwrap();
            }
        });
        assert!(took < SECOND / 4, "{took}");
        lose(&mut pair);
        let took = time(&mut pair, |pair| {
            pair.ask(wait(1), 3 * SECOND).unwrap();
            pair.ask(wait(2), 3 * SECOND).unwrap();
        });
        assert!(took < SECOND * 7 / 10, "{took}");
        assert_eq!(pair.accepted.len(), 2);
    }
}

#[test]
fn a_slow_network_and_late_answers_lengthen_the_lifetime() {
    let mut pair = quick(2);
    pair.delay_replies(50_000);
    pair.ask(get::<DeviceTime>(), SECOND).unwrap();
    let slow = pair.host.lifetime();
    assert!(slow >= 8 * 50_000, "{slow}");
    // The reply to a command arrives after its lifetime.
    let mut pair = quick(3);
    pair.delay_replies(230_000);
    let ticket = pair.host.submit(wait(1).deadline(pair.now + 5 * SECOND));
    let sent = pair.now + 10_000;
    pair.run_until(sent);
    pair.delay_replies(1_000);
    let deadline = pair.now + 5 * SECOND;
    assert_eq!(index_of(&pair.finish(ticket, deadline).unwrap()), 4);
    let later = pair.now + SECOND / 2;
    pair.run_until(later);
    assert!(pair.host.lifetime() > SECOND, "{}", pair.host.lifetime());
    assert_eq!(pair.accepted.len(), 1);
}

#[test]
fn duplicated_command_is_reported_even_if_its_first_reply_is_lost() {
    let mut pair = quick(4);
    let twice = Faults {
        duplicate_chunk: 1.0,
        ..Faults::default()
    };
    pair.set_faults(twice);
    pair.set_reply_faults(Faults::default());
    pair.lose_next_reply();
    let reply = pair.ask(wait(1), 3 * SECOND).unwrap();
    assert_eq!(index_of(&reply), 5);
    assert_eq!(pair.reports, [(4, 4)]);
}

/// An arm at rest: its queue was seen empty, and then its current index was read.
fn at_rest(settings: Settings, dropped: u32) -> Pair {
    let mut pair = Pair::new(settings, Faults::default(), 5);
    pair.count_from(1);
    // An earlier program has used the arm and cleared its queue.
    let mut before = Pair::new(Settings::ORDERED, Faults::default(), 6);
    before.count_from(1);
    let orders: [FrameBuf; 3] = [
        *Request::set(&QueuedCmdStopExec {}).unwrap().frame(),
        *Request::set(&QueuedCmdClear {}).unwrap().frame(),
        *Request::set(&QueuedCmdStartExec {}).unwrap().frame(),
    ];
    let mut tell = |frame: &FrameBuf| {
        before.arm.exchange(magician_sim::LinkId(0), frame.bytes());
    };
    tell(&orders[0]);
    (0..dropped).for_each(|_| tell(wait(0).frame()));
    tell(&orders[1]);
    tell(&orders[2]);
    pair.arm = before.arm;
    for _ in 0..2 {
        pair.ask(get::<QueuedCmdLeftSpace>(), SECOND).unwrap();
        pair.ask(get::<QueuedCmdCurrentIndex>(), SECOND).unwrap();
    }
    pair
}

#[test]
fn an_arm_at_rest_settles_the_fate_of_the_first_command() {
    for settings in [Settings::ORDERED, Settings::DATAGRAMS] {
        for dropped in [0, 3] {
            for lose in [Pair::lose_next_request, Pair::lose_next_reply] {
                for takes in [0, 5_000] {
                    let mut pair = at_rest(settings, dropped);
                    lose(&mut pair);
                    let first = pair.ask(wait(takes), 3 * SECOND);
                    if let (Err(fate), true, 0) = (&first, dropped > 0, takes) {
                        // The command has ended, with a number that might be another host's.
                        assert!(matches!(fate, Failure::Uncertain { from: Some(1), .. }));
                        continue;
                    }
                    assert!(index_of(&first.unwrap()) >= 1);
                    let second = pair.ask(wait(1), 3 * SECOND).unwrap();
                    assert_eq!(index_of(&second), u64::from(dropped) + 2);
                    assert_eq!(pair.accepted.len(), 2);
                    assert_eq!(pair.reports, []);
                }
            }
        }
    }
}

#[test]
fn index_read_before_the_queue_was_empty_is_not_a_baseline() {
    let mut pair = at_rest(Settings::ORDERED, 0);
    // Another host's command: seen running, then the queue is empty, and the index was not read
    // since.
    let order = *wait(50).frame();
    pair.arm.exchange(magician_sim::LinkId(0), order.bytes());
    pair.ask(get::<QueuedCmdLeftSpace>(), SECOND).unwrap();
    pair.ask(get::<QueuedCmdCurrentIndex>(), SECOND).unwrap();
    let later = pair.now + SECOND;
    pair.run_until(later);
    pair.ask(get::<QueuedCmdLeftSpace>(), SECOND).unwrap();
    pair.lose_next_request();
    let fate = pair.ask(wait(1), 3 * SECOND);
    assert!(matches!(fate, Err(Failure::Uncertain { .. })), "{fate:?}");
}

//! Queued commands with a lost, wrong or late reply.

use magician_protocol::commands::{DeviceName, QueuedCmdCurrentIndex};
use magician_protocol::{Ctrl, NoArgs};

use super::{SECOND, lawful, ready, shared, wait};
use crate::connection::{Failure, Request, Settings};
use crate::pair::{Faults, Pair, index_of};

#[test]
fn a_lost_reply_to_the_first_command_is_uncertain() {
    let mut pair = ready(Settings::ORDERED, 4);
    pair.mute = true;
    let deadline = pair.now + 5 * SECOND;
    let ticket = pair.host.submit(wait(1).deadline(deadline));
    let soon = pair.now + 50_000;
    pair.run_until(soon);
    pair.mute = false;
    let uncertain = Failure::Uncertain {
        from: None,
        to: None,
    };
    assert_eq!(pair.finish(ticket, deadline), Err(uncertain));
    assert_eq!(pair.accepted.len(), 1);
}

#[test]
fn lost_reply_is_recovered_by_reading_the_queue() {
    let mut pair = ready(Settings::ORDERED, 5);
    assert_eq!(index_of(&pair.ask(wait(10_000), SECOND).unwrap()), 1);
    pair.mute = true;
    let deadline = pair.now + 5 * SECOND;
    let ticket = pair.host.submit(wait(1).deadline(deadline));
    let soon = pair.now + 50_000;
    pair.run_until(soon);
    pair.mute = false;
    assert_eq!(index_of(&pair.finish(ticket, deadline).unwrap()), 2);
    assert_eq!(pair.accepted.len(), 2, "sent once");
}

#[test]
fn lost_command_is_sent_again() {
    let mut pair = ready(Settings::ORDERED, 6);
    pair.ask(wait(10_000), SECOND).unwrap();
    pair.set_faults(Faults {
        drop_chunk: 1.0,
        ..Faults::default()
    });
    let deadline = pair.now + 5 * SECOND;
    let ticket = pair.host.submit(wait(1).deadline(deadline));
    let soon = pair.now + 50_000;
    pair.run_until(soon);
    pair.set_faults(Faults::default());
    assert_eq!(index_of(&pair.finish(ticket, deadline).unwrap()), 2);
    assert_eq!(pair.accepted.len(), 2);
}

#[test]
fn controller_reset_is_reported_and_nothing_is_replayed() {
    let mut pair = ready(Settings::ORDERED, 8);
    for _ in 0..3 {
        pair.ask(wait(1), SECOND).unwrap();
    }
    let later = pair.now + SECOND;
    pair.run_until(later);
    let index = Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap();
    pair.ask(index, SECOND).unwrap();
    pair.power_cycle();
    let result = pair.ask(wait(9), 5 * SECOND);
    assert_eq!(
        result,
        Err(Failure::Uncertain {
            from: Some(4),
            to: Some(4)
        })
    );
    let index = Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap();
    pair.ask(index, SECOND).unwrap();
    assert_eq!(pair.resets, 1);
}

#[test]
fn full_queue_is_reported() {
    let mut pair = Pair::new(Settings::ORDERED, Faults::default(), 9);
    pair.count_from(1);
    for _ in 0..32 {
        pair.ask(wait(1), SECOND).unwrap();
    }
    assert_eq!(pair.ask(wait(1), SECOND), Err(Failure::QueueFull));
}

#[test]
pub(super) fn wrong_index_leaves_command_uncertain() {
    let mut pair = ready(Settings::ORDERED, 15);
    pair.ask(wait(1), SECOND).unwrap();
    pair.mute = true;
    let deadline = pair.now + SECOND;
    let ticket = pair.host.submit(wait(2).deadline(deadline));
    let sent = pair.now + 500;
    pair.run_until(sent);
    let wrong = magician_protocol::FrameBuf::new(110, Ctrl::QUEUED, &40u64.to_le_bytes()).unwrap();
    pair.inject(wrong.bytes());
    let result = pair.finish(ticket, deadline);
    assert_eq!(
        result,
        Err(Failure::Uncertain {
            from: Some(2),
            to: Some(2)
        })
    );
}

#[test]
fn a_window_of_four_streams_and_reports_a_loss_as_an_interval() {
    let mut pair = lawful(4, 16);
    let deadline = pair.now + 20 * SECOND;
    let tickets: Vec<_> = (0..20)
        .map(|_| pair.host.submit(shared(0).deadline(deadline)))
        .collect();
    for (at, ticket) in tickets.into_iter().enumerate() {
        assert_eq!(
            index_of(&pair.finish(ticket, deadline).unwrap()),
            5 + at as u64
        );
    }
    pair.ask(Request::get::<DeviceName>(&NoArgs).unwrap(), SECOND)
        .unwrap();
    // The line loses one request of a batch; which one is unknown.
    let tickets: Vec<_> = (0..4)
        .map(|_| pair.host.submit(shared(0).deadline(deadline)))
        .collect();
    pair.lose_next_request();
    let results: Vec<_> = tickets
        .into_iter()
        .map(|ticket| pair.finish(ticket, deadline))
        .collect();
    let interval = Failure::Uncertain {
        from: Some(25),
        to: Some(28),
    };
    assert!(results.contains(&Err(interval)), "{results:?}");
    assert_eq!(pair.accepted.len(), 27, "nothing was sent again");
}

#[test]
pub(super) fn request_lost_in_a_window_is_not_resent_after_the_next() {
    let mut pair = lawful(4, 17);
    let deadline = pair.now + 20 * SECOND;
    // Two commands of different ids: the reply to the second proves the first lost.
    let first = pair.host.submit(shared(1).deadline(deadline));
    let suck = magician_protocol::commands::SetEndEffectorSuctionCup {
        enable_ctrl: magician_protocol::Flag::ON,
        suck: magician_protocol::Flag::ON,
    };
    let second = Request::queued(&suck)
        .unwrap()
        .repeatable()
        .deadline(deadline);
    let second = pair.host.submit(second);
    pair.lose_next_request();
    let results = [pair.finish(first, deadline), pair.finish(second, deadline)];
    let interval = Err(Failure::Uncertain {
        from: Some(5),
        to: Some(6),
    });
    assert_eq!(results, [interval, interval]);
    let later = pair.now + SECOND;
    pair.run_until(later);
    assert_eq!(
        pair.accepted.len(),
        5,
        "the first is not sent after the second"
    );
}

//! Matching of replies to requests, and timeouts.

use magician_protocol::commands::{DeviceTime, HomeCmd, IoDi, Pose};
use magician_protocol::{Ctrl, NoArgs, Writable};

use super::{SECOND, get_di, ready, wait};
use crate::connection::{Failure, Request, Settings};
use crate::pair::{Dice, Faults, Pair, index_of};

#[test]
fn answers_a_get_and_counts_an_index() {
    let mut pair = ready(Settings::ORDERED, 1);
    let reply = pair
        .ask(Request::get::<Pose>(&NoArgs).unwrap(), SECOND)
        .unwrap();
    let pose: Pose = reply.frame().read().unwrap();
    assert_eq!(pose.joint_angle, [0.0, 45.0, 45.0, 0.0]);
    for expected in 1..=5 {
        assert_eq!(index_of(&pair.ask(wait(1), SECOND).unwrap()), expected);
    }
}

#[test]
fn a_reply_after_its_timeout_is_not_the_answer_to_a_later_request() {
    let mut pair = ready(Settings::ORDERED, 3);
    // The reply to this request is delayed by two seconds; its caller gives up after 600 ms.
    pair.set_reply_faults(Faults {
        ..Faults::default()
    });
    pair.delay_replies(2 * SECOND);
    assert!(matches!(
        pair.ask(get_di(7), 600_000),
        Err(Failure::Timeout { .. })
    ));
    let reply = pair.ask(get_di(8), 20 * SECOND).unwrap();
    assert_eq!(reply.frame().read::<IoDi>().unwrap().address, 8);
    assert!(pair.host.stats().late > 0);
}

#[test]
pub(super) fn an_answer_that_was_lost_costs_the_next_request_no_timeout() {
    let mut pair = ready(Settings::ORDERED, 23);
    pair.lose_next_reply();
    assert!(pair.ask(get_di(7), 50_000).is_err());
    let begun = pair.now;
    let reply = pair.ask(get_di(8), SECOND).unwrap();
    assert_eq!(reply.frame().read::<IoDi>().unwrap().address, 8);
    assert!(pair.now - begun < 10_000, "{}", pair.now - begun);
}

#[test]
pub(super) fn a_frame_that_stays_away_holds_up_no_answer() {
    let mut pair = ready(Settings::ORDERED, 21);
    // The beginning of a long frame, whose rest was lost, would swallow the replies that follow.
    pair.inject(&[0xAA, 0xAA, 0xF0, 0x0A]);
    let later = pair.now + SECOND;
    pair.run_until(later);
    let begun = pair.now;
    pair.ask(get_di(1), SECOND).unwrap();
    assert!(pair.now - begun < 10_000, "{}", pair.now - begun);
}

#[test]
fn a_silent_port_ends_every_call_by_its_deadline() {
    let mut pair = Pair::new(
        Settings::ORDERED,
        Faults {
            drop_chunk: 1.0,
            ..Faults::default()
        },
        11,
    );
    for round in 0..200 {
        let started = pair.now;
        let fate = pair.ask(Request::get::<Pose>(&NoArgs).unwrap(), SECOND);
        assert!(
            matches!(fate, Err(Failure::Timeout { .. })),
            "{round}: {fate:?}"
        );
        assert_eq!(pair.now - started, SECOND);
        let fate = pair.ask(wait(1), SECOND);
        let expected = [
            Err(Failure::Timeout { sent: 0 }),
            Err(Failure::Uncertain {
                from: None,
                to: None,
            }),
        ];
        assert!(expected.contains(&fate), "{fate:?}");
        let home = Request::set(&HomeCmd { reserved: 0 }).unwrap();
        assert!(pair.ask(home, SECOND).is_err());
    }
    // Once the line carries frames again, requests are answered.
    pair.set_faults(Faults::default());
    assert!(pair.ask(get_di(3), 10 * SECOND).is_ok());
}

#[test]
fn an_order_that_may_not_be_repeated_goes_out_once() {
    let mut pair = ready(Settings::ORDERED, 12);
    pair.mute = true;
    let home = Request::set(&HomeCmd { reserved: 0 }).unwrap();
    let fate = pair.ask(home, 5 * SECOND);
    assert_eq!(
        fate,
        Err(Failure::Uncertain {
            from: None,
            to: None
        })
    );
    let homes = pair
        .heard
        .iter()
        .filter(|frame| frame.frame().id() == HomeCmd::ROW.id);
    assert_eq!(homes.count(), 1);
}

#[test]
fn timeouts_adapt_to_a_slow_link() {
    let mut pair = ready(Settings::ORDERED, 13);
    pair.delay_replies(80_000);
    for _ in 0..30 {
        pair.ask(Request::get::<DeviceTime>(&NoArgs).unwrap(), SECOND)
            .unwrap();
    }
    let resent = pair.host.stats().resent;
    pair.delay_replies(250_000);
    for _ in 0..30 {
        pair.ask(Request::get::<DeviceTime>(&NoArgs).unwrap(), 5 * SECOND)
            .unwrap();
    }
    let later = pair.host.stats().resent;
    for _ in 0..30 {
        pair.ask(Request::get::<DeviceTime>(&NoArgs).unwrap(), 5 * SECOND)
            .unwrap();
    }
    assert_eq!(resent, 0);
    assert_eq!(pair.host.stats().resent, later, "it has learned");
    assert!(pair.host.answer_timeout() > 250_000);
}

#[test]
fn garbage_and_unsolicited_replies_are_ignored() {
    let mut pair = ready(Settings::ORDERED, 14);
    let mut dice = Dice::new(99);
    for round in 0..300 {
        let garbage: Vec<u8> = (0..dice.below(300))
            .map(|_| {
                if dice.chance(0.3) {
                    0xAA
                } else {
                    dice.below(256) as u8
                }
            })
            .collect();
        pair.inject(&garbage);
        let alien = magician_protocol::FrameBuf::new(dice.below(256) as u8, Ctrl(7), &[1, 2, 3]);
        pair.inject(alien.unwrap().bytes());
        let address = 1 + dice.below(20) as u8;
        let reply = pair.ask(get_di(address), 10 * SECOND).unwrap();
        assert_eq!(
            reply.frame().read::<IoDi>().unwrap().address,
            address,
            "round {round}"
        );
    }
}

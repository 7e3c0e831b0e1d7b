//! Many commands over lines that lose, damage, duplicate, delay and reorder.

use std::collections::HashMap;

use magician_protocol::NoArgs;
use magician_protocol::commands::{DeviceTime, IoDi, QueuedCmdCurrentIndex};

use super::{SECOND, get_di, ready, wait};
use crate::connection::{Failure, IndexLaw, Request, Settings};
use crate::pair::{Faults, Pair, index_of};

/// A network that delays datagrams for longer than its round trips suggest.
const HOLDS: Settings = Settings {
    shortest: Settings::DATAGRAMS.lifetime,
    ..Settings::DATAGRAMS
};

/// Sends numbered queued commands, and reads whose replies identify their requests. Returns how
/// many commands were uncertain, and how many exchanges took place.
fn stream(pair: &mut Pair, commands: u32, check_gets: bool) -> (u32, u32) {
    let mut fates = HashMap::new();
    let (mut uncertain, mut exchanges) = (0, 0);
    for number in 1..=commands {
        let fate = loop {
            let fate = pair.ask(wait(number), 30 * SECOND);
            if fate != Err(Failure::QueueFull) {
                break fate;
            }
            let later = pair.now + SECOND / 10;
            pair.run_until(later);
        };
        if let Err(Failure::Uncertain { .. }) = fate {
            uncertain += 1;
        }
        fates.insert(number, fate);
        let address = 1 + pair.dice.below(20) as u8;
        if let Ok(reply) = pair.ask(get_di(address), 2 * SECOND)
            && check_gets
        {
            let found: IoDi = reply.frame().read().unwrap();
            assert_eq!(found.address, address, "a reply to another request");
        }
        if number % 5 == 0 {
            let clock = Request::get::<DeviceTime>(&NoArgs).unwrap();
            let _ = pair.ask(clock, 2 * SECOND);
        }
        exchanges += 1;
    }
    assert_eq!(pair.resets, 0);
    let settled = pair.now + 10 * SECOND;
    pair.set_faults(Faults::default());
    pair.run_until(settled);
    let mut order = 0;
    let mut executed: HashMap<u32, Vec<u64>> = HashMap::new();
    for (params, index) in &pair.accepted {
        let number = u32::from_le_bytes(params[..4].try_into().unwrap());
        executed.entry(number).or_default().push(*index);
        assert!(number >= order, "{number} after {order}");
        order = number;
    }
    for (number, fate) in &fates {
        let done = executed.remove(number).unwrap_or_default();
        match fate {
            Ok(reply) => assert_eq!(done, [index_of(reply)], "command {number}"),
            Err(Failure::Uncertain { .. }) => assert!(done.len() <= 1, "{number}: {done:?}"),
            other => panic!("command {number}: {other:?}"),
        }
    }
    assert!(executed.is_empty());
    let law = pair.host.law();
    assert!(!matches!(law, IndexLaw::Broken(_)), "{law:?}");
    (uncertain, exchanges)
}

#[test]
pub(super) fn executes_each_command_once_over_a_serial_line_that_loses_damages_and_delays() {
    let faults = Faults {
        drop_chunk: 0.015,
        flip: 0.0005,
        stall: 0.02,
        stall_for: 900_000,
        ..Faults::default()
    };
    let mut uncertain = 0;
    for seed in 0..200 {
        let mut pair = ready(Settings::ORDERED, seed);
        pair.ask(wait(0), SECOND).unwrap();
        pair.accepted.clear();
        pair.set_faults(faults);
        uncertain += stream(&mut pair, 60, true).0;
        assert!(pair.host.stats().resent > 0);
    }
    assert_eq!(uncertain, 0, "with a known base every doubt was settled");
}

#[test]
fn a_line_that_doubles_replies_never_doubles_commands() {
    let faults = Faults {
        drop_chunk: 0.02,
        duplicate_chunk: 0.05,
        stall: 0.02,
        stall_for: 300_000,
        ..Faults::default()
    };
    for seed in 300..400 {
        let mut pair = ready(Settings::ORDERED, seed);
        pair.ask(wait(0), SECOND).unwrap();
        pair.accepted.clear();
        // Only replies are duplicated: a duplicated request is executed twice by any controller,
        // which the index of the next command reveals.
        pair.set_reply_faults(faults);
        stream(&mut pair, 40, false);
    }
}

#[test]
pub(super) fn datagrams_lost_late_and_out_of_order_lead_to_no_silent_mistake() {
    let faults = Faults {
        drop_chunk: 0.05,
        late_chunk: 0.05,
        late_for: 900_000,
        ..Faults::default()
    };
    let mut uncertain = 0;
    for seed in 500..580 {
        let mut pair = ready(HOLDS, seed);
        pair.ask(wait(0), SECOND).unwrap();
        pair.accepted.clear();
        pair.set_faults(faults);
        uncertain += stream(&mut pair, 25, true).0;
    }
    assert_eq!(uncertain, 0);
}

#[test]
fn a_line_that_doubles_requests_does_so_never_unnoticed() {
    let faults = Faults {
        drop_chunk: 0.03,
        duplicate_chunk: 0.04,
        late_chunk: 0.1,
        late_for: 900_000,
        ..Faults::default()
    };
    // The latest moment for a second copy in this test.
    let settings = Settings {
        echo: SECOND,
        ..HOLDS
    };
    let (mut doubled, mut clean) = (0, 0);
    for seed in 700..820 {
        let mut pair = ready(settings, seed);
        pair.ask(wait(0), SECOND).unwrap();
        pair.accepted.clear();
        pair.set_faults(faults);
        let mut uncertain = 0;
        for number in 1..=12 {
            let fate = pair.ask(wait(number), 60 * SECOND);
            uncertain += u32::from(fate.is_err());
        }
        pair.set_faults(Faults::default());
        let settled = pair.now + 10 * SECOND;
        pair.run_until(settled);
        // Any reading of the index would do; a wait or the next run makes one.
        let index = Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap();
        pair.ask(index, 5 * SECOND).unwrap();
        let mut numbers: Vec<_> = pair.accepted.iter().map(|(params, _)| params).collect();
        let taken = numbers.len();
        numbers.sort();
        numbers.dedup();
        if numbers.len() < taken {
            doubled += 1;
            let noticed = pair.unaccounted + uncertain > 0;
            assert!(noticed, "seed {seed}: in silence");
        } else if pair.unaccounted + uncertain == 0 {
            clean += 1;
            assert_eq!(taken, 12, "seed {seed}");
        }
    }
    assert!(doubled > 20 && clean > 10, "{doubled} {clean}");
}

#[test]
pub(super) fn datagrams_that_overtake_each_other_are_not_mixed_up() {
    let faults = Faults {
        late_chunk: 0.5,
        late_for: 900_000,
        ..Faults::default()
    };
    for seed in 900..930 {
        let mut pair = ready(HOLDS, seed);
        pair.set_faults(faults);
        for _ in 0..20 {
            let address = 1 + pair.dice.below(20) as u8;
            if let Ok(reply) = pair.ask(get_di(address), 300_000) {
                assert_eq!(reply.frame().read::<IoDi>().unwrap().address, address);
            }
        }
    }
}

//! Several commands in flight: confirmation, and the consequences of a gap.

use magician_protocol::commands::{Pose, PtpCommonParams, WaitCmd};
use magician_protocol::{Layout, NoArgs, Writable};

use super::{SECOND, lawful, ready, shared, wait};
use crate::connection::{Failure, Request, Settings, Ticket};
use crate::pair::{Faults, Pair, index_of};

/// Index of the last command of [`lawful`].
const BASE: u64 = 4;

/// A command that takes no time and carries a number.
fn numbered(number: u64) -> Request {
    let params = PtpCommonParams {
        velocity_ratio: number as f32,
        acceleration_ratio: 50.0,
    };
    Request::queued(&params).unwrap().repeatable()
}

fn number_of(params: &[u8]) -> u64 {
    PtpCommonParams::decode(params).unwrap().velocity_ratio as u64
}

/// Asserts that confirmed commands were taken once, in order, with the index claimed.
fn check(pair: &Pair) {
    let Some(confirmed) = pair.host.confirmed_index() else {
        return;
    };
    let program = pair.accepted.iter().filter(|(_, index)| *index > BASE);
    for (at, (params, index)) in program.enumerate().take((confirmed.0 - BASE) as usize) {
        let number = number_of(params);
        let place = BASE + 1 + at as u64;
        assert_eq!((number, *index), (place, place));
    }
    let taken = pair.accepted.last().map_or(0, |(_, index)| *index);
    assert!(confirmed.0 <= taken);
}

/// Sends numbered commands with reads in between until a gap. Returns the number of the last
/// confirmed command, and the gap.
fn stream(pair: &mut Pair, polls: bool) -> (u64, Option<Failure>) {
    let mut tickets: Vec<(u64, Ticket)> = Vec::new();
    for number in BASE + 1..=BASE + 100 {
        let deadline = pair.now + 20 * SECOND;
        let request = numbered(number).deadline(deadline);
        tickets.push((number, pair.host.submit(request)));
        if polls && number % 7 == 0 {
            let read = Request::get::<Pose>(&NoArgs).unwrap();
            pair.host.submit(read.deadline(deadline));
        }
        // The queue runs, and all commands are short.
        while pair.results.len() + 12 < tickets.len() {
            let end = pair.now + SECOND;
            pair.step(end);
            check(pair);
        }
        let gap = |(_, ticket): &(u64, Ticket)| match pair.results.get(ticket) {
            Some(Err(failure)) => Some(*failure),
            _ => None,
        };
        if tickets.iter().any(|one| gap(one).is_some()) {
            break;
        }
    }
    let end = pair.now + 25 * SECOND;
    while !pair.host.is_idle() && pair.now < end {
        pair.step(end);
        check(pair);
    }
    let mut gap = None;
    let mut confirmed = BASE;
    for (number, ticket) in tickets {
        match pair.results[&ticket] {
            Ok(reply) if gap.is_none() => {
                assert_eq!(index_of(&reply), number);
                confirmed = number;
            }
            // Reported before the gap was seen, and behind it in the program.
            Ok(_) => {}
            Err(failure @ Failure::Uncertain { from, to }) => {
                let (from, to) = (from.unwrap(), to.unwrap());
                let seen = *gap.get_or_insert(failure);
                assert_eq!(seen, failure, "one gap, one interval");
                assert!(from <= to && number <= to, "{number}: {from} to {to}");
                confirmed = confirmed.min(from - 1);
            }
            Err(other) => assert_eq!(other, Failure::Stopped, "{number}"),
        }
    }
    (confirmed, gap)
}

#[test]
fn confirmed_commands_were_accepted_in_order_with_their_index() {
    let faults = Faults {
        drop_chunk: 0.006,
        flip: 0.0003,
        stall: 0.003,
        stall_for: 300_000,
        ..Faults::default()
    };
    let (mut gaps, mut whole) = (0, 0);
    for seed in 0..200 {
        let mut pair = lawful(4, seed);
        pair.accepted.retain(|(_, index)| *index > BASE);
        pair.set_faults(faults);
        let (confirmed, gap) = stream(&mut pair, seed % 2 == 0);
        gaps += u32::from(gap.is_some());
        whole += u32::from(confirmed == BASE + 100);
        // Confirmed commands are the beginning of those taken, and none was taken twice.
        let numbers: Vec<u64> = (pair.accepted.iter())
            .map(|(params, _)| number_of(params))
            .collect();
        assert!(
            numbers.is_sorted_by(|a, b| a < b),
            "seed {seed}: {numbers:?}"
        );
        assert!(numbers.len() as u64 >= confirmed - BASE, "seed {seed}");
        if let Some(Failure::Uncertain { to: Some(to), .. }) = gap {
            assert!(
                BASE + numbers.len() as u64 <= to,
                "seed {seed}: more than said"
            );
        }
    }
    assert!(gaps > 50 && whole > 5, "{gaps} gaps, {whole} whole");
}

#[test]
fn a_stream_without_reads_is_confirmed_all_the_same() {
    let mut pair = lawful(4, 1);
    // Replies arrive one after the other, with a command in flight at every moment.
    pair.set_reply_faults(Faults {
        stall: 0.9,
        stall_for: 5_000,
        ..Faults::default()
    });
    let deadline = pair.now + 20 * SECOND;
    for number in 0..60 {
        pair.host.submit(numbered(number).deadline(deadline));
    }
    let mut furthest = 0;
    while !pair.host.is_idle() {
        pair.step(deadline);
        let (Some(last), Some(confirmed)) = (pair.host.last_index(), pair.host.confirmed_index())
        else {
            panic!("nothing was lost");
        };
        furthest = furthest.max(last.0 - confirmed.0);
    }
    assert!((1..=20).contains(&furthest), "{furthest}");
}

fn most_in_flight(pair: &mut Pair, requests: Vec<Request>) -> usize {
    let deadline = pair.now + 20 * SECOND;
    pair.delay_replies(20_000);
    for request in requests {
        pair.host.submit(request.deadline(deadline));
    }
    let (mut most, answered) = (0, pair.accepted.len());
    let waits = |pair: &Pair| {
        let heard = pair
            .heard
            .iter()
            .filter(|frame| frame.frame().id() == WaitCmd::ROW.id);
        heard.count()
    };
    let before = waits(pair);
    while !pair.host.is_idle() {
        pair.step(deadline);
        let told = pair
            .results
            .values()
            .filter(|result| result.is_ok_and(|reply| reply.frame().ctrl().queued()));
        most = most.max((waits(pair) - before).saturating_sub(told.count()));
    }
    assert!(pair.accepted.len() > answered);
    most
}

#[test]
fn only_what_may_be_repeated_shares_the_window() {
    let repeatable = |count: u32| (0..count).map(shared).collect::<Vec<_>>();
    let alone = |count: u32| (0..count).map(wait).collect::<Vec<_>>();
    assert_eq!(most_in_flight(&mut lawful(4, 1), repeatable(8)), 4);
    assert_eq!(most_in_flight(&mut lawful(4, 1), alone(8)), 1);
    let mixed = [repeatable(1), alone(1), repeatable(1), alone(1)].concat();
    assert_eq!(most_in_flight(&mut lawful(4, 1), mixed), 1);
    assert_eq!(most_in_flight(&mut lawful(1, 1), repeatable(8)), 1);
    // Before the arm was seen to follow the law, and over datagrams.
    let settings = Settings {
        window: 4,
        ..Settings::ORDERED
    };
    assert_eq!(most_in_flight(&mut ready(settings, 1), repeatable(3)), 1);
    let settings = Settings {
        window: 4,
        ..Settings::DATAGRAMS
    };
    assert_eq!(most_in_flight(&mut ready(settings, 1), repeatable(8)), 1);
}

#[test]
fn behind_a_gap_nothing_goes_out() {
    let mut pair = lawful(4, 2);
    let deadline = pair.now + 20 * SECOND;
    let tickets: Vec<_> = (5..25)
        .map(|number| pair.host.submit(numbered(number).deadline(deadline)))
        .collect();
    pair.lose_next_request();
    let later = pair.now + 5 * SECOND;
    pair.run_until(later);
    let fates: Vec<_> = tickets.iter().map(|ticket| pair.results[ticket]).collect();
    // The first was lost and the second answered for it, until a fence revealed the missing reply.
    let gap = |fate: &&Result<_, _>| matches!(fate, Err(Failure::Uncertain { from: Some(5), .. }));
    assert!(fates.iter().any(|fate| gap(&fate)), "{fates:?}");
    let dropped = fates.iter().rev();
    let dropped = dropped.take_while(|fate| **fate == Err(Failure::Stopped));
    assert!(dropped.count() >= 10, "{fates:?}");
    assert!(pair.accepted.len() < 4 + 10);
    assert_eq!(pair.host.confirmed_index(), None);
}

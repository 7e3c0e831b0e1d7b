//! Clients, a proxy and a virtual arm in virtual time.

mod bench;

use std::collections::VecDeque;

use magician_protocol::commands::{
    DeviceTime, IoDo, Pose, PtpCommonParams, QueuedCmdClear, QueuedCmdForceStopExec,
    QueuedCmdStartExec,
};
use magician_protocol::{Ctrl, FrameBuf, JogCommand, Readable, Row};

use super::*;
use crate::pair::Dice;
use bench::{Faults, MS, NONE, ProxyRig, get, get_output, jog, ratio, set};

/// A client that reads its own pins one after the other, `window` at a time, and gives up after a
/// timeout.
struct Asker {
    number: u32,
    window: usize,
    next: u8,
    /// Pending request, and since when.
    waiting: VecDeque<(u8, Micros)>,
    answered: u32,
    given_up: u32,
}

const PINS: u8 = 6;

impl Asker {
    fn new(number: u32, window: usize) -> Self {
        Self {
            number,
            window,
            next: 0,
            waiting: VecDeque::new(),
            answered: 0,
            given_up: 0,
        }
    }

    fn turn(&mut self, bench: &mut ProxyRig) {
        for frame in bench.received(self.number) {
            let pin = frame.frame().params()[0];
            let at = self.waiting.iter().position(|(asked, _)| *asked == pin);
            let at = at.unwrap_or_else(|| panic!("{} was given pin {pin}", self.number));
            // Replies keep the order of the requests, so the requests before it got none.
            self.given_up += at as u32;
            self.waiting.drain(..=at);
            self.answered += 1;
        }
        let now = bench.now;
        while self
            .waiting
            .front()
            .is_some_and(|(_, at)| at + 3_000 * MS <= now)
        {
            self.waiting.pop_front();
            self.given_up += 1;
        }
        while self.waiting.len() < self.window {
            // No two clients share a pin, so a reply shows whose it is.
            let pin = 1 + self.number as u8 * PINS + self.next;
            self.next = (self.next + 1) % PINS;
            self.waiting.push_back((pin, now));
            bench.say(self.number, &get_output(pin));
        }
    }
}

#[test]
fn every_client_gets_its_answers_and_no_others() {
    let hard = Faults {
        lose: 30,
        late: (30, 400 * MS),
    };
    for (faults, seeds) in [(NONE, 1), (hard, 40)] {
        for seed in 0..seeds {
            let mut bench = ProxyRig::new(Settings::default(), faults, seed);
            let mut askers = [1, 1, 3].into_iter().zip(0..);
            let mut askers: Vec<Asker> = askers
                .by_ref()
                .map(|(window, number)| Asker::new(number, window))
                .collect();
            askers.iter().for_each(|asker| bench.open(asker.number));
            while bench.now < 20_000 * MS {
                askers.iter_mut().for_each(|asker| asker.turn(&mut bench));
                // If all frames are lost at once, the next event is a timeout of a client, so a
                // step takes at most 1 s.
                bench.step(bench.now + 1_000 * MS);
            }
            let counts: Vec<u32> = askers.iter().map(|asker| asker.answered).collect();
            let lost: u32 = askers.iter().map(|asker| asker.given_up).sum();
            if seeds == 1 {
                assert_eq!(lost, 0);
                // A round trip takes 2 ms, and clients take turns.
                assert!(counts.iter().all(|count| *count >= 3_300), "{counts:?}");
            } else {
                assert!(counts.iter().all(|count| *count > 5), "{seed}: {counts:?}");
                assert!(lost > 0, "{seed}");
            }
        }
    }
}

#[test]
fn a_second_terminal_costs_the_first_nothing() {
    let mut bench = ProxyRig::with_clients(2);
    let mut counts = [0, 0];
    let mut last = [0, 0];
    let pose = get::<DeviceTime>();
    bench.say(0, &pose);
    bench.say(1, &pose);
    while bench.now < 1_000 * MS {
        bench.step(1_000 * MS);
        for (number, (count, last)) in (0..).zip(counts.iter_mut().zip(&mut last)) {
            for frame in bench.received(number) {
                let time = frame.frame().read::<DeviceTime>().unwrap().g_systick;
                assert!(time > *last || *count == 0, "nobody is told the same twice");
                (*count, *last) = (*count + 1, time);
                bench.say(number, &pose);
            }
        }
    }
    // A second has 500 round trips of 2 ms, and both clients share each.
    assert!(counts.iter().all(|count| *count >= 498), "{counts:?}");
    assert!(bench.sent.len() <= 502, "{}", bench.sent.len());
    let shared = |event: &&Event| matches!(event, Event::Reply { shared: true, .. });
    assert!(bench.events.iter().filter(shared).count() >= 498);
}

#[test]
fn shared_reply_is_no_older_than_max_reply_age() {
    let mut bench = ProxyRig::with_clients(3);
    let time = get::<DeviceTime>();
    let read = |frame: FrameBuf| frame.frame().read::<DeviceTime>().unwrap().g_systick;
    let first = read(bench.ask(0, &time));
    bench.say(0, &time);
    bench.run_for(2 * MS);
    let again = bench.received(0);
    assert_eq!(again.len(), 1);
    let again = read(again[0]);
    assert!(again > first);
    bench.run_for(19 * MS);
    bench.say(1, &time);
    assert_eq!(
        bench.received(1).into_iter().map(read).collect::<Vec<_>>(),
        [again]
    );
    bench.run_for(MS);
    bench.say(2, &time);
    assert!(bench.received(2).is_empty(), "20 ms are over");
    bench.run_for(2 * MS);
    let latest = bench.received(2);
    assert!(read(latest[0]) > again);
    assert_eq!(bench.sent.len(), 3);
}

#[test]
fn zero_max_reply_age_sends_every_get_to_the_arm() {
    let settings = Settings {
        max_reply_age: 0,
        ..Settings::default()
    };
    let mut bench = ProxyRig::new(settings, NONE, 1);
    (0..3).for_each(|number| bench.open(number));
    (0..3).for_each(|number| bench.say(number, &get::<Pose>()));
    bench.run_for(20 * MS);
    assert!((0..3).all(|number| bench.received(number).len() == 1));
    assert_eq!(bench.sent.len(), 3);
}

#[test]
fn what_may_not_be_shared_is_asked_for_each() {
    let taught = FrameBuf::new(42, Ctrl::GET, &[]).unwrap();
    let last_pin = FrameBuf::new(<IoDo as Readable>::ROW.id, Ctrl::GET, &[]).unwrap();
    let unknown = FrameBuf::new(99, Ctrl::GET, &[]).unwrap();
    for frame in [taught, last_pin, unknown, ratio(40.0)] {
        let mut bench = ProxyRig::with_clients(2);
        bench.say(0, &frame);
        bench.say(1, &frame);
        bench.run_for(2_000 * MS);
        // A fence separates two unanswered requests.
        bench.sent.retain(|frame| frame.frame().id() != 246);
        assert_eq!(bench.sent, [frame; 2]);
    }
    let mut bench = ProxyRig::with_clients(2);
    bench.say(0, &get_output(1));
    bench.say(1, &get_output(2));
    bench.run_for(20 * MS);
    assert_eq!(bench.sent, [get_output(1), get_output(2)]);
    bench.say(0, &get_output(2));
    assert_eq!(
        bench.received(0).len(),
        2,
        "the same pin is the same question"
    );
}

#[test]
fn every_get_of_the_table_but_one_can_be_shared() {
    let apart: Vec<u8> = (0..=255)
        .filter_map(Row::with_id)
        .filter(|row| row.value.is_some() && !row.only_looks(Ctrl::GET))
        .map(|row| row.id)
        .collect();
    assert_eq!(apart, [42]);
}

#[test]
fn get_after_set_returns_the_set_value() {
    let mut bench = ProxyRig::with_clients(2);
    let read = get::<PtpCommonParams>();
    bench.say(1, &read);
    for percent in 1..=99u8 {
        let percent = f32::from(percent);
        // Both at once: the read must not get the reply that the watcher requested before the set.
        bench.say(0, &ratio(percent));
        bench.say(0, &read);
        for _ in 0..20 {
            bench.step(bench.now + MS);
            if !bench.received(1).is_empty() {
                bench.say(1, &read);
            }
        }
        let answers = bench.received(0);
        assert_eq!(answers.len(), 2);
        let value = answers[1].frame().read::<PtpCommonParams>().unwrap();
        assert_eq!(value.velocity_ratio, percent);
    }
}

#[test]
fn a_stop_overtakes_all_that_waits() {
    let mut bench = ProxyRig::with_clients(3);
    for _ in 0..20 {
        bench.say(0, &get::<Pose>());
        bench.say(1, &ratio(10.0));
        bench.say(2, &get_output(3));
    }
    let before = bench.sent.len();
    assert_eq!(before, 1, "one in flight");
    bench.say(2, &set(&QueuedCmdForceStopExec {}));
    bench.say(2, &set(&QueuedCmdClear {}));
    assert_eq!(
        bench.ids_sent()[before..],
        [242],
        "at once, beside the one in flight"
    );
    bench.run_for(2 * MS);
    assert_eq!(bench.ids_sent()[before + 1], 245);
    bench.run_for(1_000 * MS);
    assert_eq!(bench.received(0).len(), 20);
    assert_eq!(bench.received(1).len(), 20, "other clients lose nothing");
    let own = bench.received(2);
    let ids: Vec<u8> = own.iter().map(|frame| frame.frame().id()).collect();
    let mut expected = vec![131; 20];
    expected.extend([242, 245]);
    assert_eq!(ids, expected, "and the client sees its own order");
}

#[test]
fn nothing_that_a_stop_overtook_comes_after_it() {
    let mut bench = ProxyRig::with_clients(2);
    bench.say(1, &get::<Pose>());
    let start = set(&QueuedCmdStartExec {});
    bench.say(0, &start);
    bench.say(0, &jog(JogCommand::Axis1Plus));
    bench.say(0, &set(&QueuedCmdForceStopExec {}));
    bench.run_for(500 * MS);
    assert_eq!(bench.ids_sent(), [10, 242]);
    let ids: Vec<u8> = (bench.received(0).iter())
        .map(|frame| frame.frame().id())
        .collect();
    assert_eq!(ids, [242]);
    let dropped = |event: &&Event| {
        matches!(
            event,
            Event::Dropped {
                reason: Reason::Stopped,
                ..
            }
        )
    };
    assert_eq!(bench.events.iter().filter(dropped).count(), 2);
    bench.ask(0, &start);
}

#[test]
fn a_stop_whose_first_answer_was_lost_is_answered_the_second_time() {
    let mut bench = ProxyRig::with_clients(1);
    let stop = set(&QueuedCmdForceStopExec {});
    bench.faults.lose = 1_000;
    bench.say(0, &stop);
    bench.run_for(3_000 * MS);
    assert!(bench.received(0).is_empty(), "as from the arm");
    bench.faults.lose = 0;
    bench.ask(0, &stop);
    assert_eq!(bench.ids_sent(), [242, 246, 242], "with a fence before it");
}

/// A bench whose client 0 reads a pin, with a reply delayed by this time.
fn answering_after(late: Micros) -> ProxyRig {
    let mut bench = ProxyRig::with_clients(2);
    bench.ask(0, &get::<Pose>());
    bench.say(0, &get_output(1));
    bench.run_for(MS);
    let (at, _) = bench.from_arm.front_mut().expect("an answer under way");
    *at += late;
    bench
}

fn count(bench: &ProxyRig, what: impl Fn(&Event) -> bool) -> usize {
    bench.events.iter().filter(|event| what(event)).count()
}

fn unanswered(event: &Event) -> bool {
    matches!(event, Event::Unanswered { .. })
}

/// True for an unclaimed reply about a pin. The reply to a fence may be late as well, and does not
/// count.
fn unclaimed(event: &Event) -> bool {
    let pin = <IoDo as Readable>::ROW.id;
    matches!(event, Event::Unclaimed { frame } if frame.frame().id() == pin)
}

#[test]
fn late_reply_goes_to_its_requester_and_does_not_block_the_line() {
    let mut bench = answering_after(1_500 * MS);
    bench.run_for(1_000 * MS);
    assert!(bench.received(0).is_empty());
    let before = bench.sent.len();
    bench.say(1, &get::<Pose>());
    assert_eq!(bench.ids_sent()[before..], [10], "the line is free");
    bench.run_for(1_000 * MS);
    let answers = bench.received(0);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].frame().params()[0], 1);
    assert_eq!(bench.received(1).len(), 1);
    assert_eq!(count(&bench, unanswered) + count(&bench, unclaimed), 0);
}

#[test]
fn repeated_requests_get_one_reply_each() {
    for asks_again_after in [10 * MS, 1_000 * MS] {
        let mut bench = answering_after(1_500 * MS);
        bench.run_for(asks_again_after);
        bench.say(0, &get_output(2));
        bench.run_for(3_000 * MS);
        let pins: Vec<u8> = (bench.received(0).iter())
            .map(|answer| answer.frame().params()[0])
            .collect();
        assert_eq!(pins, [1, 2]);
        assert_eq!(count(&bench, unanswered) + count(&bench, unclaimed), 0);
    }
}

#[test]
fn repeated_request_after_a_loss_gets_one_reply() {
    let mut bench = ProxyRig::with_clients(1);
    bench.faults.lose = 1_000;
    bench.say(0, &get_output(1));
    bench.run_for(800 * MS);
    bench.faults.lose = 0;
    bench.ask(0, &get_output(1));
    assert_eq!(count(&bench, unanswered), 1);
    assert_eq!(bench.ids_sent(), [131, 246, 131], "with a fence before it");
}

#[test]
fn pipelined_requests_all_get_replies_from_a_slow_arm() {
    let mut bench = ProxyRig::with_clients(1);
    bench.ask(0, &get::<Pose>());
    (1..=3).for_each(|pin| bench.say(0, &get_output(pin)));
    bench.run_for(MS);
    let (at, _) = bench.from_arm.front_mut().expect("an answer under way");
    *at += 300 * MS;
    bench.run_for(1_000 * MS);
    let pins: Vec<u8> = (bench.received(0).iter())
        .map(|answer| answer.frame().params()[0])
        .collect();
    assert_eq!(pins, [1, 2, 3]);
    assert_eq!(count(&bench, unanswered), 0);
}

#[test]
fn a_shared_answer_does_not_overtake_a_late_one() {
    let settings = Settings {
        max_reply_age: 10_000 * MS,
        ..Settings::default()
    };
    let mut bench = ProxyRig::new(settings, NONE, 1);
    (0..2).for_each(|number| bench.open(number));
    bench.ask(1, &get::<Pose>());
    bench.say(0, &get_output(1));
    bench.run_for(MS);
    let (at, _) = bench.from_arm.front_mut().expect("an answer under way");
    *at += 1_000 * MS;
    bench.run_for(500 * MS);
    bench.say(0, &get::<Pose>());
    bench.run_for(1_000 * MS);
    let ids: Vec<u8> = (bench.received(0).iter())
        .map(|answer| answer.frame().id())
        .collect();
    assert_eq!(ids, [131, 10]);
    assert_eq!(count(&bench, unanswered), 0);
}

#[test]
fn a_late_answer_is_never_anothers() {
    for stays in [true, false] {
        let mut bench = answering_after(30_000 * MS);
        bench.run_for(1_000 * MS);
        if !stays {
            bench.close(0);
            assert_eq!(count(&bench, unanswered), 1);
        }
        bench.say(1, &get_output(2));
        bench.run_for(40_000 * MS);
        let pins = |answers: Vec<FrameBuf>| -> Vec<u8> {
            (answers.iter())
                .map(|answer| answer.frame().params()[0])
                .collect()
        };
        assert_eq!(pins(bench.received(1)), [2]);
        assert_eq!(pins(bench.received(0)).len(), usize::from(stays));
        assert_eq!(count(&bench, unclaimed), usize::from(!stays));
    }
}

#[test]
fn missing_reply_is_given_up_after_a_minute() {
    let mut bench = ProxyRig::with_clients(1);
    bench.faults.lose = 1_000;
    bench.say(0, &get_output(1));
    bench.run_for(59_000 * MS);
    assert_eq!(count(&bench, unanswered), 0);
    bench.run_for(2_000 * MS);
    assert_eq!(count(&bench, unanswered), 1);
    assert_eq!(bench.proxy.poll_timeout(), None);
}

#[test]
fn sharer_of_a_lost_reply_gets_its_own_request() {
    let mut bench = ProxyRig::with_clients(2);
    bench.faults.lose = 1_000;
    bench.say(0, &get::<Pose>());
    bench.say(1, &get::<Pose>());
    assert_eq!(bench.sent.len(), 1);
    bench.run_for(MS);
    bench.faults.lose = 0;
    bench.run_for(2_000 * MS);
    assert!(bench.received(0).is_empty());
    assert_eq!(bench.received(1).len(), 1);
    // The fence, 246, shows that the first reply is lost.
    assert_eq!(bench.ids_sent(), [10, 246, 10]);
}

#[test]
fn queued_sets_never_go_out_twice() {
    let mut bench = ProxyRig::with_clients(1);
    let wait = FrameBuf::new(110, Ctrl::QUEUED, &[0; 4]).unwrap();
    bench.faults.lose = 1_000;
    bench.say(0, &wait);
    bench.run_for(10_000 * MS);
    assert_eq!(bench.sent, [wait]);
}

#[test]
fn closing_a_client_drops_its_waiting_requests_except_stops() {
    let mut bench = ProxyRig::with_clients(2);
    bench.say(1, &get::<Pose>());
    bench.say(0, &ratio(10.0));
    bench.close(0);
    bench.run_for(50 * MS);
    assert_eq!(bench.ids_sent(), [10]);

    bench.open(0);
    bench.say(1, &set(&QueuedCmdForceStopExec {}));
    bench.say(0, &set(&QueuedCmdClear {}));
    bench.close(0);
    bench.run_for(50 * MS);
    assert_eq!(bench.ids_sent(), [10, 242, 245]);
}

#[test]
fn a_jog_ends_when_its_client_leaves() {
    for (keep_going, lose) in [(false, 0), (false, 200), (true, 0)] {
        let settings = Settings {
            keep_going,
            ..Settings::default()
        };
        let mut bench = ProxyRig::new(settings, NONE, 5);
        bench.open(0);
        bench.open(1);
        bench.ask(0, &jog(JogCommand::Axis1Plus));
        bench.close(1);
        bench.run_for(100 * MS);
        assert!(bench.arm.state().moving, "it was not that client's");
        bench.faults.lose = lose;
        bench.close(0);
        bench.run_for(if lose == 0 { 200 } else { 20_000 } * MS);
        let ended = bench.sent.last() == Some(&jog(JogCommand::Stop));
        assert_eq!(ended, !keep_going);
        assert_eq!(bench.arm.state().moving, keep_going);
        assert!(!bench.proxy.is_letting_go());
    }
}

#[test]
fn stopped_jog_has_no_owner() {
    let mut bench = ProxyRig::with_clients(1);
    bench.ask(0, &jog(JogCommand::Axis1Plus));
    bench.ask(0, &jog(JogCommand::Stop));
    bench.close(0);
    bench.run_for(100 * MS);
    assert_eq!(bench.sent.len(), 2);
}

#[test]
fn a_lost_line_is_silence_and_nothing_is_done_later() {
    let mut bench = ProxyRig::with_clients(2);
    bench.ask(0, &jog(JogCommand::Axis1Plus));
    bench.say(1, &get::<Pose>());
    bench.say(0, &ratio(10.0));
    bench.proxy.lose_line();
    bench.from_arm.clear();
    bench.to_arm.clear();
    bench.say(1, &ratio(20.0));
    bench.run_for(1_000 * MS);
    assert!(bench.received(0).is_empty() && bench.received(1).is_empty());
    let sent = bench.sent.len();
    bench.proxy.find_line();
    bench.run_for(1_000 * MS);
    assert_eq!(bench.sent[sent..], [jog(JogCommand::Stop)]);
    bench.ask(1, &get::<Pose>());
}

#[test]
fn noise_and_damaged_frames_do_not_affect_other_clients() {
    let mut damaged = ratio(10.0).bytes().to_vec();
    *damaged.last_mut().unwrap() ^= 1;
    for transparent in [false, true] {
        let settings = Settings {
            transparent,
            ..Settings::default()
        };
        let mut bench = ProxyRig::new(settings, NONE, 1);
        bench.open(0);
        bench.open(1);
        let bytes = [b"M10\r\n".as_slice(), &damaged, get_output(1).bytes()].concat();
        bench.proxy.receive(bench.now, Client(0), &bytes);
        bench.say(1, &get_output(2));
        bench.run_for(100 * MS);
        assert_eq!(bench.received(0).len(), 1);
        assert_eq!(bench.received(1).len(), 1);
        let foreign = bench.events.iter().filter_map(|event| match event {
            Event::Foreign { bytes, passed, .. } => Some((bytes.bytes().len(), *passed)),
            _ => None,
        });
        let told: usize = foreign
            .map(|(count, passed)| {
                assert_eq!(passed, transparent);
                count
            })
            .sum();
        assert_eq!(told, 5 + damaged.len());
    }
}

#[test]
fn half_a_frame_is_given_up() {
    let mut bench = ProxyRig::with_clients(1);
    let frame = ratio(10.0);
    bench.proxy.receive(0, Client(0), &frame.bytes()[..7]);
    bench.run_for(100 * MS);
    bench.ask(0, &get::<Pose>());
    assert_eq!(bench.ids_sent(), [10]);
}

#[test]
fn a_client_that_sends_without_end_is_bounded() {
    let mut bench = ProxyRig::with_clients(2);
    for _ in 0..1_000 {
        bench.say(0, &ratio(1.0));
    }
    assert_eq!(bench.proxy.room(Client(0)), 0);
    assert!(bench.proxy.room(Client(1)) > 0);
    bench.say(1, &get::<Pose>());
    bench.say(0, &set(&QueuedCmdForceStopExec {}));
    bench.run_for(10 * MS);
    assert_eq!(bench.received(1).len(), 1);
    assert!(bench.ids_sent().contains(&242), "a stop has room");
    bench.run_for(1_000 * MS);
    assert!(bench.proxy.room(Client(0)) > 0);
}

#[test]
fn datagram_replies_are_separated_by_time_only() {
    let settings = Settings {
        line: connection::Settings::DATAGRAMS,
        ..Settings::default()
    };
    let mut bench = ProxyRig::new(settings, NONE, 1);
    bench.open(0);
    bench.open(1);
    bench.faults.lose = 1_000;
    bench.say(0, &get_output(1));
    bench.run_for(1_000 * MS);
    bench.faults.lose = 0;
    bench.say(1, &get_output(2));
    bench.ask(0, &get::<Pose>());
    assert!(
        bench.received(1).is_empty(),
        "an answer to the first may still come"
    );
    bench.run_for(2_000 * MS);
    assert_eq!(bench.received(1).len(), 1);
    assert_eq!(bench.ids_sent(), [131, 10, 131], "without fences");
}

#[test]
fn any_bytes_from_anywhere_do_no_harm() {
    for seed in 0..100 {
        let mut bench = ProxyRig::new(Settings::default(), NONE, seed);
        (0..3).for_each(|number| bench.open(number));
        let mut dice = Dice::new(seed);
        for _ in 0..200 {
            let frame = FrameBuf::new(
                dice.below(256) as u8,
                Ctrl(dice.below(256) as u8),
                &vec![dice.below(256) as u8; dice.below(30) as usize],
            );
            let mut bytes = frame.unwrap().bytes().to_vec();
            if dice.below(1000) < 300 {
                let at = dice.below(bytes.len() as u64) as usize;
                bytes[at] = dice.below(256) as u8;
            }
            match dice.below(12) {
                0 => bench.proxy.receive_from_arm(bench.now, &bytes),
                1 => bench.close(dice.below(3) as u32),
                2 => bench.open(dice.below(3) as u32),
                3 => bench.proxy.lose_line(),
                4 | 5 => bench.proxy.find_line(),
                number => {
                    let client = Client(number as u32 % 3);
                    bench.proxy.receive(bench.now, client, &bytes);
                }
            }
            bench.exchange();
            bench.run_for(dice.below(40) * MS);
        }
        // New clients are served whatever happened before.
        bench.proxy.find_line();
        bench.run_for(60_000 * MS);
        bench.open(9);
        bench.say(9, &get::<Pose>());
        bench.run_for(5_000 * MS);
        assert_eq!(bench.received(9).len(), 1, "{seed}");
    }
}

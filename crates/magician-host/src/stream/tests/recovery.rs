use magician_protocol::commands::QueuedCmdStartExec;
use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::LinkId;

use super::rig::{Rig, SECOND, START, increment, path, segment, wait};
use crate::connection::{Failure, Request, Settings};
use crate::pair::{Dice, Faults};
use crate::stream::drive::Phase;
use crate::stream::line::distance_to_segment;
use crate::stream::{Item, LINE_TOLERANCE, StreamEvent, StreamFailure, StreamSettings};

const FOUR: Settings = Settings {
    window: 4,
    ..Settings::ORDERED
};

fn four(program: &[Item]) -> Rig {
    let settings = StreamSettings {
        window: 4,
        ..StreamSettings::default()
    };
    Rig::new(FOUR, settings, program)
}

fn recoveries(rig: &Rig) -> usize {
    let recovered = |event: &&StreamEvent| matches!(event, StreamEvent::Recovered { .. });
    rig.events.iter().filter(recovered).count()
}

/// Asserts that the program's line was drawn: no command ran twice or out of order, and the targets
/// of lost ones lie on a line that was drawn.
fn same_line(done: &[usize], program: &[Item]) {
    assert!(done.is_sorted_by(|one, next| one < next), "{done:?}");
    assert_eq!(done.last(), Some(&(program.len() - 1)), "{done:?}");
    let place = |at: usize| {
        let [x, y, z, _] = program[at].end.unwrap();
        [x, y, z]
    };
    let mut before = None;
    for at in done {
        let from = before.map_or(START, place);
        for lost in before.map_or(0, |before| before + 1)..*at {
            let off = distance_to_segment(place(lost), from, place(*at));
            assert!(off <= LINE_TOLERANCE, "{lost} is {off} off: {done:?}");
        }
        before = Some(*at);
    }
}

#[test]
fn several_travel_at_once() {
    let program = path(200, 1.5, 15_000);
    let mut rig = four(&program);
    let mut most = 0;
    while !rig.stream.is_over() {
        rig.turn(60 * SECOND);
        most = most.max(rig.stream.flying());
    }
    assert_eq!(rig.failure(), None);
    assert_eq!(most, 4);
    assert_eq!(rig.done(&program), (0..200).collect::<Vec<_>>());
    assert_eq!(recoveries(&rig), 0);
}

/// A path of which the arm executes eight segments between two readings, so that four are in flight
/// at once while it runs.
fn quick() -> Vec<Item> {
    path(120, 0.48, 20_000)
}

/// Runs until a number of commands is taken, with four in flight and more ready, and loses a
/// request or a reply.
fn with_loss(program: &[Item], request: bool, after: usize) -> Rig {
    let mut rig = four(program);
    let flows = |rig: &Rig| rig.stream.flying() == 4 && rig.stream.credit() > 2;
    while rig.pair.accepted.len() < after || !flows(&rig) {
        assert!(!rig.stream.is_over());
        rig.turn(60 * SECOND);
    }
    if request {
        rig.pair.lose_next_request();
    } else {
        rig.pair.lose_next_reply();
    }
    rig
}

/// Losses of a request (true) or of a reply, each after a number of commands taken: while the queue
/// is filled, and while the arm runs.
const LOSSES: [(bool, usize); 5] = [(true, 10), (false, 10), (true, 47), (false, 48), (true, 90)];

#[test]
fn a_loss_between_others_leaves_the_line() {
    for (request, after) in LOSSES {
        let program = quick();
        let mut rig = with_loss(&program, request, after);
        assert_eq!(rig.started.is_empty(), after < 32);
        rig.run(120 * SECOND).unwrap();
        same_line(&rig.done(&program), &program);
        assert_eq!(recoveries(&rig), 1, "{request} {after}");
        assert_eq!(rig.reported_accepted, program.len() as u64);
    }
}

/// Strokes with sharp corners and lifts between them, and some short segments along a line.
fn corners() -> Vec<Item> {
    let mut places = Vec::new();
    for stroke in 0..6 {
        let (x, y) = (
            205.0 + 5.0 * f64::from(stroke),
            -20.0 + 7.0 * f64::from(stroke),
        );
        places.extend([[x, y, 8.0], [x, y, 0.0], [x + 3.0, y, 0.0]]);
        places.extend([[x + 3.0, y + 5.0, 0.0], [x - 2.0, y + 1.0, 0.0]]);
        places.extend((1..=5).map(|at| [x - 2.0 + 0.3 * f64::from(at), y + 1.0, 0.0]));
        places.push([x - 0.5, y + 1.0, 9.0 + f64::from(stroke)]);
    }
    // Corners take a fraction of the 3 s given here. So the queue runs dry, and a command behind a
    // loss begins before the loss shows. Only the short segments and the last lift of a stroke have
    // fractional x coordinates.
    let time = |[x, ..]: &[f64; 3]| if x.fract() == 0.0 { 3 * SECOND } else { 1_000 };
    places
        .into_iter()
        .map(|at| segment(at, time(&at)))
        .collect()
}

#[test]
fn any_single_loss_at_any_window_draws_the_same_line() {
    let program = corners();
    let mut back = 0;
    for window in [2, 4, 8] {
        for (after, request) in (2..program.len())
            .step_by(3)
            .flat_map(|after| [(after, true), (after, false)])
        {
            let line = Settings { window, ..FOUR };
            let settings = StreamSettings {
                window,
                ..StreamSettings::default()
            };
            let mut rig = Rig::new(line, settings, &program);
            while rig.pair.accepted.len() < after {
                rig.turn(60 * SECOND);
            }
            if request {
                rig.pair.lose_next_request();
            } else {
                rig.pair.lose_next_reply();
            }
            rig.run(600 * SECOND).unwrap();
            same_line(&rig.done(&program), &program);
            back += recoveries(&rig);
        }
    }
    assert!(back > 0, "{back}");
}

#[test]
fn a_corner_and_a_lift_travel_alone() {
    let mut rig = four(&corners());
    let mut most = 0;
    while !rig.stream.is_over() {
        rig.turn(60 * SECOND);
        let flying = rig
            .stream
            .entries
            .iter()
            .filter(|entry| entry.is_in_flight());
        let places = flying.clone().filter_map(|entry| entry.place());
        let is_corner = |[x, ..]: [f64; 3]| x.fract() == 0.0;
        let count = flying.count();
        assert!(count == 1 || !places.into_iter().any(is_corner));
        most = most.max(count);
    }
    assert_eq!(rig.failure(), None);
    assert_eq!(most, 4);
}

#[test]
fn a_bad_line_is_recovered_from_until_the_rest_goes_one_by_one() {
    let mut back = 0;
    for seed in 0..8 {
        let program = path(200, 1.5, 15_000);
        let mut rig = four(&program);
        // The first index is known before the line turns bad.
        while rig.pair.accepted.len() < 5 {
            rig.turn(60 * SECOND);
        }
        rig.pair.dice = Dice::new(seed);
        rig.pair.set_faults(Faults {
            drop_chunk: 0.015,
            flip: 0.00075,
            ..Faults::default()
        });
        rig.run(600 * SECOND).unwrap();
        same_line(&rig.done(&program), &program);
        back += recoveries(&rig);
    }
    // With less than one recovery per seed the line would be too good for this test.
    assert!(back > 8, "{back}");
}

#[test]
fn non_idempotent_commands_are_sent_alone_and_executed_once() {
    let mut program = Vec::new();
    for part in path(90, 1.5, 15_000).chunks(10) {
        program.extend_from_slice(part);
        let [x, y, z, _] = part[9].end.unwrap();
        let step = program.len() as f64 / 1000.0;
        program.push(increment([x, y, z], [0.5 + step, 0.0, 0.0], 20_000));
        program.push(wait(20 + program.len() as u32, [x + 0.5 + step, y, z]));
    }
    let once: Vec<_> = (0..program.len()).filter(|at| at % 12 >= 10).collect();
    let mut failed = 0;
    for seed in 0..10 {
        let mut rig = four(&program);
        while rig.pair.accepted.len() < 5 {
            rig.turn(60 * SECOND);
        }
        rig.pair.dice = Dice::new(seed);
        rig.pair.set_faults(Faults {
            drop_chunk: 0.01,
            flip: 0.0005,
            ..Faults::default()
        });
        let outcome = rig.run(600 * SECOND);
        failed += u32::from(outcome.is_err());
        let done = rig.done(&program);
        let often = |at: &usize| done.iter().filter(|done| *done == at).count();
        assert!(
            once.iter().all(|at| often(at) <= 1),
            "seed {seed}: {done:?}"
        );
        if outcome.is_ok() {
            assert!(
                once.iter().all(|at| often(at) == 1),
                "seed {seed}: {done:?}"
            );
            same_line(&done, &program);
        }
    }
    // If all runs failed, none would show that each command is done exactly once.
    assert!(failed < 10, "{failed}");
}

#[test]
fn program_resumes_after_a_line_break_at_any_instant_of_a_recovery() {
    for (request, after) in LOSSES {
        let program = quick();
        for turns in 0.. {
            let mut rig = with_loss(&program, request, after);
            for _ in 0..turns {
                rig.turn(60 * SECOND);
            }
            if recoveries(&rig) > 0 && rig.stream.flows() {
                println!("{request} {after}: {turns} instants");
                assert!(turns > 20, "{turns}");
                break;
            }
            rig.interrupt();
            // Three lengths of interruption in turn, as all three at each instant would triple the
            // runs.
            let back = rig.pair.now + [0, 40_000, 2 * SECOND][turns % 3];
            rig.pair.run_until(back);
            rig.resume();
            if let Err(failure) = rig.run(120 * SECOND) {
                panic!("{request} after {after}, turn {turns}: {failure}");
            }
            same_line(&rig.done(&program), &program);
        }
    }
}

#[test]
fn a_line_that_breaks_at_any_instant_of_a_path_is_gone_on_from() {
    let program = quick();
    let mut turns = 0;
    loop {
        let mut rig = four(&program);
        for _ in 0..turns {
            rig.turn(60 * SECOND);
        }
        if rig.stream.is_over() {
            break;
        }
        rig.interrupt();
        rig.resume();
        rig.run(120 * SECOND).unwrap();
        same_line(&rig.done(&program), &program);
        // Every ninth instant limits the number of runs.
        turns += 9;
    }
    assert!(turns > 200, "{turns}");
}

#[test]
fn an_arm_that_is_reset_while_its_queue_drains_gets_no_more_of_the_program() {
    let program = quick();
    let mut rig = four(&program);
    // The arm has executed something, so its count can go back; after the reset it stands where it
    // did.
    let start = Request::set(&QueuedCmdStartExec {}).unwrap();
    rig.pair.ask(start, SECOND).unwrap();
    let wait = Request::raw(110, Ctrl::QUEUED, &[10, 0, 0, 0]).unwrap();
    rig.pair.ask(wait, SECOND).unwrap();
    rig.pair.run_until(SECOND);
    rig.pair.accepted.clear();
    while rig.pair.accepted.len() < 10 || rig.stream.flying() < 4 {
        rig.turn(60 * SECOND);
    }
    rig.pair.lose_next_request();
    while !matches!(rig.stream.phase, Phase::Drain { .. }) {
        rig.turn(60 * SECOND);
    }
    rig.pair.power_cycle();
    let heard = rig.pair.heard.len();
    let failure = rig.run(60 * SECOND).unwrap_err();
    assert!(matches!(failure, StreamFailure::Reset { .. }), "{failure}");
    let sets = |frame: &FrameBuf| frame.frame().ctrl().write();
    assert!(!rig.pair.heard[heard..].iter().any(sets));
}

#[test]
fn a_queue_with_commands_of_others_is_never_cleared_nor_stopped() {
    let program = quick();
    for seed in 0..4 {
        let mut rig = four(&program);
        let wait = FrameBuf::new(110, Ctrl::QUEUED, &[200, 0, 0, 0]).unwrap();
        for _ in 0..20 {
            rig.pair.arm.receive(LinkId(7), wait.bytes());
        }
        rig.pair.dice = Dice::new(seed);
        let outcome = loop {
            if rig.stream.is_over() {
                break rig.failure();
            }
            rig.turn(120 * SECOND);
            // The first index is known before the line turns bad.
            if rig.pair.accepted.len() == 3 {
                rig.pair.set_faults(Faults {
                    drop_chunk: 0.02,
                    ..Faults::default()
                });
            }
            let others_wait = rig.pair.arm.state().queue.current_index < 21;
            // StopExec, ForceStopExec and Clear act on the commands of others, too.
            let steered = |frame: &FrameBuf| [241, 242, 245].contains(&frame.frame().id());
            assert!(!others_wait || !rig.pair.heard.iter().any(steered));
        };
        match outcome {
            None => {
                assert_eq!(rig.started[..20], (2..=21).collect::<Vec<_>>());
                same_line(&rig.done(&program), &program);
            }
            // Until the others have finished, the fate of a command is unknown.
            Some(failure) => assert!(
                matches!(failure, StreamFailure::Request(Failure::Uncertain { .. })),
                "{failure}"
            ),
        }
    }
}

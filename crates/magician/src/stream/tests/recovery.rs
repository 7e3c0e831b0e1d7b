use super::rig::{Rig, SECOND, increment, path, wait};
use crate::connection::Settings;
use crate::pair::{Dice, Faults};
use crate::stream::{Item, StreamEvent, StreamSettings};

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

/// Every vertex was passed, and after the last time each was passed only later ones came.
fn all_passed(done: &[usize], count: usize) {
    let mut last = vec![None; count];
    for (when, at) in done.iter().enumerate() {
        last[*at] = Some(when);
    }
    assert!(last.iter().all(Option::is_some), "{done:?}");
    assert!(last.is_sorted(), "{done:?}");
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

#[test]
fn a_loss_between_others_is_gone_back_to() {
    for (request, after) in [(true, 10), (false, 10), (true, 47), (false, 48), (true, 90)] {
        let program = path(120, 1.5, 15_000);
        let mut rig = four(&program);
        while rig.pair.accepted.len() < after {
            rig.turn(60 * SECOND);
        }
        match request {
            true => rig.pair.lose_next_request(),
            false => rig.pair.lose_next_reply(),
        }
        rig.run(120 * SECOND).unwrap();
        all_passed(&rig.done(&program), 120);
    }
}

#[test]
fn a_bad_line_is_gone_back_on_until_the_rest_goes_one_by_one() {
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
        all_passed(&rig.done(&program), 200);
        back += recoveries(&rig);
    }
    assert!(back > 8, "{back}");
}

#[test]
fn what_must_not_be_done_twice_travels_alone_and_is_done_once() {
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
            all_passed(&done, program.len());
        }
    }
    assert!(failed < 10, "{failed}");
}

//! A lossy line does not change a drawing: it is the same in the end, or the run stops and says
//! where.
//!
//! `cargo xtask soak drawing` runs the same for any length of time.

mod datagrams;
mod ink;
mod programs;
mod rig;
mod sheet;
mod troubles;
mod verdict;

use std::path::Path;

use ink::Ink;
use magician::faults::Faults;
use magician_program::Plan;
use programs::PROGRAMS;
use rig::{FaultSetup, Outcome, draw, draw_at, on_virtual_clock};
use sheet::{Passage, Row};
use verdict::{Verdict, drawn, judge};

fn plan(name: &str) -> Plan {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    programs::plan(&samples, name).unwrap()
}

fn faults(text: &str, seed: u64) -> Faults {
    format!("{text},seed={seed}").parse().unwrap()
}

/// Runs a plan through faults; returns the outcome and its class.
fn run_and_judge(plan: &Plan, trouble: FaultSetup) -> (Outcome, Verdict) {
    let right = drawn(plan, None);
    assert!(!right.is_empty(), "{}", plan.title);
    let outcome = on_virtual_clock(draw(plan, trouble)).unwrap();
    match judge(plan, &right, trouble, &outcome) {
        Ok(came) => (outcome, came),
        Err(why) => panic!("{trouble:?}: {why}; {:?}", outcome.end),
    }
}

/// Runs a program through every kind of fault, each with its own seeds; mostly at window 1, some at
/// 4.
fn run_under_all_faults(program: usize) {
    let name = PROGRAMS[program];
    let plan = plan(name);
    let mut whole = 0;
    for (nth, text) in troubles::SERIAL_FAULTS.iter().enumerate() {
        let seed = (100 * program + nth) as u64;
        let window = if (program + nth).is_multiple_of(3) {
            4
        } else {
            1
        };
        let trouble = FaultSetup {
            faults: faults(text, seed),
            window,
        };
        let (outcome, came) = run_and_judge(&plan, trouble);
        println!(
            "{name}, {text}, seed {seed}, window {window}: {came:?}, interrupted {} times, {:?} requests and sent again{}",
            outcome.between.len(),
            outcome.requests,
            outcome
                .end
                .err()
                .map_or_else(String::new, |error| format!("; {error}"))
        );
        whole += usize::from(came != Verdict::Stopped);
    }
    assert!(whole >= 3, "{name}: only {whole} of 6 whole");
}

#[test]
fn shapes_survive_faults() {
    run_under_all_faults(0);
}

#[test]
fn curves_survive_faults() {
    run_under_all_faults(1);
}

#[test]
fn g_code_survives_faults() {
    run_under_all_faults(2);
}

#[test]
fn laser_program_survives_faults() {
    run_under_all_faults(3);
}

#[test]
fn image_survives_faults() {
    run_under_all_faults(4);
}

#[test]
fn pulled_cable_does_not_change_the_drawing() {
    let plan = plan("house.svg");
    let all = Ink::of(&drawn(&plan, None)).length();
    let mut in_the_middle = 0;
    for seed in 0..6 {
        let trouble = FaultSetup {
            faults: faults("unplug=2e-3,unplug-ms=900", seed),
            window: 1,
        };
        let (outcome, came) = run_and_judge(&plan, trouble);
        assert_eq!(came, Verdict::Same, "seed {seed}");
        let begun = outcome.between.iter().map(|part| Ink::of(part).length());
        in_the_middle += begun.filter(|ink| *ink > 1.0 && *ink < all - 1.0).count();
    }
    assert!(in_the_middle >= 5, "{in_the_middle}");
}

#[test]
fn restart_of_the_arm_is_reported_with_the_steps_in_doubt() {
    let plan = plan("curves.svg");
    let mut stopped = 0;
    for seed in 0..4 {
        let trouble = FaultSetup {
            faults: faults("reset=4e-3", seed),
            window: 1,
        };
        let (outcome, came) = run_and_judge(&plan, trouble);
        let Err(error) = outcome.end else { continue };
        assert_eq!(came, Verdict::Stopped, "seed {seed}");
        assert_eq!(error.kind(), magician::ErrorKind::Uncertain, "{error}");
        assert!(error.from_index() <= error.to_index(), "{error}");
        stopped += 1;
    }
    assert!(stopped >= 2, "{stopped}");
}

#[test]
fn same_seed_gives_the_same_faults() {
    let plan = plan("pen_outline.gcode");
    let trouble = FaultSetup {
        faults: faults(troubles::SERIAL_FAULTS[2], 7),
        window: 4,
    };
    let [one, two] = [(); 2].map(|()| on_virtual_clock(draw(&plan, trouble)).unwrap());
    assert_eq!(one.drawing, two.drawing);
    assert_eq!(one.requests, two.requests);
    assert!(one.requests[1] > 0);
}

/// Runs a hard drawing over lines of one kind; counts the runs that report success, and their
/// faults.
fn run_hard_drawing(windows: &[usize], text: &str, pace: f64, runs: u64) -> Row {
    let plan = programs::hard(12).unwrap();
    let right = drawn(&plan, None);
    let mut row = Row::new(text);
    for (window, seed) in windows
        .iter()
        .flat_map(|window| (0..runs).map(move |seed| (*window, seed)))
    {
        let faults = faults(text, seed);
        let outcome =
            on_virtual_clock(draw_at(&plan, FaultSetup { faults, window }, pace)).unwrap();
        let wrong = row.add(&Passage {
            right: &right,
            drawn: &outcome.drawing,
            done: outcome.end.is_ok() && outcome.between.is_empty(),
            took: outcome.took,
            usual: outcome.took,
        });
        if let Some(wrong) = wrong {
            println!("window {window}, {faults}: {wrong}");
        }
        for why in &outcome.why {
            println!("window {window}, {faults}: {why}");
        }
    }
    println!("{}\n{}", Row::TABLE_HEAD, row.line());
    row
}

#[test]
fn run_reported_done_is_complete_at_every_window() {
    // The arm is faster than the host assumes, and acts on a loss before the host sees it.
    let row = run_hard_drawing(&[1, 2, 3, 4, 5, 6, 7, 8], "replace=2e-3", 20.0, 6);
    assert_eq!((row.runs, row.wrong), (48, 0));
    // Losing one command before the arm's first index is known ends a run at any window.
    assert!(row.done >= 40, "{row:?}");
}

#[test]
fn stalled_line_leaves_the_same_drawing() {
    for seconds in [1, 3, 8, 20] {
        let ms = seconds * 1000;
        let text = format!("stall=0.004,stall-min-ms={ms},stall-ms={ms}");
        let row = run_hard_drawing(&[1, 4], &text, 1.0, 4);
        assert_eq!((row.runs, row.wrong), (8, 0), "{row:?}");
        // Consecutive delays may last longer than a run waits.
        assert!(row.done >= 7, "{row:?}");
    }
}

/// Runs a drawing over datagrams; true if it ran to its end.
fn over_a_network(name: &str, text: &str, seed: u64) -> bool {
    let plan = plan(name);
    let all = Ink::of(&drawn(&plan, None));
    let came = datagrams::draw(&plan, faults(text, seed)).unwrap();
    let ink = Ink::of(&came.drawing);
    let said = format!(
        "{name}, {text}, seed {seed}: {:?}, resumed {} times, told of {}, {} requests, {:.2} of {:.2} mm",
        came.stopped,
        came.resumed,
        came.told,
        came.requests,
        ink.length(),
        all.length()
    );
    println!("{said}");
    let off = ink.distance_from_beginning_of(&all);
    assert!(
        off.is_some_and(|off| off <= ink::CORNER_ACCURACY),
        "{said}: {off:?}"
    );
    // A run stops at a command that was duplicated or is in doubt; earlier ones are done.
    let most = came.stopped.as_ref().map(|(_, taken)| taken + 1);
    let most = Ink::of(&drawn(&plan, most)).length();
    assert!(
        ink.length() <= most + ink::CORNER_ACCURACY,
        "{said}: {most}"
    );
    let ended = came.stopped.is_none();
    assert!(
        !ended || ink.length() >= most - ink::CORNER_ACCURACY,
        "{said}"
    );
    ended
}

#[test]
fn lossy_network_leaves_the_same_drawing() {
    let text = troubles::NETWORK_FAULTS[0];
    let whole = (0..)
        .zip(PROGRAMS)
        .filter(|(seed, name)| over_a_network(name, text, *seed));
    assert!(whole.count() >= 4);
}

#[test]
fn few_lost_or_duplicated_datagrams_cost_only_time() {
    let plan = plan("house.svg");
    let all = Ink::of(&drawn(&plan, None));
    let good = datagrams::draw(&plan, Faults::NONE).unwrap();
    let (mut slowest, mut told) = (0, 0);
    for seed in 0..20 {
        let faults = faults("drop-chunk=0.02,duplicate-chunk=0.01", seed);
        let came = datagrams::draw(&plan, faults).unwrap();
        assert_eq!(came.stopped, None, "seed {seed}");
        assert_eq!(came.resumed, 0, "seed {seed}");
        // A segment replanned within a period leaves a chord of up to a period's distance (2 mm at
        // 100 mm/s) on its line: at 150 mm from the base that is 2 * 2 / (8 * 150) = 0.004 mm
        // beside it.
        let ink = Ink::of(&came.drawing);
        let off = ink.distance_from_beginning_of(&all);
        assert!(
            off.is_some_and(|off| off <= ink::CORNER_ACCURACY)
                && (ink.length() - all.length()).abs() <= ink::CORNER_ACCURACY,
            "seed {seed}: {off:?}"
        );
        slowest = came.lasted.max(slowest);
        told += came.told;
    }
    println!(
        "{slowest} us at most, {} us without a loss, {told} doubled",
        good.lasted
    );
    assert!(slowest < 2 * good.lasted, "{slowest} {}", good.lasted);
    assert!(told > 0);
}

#[test]
fn duplicated_datagrams_stop_a_drawing_or_leave_it_unchanged() {
    for (seed, name) in (0..).zip(PROGRAMS) {
        over_a_network(name, troubles::NETWORK_FAULTS[1], seed);
    }
}

//! A lossy line does not change a drawing: it is the same in the end, or it stops and says where.

mod ink;
mod programs;
mod rig;
mod verdict;

use std::collections::BTreeMap;

use magician::faults::Faults;
use programs::{PROGRAMS, plan};
use rig::{Trouble, draw, on_a_jumping_clock};
use verdict::{Came, drawn, judge};

/// What lines do.
const TROUBLES: [&str; 6] = [
    "replace=1e-3,drop=1e-4",
    "flip=2e-3,insert=5e-4,duplicate=5e-4",
    "drop-chunk=0.03,stall=0.01,rechunk=0.1",
    "unplug=4e-3,unplug-ms=700,replace=2e-4",
    "drop-chunk=0.15",
    "reset=2e-3,drop-chunk=0.01",
];

fn try_all(windows: &[usize], seeds: impl Iterator<Item = u64> + Clone) -> BTreeMap<String, u32> {
    let mut came: BTreeMap<String, u32> = BTreeMap::new();
    let mut seed = 0;
    for name in PROGRAMS {
        let plan = plan(name).unwrap();
        let right = drawn(&plan, None);
        assert!(!right.is_empty(), "{name}");
        for (trouble, of) in TROUBLES
            .iter()
            .flat_map(|trouble| seeds.clone().map(move |seed| (trouble, seed)))
        {
            seed += 1;
            let window = windows[seed % windows.len()];
            let text = format!("{trouble},seed={}", seed as u64 * 1000 + of);
            let faults: Faults = text.parse().unwrap();
            let trouble = Trouble { faults, window };
            let outcome = on_a_jumping_clock(draw(&plan, trouble)).unwrap();
            let verdict = judge(&plan, &right, trouble, &outcome);
            let ended = outcome.end.as_ref().map(|ran| ran.commands);
            let verdict = match verdict {
                Ok(v) => v,
                Err(why) => {
                    println!("FAIL {name} {text} window {window}: {why}; {ended:?}");
                    continue;
                }
            };
            println!(
                "{name} {text} window {window}: {verdict:?}, interrupted {}, {:?} {:?}",
                outcome.between.len(),
                outcome.steps,
                outcome.end.as_ref().err().map(|error| error.to_string())
            );
            *came.entry(format!("{verdict:?}")).or_default() += 1;
            if !outcome.between.is_empty() && verdict != Came::Stopped {
                *came.entry("interrupted".to_owned()).or_default() += 1;
            }
        }
    }
    came
}

#[test]
fn a_bad_line_leaves_the_same_drawing_or_stops_and_says_where() {
    let came = try_all(&[1, 1, 4], 0..3);
    println!("{came:?}");
}

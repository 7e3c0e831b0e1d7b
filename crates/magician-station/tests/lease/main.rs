//! Exhaustive search: control is run through all interleavings of what three sessions and two arms
//! can do, to a depth at which every planted bug is found.

mod class;
mod codes;
mod effects;
mod laws;
mod model;
mod mutant;
mod regressions;
mod search;
mod step;

use self::model::Model;
use self::mutant::BUGS;
use self::search::{finds_all, search};

/// Depth at which each planted bug is found.
const DEPTH: usize = 5;
/// Depth to which control is searched without a fault.
const FURTHER: usize = 6;

#[test]
fn control_invariants_hold_for_every_event_sequence() {
    let (found, states) = search(Model::new(None), FURTHER);
    println!("states at each depth: {states:?}");
    assert!(found.is_none(), "{found:#?}");
    let all: usize = states.iter().sum();
    assert!(all > 100_000, "the search is one: {all} states");
}

#[test]
fn every_planted_bug_is_found() {
    finds_all(&BUGS, DEPTH, |bug| Model::new(Some(bug)));
}

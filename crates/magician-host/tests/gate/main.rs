//! Exhaustive test of the motion gate: every order of events from two holders, their guards, other
//! programs, stops and a line that breaks, up to a depth at which each planted bug is found.

mod model;
mod mutant;
// One search implementation serves all state machines of the repository.
#[path = "../../../magician-station/tests/lease/search.rs"]
mod search;

use self::model::Model;
use self::mutant::BUGS;
use self::search::{finds_all, search};

/// Depth, in events, within which each planted bug is found.
const DEPTH: usize = 5;
/// Depth, in events, to which the gate is explored.
const FURTHER: usize = 6;

#[test]
fn gate_keeps_its_laws_in_every_order_of_events() {
    let (found, states) = search(Model::new(None), FURTHER);
    println!("states at each depth: {states:?}");
    assert!(found.is_none(), "{found:#?}");
    let all: usize = states.iter().sum();
    println!("states: {all}");
    assert!(all > 300_000, "the search is one: {all} states");
}

#[test]
fn every_planted_bug_is_found() {
    finds_all(&BUGS, DEPTH, |bug| Model::new(Some(bug)));
}

//! Who may move an arm, in every order in which three sessions and two arms can come to it: control is run through all
//! interleavings of what can happen, up to a depth at which each of the bugs that are planted in it is found.

mod class;
mod codes;
mod effects;
mod found;
mod laws;
mod model;
mod mutant;
mod search;
mod step;

use self::model::Model;
use self::mutant::BUGS;
use self::search::{finds_all, search};

/// Events, one after the other, within which each planted bug is found.
const DEPTH: usize = 5;
/// Events within which control has none.
const FURTHER: usize = 6;

#[test]
fn control_keeps_its_laws_in_every_order_of_events() {
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

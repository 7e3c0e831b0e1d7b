//! Who may move an arm, in every order in which three sessions and two arms can come to it: control is run through all
//! interleavings of what can happen, up to a depth at which each of the bugs that are planted in it is found.

mod class;
mod effects;
mod found;
mod laws;
mod model;
mod mutant;
mod step;

use std::collections::HashSet;

use self::model::{Event, Model};
use self::mutant::{BUGS, Bug};

/// Events, one after the other, within which each planted bug is found.
const DEPTH: usize = 5;
/// Events within which control has none.
const FURTHER: usize = 6;

/// What a search has found.
#[derive(Debug)]
struct Found {
    what: String,
    path: Vec<Event>,
}

/// Runs through everything, nearest first: what was found, and how many states there were at each depth.
fn search(bug: Option<Bug>, depth: usize) -> (Option<Found>, Vec<usize>) {
    let first = Model::new(bug);
    let mut seen = HashSet::from([first.key()]);
    let mut edge = vec![first];
    let mut states = Vec::new();
    for _ in 0..depth {
        let mut next = Vec::new();
        for model in &edge {
            for event in model.events() {
                let mut then = model.clone();
                if let Err(what) = then.step(event) {
                    let path = then.path;
                    return (Some(Found { what, path }), states);
                }
                if seen.insert(then.key()) {
                    next.push(then);
                }
            }
        }
        states.push(next.len());
        edge = next;
    }
    (None, states)
}

#[test]
fn control_keeps_its_laws_in_every_order_of_events() {
    let (found, states) = search(None, FURTHER);
    println!("states at each depth: {states:?}");
    assert!(found.is_none(), "{found:#?}");
    let all: usize = states.iter().sum();
    assert!(all > 100_000, "the search is one: {all} states");
}

#[test]
fn every_planted_bug_is_found() {
    for (bug, law) in BUGS {
        let (found, _) = search(Some(bug), DEPTH);
        let found = found.unwrap_or_else(|| panic!("{bug:?} is not found"));
        println!("{bug:?} at depth {}: {:?}", found.path.len(), found.path);
        assert_eq!(found.what, law, "{bug:?}: {:?}", found.path);
    }
}

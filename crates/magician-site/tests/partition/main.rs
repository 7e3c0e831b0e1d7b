//! Who may move an arm where stations, programs and the network between them fail each by itself: three users come to three
//! stations that serve an arm of the same name (a site that was torn apart and healed), over lines that lose, double and delay
//! what they carry; each station has its own clock, which agrees with no other, and its own schedule. Everything that can happen
//! is tried, up to a depth at which each of the planted bugs is found.
//!
//! What is tried is the real thing: the control of a station, the packets of a session and the choice of who is meant.

mod bug;
mod laws;
mod world;

use std::collections::HashSet;

use self::bug::{BUGS, Bug};
use self::world::{Event, World};

/// Events within which each planted bug is found.
const DEPTH: usize = 5;
/// Events within which nothing is.
const FURTHER: usize = 6;

/// What a search has found.
#[derive(Debug)]
struct Found {
    what: String,
    path: Vec<Event>,
}

/// Runs through everything, nearest first: what was found, and how many states there were at each depth.
fn search(bug: Option<Bug>, depth: usize) -> (Option<Found>, Vec<usize>) {
    let first = World::new(bug);
    let mut seen = HashSet::from([first.key()]);
    let mut edge = vec![first];
    let mut states = Vec::new();
    for _ in 0..depth {
        let mut next = Vec::new();
        for world in &edge {
            for event in world.events() {
                let mut then = world.clone();
                if let Err(what) = then.step(world, event) {
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
fn an_arm_has_one_holder_whatever_fails() {
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

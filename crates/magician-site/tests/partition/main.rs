//! Exhaustive search for violations of mutual exclusion, where stations, programs and the network
//! fail independently.
//!
//! Three users connect to three stations that serve an arm of the same name (a site that was split
//! and healed). Connections delay messages and are cut. Each station has its own clock and
//! schedule. All sequences of events are tried, up to a depth at which every planted bug is found.
//!
//! The code under test is the real lease control of a station.

mod bug;
mod laws;
#[path = "../../../magician-station/tests/lease/search.rs"]
mod search;
mod world;

use self::bug::BUGS;
use self::search::{finds_all, search};
use self::world::World;

/// Depth at which each planted bug is found, events.
const BUG_SEARCH_DEPTH: usize = 5;
/// Depth of the search without a bug, events.
const SEARCH_DEPTH: usize = 6;

#[test]
fn an_arm_has_one_holder_whatever_fails() {
    let (found, states) = search(World::new(None), SEARCH_DEPTH);
    println!("states at each depth: {states:?}");
    assert!(found.is_none(), "{found:#?}");
    let all: usize = states.iter().sum();
    assert!(all > 100_000, "the search is one: {all} states");
}

#[test]
fn every_planted_bug_is_found() {
    finds_all(&BUGS, BUG_SEARCH_DEPTH, |bug| World::new(Some(bug)));
}

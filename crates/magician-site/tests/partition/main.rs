//! Who may move an arm where stations, programs and the network between them fail each by itself: three users come to three
//! stations that serve an arm of the same name (a site that was torn apart and healed), over connections that delay
//! what they carry and are cut; each station has its own clock, which agrees with no other, and its own schedule. Everything that can happen
//! is tried, up to a depth at which each of the planted bugs is found.
//!
//! What is tried is the real thing: the control of a station.

mod bug;
mod laws;
#[path = "../../../magician-station/tests/lease/search.rs"]
mod search;
mod world;

use self::bug::BUGS;
use self::search::{finds_all, search};
use self::world::World;

/// Events within which each planted bug is found.
const DEPTH: usize = 5;
/// Events within which nothing is.
const FURTHER: usize = 6;

#[test]
fn an_arm_has_one_holder_whatever_fails() {
    let (found, states) = search(World::new(None), FURTHER);
    println!("states at each depth: {states:?}");
    assert!(found.is_none(), "{found:#?}");
    let all: usize = states.iter().sum();
    assert!(all > 100_000, "the search is one: {all} states");
}

#[test]
fn every_planted_bug_is_found() {
    finds_all(&BUGS, DEPTH, |bug| World::new(Some(bug)));
}

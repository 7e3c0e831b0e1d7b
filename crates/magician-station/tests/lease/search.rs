//! Breadth-first search over all orders of events, to a depth.

use std::collections::HashSet;
use std::fmt::Debug;

/// State that can be searched.
pub(crate) trait Explored: Clone {
    /// Event.
    type Event: Copy + Debug;

    /// Returns the possible events.
    fn events(&self) -> Vec<Self::Event>;

    /// Applies an event; `before` is the state before it. The error is the broken invariant.
    fn step(&mut self, before: &Self, event: Self::Event) -> Result<(), String>;

    /// Returns a key: states with equal keys behave alike.
    fn key(&self) -> u64;
}

/// Fault found by a search.
#[derive(Debug)]
pub(crate) struct Found<E> {
    /// Broken invariant.
    pub(crate) what: String,
    /// Events that lead to it.
    pub(crate) path: Vec<E>,
}

/// Searches all orders. Returns the fault, if any, and the number of states per depth.
pub(crate) fn search<M: Explored>(first: M, depth: usize) -> (Option<Found<M::Event>>, Vec<usize>) {
    let mut seen = HashSet::from([first.key()]);
    let mut edge = vec![(first, Vec::new())];
    let mut states = Vec::new();
    for _ in 0..depth {
        let mut next = Vec::new();
        for (model, path) in &edge {
            for event in model.events() {
                let mut then = model.clone();
                let path = || path.iter().copied().chain([event]).collect();
                if let Err(what) = then.step(model, event) {
                    let path = path();
                    return (Some(Found { what, path }), states);
                }
                if seen.insert(then.key()) {
                    next.push((then, path()));
                }
            }
        }
        states.push(next.len());
        edge = next;
    }
    (None, states)
}

/// Checks that each planted bug is found by the invariant that it breaks.
pub(crate) fn finds_all<M: Explored, B: Copy + Debug>(
    bugs: &[(B, &str)],
    depth: usize,
    first: impl Fn(B) -> M,
) {
    for (bug, law) in bugs {
        let (found, _) = search(first(*bug), depth);
        let found = found.unwrap_or_else(|| panic!("{bug:?} is not found"));
        println!("{bug:?} at depth {}: {:?}", found.path.len(), found.path);
        assert_eq!(found.what, *law, "{bug:?}: {:?}", found.path);
    }
}

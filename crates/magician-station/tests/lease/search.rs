//! Everything that can happen to a model, in every order up to a depth, nearest first.

use std::collections::HashSet;
use std::fmt::Debug;

/// What can be searched: a state, and what can happen in it.
pub(crate) trait Explored: Clone {
    /// What happens.
    type Event: Copy + Debug;

    /// What can happen now.
    fn events(&self) -> Vec<Self::Event>;

    /// It happens; `before` is the state until then. An error is the law that is broken.
    fn step(&mut self, before: &Self, event: Self::Event) -> Result<(), String>;

    /// States of one key go on alike.
    fn key(&self) -> u64;
}

/// What a search has found.
#[derive(Debug)]
pub(crate) struct Found<E> {
    /// The law that is broken.
    pub(crate) what: String,
    /// What has happened.
    pub(crate) path: Vec<E>,
}

/// Runs through everything: what was found, and how many states there were at each depth.
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

/// Each of the planted bugs is found, as the law that it breaks.
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

//! Channel from an arm's server task to the picture: log lines, endpoints and clients.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use magician::serve::Notice;

/// Largest number of lines kept.
const MAX_LINES: usize = 256;

/// Line of the log.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::verbs::sim) struct Line {
    /// Time since the server began, s.
    pub(super) at: f64,
    pub(super) text: String,
}

/// Everything reported about one arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FeedState {
    /// Latest lines, oldest first.
    pub(super) lines: VecDeque<Line>,
    /// Total number of lines so far.
    pub(super) count: u64,
    /// Endpoints.
    pub(super) endpoints: Vec<String>,
    /// Connected clients.
    pub(super) clients: BTreeSet<String>,
}

/// Channel with one writer and one reader, which share the state.
#[derive(Clone, Debug)]
pub(in crate::verbs::sim) struct Feed {
    begun: Instant,
    state: Arc<Mutex<FeedState>>,
}

impl Feed {
    pub(in crate::verbs::sim) fn new() -> Self {
        Self {
            begun: Instant::now(),
            state: Arc::default(),
        }
    }

    /// Adds a line.
    pub(in crate::verbs::sim) fn say(&self, text: String) {
        let at = self.begun.elapsed().as_secs_f64();
        self.lock().say(Line { at, text });
    }

    /// Records that a client connected or disconnected.
    pub(in crate::verbs::sim) fn follow(&self, notice: &Notice) {
        self.lock().follow(notice);
    }

    /// Records the endpoints.
    pub(in crate::verbs::sim) fn endpoints(&self, endpoints: Vec<String>) {
        self.lock().endpoints = endpoints;
    }

    /// Copies the state into `known`. Returns true if it has changed.
    pub(super) fn update_from(&self, known: &mut FeedState) -> bool {
        let state = self.lock();
        let new = *known != *state;
        if new {
            known.clone_from(&state);
        }
        new
    }

    fn lock(&self) -> MutexGuard<'_, FeedState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FeedState {
    pub(super) fn say(&mut self, line: Line) {
        if self.lines.len() == MAX_LINES {
            self.lines.pop_front();
        }
        self.lines.push_back(line);
        self.count += 1;
    }

    fn follow(&mut self, notice: &Notice) {
        match notice {
            Notice::Connected(who) => {
                self.clients.insert(who.clone());
            }
            Notice::Left(who) | Notice::MadeRoom(who) => {
                self.clients.remove(who);
            }
            Notice::Unplugged => self.clients.clear(),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unplugged_cable_removes_all_clients() {
        let feed = Feed::new();
        let mut state = FeedState::default();
        let connected = |who: &str| feed.follow(&Notice::Connected(who.to_owned()));
        ["a", "b", "c"].into_iter().for_each(connected);
        feed.follow(&Notice::Left("b".to_owned()));
        assert!(feed.update_from(&mut state));
        assert_eq!(state.clients.iter().collect::<Vec<_>>(), ["a", "c"]);
        feed.follow(&Notice::Unplugged);
        assert!(feed.update_from(&mut state) && state.clients.is_empty());
        assert!(!feed.update_from(&mut state));
    }

    #[test]
    fn the_latest_lines_are_kept() {
        let feed = Feed::new();
        let mut state = FeedState::default();
        (0..1000).for_each(|n| feed.say(n.to_string()));
        feed.update_from(&mut state);
        assert_eq!((state.lines.len(), state.count), (MAX_LINES, 1000));
        assert_eq!(state.lines.back().map(|line| &line.text[..]), Some("999"));
    }
}

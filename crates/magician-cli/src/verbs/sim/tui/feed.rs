//! Channel from an arm's server task to the picture: log lines, endpoints and clients.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use magician::serve::Notice;

/// Largest number of lines kept.
const KEPT: usize = 256;

/// Line of the log.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::verbs::sim) struct Line {
    /// Time since the server began, s.
    pub(super) at: f64,
    pub(super) text: String,
}

/// Everything reported about one arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Told {
    /// Latest lines, oldest first.
    pub(super) lines: VecDeque<Line>,
    /// Total number of lines so far.
    pub(super) count: u64,
    /// Endpoints.
    pub(super) doors: Vec<String>,
    /// Connected clients.
    pub(super) clients: BTreeSet<String>,
}

/// Channel with one writer and one reader, which share the state.
#[derive(Clone, Debug)]
pub(in crate::verbs::sim) struct Feed {
    begun: Instant,
    told: Arc<Mutex<Told>>,
}

impl Feed {
    pub(in crate::verbs::sim) fn new() -> Self {
        Self {
            begun: Instant::now(),
            told: Arc::default(),
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
    pub(in crate::verbs::sim) fn doors(&self, doors: Vec<String>) {
        self.lock().doors = doors;
    }

    /// Copies the state into `known`. Returns true if it has changed.
    pub(super) fn catch_up(&self, known: &mut Told) -> bool {
        let told = self.lock();
        let new = *known != *told;
        if new {
            known.clone_from(&told);
        }
        new
    }

    fn lock(&self) -> MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Told {
    pub(super) fn say(&mut self, line: Line) {
        if self.lines.len() == KEPT {
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
    fn clients_come_and_go_and_a_pulled_cable_takes_all() {
        let feed = Feed::new();
        let mut told = Told::default();
        let connected = |who: &str| feed.follow(&Notice::Connected(who.to_owned()));
        ["a", "b", "c"].into_iter().for_each(connected);
        feed.follow(&Notice::Left("b".to_owned()));
        assert!(feed.catch_up(&mut told));
        assert_eq!(told.clients.iter().collect::<Vec<_>>(), ["a", "c"]);
        feed.follow(&Notice::Unplugged);
        assert!(feed.catch_up(&mut told) && told.clients.is_empty());
        assert!(!feed.catch_up(&mut told));
    }

    #[test]
    fn the_latest_lines_are_kept() {
        let feed = Feed::new();
        let mut told = Told::default();
        (0..1000).for_each(|n| feed.say(n.to_string()));
        feed.catch_up(&mut told);
        assert_eq!((told.lines.len(), told.count), (KEPT, 1000));
        assert_eq!(told.lines.back().map(|line| &line.text[..]), Some("999"));
    }
}

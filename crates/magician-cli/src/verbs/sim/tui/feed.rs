//! What the arm's server has to tell, from its task to the picture.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use magician::serve::Notice;

/// Lines that are kept.
const KEPT: usize = 256;

/// A line of the log.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::verbs::sim) struct Line {
    /// When, in seconds since the server began.
    pub(super) at: f64,
    pub(super) text: String,
}

/// What has been told of one arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Told {
    /// The latest lines, oldest first.
    pub(super) lines: VecDeque<Line>,
    /// How many there have been.
    pub(super) count: u64,
    /// What is served where.
    pub(super) doors: Vec<String>,
    /// The connected clients.
    pub(super) clients: BTreeSet<String>,
}

/// One end writes, the other reads.
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

    /// Notes which clients connect and disconnect.
    pub(in crate::verbs::sim) fn follow(&self, notice: &Notice) {
        self.lock().follow(notice);
    }

    /// Notes what is served where.
    pub(in crate::verbs::sim) fn doors(&self, doors: Vec<String>) {
        self.lock().doors = doors;
    }

    /// Takes what is new; whether there was anything.
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

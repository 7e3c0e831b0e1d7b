//! The reported results of commands, compared with what the arm took.

use std::collections::{HashMap, VecDeque};

use magician::connection::Failure;

use crate::bench::figure::Figure;

/// A command is judged when so many later ones were sent.
const KEPT: usize = 512;

/// A command from being sent to being judged.
struct Entry {
    number: u64,
    params: Vec<u8>,
    fate: Option<Result<u64, Failure>>,
    /// The indices under which the arm took it.
    taken: Vec<u64>,
    /// The arm was reset since a command was told as accepted.
    reset: bool,
}

/// What came of all commands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) commands: u64,
    /// Told as accepted, and taken once with this index and these parameters.
    pub(super) once: u64,
    /// Told as accepted; the arm took another command than was sent, for the checksum did not show it.
    pub(super) altered: u64,
    /// Reported as uncertain.
    pub(super) uncertain: u64,
    /// Of these, the ones that the arm took.
    pub(super) uncertain_taken: u64,
    /// Nothing was sent, or it is known that the arm took nothing; and so it was.
    pub(super) not_taken: u64,
    /// Told as accepted, and not taken.
    pub(super) lost: u64,
    /// Taken more than once.
    pub(super) twice: u64,
    /// Taken after a later one.
    pub(super) disordered: u64,
    /// Taken with another index than was told.
    pub(super) misplaced: u64,
    /// Told as not taken, and taken.
    pub(super) denied: u64,
    /// An uncertain one outside of the interval that was told.
    pub(super) outside: u64,
    /// Lost, taken twice or disordered, and the host has said so.
    pub(super) reported: u64,
    /// Commands that the arm took but that were not sent like this, beside those that were told as accepted.
    pub(super) strays: u64,
}

impl Tally {
    pub(super) fn figures(&self) -> Vec<Figure> {
        let count = |name: &str, value: u64| Figure::new(name, value as f64, "commands");
        let never = |name, value| count(name, value).at_most(0.0);
        vec![
            count("sent", self.commands),
            count("accepted, and taken once", self.once),
            count("told as not taken, rightly", self.not_taken),
            (count("told as uncertain", self.uncertain))
                .with("of which the arm took", self.uncertain_taken as f64),
            never("lost in silence", self.lost),
            never("taken twice in silence", self.twice),
            never("out of order in silence", self.disordered),
            never("taken with another index", self.misplaced),
            never("taken though told otherwise", self.denied),
            never("outside of the interval told", self.outside),
            count("lost or twice, and reported", self.reported),
        ]
    }
}

/// The commands of one arm from one reset to the next, or of many.
#[derive(Default)]
pub(super) struct CommandLog {
    entries: VecDeque<Entry>,
    numbers: HashMap<Vec<u8>, u64>,
    /// What the arm took that was not sent like this, by index.
    strays: VecDeque<u64>,
    /// Intervals of indices that the host was told not to rely on.
    reports: VecDeque<(u64, u64)>,
    newest: u64,
    /// How often the arm had been reset when a command was told as accepted.
    boots: u32,
    pub(super) tally: Tally,
}

impl CommandLog {
    /// A command is about to be sent. Numbers follow each other.
    pub(super) fn send(&mut self, number: u64, params: &[u8]) {
        self.tally.commands += 1;
        self.numbers.insert(params.to_vec(), number);
        self.entries.push_back(Entry {
            number,
            params: params.to_vec(),
            fate: None,
            taken: Vec::new(),
            reset: false,
        });
        while self.entries.len() > KEPT {
            self.judge_first();
        }
    }

    fn entry(&mut self, number: u64) -> Option<&mut Entry> {
        let first = self.entries.front()?.number;
        let at = usize::try_from(number.checked_sub(first)?).ok()?;
        self.entries.get_mut(at)
    }

    /// The arm took something into its queue.
    pub(super) fn take(&mut self, params: &[u8], index: u64) {
        let Some(number) = self.numbers.get(params).copied() else {
            self.strays.push_back(index);
            self.tally.strays += 1;
            if self.strays.len() > KEPT {
                self.strays.pop_front();
            }
            return;
        };
        let late = number < self.newest;
        self.newest = self.newest.max(number);
        let Some(entry) = self.entry(number) else {
            return;
        };
        entry.taken.push(index);
        let again = entry.taken.len() > 1;
        self.tally.disordered += u64::from(late && !again);
    }

    /// The host was told; the arm has been reset so often.
    pub(super) fn tell(&mut self, number: u64, fate: Result<u64, Failure>, boots: u32) {
        let reset = boots != self.boots;
        if fate.is_ok() {
            self.boots = boots;
        }
        if let Some(entry) = self.entry(number) {
            (entry.fate, entry.reset) = (Some(fate), reset);
        }
        if let Err(Failure::Uncertain { from, to }) = fate {
            self.report((from.unwrap_or(u64::MAX), to.unwrap_or(0)));
        }
    }

    /// The host was told that these indices are not what it thought.
    pub(super) fn report(&mut self, interval: (u64, u64)) {
        self.reports.push_back(interval);
        if self.reports.len() > KEPT {
            self.reports.pop_front();
        }
    }

    fn is_reported(&self, index: u64) -> bool {
        (self.reports.iter()).any(|(from, to)| (*from..=*to).contains(&index))
    }

    /// Judges what has not been.
    pub(super) fn close(&mut self) {
        while !self.entries.is_empty() {
            self.judge_first();
        }
    }

    fn judge_first(&mut self) {
        let Some(entry) = self.entries.pop_front() else {
            return;
        };
        self.numbers.remove(&entry.params);
        let taken = entry.taken.as_slice();
        let told = entry.fate.and_then(Result::ok);
        let reported = match taken {
            [] => told.is_some_and(|index| self.is_reported(index)),
            // One of them was as it should be.
            [..] => {
                taken
                    .iter()
                    .filter(|index| self.is_reported(**index))
                    .count()
                    + 1
                    >= taken.len()
            }
        };
        let tally = &mut self.tally;
        let wrong = match entry.fate {
            Some(Ok(index)) => match taken {
                [one] if *one == index => {
                    tally.once += 1;
                    return;
                }
                [_] => &mut tally.misplaced,
                [] => match self.strays.iter().position(|stray| *stray == index) {
                    Some(at) => {
                        self.strays.remove(at);
                        tally.strays -= 1;
                        tally.altered += 1;
                        return;
                    }
                    None => &mut tally.lost,
                },
                _ => &mut tally.twice,
            },
            Some(Err(Failure::Uncertain { from, to })) => {
                tally.uncertain += 1;
                tally.uncertain_taken += u64::from(!taken.is_empty());
                let inside = |index: &u64| {
                    from.is_none_or(|from| from <= *index) && to.is_none_or(|to| *index <= to)
                };
                match taken {
                    [] => return,
                    [one] if inside(one) || entry.reset => return,
                    [_] => &mut tally.outside,
                    _ => &mut tally.twice,
                }
            }
            _ if taken.is_empty() => {
                tally.not_taken += 1;
                return;
            }
            _ => &mut tally.denied,
        };
        if reported && !matches!(taken, [_]) {
            tally.reported += 1;
        } else {
            *wrong += 1;
        }
    }
}

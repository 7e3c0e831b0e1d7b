//! Compares the reported outcome of each command with what the arm accepted.
//!
//! A command is sent under a number with unique parameters. The arm's side reports what it
//! accepted, the host's side the outcome it was given. Once enough later commands were sent,
//! nothing about a command can change any more, and [`CommandLog`] judges it into one field of
//! [`Tally`].

use std::collections::{HashMap, VecDeque};

use magician::connection::Failure;

use crate::bench::figure::Figure;

/// Number of later commands after which a command is judged.
const JUDGE_AFTER: usize = 512;

/// Command that has been sent and not yet judged.
struct Entry {
    number: u64,
    params: Vec<u8>,
    outcome: Option<Result<u64, Failure>>,
    /// Indices under which the arm accepted it.
    taken: Vec<u64>,
    /// True if the arm was reset since a command was last reported as accepted.
    reset: bool,
}

/// Number of commands by outcome.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) commands: u64,
    /// Reported as accepted, and accepted once with this index and these parameters.
    pub(super) once: u64,
    /// Reported as accepted, but the arm accepted other parameters: the checksum did not detect the
    /// change.
    pub(super) altered: u64,
    /// Reported as uncertain.
    pub(super) uncertain: u64,
    /// Reported as uncertain, but accepted by the arm.
    pub(super) uncertain_taken: u64,
    /// Reported as not accepted, correctly.
    pub(super) not_taken: u64,
    /// Reported as accepted, but not accepted.
    pub(super) lost: u64,
    /// Accepted more than once.
    pub(super) twice: u64,
    /// Accepted after a later command.
    pub(super) disordered: u64,
    /// Accepted with another index than reported.
    pub(super) misplaced: u64,
    /// Reported as not accepted, but accepted.
    pub(super) denied: u64,
    /// Uncertain ones accepted outside of the reported interval.
    pub(super) outside: u64,
    /// Lost, accepted twice or out of order, but the host has reported that.
    pub(super) reported: u64,
    /// Commands that the arm accepted with parameters never sent, except those counted as altered.
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

/// Log of the commands of one arm between resets, or of several arms.
#[derive(Default)]
pub(super) struct CommandLog {
    entries: VecDeque<Entry>,
    numbers: HashMap<Vec<u8>, u64>,
    /// Indices of accepted commands whose parameters were never sent.
    strays: VecDeque<u64>,
    /// Intervals of indices that were reported to the host as unreliable.
    reports: VecDeque<(u64, u64)>,
    newest: u64,
    /// Number of resets when a command was last reported as accepted.
    boots: u32,
    pub(super) tally: Tally,
}

impl CommandLog {
    /// Records a command that is about to be sent. Numbers must be consecutive.
    pub(super) fn send(&mut self, number: u64, params: &[u8]) {
        self.tally.commands += 1;
        self.numbers.insert(params.to_vec(), number);
        self.entries.push_back(Entry {
            number,
            params: params.to_vec(),
            outcome: None,
            taken: Vec::new(),
            reset: false,
        });
        while self.entries.len() > JUDGE_AFTER {
            self.judge_first();
        }
    }

    fn entry(&mut self, number: u64) -> Option<&mut Entry> {
        let first = self.entries.front()?.number;
        let at = usize::try_from(number.checked_sub(first)?).ok()?;
        self.entries.get_mut(at)
    }

    /// Records that the arm accepted a command.
    pub(super) fn note_accepted(&mut self, params: &[u8], index: u64) {
        let Some(number) = self.numbers.get(params).copied() else {
            self.strays.push_back(index);
            self.tally.strays += 1;
            if self.strays.len() > JUDGE_AFTER {
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

    /// Records the outcome reported to the caller. `boots` is the number of resets so far.
    pub(super) fn note_outcome(&mut self, number: u64, outcome: Result<u64, Failure>, boots: u32) {
        let reset = boots != self.boots;
        if outcome.is_ok() {
            self.boots = boots;
        }
        if let Some(entry) = self.entry(number) {
            (entry.outcome, entry.reset) = (Some(outcome), reset);
        }
        if let Err(Failure::Uncertain { from, to }) = outcome {
            self.note_unreliable((from.unwrap_or(u64::MAX), to.unwrap_or(0)));
        }
    }

    /// Records that these indices were reported to the host as unreliable.
    pub(super) fn note_unreliable(&mut self, interval: (u64, u64)) {
        self.reports.push_back(interval);
        if self.reports.len() > JUDGE_AFTER {
            self.reports.pop_front();
        }
    }

    fn is_reported(&self, index: u64) -> bool {
        (self.reports.iter()).any(|(from, to)| (*from..=*to).contains(&index))
    }

    /// Judges all remaining commands.
    pub(super) fn judge_rest(&mut self) {
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
        let reported = entry.outcome.and_then(Result::ok);
        let reported = match taken {
            [] => reported.is_some_and(|index| self.is_reported(index)),
            // A single acceptance is correct; any further ones must have been reported.
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
        let wrong = match entry.outcome {
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

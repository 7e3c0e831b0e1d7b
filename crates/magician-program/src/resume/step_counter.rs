//! From the queue's index to the step of a plan.

use std::collections::VecDeque;

use crate::program::StepNumbering;

/// Number of index and command pairs kept: more than any queue is long.
pub(super) const MAX_INDEX_PAIRS: usize = 256;

/// Maps a queue index to a step. A driver may insert commands between those of a plan and skip
/// indices, so the difference is not constant.
#[derive(Clone, Debug, Default)]
pub struct StepCounter {
    /// Number of commands before the first step.
    lead: u64,
    /// True if the driver may insert commands between the steps, or skip indices.
    mixed: bool,
    /// Indices with the number of the plan's commands up to each.
    pairs: VecDeque<(u64, u64)>,
    /// Last finished index of the arm at rest, before the first command.
    rest: Option<u64>,
    /// Commands inserted by the driver, by their number among all commands taken.
    inserted: VecDeque<u64>,
    /// Number of inserted commands that are no longer listed.
    unlisted: u64,
    /// Numbering of the steps, some of which have no command.
    numbering: StepNumbering,
    /// Number of commands of the steps before the first.
    before: u64,
    /// The first step.
    from: u64,
}

/// Number of steps known within bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepRange {
    /// Lower bound.
    pub least: u64,
    /// Upper bound.
    pub most: u64,
}

impl StepCounter {
    /// Creates the counter of a run whose first step is preceded by `lead` commands. `mixed` is
    /// true if the driver may insert commands (to switch a laser off), or skip indices (above
    /// window 1, when lost commands are sent again).
    #[must_use]
    pub fn new(lead: u64, mixed: bool) -> Self {
        Self {
            lead,
            mixed,
            pairs: VecDeque::new(),
            rest: None,
            inserted: VecDeque::new(),
            unlisted: 0,
            numbering: StepNumbering::default(),
            before: 0,
            from: 0,
        }
    }

    /// Applies the numbering of a program in which some steps have no command, starting at step
    /// `from`.
    #[must_use]
    pub(crate) fn numbered(self, numbering: StepNumbering, from: u64) -> Self {
        Self {
            before: numbering.commands(from),
            numbering,
            from,
            ..self
        }
    }

    /// Number of steps that this many commands complete.
    fn steps(&self, commands: u64) -> u64 {
        match commands.saturating_sub(self.lead) {
            0 => 0,
            commands => {
                let steps = self.numbering.steps(self.before.saturating_add(commands));
                steps.saturating_sub(self.from)
            }
        }
    }

    /// Sets the last finished index of an arm that was at rest, with an empty queue, before the
    /// first command.
    #[must_use]
    pub fn from_rest(mut self, index: Option<u64>) -> Self {
        self.rest = index.map(first_counted_index);
        self
    }

    /// Marks the command with this number (from 1) as inserted: it counts for no step. Call this
    /// before the arm takes the command, and in order.
    pub fn insert(&mut self, command: u64) {
        if self.inserted.len() >= MAX_INDEX_PAIRS {
            self.inserted.pop_front();
            self.unlisted += 1;
        }
        self.inserted.push_back(command);
    }

    /// True if the arm has finished all inserted commands when it has finished this index.
    #[must_use]
    pub fn has_passed_inserted(&self, current: u64) -> bool {
        let last = self.inserted.back();
        last.is_none_or(|last| self.taken(current).least >= *last)
    }

    /// Number of commands without the inserted ones.
    fn plan_commands(&self, commands: u64) -> u64 {
        let later = self.inserted.iter().rev();
        let later = later.take_while(|inserted| **inserted > commands).count() as u64;
        let earlier = self.unlisted + self.inserted.len() as u64 - later;
        commands.saturating_sub(earlier)
    }

    /// Notes that the arm has taken `commands` in all, the last one under `index`.
    pub fn note(&mut self, commands: u64, index: u64) {
        if commands == 0 {
            return;
        }
        // Commands dropped from the queue and sent again get new indices.
        while self
            .pairs
            .back()
            .is_some_and(|(_, known)| *known > commands)
        {
            self.pairs.pop_back();
        }
        // Keep the first and the last index with the same number of commands: those between are the
        // driver's own.
        let as_many = self
            .pairs
            .iter()
            .rev()
            .take_while(|(_, known)| *known == commands);
        if as_many.count() > 1 {
            self.pairs.pop_back();
        }
        // The oldest pair is far behind anything still in the queue.
        if self.pairs.len() >= MAX_INDEX_PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back((index, commands));
    }

    /// Range of steps finished when the arm has finished this index.
    #[must_use]
    pub fn finished(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.commands(current);
        StepRange {
            least: self.steps(least),
            most: self.steps(most),
        }
    }

    /// True if the commands before the first step are certainly finished when the arm has finished
    /// this index.
    #[must_use]
    pub fn is_at_first(&self, current: u64) -> bool {
        self.commands(current).least >= self.lead
    }

    /// Like [`finished`](Self::finished), but counts commands, including the lead before the first
    /// step.
    pub(crate) fn commands(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.taken(current);
        StepRange {
            least: self.plan_commands(least),
            most: self.plan_commands(most),
        }
    }

    /// Like [`commands`](Self::commands), including inserted ones.
    fn taken(&self, current: u64) -> StepRange {
        let before = self.pairs.iter().rev().find(|(index, _)| *index <= current);
        let after = self.pairs.iter().find(|(index, _)| *index > current);
        let (mut least, mut most) = (0, u64::MAX);
        if let Some((index, commands)) = before {
            least = *commands;
            most = commands.saturating_add(current.saturating_sub(*index));
        }
        if let Some((index, commands)) = after {
            least = least.max(commands.saturating_sub(index.saturating_sub(current)));
            most = most.min(*commands);
        }
        if !self.mixed {
            // Without foreign commands the nearest known index is exact.
            (least, most) = match after {
                Some(_) => (least, least),
                None => (most, most),
            };
        }
        // Before the first reply the arm may have taken any number of commands, up to its progress
        // since the run began.
        if self.pairs.is_empty() {
            (least, most) = (0, current.saturating_sub(self.rest.unwrap_or(current)));
        }
        StepRange {
            least,
            most: most.max(least),
        }
    }

    /// Like [`finished`](Self::finished), for an arm where indices after the last known one may
    /// belong to foreign or duplicate commands.
    #[must_use]
    pub fn certain(&self, current: u64) -> StepRange {
        let span = self.finished(current);
        match self.last() {
            Some((index, steps)) if current > index => StepRange {
                least: steps,
                ..span
            },
            _ => span,
        }
    }

    /// Last known index, and the steps up to it.
    ///
    /// Until a step is taken, this is the index of the last command before the first step. The
    /// queue was empty at the start, so that index is known before the arm reports it.
    #[must_use]
    pub fn last(&self) -> Option<(u64, u64)> {
        let ahead = self.lead_commands();
        match self.pairs.back() {
            Some((index, commands)) if *commands < ahead => Some((index + (ahead - commands), 0)),
            Some((index, commands)) => Some((*index, self.steps(self.plan_commands(*commands)))),
            None => Some((self.rest?.saturating_add(ahead), 0)),
        }
    }

    /// Number of commands before the first step, including those inserted among them.
    fn lead_commands(&self) -> u64 {
        let inserted = (0..).zip(&self.inserted);
        let ahead = inserted.take_while(|(nth, command)| **command <= self.lead + nth + 1);
        self.lead + ahead.count() as u64
    }
}

/// Index from which the commands of an arm at rest are counted. Arms number their first command 2
/// (model section 14), so the index 0 of an arm that has finished none counts as 1. On an arm that
/// begins with 1 the count is one command too low until its first reply.
pub(super) fn first_counted_index(current: u64) -> u64 {
    current.max(1)
}

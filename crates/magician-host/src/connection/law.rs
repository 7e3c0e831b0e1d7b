//! The index law, and whether this arm follows it.
//!
//! Conclusions from indices rest on three properties of the controller (errata E37): every accepted
//! command gets the index after the previous one; the current index never names a command that was
//! not accepted; and the commands in between occupy the queue, so `current + capacity - left space`
//! is the last index given. If one of them does not hold, "lost" and "taken" cannot be
//! distinguished, and every conclusion would be a guess.
//!
//! The [`IndexLawMonitor`] only listens and sends nothing. In ordinary traffic it looks for four
//! violations:
//!
//! * *Step*: the indices of two consecutive commands that travelled alone differ by something other
//!   than 1. Another host on the same arm causes this now and then, and so does a duplicated
//!   datagram; several in a row without a single +1 are the arm's own doing.
//! * *Current*: a new command gets an index at or below a current index read before, and the next
//!   reading confirms that reading. If the controller was switched off and on in between, the
//!   second reading is lower instead.
//! * *Back*: the current index goes back while the indices of new commands simply continue. A real
//!   reset restarts them.
//! * *Left space*: the head of the queue that the left space implies is before the last current
//!   index or beyond the next one. Another host can cause this, too. If it queued commands, they
//!   show in the next index. If it sent a Clear, the implied head stays the same until the current
//!   index is right again. So each implied head counts once, and only several mismatches without a
//!   match in a filled queue break the law.

use std::fmt;

/// State of knowledge about an arm's numbering of queued commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IndexLaw {
    /// Too few commands were accepted to decide. Commands travel one at a time.
    #[default]
    Unknown,
    /// The arm numbers them as errata E37 says.
    Followed,
    /// The arm breaks the law. Lost replies are not recovered, and commands travel one at a time.
    Broken(LawViolation),
}

/// Observed violation of errata E37.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LawViolation {
    /// Consecutive commands got indices with a gap or out of order.
    Step {
        /// Index of the earlier command.
        before: u64,
        /// Index of the later one.
        after: u64,
    },
    /// The arm reported a command as finished before it gave that index to any command.
    Current {
        /// Current index read.
        current: u64,
        /// Index given to a command afterwards.
        index: u64,
    },
    /// The current index went back although the arm was not reset.
    Back {
        /// Index given to the next command.
        index: u64,
    },
    /// Current index and left space do not add up to the last index given.
    LeftSpace {
        /// Current index read.
        current: u64,
        /// Left space read.
        left: u32,
        /// Last index given.
        last: u64,
    },
}

impl fmt::Display for LawViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step { before, after } => write!(
                f,
                "the arm does not number queued commands one by one: after {before} came {after}"
            ),
            Self::Current { current, index } => write!(
                f,
                "the arm's current index cannot be relied on: it was {current} before the arm gave index {index} to a new command"
            ),
            Self::Back { index } => write!(
                f,
                "the arm's current index went back although the arm was not reset: the next \
                    command still got index {index}"
            ),
            Self::LeftSpace {
                current,
                left,
                last,
            } => write!(
                f,
                "the arm's left space cannot be relied on: {left} places are free at current index {current}, which does not fit the last command's index {last}"
            ),
        }
    }
}

/// Consecutive steps of +1 after which the law counts as followed.
// A choice: two could be chance with another host.
const STEPS_TO_TRUST: u32 = 3;
/// Consecutive mismatches after which it counts as broken.
// A choice: another host causes single ones.
const MISMATCHES_TO_BREAK: u32 = 3;
/// Resets contradicted by the next index after which it counts as broken.
const FALSE_RESETS_TO_BREAK: u32 = 2;

/// Checks whether the arm follows the index law.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexLawMonitor {
    law: IndexLaw,
    /// Index in the last reply, correct or not. `None` if the next index cannot be compared with
    /// it.
    last: Option<u64>,
    /// Number of consecutive steps of +1.
    consecutive_steps: u32,
    /// Number of consecutive steps other than +1, of commands that travelled alone.
    consecutive_mismatches: u32,
    /// Highest current index read since power-up.
    highest: u64,
    /// Index given to a command, and a current index, not lower, that was read before the command
    /// was sent.
    contradicted: Option<(u64, u64)>,
    /// True if every reply since `highest` was read continued the count.
    unbroken: bool,
    /// Value of `last` when the current index went back, if the count was `unbroken`.
    before_reset: Option<u64>,
    false_resets: u32,
    left_space_check: LeftSpaceCheck,
}

/// Comparison of left space and current index.
#[derive(Clone, Copy, Debug, Default)]
struct LeftSpaceCheck {
    /// Head that the next current index must have reached.
    ahead: Option<(u64, QueueReading)>,
    /// Reading with more waiting commands than this host can have queued. The next index shows
    /// whether another host queued some of them.
    excess: Option<QueueReading>,
    /// Consecutive mismatches.
    mismatches: u32,
    /// Head at the last mismatch.
    last_mismatched_head: Option<u64>,
}

/// A reading of the left space, from which the queue's head follows.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueueReading {
    pub(super) left: u32,
    /// Occupied places.
    pub(super) waiting: u32,
    /// Last index given to a command that this reading must include.
    pub(super) last: u64,
    /// Lowest head of the queue at the last reading of the current index.
    pub(super) reached: u64,
}

impl IndexLawMonitor {
    pub(super) fn law(&self) -> IndexLaw {
        self.law
    }

    pub(super) fn is_broken(&self) -> bool {
        matches!(self.law, IndexLaw::Broken(_))
    }

    /// True if a current index that goes back is evidence of a reset.
    pub(super) fn trusts_current(&self) -> bool {
        !matches!(
            self.law,
            IndexLaw::Broken(LawViolation::Back { .. } | LawViolation::Current { .. })
        )
    }

    /// Highest current index read so far.
    pub(super) fn highest(&self) -> u64 {
        self.highest
    }

    /// Processes the index of a reply. `alone` is true if no other command was unaccounted for;
    /// `highest` is the highest current index read when the command was sent.
    pub(super) fn note_reply(&mut self, index: u64, alone: bool, highest: u64) {
        if let Some(before) = self.before_reset.take() {
            // Index 1 is what a real reset would give, too.
            let went_on = index > 1 && before.checked_add(1) == Some(index);
            self.false_resets = if went_on { self.false_resets + 1 } else { 0 };
            if self.false_resets >= FALSE_RESETS_TO_BREAK {
                self.mark_broken(LawViolation::Back { index });
            }
        }
        let before = self.last.replace(index);
        self.unbroken &= before.is_some_and(|before| before.checked_add(1) == Some(index));
        if let Some(reading) = self.left_space_check.excess.take()
            && reading.last.checked_add(1) == Some(index)
        {
            self.note_mismatch(reading.reached, reading);
        }
        match before.map(|before| (before, before.checked_add(1) == Some(index))) {
            Some((_, true)) => {
                // An index out of order may be another command's reply, duplicated.
                self.contradicted = (index <= highest).then_some((index, highest));
                (self.consecutive_steps, self.consecutive_mismatches) =
                    (self.consecutive_steps.saturating_add(1), 0);
                // A broken law stays broken: later good indices do not make the arm reliable.
                if self.consecutive_steps >= STEPS_TO_TRUST && self.law == IndexLaw::Unknown {
                    self.law = IndexLaw::Followed;
                }
            }
            // In a window a lost command explains the step.
            Some((before, false)) if alone => {
                (self.consecutive_steps, self.consecutive_mismatches) =
                    (0, self.consecutive_mismatches + 1);
                if self.consecutive_mismatches >= MISMATCHES_TO_BREAK {
                    let after = index;
                    self.mark_broken(LawViolation::Step { before, after });
                }
            }
            // No index before, or commands beside it: nothing follows from the step.
            _ => {}
        }
    }

    /// Restarts the comparison: the next index is compared with `last`, or with nothing if what
    /// came between is unknown.
    pub(super) fn resume(&mut self, last: Option<u64>) {
        self.last = last;
        self.unbroken = false;
        self.drop_open_checks();
    }

    /// Processes a reading of the current index that shows no reset. `reached` is the head it
    /// implies, if known.
    pub(super) fn note_current(&mut self, current: u64, reached: Option<u64>) {
        if let Some((index, highest)) = self.contradicted.take()
            && current >= highest
        {
            let current = highest;
            self.mark_broken(LawViolation::Current { current, index });
        }
        if current > self.highest {
            (self.highest, self.unbroken) = (current, true);
        }
        let (Some((head, reading)), Some(reached)) = (self.left_space_check.ahead.take(), reached)
        else {
            return;
        };
        if head > reached {
            self.note_mismatch(current, reading);
        // An empty queue always matches, so only a match in a filled one clears the count.
        } else if reading.waiting > 0 {
            self.left_space_check.mismatches = 0;
        }
    }

    /// Notes a reset. `by_current` is true if the current index went back.
    pub(super) fn reset(&mut self, by_current: bool) {
        self.before_reset = self.last.filter(|_| by_current && self.unbroken);
        self.highest = 0;
        self.contradicted = None;
        self.resume(None);
    }

    /// Drops open comparisons, because the queue no longer holds what was accepted.
    pub(super) fn drop_open_checks(&mut self) {
        self.left_space_check.ahead = None;
        self.left_space_check.excess = None;
    }

    /// Processes a reading of the left space.
    pub(super) fn note_left_space(&mut self, reading: QueueReading) {
        self.drop_open_checks();
        match reading.last.checked_sub(reading.waiting.into()) {
            Some(head) if head >= reading.reached => {
                self.left_space_check.ahead = Some((head, reading))
            }
            _ => self.left_space_check.excess = Some(reading),
        }
    }

    /// Counts a left space that does not fit.
    ///
    /// Another host's Clear looks the same, but then the implied head stands still until the
    /// current index is right again, so one head counts once.
    fn note_mismatch(&mut self, current: u64, reading: QueueReading) {
        let head = reading.last.saturating_sub(reading.waiting.into());
        if self.left_space_check.last_mismatched_head.replace(head) == Some(head) {
            return;
        }
        self.left_space_check.mismatches += 1;
        if self.left_space_check.mismatches >= MISMATCHES_TO_BREAK {
            self.mark_broken(LawViolation::LeftSpace {
                current,
                left: reading.left,
                last: reading.last,
            });
        }
    }

    fn mark_broken(&mut self, breach: LawViolation) {
        if !self.is_broken() {
            self.law = IndexLaw::Broken(breach);
        }
    }
}

//! The index law, and whether this arm keeps it.
//!
//! What may be concluded from indices rests on three habits of the controller (errata E37): every accepted command gets
//! the index after the one before; the current index never names a command that was not accepted; and in between stand
//! the commands that take up the queue's places, so that `current + capacity - left space` is the index given last. Where
//! one of them does not hold, "lost" and "taken" cannot be told apart, and every conclusion would be a guess.
//!
//! The [`IndexLawMonitor`] only listens. Each habit is held against what passes anyway:
//!
//! * A *step* other than +1 between the answers to two commands that travelled alone. Another host that shares the arm
//!   makes one now and then, a datagram that came twice as well; several in a row without a single +1 are the arm's own.
//! * A new command whose index is at or below a *current* index read before, which the next reading confirms. Between the
//!   two the controller may have been switched off and on, but then the second reading is lower.
//! * A current index that goes *back* while the indices of new commands simply go on: no reset, which begins them anew.
//! * The *left space*. It names the command at the queue's head, which must be neither before the current index read
//!   last nor beyond the one read next. What another host queued shows in the next index; after what it cleared the head
//!   stands still until the current index is right again. So a mismatch counts once for each new head, and several
//!   without a fit in a filled queue between them break the law.

use std::fmt;

/// What is known of an arm's habit of numbering queued commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// Too few commands were accepted to tell. Commands travel one at a time.
    #[default]
    Unknown,
    /// It numbers them as errata E37 says.
    Followed,
    /// It does not: a lost answer is never made up for, and commands travel one at a time.
    Broken(Breach),
}

/// How an arm was seen not to number its queued commands as errata E37 says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Breach {
    /// Commands that followed each other got indices that do not.
    Step {
        /// Index of the earlier command.
        before: u64,
        /// Index of the later one.
        after: u64,
    },
    /// The arm reported a command as finished before it gave its index away.
    Current {
        /// The current index that was read.
        current: u64,
        /// The index given to a command after that.
        index: u64,
    },
    /// The current index went back although the arm was not reset.
    Back {
        /// The index given to the next command.
        index: u64,
    },
    /// Current index and left space do not add up to the index given last.
    LeftSpace {
        /// The current index that was read.
        current: u64,
        /// The left space that was read.
        left: u32,
        /// The index given last.
        last: u64,
    },
}

impl fmt::Display for Breach {
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

/// So many +1 in a row and the law counts as followed.
const ENOUGH: u32 = 3;
/// So many mismatches in a row and it counts as broken.
const TOO_MANY: u32 = 3;
/// So many resets that were none.
const FALSE_RESETS: u32 = 2;

/// Watches whether the arm keeps the law.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexLawMonitor {
    law: Law,
    /// The index in the last answer, believed or not, while the next one is to be compared with it.
    last: Option<u64>,
    good: u32,
    odd: u32,
    /// Highest current index read since the arm was switched on.
    highest: u64,
    /// A command got this index although this current index, no lower, had been read before it was sent.
    contradicted: Option<(u64, u64)>,
    /// Every answer since `highest` was read followed the one before.
    unbroken: bool,
    /// `last` when the current index went back, if it was `unbroken`.
    before_reset: Option<u64>,
    false_resets: u32,
    books: Accounts,
}

/// Left space held against current index.
#[derive(Clone, Copy, Debug, Default)]
struct Accounts {
    /// The next current index is to have reached this head.
    ahead: Option<(u64, QueueReading)>,
    /// More waits than can, unless another host's commands are among it, which the next index tells.
    excess: Option<QueueReading>,
    /// Mismatches in a row.
    strikes: u32,
    /// The head at the latest of them.
    struck: Option<u64>,
}

/// One look at the queue, from which the head follows.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueueReading {
    pub(super) left: u32,
    /// Places taken.
    pub(super) waiting: u32,
    /// Index given last to a command that the look must have seen.
    pub(super) last: u64,
    /// The head was at least here when the current index was read last.
    pub(super) reached: u64,
}

impl IndexLawMonitor {
    pub(super) fn law(&self) -> Law {
        self.law
    }

    pub(super) fn is_broken(&self) -> bool {
        matches!(self.law, Law::Broken(_))
    }

    /// Whether a current index that goes back means anything.
    pub(super) fn trusts_current(&self) -> bool {
        !matches!(
            self.law,
            Law::Broken(Breach::Back { .. } | Breach::Current { .. })
        )
    }

    /// The highest current index read so far.
    pub(super) fn highest(&self) -> u64 {
        self.highest
    }

    /// An answer with this index came. `alone`: to a command beside which no other was unaccounted for; `highest`: the
    /// highest current index read when it was sent.
    pub(super) fn answered(&mut self, index: u64, alone: bool, highest: u64) {
        if let Some(before) = self.before_reset.take() {
            let went_on = index > 1 && before.checked_add(1) == Some(index);
            self.false_resets = if went_on { self.false_resets + 1 } else { 0 };
            if self.false_resets >= FALSE_RESETS {
                self.breaks(Breach::Back { index });
            }
        }
        let before = self.last.replace(index);
        self.unbroken &= before.is_some_and(|before| before.checked_add(1) == Some(index));
        if let Some(look) = self.books.excess.take()
            && look.last.checked_add(1) == Some(index)
        {
            self.strike(look.reached, look);
        }
        match before.map(|before| (before, before.checked_add(1) == Some(index))) {
            Some((_, true)) => {
                // An index that does not follow may be another command's answer come again.
                self.contradicted = (index <= highest).then_some((index, highest));
                (self.good, self.odd) = (self.good.saturating_add(1), 0);
                if self.good >= ENOUGH && self.law == Law::Unknown {
                    self.law = Law::Followed;
                }
            }
            Some((before, false)) if alone => {
                (self.good, self.odd) = (0, self.odd + 1);
                if self.odd >= TOO_MANY {
                    let after = index;
                    self.breaks(Breach::Step { before, after });
                }
            }
            _ => {}
        }
    }

    /// The next answer is compared with this index, or with none: what came between is not known.
    pub(super) fn resume(&mut self, last: Option<u64>) {
        self.last = last;
        self.unbroken = false;
        self.cleared();
    }

    /// A current index was read that shows no reset. `reached`: what it means, where that is known.
    pub(super) fn current(&mut self, current: u64, reached: Option<u64>) {
        if let Some((index, highest)) = self.contradicted.take()
            && current >= highest
        {
            let current = highest;
            self.breaks(Breach::Current { current, index });
        }
        if current > self.highest {
            (self.highest, self.unbroken) = (current, true);
        }
        let (Some((head, look)), Some(reached)) = (self.books.ahead.take(), reached) else {
            return;
        };
        if head > reached {
            self.strike(current, look);
        } else if look.waiting > 0 {
            self.books.strikes = 0;
        }
    }

    /// The controller was reset; `by_current`: the current index went back.
    pub(super) fn reset(&mut self, by_current: bool) {
        self.before_reset = self.last.filter(|_| by_current && self.unbroken);
        self.highest = 0;
        self.contradicted = None;
        self.resume(None);
    }

    /// What waits is no longer what was accepted.
    pub(super) fn cleared(&mut self) {
        self.books.ahead = None;
        self.books.excess = None;
    }

    /// A left space was read.
    pub(super) fn look(&mut self, look: QueueReading) {
        self.cleared();
        match look.last.checked_sub(look.waiting.into()) {
            Some(head) if head >= look.reached => self.books.ahead = Some((head, look)),
            _ => self.books.excess = Some(look),
        }
    }

    /// The left space does not fit. What another host cleared looks like that too, but then the head it names stands
    /// still until the current index is right again.
    fn strike(&mut self, current: u64, look: QueueReading) {
        let head = look.last.saturating_sub(look.waiting.into());
        if self.books.struck.replace(head) == Some(head) {
            return;
        }
        self.books.strikes += 1;
        if self.books.strikes >= TOO_MANY {
            self.breaks(Breach::LeftSpace {
                current,
                left: look.left,
                last: look.last,
            });
        }
    }

    fn breaks(&mut self, breach: Breach) {
        if !self.is_broken() {
            self.law = Law::Broken(breach);
        }
    }
}

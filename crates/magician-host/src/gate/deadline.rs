//! The deadline of a jog.

use super::JogEnd;
use crate::connection::Micros;

/// Instant at which the stop of a jog is due, with the reason: the hold time of its holder, or a bound of its way (the arm's
/// fence, the end of its axis) if that comes first.
///
/// A jog has this one deadline. It had four: of the guard, the gate, the fence and the pieces. Each was looked at in another
/// place, and none of them knew of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Deadline {
    kept_until: Micros,
    bound: Option<(Micros, JogEnd)>,
}

impl Deadline {
    /// No deadline: the caller gives one before time passes.
    pub(super) const NONE: Self = Self {
        kept_until: Micros::MAX,
        bound: None,
    };

    /// Sets the hold time, and leaves the bound as it is.
    pub(super) fn keep_until(&mut self, at: Micros) {
        self.kept_until = at;
    }

    /// Bounds the jog. The earliest bound counts: a later one does not extend it.
    pub(super) fn bound(&mut self, at: Micros, why: JogEnd) {
        if self.bound.is_none_or(|(bound, _)| at < bound) {
            self.bound = Some((at, why));
        }
    }

    /// Instant, and why the jog ends then.
    pub(super) fn next(&self) -> (Micros, JogEnd) {
        match self.bound {
            Some((at, why)) if at < self.kept_until => (at, why),
            _ => (self.kept_until, JogEnd::NotKept),
        }
    }

    /// Why the jog is over at `now`, if it is.
    pub(super) fn passed(&self, now: Micros) -> Option<JogEnd> {
        let (at, why) = self.next();
        (at <= now).then_some(why)
    }

    /// The same deadline with its instants counted from `now`.
    pub(super) fn rebased(self, now: Micros) -> Self {
        Self {
            kept_until: self.kept_until.saturating_sub(now),
            bound: self.bound.map(|(at, why)| (at.saturating_sub(now), why)),
        }
    }
}

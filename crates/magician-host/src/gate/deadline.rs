//! The single deadline of a jog.

use super::JogEnd;
use crate::connection::Micros;

/// Instant at which the stop of a jog is due, with the reason: the hold time, or a bound (the arm's
/// fence, the end of its axis) if that comes first.
///
/// A jog has only this deadline. Earlier versions had four independent ones: in guard, gate, fence
/// and pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Deadline {
    kept_until: Micros,
    bound: Option<(Micros, JogEnd)>,
}

impl Deadline {
    /// No deadline. The caller sets one before time passes.
    pub(super) const NONE: Self = Self {
        kept_until: Micros::MAX,
        bound: None,
    };

    /// Sets the end of the hold time and leaves the bound unchanged.
    pub(super) fn keep_until(&mut self, at: Micros) {
        self.kept_until = at;
    }

    /// Adds a bound. The earliest one counts: a later bound does not extend the jog.
    pub(super) fn bound(&mut self, at: Micros, why: JogEnd) {
        // On a tie the first reason stays.
        if self.bound.is_none_or(|(bound, _)| at < bound) {
            self.bound = Some((at, why));
        }
    }

    /// Instant and reason of the end.
    pub(super) fn next(&self) -> (Micros, JogEnd) {
        match self.bound {
            // On a tie the holder's silence is the reason.
            Some((at, why)) if at < self.kept_until => (at, why),
            _ => (self.kept_until, JogEnd::NotKept),
        }
    }

    /// Reason if the jog is over at `now`. `None` otherwise.
    pub(super) fn passed(&self, now: Micros) -> Option<JogEnd> {
        let (at, why) = self.next();
        (at <= now).then_some(why)
    }

    /// The same deadline with instants relative to `now`.
    pub(super) fn rebased(self, now: Micros) -> Self {
        Self {
            kept_until: self.kept_until.saturating_sub(now),
            bound: self.bound.map(|(at, why)| (at.saturating_sub(now), why)),
        }
    }
}

use std::time::Duration;

use magician_protocol::ArmInstant;

use crate::connection::Micros;

/// The arm's time, as far as the stream is concerned, beside the connection's clock.
#[derive(Clone, Copy, Debug)]
pub(super) enum Clock {
    /// It passes as there: it showed the first when that one showed the second.
    Runs(ArmInstant, Micros),
    /// It stands until it leaps: what the host does takes none of it.
    Stands(ArmInstant),
}

impl Default for Clock {
    fn default() -> Self {
        Self::Runs(ArmInstant::ZERO, 0)
    }
}

impl Clock {
    /// What it shows when the connection's shows `now`.
    pub(super) fn at(&self, now: Micros) -> ArmInstant {
        match *self {
            Self::Runs(arm, then) => arm.after_micros(now.saturating_sub(then)),
            Self::Stands(arm) => arm,
        }
    }

    /// What the connection's will show when this one shows `arm`, if that comes by itself.
    pub(super) fn comes(&self, arm: ArmInstant) -> Option<Micros> {
        match *self {
            Self::Runs(began, then) => Some(then.saturating_add(arm.micros_since(began))),
            Self::Stands(_) => None,
        }
    }

    /// Whether it shows the end of a command when that comes, and nothing between.
    pub(super) fn leaps(&self) -> bool {
        matches!(self, Self::Stands(_))
    }

    pub(super) fn leap(&mut self, now: Micros, time: Duration) -> ArmInstant {
        let arm = self.at(now) + time;
        *self = Self::Stands(arm);
        arm
    }

    pub(super) fn run(&mut self, now: Micros) {
        if let Self::Stands(arm) = *self {
            *self = Self::Runs(arm, now);
        }
    }
}

//! The arm's clock beside the connection's. For a real arm both run together; the clock of a
//! virtual arm may leap.

use std::time::Duration;

use magician_protocol::ArmInstant;

use crate::connection::Micros;

/// The arm's time as the stream sees it, relative to the connection's clock.
#[derive(Clone, Copy, Debug)]
pub(super) enum Clock {
    /// Runs with the connection's clock. The arm's clock showed the first value when the
    /// connection's clock showed the second.
    Runs(ArmInstant, Micros),
    /// Stands until the next leap: actions of the host take no time.
    Stands(ArmInstant),
}

impl Default for Clock {
    fn default() -> Self {
        Self::Runs(ArmInstant::ZERO, 0)
    }
}

impl Clock {
    /// Time of the arm when the connection's clock shows `now`.
    pub(super) fn at(&self, now: Micros) -> ArmInstant {
        match *self {
            Self::Runs(arm, then) => arm.after_micros(now.saturating_sub(then)),
            Self::Stands(arm) => arm,
        }
    }

    /// Time of the connection's clock when the arm's shows `arm`. `None` if the clock stands.
    pub(super) fn comes(&self, arm: ArmInstant) -> Option<Micros> {
        match *self {
            Self::Runs(began, then) => Some(then.saturating_add(arm.micros_since(began))),
            Self::Stands(_) => None,
        }
    }

    /// True if the clock leaps from the end of one command to the end of the next.
    pub(super) fn leaps(&self) -> bool {
        matches!(self, Self::Stands(_))
    }

    pub(super) fn leap(&mut self, now: Micros, time: Duration) -> ArmInstant {
        let arm = self.at(now) + time;
        // After a leap the clock stands, so that the host's own delays cost the arm no time.
        *self = Self::Stands(arm);
        arm
    }

    pub(super) fn run(&mut self, now: Micros) {
        // A running clock keeps its origin: setting it again would lose fractions.
        if let Self::Stands(arm) = *self {
            *self = Self::Runs(arm, now);
        }
    }
}

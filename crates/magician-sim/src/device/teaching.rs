//! The unlock key on the forearm, and the taught point not yet read (document 1.7, model section
//! 12).
//!
//! While the key is held the motors are released, a hand may move the arm, and the queue waits. A
//! host polls for new points, so periodic points are not scheduled: they are computed when the host
//! asks.

use magician_protocol::TeachTrigger;

use super::store::settings::Settings;
use crate::{ArmInstant, Micros};

/// State of the unlock key, and of the taught point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Teaching {
    held: bool,
    since: ArmInstant,
    /// Interval of periodic points.
    period: Micros,
    /// Number of periods accounted for since the key was pressed.
    periods: u64,
    new_point: bool,
}

impl Teaching {
    /// State at the start of a controller.
    pub(crate) fn at(now: ArmInstant, held: bool, period: Micros) -> Self {
        Self {
            held,
            since: now,
            // Guards the division against a period that rounds to 0.
            period: period.max(1),
            periods: 0,
            new_point: false,
        }
    }

    /// True while the key is held.
    pub(crate) fn held(&self) -> bool {
        self.held
    }

    /// Presses the key: periods count from now.
    pub(crate) fn press(&mut self, now: ArmInstant) {
        *self = Self {
            new_point: self.new_point,
            ..Self::at(now, true, self.period)
        };
    }

    /// Releases the key. With the trigger "on release" this makes a point.
    pub(crate) fn release(&mut self, settings: &Settings) {
        self.held = false;
        self.new_point |= is_due(settings, TeachTrigger::OnRelease);
    }

    /// Accounts for the periods until now; returns true if a point has fallen due.
    #[must_use]
    pub(crate) fn look_for_point(&mut self, now: ArmInstant, settings: &Settings) -> bool {
        if !self.held {
            return false;
        }
        let periods = now.micros_since(self.since) / self.period;
        // Several periods without a poll make one point: reading clears it (model section 12).
        let new = periods > std::mem::replace(&mut self.periods, periods);
        let due = new && is_due(settings, TeachTrigger::Periodic);
        self.new_point |= due;
        due
    }

    pub(crate) fn has_point(&self) -> bool {
        self.new_point
    }

    /// Returns true if there is a point, and clears it.
    pub(crate) fn take_point(&mut self) -> bool {
        std::mem::take(&mut self.new_point)
    }
}

/// True if points are enabled with this trigger.
fn is_due(settings: &Settings, trigger: TeachTrigger) -> bool {
    settings.teach_mode.mode == trigger && settings.teach_enabled.is_enabled.is_on()
}

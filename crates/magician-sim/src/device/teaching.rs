//! The unlock key on the forearm, and the point that was not read yet (document 1.7, model section
//! 12).
//!
//! While the key is held the motors are released and a hand may move the arm; the queue waits. What
//! the controller then reports as a new point is asked for and not sent, so it is worked out when
//! it is asked for.

use magician_protocol::TeachTrigger;

use super::store::settings::Settings;
use crate::{ArmInstant, Micros};

/// The unlock key, and the point that was not read yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Teaching {
    held: bool,
    since: ArmInstant,
    /// How often a point is new while the key is held.
    period: Micros,
    /// Periods that have been looked at since the key was pressed.
    periods: u64,
    new_point: bool,
}

impl Teaching {
    /// The key as a controller finds it that starts at an instant.
    pub(crate) fn at(now: ArmInstant, held: bool, period: Micros) -> Self {
        Self {
            held,
            since: now,
            period: period.max(1),
            periods: 0,
            new_point: false,
        }
    }

    /// Whether the key is held: the motors are released.
    pub(crate) fn held(&self) -> bool {
        self.held
    }

    /// The key is pressed: periods begin anew.
    pub(crate) fn press(&mut self, now: ArmInstant) {
        *self = Self {
            new_point: self.new_point,
            ..Self::at(now, true, self.period)
        };
    }

    /// The key is released, which may be what makes a point.
    pub(crate) fn release(&mut self, settings: &Settings) {
        self.held = false;
        self.new_point |= is_due(settings, TeachTrigger::OnRelease);
    }

    /// Finds out whether a point has become due by now while the key is held.
    #[must_use]
    pub(crate) fn look_for_point(&mut self, now: ArmInstant, settings: &Settings) -> bool {
        if !self.held {
            return false;
        }
        let periods = now.micros_since(self.since) / self.period;
        let new = periods > std::mem::replace(&mut self.periods, periods);
        let due = new && is_due(settings, TeachTrigger::Periodic);
        self.new_point |= due;
        due
    }

    pub(crate) fn has_point(&self) -> bool {
        self.new_point
    }

    /// Reports the point, once.
    pub(crate) fn take_point(&mut self) -> bool {
        std::mem::take(&mut self.new_point)
    }
}

/// Whether points are to be made in that way.
fn is_due(settings: &Settings, trigger: TeachTrigger) -> bool {
    settings.teach_mode.mode == trigger && settings.teach_enabled.is_enabled.is_on()
}

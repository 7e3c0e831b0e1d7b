//! The belt of the conveyor: its travel at an instant, and the instant of a given travel.

use super::ObjectPose;
use crate::scenario::Conveyor;
use crate::{ArmInstant, Micros};

/// Travel of the belt: linear in time between two changes of its stepper.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Belt {
    since: ArmInstant,
    /// Travel at `since`, mm.
    travel: f64,
    /// Speed since then, mm/s.
    rate: f64,
}

impl Belt {
    pub(super) fn travel(&self, now: ArmInstant) -> f64 {
        let elapsed = now.micros_since(self.since) as f64;
        self.travel + self.rate * elapsed * 1e-6
    }

    pub(super) fn run(&mut self, now: ArmInstant, rate: f64) {
        *self = Self {
            since: now,
            travel: self.travel(now),
            rate,
        };
    }

    pub(super) fn runs(&self) -> bool {
        self.rate != 0.0
    }

    /// First whole microsecond after `now` at which the belt has reached this travel; `None` if it
    /// does not.
    pub(super) fn time_at(&self, travel: f64, now: ArmInstant) -> Option<ArmInstant> {
        let elapsed = (travel - self.travel) / self.rate * 1e6;
        // 1e15 us are 31 years: beyond any run, and still exact in `f64`. NaN is refused, too.
        if !(0.0..1e15).contains(&elapsed) {
            return None;
        }
        let at = self.since.after_micros(elapsed.ceil() as Micros);
        Some(at).filter(|at| *at > now)
    }
}

impl Conveyor {
    /// Frame that moves with the belt, X along it.
    pub(super) fn frame_after(&self, travel: f64) -> ObjectPose {
        let along = ObjectPose {
            x: travel,
            ..ObjectPose::default()
        };
        self.frame().then(&along)
    }
}

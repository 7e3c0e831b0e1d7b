//! Standing alarms, and their hold on the queue (model section 4).
//!
//! An alarm from 0x40 on may drop by itself when its joint is back within its limits, but a
//! blocking alarm has stopped the queue by then. So the hold is a separate latch, which only a
//! clear resets (a choice: `LatchedHold`).

use magician_protocol::{Alarm, AlarmSet};

/// Alarm bits and the latch of the hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alarms {
    standing: AlarmSet,
    latched: bool,
    /// True if the firmware's queue obeys the latch.
    obeys_latch: bool,
}

impl Alarms {
    pub(crate) fn new(obeys_latch: bool) -> Self {
        Self {
            standing: AlarmSet::default(),
            latched: false,
            obeys_latch,
        }
    }

    pub(crate) fn standing(&self) -> AlarmSet {
        self.standing
    }

    /// True if a blocking alarm was raised and not cleared. The latch outlives a limit alarm that
    /// has dropped.
    pub(crate) fn latched(&self) -> bool {
        self.latched
    }

    /// True if an alarm holds the queue.
    pub(crate) fn hold_queue(&self) -> bool {
        self.latched && self.obeys_latch
    }

    /// Sets an alarm and returns true if it is new.
    pub(crate) fn set(&mut self, code: u8) -> bool {
        let new = !self.standing.contains(code);
        self.standing.insert(code);
        // 0x00 to 0x07 are notes of the controller; every other alarm holds the queue (model
        // section 4).
        self.latched |= Alarm::blocks(code);
        new
    }

    /// Drops an alarm whose cause is gone; the latch stays.
    pub(crate) fn drop_alarm(&mut self, code: u8) {
        self.standing.remove(code);
    }

    /// Clears every alarm whose cause is gone and returns them. The latch ends if no blocking alarm
    /// is left.
    pub(crate) fn clear(&mut self, cause_stands: impl Fn(u8) -> bool) -> AlarmSet {
        let before = self.standing;
        // A joint still at its limit would raise its alarm again at once, so it stays set.
        let cleared: AlarmSet = before.codes().filter(|code| !cause_stands(*code)).collect();
        for code in cleared.codes() {
            self.standing.remove(code);
        }
        self.latched = self.standing.blocking();
        cleared
    }
}

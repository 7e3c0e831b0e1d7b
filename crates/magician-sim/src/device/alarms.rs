//! The alarms that stand, and the hold they put on the queue (model section 4).

use magician_protocol::{Alarm, AlarmSet};

/// Alarm bits and the latch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alarms {
    standing: AlarmSet,
    latched: bool,
    /// Whether the firmware's queue heeds the latch.
    hold: bool,
}

impl Alarms {
    pub(crate) fn new(hold: bool) -> Self {
        Self {
            standing: AlarmSet::default(),
            latched: false,
            hold,
        }
    }

    pub(crate) fn standing(&self) -> AlarmSet {
        self.standing
    }

    /// Whether an alarm that blocks was raised and not cleared. The latch outlives a limit bit that
    /// has dropped.
    pub(crate) fn latched(&self) -> bool {
        self.latched
    }

    /// Whether an alarm holds the queue.
    pub(crate) fn hold_queue(&self) -> bool {
        self.latched && self.hold
    }

    /// Sets an alarm; whether it is new.
    pub(crate) fn set(&mut self, code: u8) -> bool {
        let new = !self.standing.contains(code);
        self.standing.insert(code);
        self.latched |= Alarm::blocks(code);
        new
    }

    /// An alarm drops by itself; the latch stays.
    pub(crate) fn drop_alarm(&mut self, code: u8) {
        self.standing.remove(code);
    }

    /// Clears every alarm whose cause does not stand, and gives those that went; the latch ends
    /// when none is left that blocks.
    pub(crate) fn clear(&mut self, cause_stands: impl Fn(u8) -> bool) -> AlarmSet {
        let before = self.standing;
        let cleared: AlarmSet = before.codes().filter(|code| !cause_stands(*code)).collect();
        for code in cleared.codes() {
            self.standing.remove(code);
        }
        self.latched = self.standing.blocking();
        cleared
    }
}

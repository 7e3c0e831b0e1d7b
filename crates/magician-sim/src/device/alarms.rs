//! The alarms that stand, and the hold they put on the queue (model section 4).

use magician_protocol::{Alarm, AlarmSet};

/// Alarm bits and the latch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Alarms {
    standing: AlarmSet,
    held: bool,
}

impl Alarms {
    pub(crate) fn standing(&self) -> AlarmSet {
        self.standing
    }

    /// Whether an alarm holds the queue. Latched: the hold outlives a limit bit that has dropped.
    pub(crate) fn held(&self) -> bool {
        self.held
    }

    /// Raises an alarm; whether it is new.
    pub(crate) fn raise(&mut self, code: u8) -> bool {
        let new = !self.standing.contains(code);
        self.standing.insert(code);
        self.held |= Alarm::blocks(code);
        new
    }

    /// An alarm drops by itself; the hold stays.
    pub(crate) fn drop_alarm(&mut self, code: u8) {
        self.standing.remove(code);
    }

    /// Clears every alarm whose cause does not stand; the hold ends when none is left that blocks.
    pub(crate) fn clear(&mut self, cause_stands: impl Fn(u8) -> bool) {
        let codes = self.standing;
        for code in codes.codes().filter(|code| !cause_stands(*code)) {
            self.standing.remove(code);
        }
        self.held = self.standing.blocking();
    }
}

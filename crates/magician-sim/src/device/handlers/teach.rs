//! Hand teaching (document 1.7, model section 12).
//!
//! While the unlock key on the forearm is held the motors are released and a hand may move the arm; the queue waits.
//! What the controller then reports as a new point is asked for and not sent, so it is worked out when it is asked for.

use magician_motion::JointAngles;
use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs, TeachTrigger};

use crate::Micros;
use crate::convert::micros;
use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn};
use crate::fidelity::Assumption;

/// The unlock key, and the point that nobody has asked for yet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Teaching {
    held: bool,
    since: Micros,
    /// Periods that have been looked at since the key was pressed.
    periods: u64,
    new_point: bool,
}

impl Teaching {
    /// The key as a controller finds it that starts at an instant.
    pub(crate) fn at(now: Micros, held: bool) -> Self {
        Self {
            held,
            since: now,
            ..Self::default()
        }
    }

    /// Whether the key is held: the motors are released.
    pub(crate) fn held(&self) -> bool {
        self.held
    }
}

impl Device {
    /// The unlock key is pressed or released. Pressed, it ends what moves and has the sensors read; released, the
    /// motors hold the arm where it is.
    pub(crate) fn unlock(&mut self, held: bool) {
        if held == self.teaching.held {
            return;
        }
        self.look_for_point();
        self.assume(Assumption::TeachKey);
        if held {
            self.halt();
            self.actuators.burn(0.0);
            self.read_sensors();
            self.teaching = Teaching {
                new_point: self.teaching.new_point,
                ..Teaching::at(self.now, true)
            };
        } else {
            self.teaching.held = false;
            let due = self.settings.teach_mode.mode == TeachTrigger::OnRelease;
            self.teaching.new_point |= due && self.settings.teach_enabled.is_enabled.is_on();
        }
    }

    /// A hand moves the arm there, as far as it goes. Without the key the motors hold it where it is.
    pub(crate) fn guide(&mut self, joints: JointAngles) {
        if !self.teaching.held {
            return;
        }
        let before = self.posture().joints;
        let really = self.bent_to(joints, before);
        self.be_moved(really);
    }

    /// Whether a point waits that nobody has asked for.
    pub(crate) fn has_new_point(&mut self) -> bool {
        self.look_for_point();
        self.teaching.new_point
    }

    /// Finds out whether a point has become due by now while the key is held.
    fn look_for_point(&mut self) {
        if !self.teaching.held {
            return;
        }
        let period = micros(self.profile.teach.period).max(1);
        let periods = self.now.saturating_sub(self.teaching.since) / period;
        let new = periods > std::mem::replace(&mut self.teaching.periods, periods);
        let due = self.settings.teach_mode.mode == TeachTrigger::Periodic;
        if new && due && self.settings.teach_enabled.is_enabled.is_on() {
            self.teaching.new_point = true;
            self.assume(Assumption::TeachPeriod);
        }
    }
}

impl Report for HhtTrigMode {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.teach_mode
    }
}

impl Apply for HhtTrigMode {
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.look_for_point();
        core.settings.teach_mode = *self;
        Step::Done
    }
}

impl Report for HhtTrigOutputEnabled {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.teach_enabled
    }
}

impl Apply for HhtTrigOutputEnabled {
    /// Disabled, it forgets a point that nobody has asked for.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.look_for_point();
        core.settings.teach_enabled = *self;
        core.teaching.new_point &= self.is_enabled.is_on();
        Step::Done
    }
}

impl Report for HhtTrigOutput {
    /// Once for each point: reading it clears it.
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.look_for_point();
        let new_point = std::mem::take(&mut core.teaching.new_point);
        Self {
            is_triggered: Flag::from(new_point),
        }
    }
}

//! What a picture tells.

use magician_protocol::{Alarm, AlarmSet, Readable};

use super::standing::VALIDITY;
use super::{
    ArmOutputs, ArmPicture, HomingTracker, LightsOut, MotionInFlight, OwnCommands, Standing,
    StateReadings,
};
use crate::connection::Micros;
use crate::gate::Motors;
use crate::stream::ArmPace;

/// What is known at one moment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ArmSnapshot {
    /// Last readings; `None` before each of them was read.
    pub readings: Option<StateReadings>,
    /// True if the arm was seen to be homed since power-up, false while its alarms say that it was not.
    pub homed: Option<bool>,
    /// True if motion of this connection may be under way.
    pub moving: bool,
    /// Tool, laser, suction cup, gripper and speed.
    pub outputs: ArmOutputs,
    /// Number of times that an output became unknown, so that it has to be read again.
    pub lapses: u64,
}

impl ArmPicture {
    /// A value that counts at `now`, us. `None` as well if the arm may have been switched off and on without that being
    /// seen, and a second after it was read on a line that others use.
    #[must_use]
    pub fn setting<T: Readable>(&self, now: Micros, query: &T::Query) -> Option<T> {
        let since = match (self.standing.shows_resets(), self.shared_line) {
            (false, _) => return None,
            (true, false) => 0,
            (true, true) => now.saturating_sub(VALIDITY),
        };
        self.values.settings.get_with(query, since)
    }

    /// All of it that is shown.
    #[must_use]
    pub fn snapshot(&self) -> ArmSnapshot {
        ArmSnapshot {
            readings: self.readings.all(),
            homed: self.homed(),
            moving: self.motion.is_moving(),
            outputs: self.outputs(),
            lapses: self.values.lapses,
        }
    }

    /// Motion that was set going and not seen finished.
    #[must_use]
    pub const fn motion(&self) -> &MotionInFlight {
        &self.motion
    }

    /// Commands that this connection has put into the queue lately.
    #[must_use]
    pub const fn own(&self) -> &OwnCommands {
        &self.own
    }

    /// Motor outputs, as this connection set them.
    #[must_use]
    pub const fn motors(&self) -> &Motors {
        &self.motors
    }

    /// Homing since power-up.
    #[must_use]
    pub const fn homing(&self) -> &HomingTracker {
        &self.homing
    }

    /// Where the arm was when this connection put its laser out, if no command was queued since and the arm has told its
    /// pose.
    #[must_use]
    pub fn lights_out(&self) -> Option<LightsOut> {
        self.darkness.and_then(|darkness| darkness.seen())
    }

    /// How fast the arm is beside the check's times.
    #[must_use]
    pub const fn pace(&self) -> ArmPace {
        self.pace
    }

    /// Where the arm was left, and the last look at its queue.
    #[must_use]
    pub const fn standing(&self) -> &Standing {
        &self.standing
    }

    /// Alarms that were read within the last second, if none of them holds the queue and nothing was sent since that
    /// changes them.
    #[must_use]
    pub fn harmless_alarms(&self, now: Micros) -> Option<AlarmSet> {
        let alarms = self.readings.alarms_since(now.saturating_sub(VALIDITY));
        alarms.filter(|alarms| !alarms.blocking())
    }

    /// True if the queue runs for certain: this connection has started it, nothing has held it since, and no other program
    /// can have stopped it.
    #[must_use]
    pub fn runs_queue(&self) -> bool {
        let started = self.motion.started() == Some(true);
        started && self.standing.runs_queue() && !self.shared_line
    }

    /// Current index that was read last.
    #[must_use]
    pub const fn current_index(&self) -> Option<u64> {
        self.readings.current
    }

    /// Serial number of the arm, once it has told it.
    #[must_use]
    pub fn serial(&self) -> Option<&str> {
        self.readings.serial.as_deref()
    }

    /// True if the arm was seen to be homed since power-up, false while its alarms say that it was not.
    #[must_use]
    pub fn homed(&self) -> Option<bool> {
        if self.homing.is_homed() {
            return Some(true);
        }
        let reset =
            (self.readings.alarms).is_some_and(|alarms| alarms.contains(Alarm::ResetOccurred));
        reset.then_some(false)
    }
}

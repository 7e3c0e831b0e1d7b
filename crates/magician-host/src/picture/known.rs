//! Queries of the picture.

use magician_protocol::{Alarm, AlarmSet, Readable};

use super::standing::STATE_VALIDITY;
use super::{
    ArmOutputs, ArmPicture, HomingTracker, LaserOffPose, MotionInFlight, OwnCommands, RestState,
    StateReadings,
};
use crate::connection::Micros;
use crate::gate::Motors;
use crate::stream::ArmPace;

/// State of an arm at one moment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ArmSnapshot {
    /// Last readings. `None` until each of them was read.
    pub readings: Option<StateReadings>,
    /// True if the arm was seen homed since power-up, false while its alarms say that it was not.
    /// `None` if unknown.
    pub homed: Option<bool>,
    /// True if motion of this connection may be under way.
    pub moving: bool,
    /// Tool, laser, suction cup, gripper and speed.
    pub outputs: ArmOutputs,
    /// Number of times that an output became unknown, so that it must be read again.
    pub lapses: u64,
}

impl ArmPicture {
    /// Value of a setting that is valid at `now`, us.
    ///
    /// `None` if it is not known, if the arm may have been switched off and on unnoticed, and, on a
    /// shared line, a second after it was read.
    #[must_use]
    pub fn setting<T: Readable>(&self, now: Micros, query: &T::Query) -> Option<T> {
        let since = match (self.standing.shows_resets(), self.shared_line) {
            // An arm with index 0 may have been switched off and on without a trace.
            (false, _) => return None,
            (true, false) => 0,
            (true, true) => now.saturating_sub(STATE_VALIDITY),
        };
        self.values.settings.get_with(query, since)
    }

    /// Everything that is displayed.
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

    /// Motion that was started and not seen finished.
    #[must_use]
    pub const fn motion(&self) -> &MotionInFlight {
        &self.motion
    }

    /// Commands that this connection has put into the queue recently.
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

    /// Pose at which this connection switched the laser off. `None` if a command was queued since,
    /// or the arm has not reported a pose.
    #[must_use]
    pub fn lights_out(&self) -> Option<LaserOffPose> {
        self.darkness.and_then(|darkness| darkness.seen())
    }

    /// Pace of the arm relative to the durations that checks calculate.
    #[must_use]
    pub const fn pace(&self) -> ArmPace {
        self.pace
    }

    /// Pose where the arm was left, and the last reading of its queue.
    #[must_use]
    pub const fn standing(&self) -> &RestState {
        &self.standing
    }

    /// Alarms read within the last second. `None` if one of them holds the queue, or something was
    /// sent since that may change them.
    #[must_use]
    pub fn harmless_alarms(&self, now: Micros) -> Option<AlarmSet> {
        let alarms = self
            .readings
            .alarms_since(now.saturating_sub(STATE_VALIDITY));
        alarms.filter(|alarms| !alarms.blocking())
    }

    /// True if the queue certainly runs: this connection has started it, nothing has held it since,
    /// and no other program can have stopped it.
    #[must_use]
    pub fn runs_queue(&self) -> bool {
        let started = self.motion.started() == Some(true);
        started && self.standing.runs_queue() && !self.shared_line
    }

    /// Current index read last. `None` before the first reading.
    #[must_use]
    pub const fn current_index(&self) -> Option<u64> {
        self.readings.current
    }

    /// Serial number of the arm. `None` if it has not reported one.
    #[must_use]
    pub fn serial(&self) -> Option<&str> {
        self.readings.serial.as_deref()
    }

    /// True if the arm was seen homed since power-up, false while its alarms say that it was not.
    /// `None` if unknown.
    #[must_use]
    pub fn homed(&self) -> Option<bool> {
        if self.homing.is_homed() {
            return Some(true);
        }
        // After power-up the alarm stands until it is cleared, so its presence proves a reset, but
        // its absence proves nothing.
        let reset =
            (self.readings.alarms).is_some_and(|alarms| alarms.contains(Alarm::ResetOccurred));
        reset.then_some(false)
    }
}

//! What a picture tells.

use magician_protocol::commands::Pose;
use magician_protocol::{Alarm, AlarmSet, NoArgs, Readable};

use super::standing::VALIDITY;
use super::{
    ArmOutputs, ArmPicture, HomingTracker, LightsOut, MotionInFlight, OwnCommands, QueueLook,
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
    /// A value, if it is known and was so at `since` (us) or later.
    #[must_use]
    pub fn get<T: Readable<Query = NoArgs>>(&self, since: Micros) -> Option<T> {
        self.values.get_with(&NoArgs, since)
    }

    /// A value that counts at `now`, us. `None` as well if the arm may have been switched off and on without that being
    /// seen, and a second after it was read on a line that others use.
    #[must_use]
    pub fn setting<T: Readable>(&self, now: Micros, query: &T::Query) -> Option<T> {
        let since = match (self.standing.shows_resets(), self.shared_line) {
            (false, _) => return None,
            (true, false) => 0,
            (true, true) => now.saturating_sub(VALIDITY),
        };
        self.values.get_with(query, since)
    }

    /// Tool, laser, suction cup, gripper and speed.
    #[must_use]
    pub fn outputs(&self) -> ArmOutputs {
        self.values.outputs(self.laser_pins)
    }

    /// All of it that is shown.
    #[must_use]
    pub fn snapshot(&self) -> ArmSnapshot {
        ArmSnapshot {
            readings: self.readings.all(),
            homed: self.homed(),
            moving: self.motion.is_moving(),
            outputs: self.outputs(),
            lapses: self.values.lapses(),
        }
    }

    /// True if commands of this connection may have lit the laser, by its pins or otherwise.
    #[must_use]
    pub fn may_be_lit(&self) -> bool {
        self.values.may_be_lit()
    }

    /// True if commands of this connection may have raised one of the laser's pins.
    #[must_use]
    pub fn pins_may_be_high(&self) -> bool {
        self.values.pins_may_be_high()
    }

    /// True if the levels of the laser's pins are known.
    #[must_use]
    pub const fn knows_laser_pins(&self) -> bool {
        self.values.knows_laser_pins()
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

    /// Number of frames so far that were no reads.
    #[must_use]
    pub const fn orders(&self) -> u64 {
        self.standing.orders()
    }

    /// The last look at the queue, if it is fresh and nothing but reads was sent since.
    #[must_use]
    pub fn fresh_look(&self, now: Micros) -> Option<QueueLook> {
        self.standing.fresh_look(now)
    }

    /// Pose of an arm by its last motion, if this look at its queue fits and nothing has moved it since.
    #[must_use]
    pub fn standing(&self, now: Micros, look: &QueueLook) -> Option<Pose> {
        self.standing.pose(now, look)
    }

    /// True if an arm at this pose is where its last motion over this connection has left it.
    #[must_use]
    pub fn was_left_at(&self, there: &Pose, look: &QueueLook) -> bool {
        self.standing.was_left_at(there, look)
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
        self.readings.current()
    }

    /// Serial number of the arm, once it has told it.
    #[must_use]
    pub fn serial(&self) -> Option<&str> {
        self.readings.serial()
    }

    /// True if the arm was seen to be homed since power-up, false while its alarms say that it was not.
    #[must_use]
    pub fn homed(&self) -> Option<bool> {
        if self.homing.is_homed() {
            return Some(true);
        }
        let alarms = self.readings.alarms();
        let reset = alarms.is_some_and(|alarms| alarms.contains(Alarm::ResetOccurred));
        reset.then_some(false)
    }
}

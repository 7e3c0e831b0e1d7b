//! Functions for front ends only: command line, station, language bindings.

use std::time::Duration;

use magician_protocol::commands::{EndEffectorParams, Pose};
use magician_protocol::{Alarm, AlarmSet, Set};

use super::{Arm, EndNotice};
use crate::Result;
use crate::preflight::Guards;

/// Access to an arm for front ends, returned by [`Arm::front_end`]. Programs do not need it, and it
/// may change at any time.
#[derive(Clone, Copy, Debug)]
pub struct FrontEnd<'a> {
    arm: &'a Arm,
}

impl Arm {
    /// Returns the functions for front ends.
    #[doc(hidden)]
    #[must_use]
    pub const fn front_end(&self) -> FrontEnd<'_> {
        FrontEnd { arm: self }
    }
}

impl FrontEnd<'_> {
    /// True if the arm is a virtual one in this process, and ends with it.
    #[must_use]
    pub fn is_in_process(self) -> bool {
        self.arm.inner.in_process
    }

    /// Returns the number of a virtual arm, unique among all that this process has had; `None` for
    /// any other arm.
    #[must_use]
    pub fn virtual_number(self) -> Option<u64> {
        #[cfg(feature = "sim")]
        return { self.arm.inner.virtual_arm.as_ref() }.map(crate::VirtualArm::number);
        #[cfg(not(feature = "sim"))]
        None
    }

    /// True if the line delivers frames in order. UDP does not: it may also duplicate a command,
    /// which then has an index that this connection never received.
    #[must_use]
    pub fn keeps_order(self) -> bool {
        self.arm.inner.shared.ordered
    }

    /// Returns the notice that the line will end
    /// ([`Options::end_notice`](super::Options::end_notice)).
    #[must_use]
    pub fn end_notice(self) -> EndNotice {
        self.arm.inner.options.end_notice.clone()
    }

    /// Ends the trace of this connection ([`Options::trace`](super::Options::trace)) and of all
    /// others with the same tracer. For owners that keep the handle longer than its connection.
    #[cfg(feature = "trace")]
    pub fn end_trace(self) {
        if let Some(tracer) = &self.arm.inner.options.trace {
            tracer.end();
        }
    }

    /// Returns a handle of the same connection whose calls have at least this timeout, if
    /// [`Options::timeout`] is shorter.
    ///
    /// For calls that belong to a long job, which a pause of some seconds on the line must not end.
    /// Runs have their own: [`RunOptions::patience`](crate::RunOptions::patience).
    ///
    /// [`Options::timeout`]: super::Options::timeout
    #[must_use]
    pub fn patient(self, patience: Duration) -> Arm {
        Arm {
            patience,
            ..self.arm.clone()
        }
    }

    /// Returns a handle of the same connection that sends a [`JogCmd`](crate::commands::JogCmd)
    /// unchanged; see [`Options::raw_jogs`](super::Options::raw_jogs).
    #[must_use]
    pub fn passing_jogs(self) -> Arm {
        Arm {
            passes_jogs: true,
            ..self.arm.clone()
        }
    }

    /// Returns the pose of the arm: known from the end of its last motion over this connection if
    /// nothing was queued since, else read. Relative moves can then be checked and sent without a
    /// separate read.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get).
    pub async fn known_pose(self) -> Result<Pose> {
        self.arm.come_to_rest().await?;
        let look = self.arm.known().look_at_queue().await?;
        let known = self.arm.picture().standing().pose(self.arm.clock(), &look);
        match known {
            Some(pose) => Ok(pose),
            None => {
                let pose = self.arm.get().await?;
                // The arm is where our last command left it, and nothing waits: remember it, so
                // that the next call need not read.
                let was_left_there = self.arm.picture().standing().was_left_at(&pose, &look);
                if look.waiting() == 0 && was_left_there {
                    self.arm.known().note_standing(look.current, pose);
                }
                Ok(pose)
            }
        }
    }

    /// True if these alarms may be caused by a tool that was never set: one of them reports an
    /// unreachable pose, and the tool bias is 0. [`Alarm::TOOL_UNKNOWN`] is the sentence for it.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get).
    pub async fn tool_is_unknown(self, alarms: &AlarmSet) -> Result<bool> {
        if !alarms.codes().any(Alarm::is_kinematic) {
            return Ok(false);
        }
        Ok(self.arm.get::<EndEffectorParams>().await?.is_zero())
    }

    /// Checks the alarms and homing guards before these commands, as [`run`](Arm::run) does first.
    /// While an alarm holds the queue, only homing is allowed.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) for the guard `alarms`,
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for `require_homed`; else as
    /// [`get`](Arm::get).
    pub async fn check_alarms(self, commands: &[Set], guards: Guards) -> Result<()> {
        let alarms = self.arm.alarms().await?;
        self.arm.refuse_alarms(alarms, commands, guards).await
    }

    /// Checks that the arm is ready for a program of many steps: as
    /// [`check_alarms`](Self::check_alarms), and the laser must be off. It does not look for
    /// commands of other programs in the queue; an empty run does.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if the laser is on, else as
    /// [`check_alarms`](Self::check_alarms).
    pub async fn check_ready(self, commands: &[Set], guards: Guards) -> Result<()> {
        self.check_alarms(commands, guards).await?;
        self.arm.laser().check_off().await
    }
}

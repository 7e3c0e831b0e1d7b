//! What only front ends need: the command, the station, the bindings of other languages.

use std::time::Duration;

use magician_protocol::commands::{EndEffectorParams, Pose};
use magician_protocol::{Alarm, AlarmSet, Set};

use super::{Arm, EndNotice};
use crate::Result;
use crate::preflight::Guards;

/// Access of front ends to an arm: [`Arm::front_end`] hands it out. Programs have no use for it, and it may change at any time.
#[derive(Clone, Copy, Debug)]
pub struct FrontEnd<'a> {
    arm: &'a Arm,
}

impl Arm {
    /// What only front ends need.
    #[doc(hidden)]
    #[must_use]
    pub const fn front_end(&self) -> FrontEnd<'_> {
        FrontEnd { arm: self }
    }
}

impl FrontEnd<'_> {
    /// Whether it is a virtual arm in this process, which ends with it.
    #[must_use]
    pub fn is_in_process(self) -> bool {
        self.arm.inner.in_process
    }

    /// Number that tells a virtual arm in this process from all others that this process has had; `None` for any other arm.
    #[must_use]
    pub fn virtual_number(self) -> Option<u64> {
        #[cfg(feature = "sim")]
        return { self.arm.inner.virtual_arm.as_ref() }.map(crate::VirtualArm::number);
        #[cfg(not(feature = "sim"))]
        None
    }

    /// Whether the line keeps the order of what it carries. UDP does not: it may also carry a command twice, and the queue
    /// then has an index that no command of this connection's was told.
    #[must_use]
    pub fn keeps_order(self) -> bool {
        self.arm.inner.shared.ordered
    }

    /// Notice of the end of its line ([`Options::end_notice`](super::Options::end_notice)).
    #[must_use]
    pub fn end_notice(self) -> EndNotice {
        self.arm.inner.options.end_notice.clone()
    }

    /// Ends the trace of this connection ([`Options::trace`](super::Options::trace)), and of others that have the same:
    /// for an owner that keeps the handle after its connection.
    #[cfg(feature = "trace")]
    pub fn end_trace(self) {
        if let Some(tracer) = &self.arm.inner.options.trace {
            tracer.end();
        }
    }

    /// A handle of the same connection whose calls wait for an answer for so long at least, where [`Options::timeout`] is
    /// shorter: for what belongs to a long job, which a line that is held for some seconds must not end. Runs have their own:
    /// [`RunOptions::patience`](crate::RunOptions::patience).
    ///
    /// [`Options::timeout`]: super::Options::timeout
    #[must_use]
    pub fn patient(self, patience: Duration) -> Arm {
        Arm {
            patience,
            ..self.arm.clone()
        }
    }

    /// A handle of the same connection that sends a [`JogCmd`](crate::commands::JogCmd) as it is: see
    /// [`Options::raw_jogs`](super::Options::raw_jogs).
    #[must_use]
    pub fn passing_jogs(self) -> Arm {
        Arm {
            passes_jogs: true,
            ..self.arm.clone()
        }
    }

    /// Where the arm is: where its last motion over this connection ended a moment ago, if nothing was put into its queue since,
    /// and else read. What is relative to it can be checked and sent without a read of its own.
    ///
    /// # Errors
    /// As [`get`](Arm::get).
    pub async fn known_pose(self) -> Result<Pose> {
        self.arm.come_to_rest().await?;
        let look = self.arm.known().look_at_queue().await?;
        let known = self.arm.picture().standing().pose(self.arm.clock(), &look);
        match known {
            Some(pose) => Ok(pose),
            None => {
                let pose = self.arm.get().await?;
                let was_left_there = self.arm.picture().standing().was_left_at(&pose, &look);
                if look.waiting() == 0 && was_left_there {
                    self.arm.known().note_standing(look.current, pose);
                }
                Ok(pose)
            }
        }
    }

    /// Whether these alarms may come from a tool that the arm was never told of: one of them says that a pose is out of
    /// reach, and the tool bias is 0. [`Alarm::TOOL_UNKNOWN`] is the sentence for it.
    ///
    /// # Errors
    /// As [`get`](Arm::get).
    pub async fn tool_is_unknown(self, alarms: &AlarmSet) -> Result<bool> {
        if !alarms.codes().any(Alarm::is_kinematic) {
            return Ok(false);
        }
        Ok(self.arm.get::<EndEffectorParams>().await?.is_zero())
    }

    /// Whether the arm is ready for these commands, as far as its alarms tell and these guards ask: what
    /// [`run`](Arm::run) looks at first. An alarm that holds the queue lets nothing run but homing.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) for the guard `alarms`, [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for `require_homed`; else as
    /// [`get`](Arm::get).
    pub async fn check_alarms(self, commands: &[Set], guards: Guards) -> Result<()> {
        let alarms = self.arm.alarms().await?;
        self.arm.refuse_alarms(alarms, commands, guards).await
    }

    /// Whether the arm is ready for a program of many steps: as [`check_alarms`](Self::check_alarms), and with the laser dark,
    /// as every program begins. Whether commands of others wait in its queue, a run of nothing tells.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) when the laser is on, else as [`check_alarms`](Self::check_alarms).
    pub async fn check_ready(self, commands: &[Set], guards: Guards) -> Result<()> {
        self.check_alarms(commands, guards).await?;
        self.arm.laser().check_off().await
    }
}

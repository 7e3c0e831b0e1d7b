//! Known values of the arm, which are read only if the picture does not have them.
//!
//! A move depends on some ten settings, the queue and the pose. To read all of them before each
//! move would cost more frames than the move. [`Known`] returns what the picture holds if that is
//! still valid, and reads the arm otherwise. How long a value is valid is decided by the picture
//! (`magician-host/src/picture`).

use std::time::Duration;

use magician_host::ArmOutputs;
use magician_host::picture::QueueLook;
use magician_protocol::commands::{
    EndEffectorGripper, EndEffectorParams, EndEffectorSuctionCup, Pose, PtpCommonParams,
    QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use magician_protocol::{AlarmSet, NoArgs, Readable};
use tokio::time::sleep;

use super::Arm;
use super::driver::micros;
use super::laser::answered;
use crate::connection::Micros;
use crate::{ArmSnapshot, RestDetector, Result};

impl Arm {
    /// Returns access to known values, with a read as fallback.
    pub(super) fn known(&self) -> Known<'_> {
        Known { arm: self }
    }

    pub(super) fn clock(&self) -> Micros {
        micros(self.inner.shared.begun.elapsed())
    }

    /// Returns tool, laser, suction cup, gripper and speed; each is `None` if unknown.
    ///
    /// The values follow from the commands sent over this connection and from the answers of the
    /// arm. A queued command counts once the arm has finished it, which the current index shows.
    /// The laser counts as lit as soon as a command that may burn is sent, until a command that
    /// switches it off was answered or has finished. Changes by another program show only when
    /// read: [`read_outputs`](Self::read_outputs). Sends no frame.
    #[must_use]
    pub fn outputs(&self) -> ArmOutputs {
        self.picture().outputs()
    }

    /// Reads the [`outputs`](Self::outputs); each is `None` if the arm does not support the
    /// reading.
    ///
    /// # Errors
    /// Same as [`get`](Self::get); readings that some arms do not support are no error.
    pub async fn read_outputs(&self) -> Result<ArmOutputs> {
        // Finished commands of other programs invalidate earlier readings, and the queue shows them
        // first.
        self.known().look_at_queue().await?;
        answered(self.get::<EndEffectorSuctionCup>().await)?;
        answered(self.get::<EndEffectorGripper>().await)?;
        answered(self.get::<EndEffectorParams>().await)?;
        answered(self.get::<PtpCommonParams>().await)?;
        self.laser().is_on().await?;
        self.laser().learn_pins().await?;
        Ok(self.outputs())
    }

    /// Returns a snapshot of the arm for display, from the answers over this connection. Sends no
    /// frame.
    #[must_use]
    pub fn snapshot(&self) -> ArmSnapshot {
        self.picture().snapshot()
    }
}

/// Access to known values of an arm, with a read as fallback.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    arm: &'a Arm,
}

impl Known<'_> {
    /// Returns a setting, known or read.
    pub(super) async fn setting<T: Readable<Query = NoArgs>>(self) -> Result<T> {
        self.setting_with(&NoArgs).await
    }

    /// Returns a setting that depends on a query (a pin, for example), known or read.
    pub(super) async fn setting_with<T: Readable>(self, query: &T::Query) -> Result<T> {
        let known = self.arm.picture().setting(self.arm.clock(), query);
        match known {
            Some(value) => Ok(value),
            None => self.arm.get_with(query).await,
        }
    }

    /// Returns the alarms from a recent reading, or reads them.
    pub(super) async fn alarms(self) -> Result<AlarmSet> {
        let known = self.arm.picture().harmless_alarms(self.arm.clock());
        match known {
            Some(alarms) => Ok(alarms),
            None => self.arm.alarms().await,
        }
    }

    /// Returns the state of the queue, recent or read; left space is read before the index. The
    /// steps of one call share it as long as only reads are sent.
    pub(super) async fn look_at_queue(self) -> Result<QueueLook> {
        let known = self.arm.picture().standing().fresh_look(self.arm.clock());
        match known {
            Some(look) => Ok(look),
            None => self.read_queue().await,
        }
    }

    pub(super) async fn read_queue(self) -> Result<QueueLook> {
        // Counted before the reads: a command sent between them makes the look stale, and the
        // picture has to notice.
        let orders = self.arm.picture().standing().writes_sent();
        let left = self.arm.get::<QueuedCmdLeftSpace>().await?.left_space;
        let read = self.arm.get::<QueuedCmdCurrentIndex>().await?;
        let current = read.queued_cmd_current_index;
        let (_, places) = self.arm.stats().await?;
        let look = QueueLook {
            left,
            current,
            places,
            at: self.arm.clock(),
        };
        self.arm.picture().note_look(look, orders);
        Ok(look)
    }

    /// Returns the pose of an arm that `rest` saw at `there`; `None` while commands wait in the
    /// queue or the arm moves.
    pub(super) async fn stands_at(
        self,
        there: Pose,
        rest: RestDetector,
        look: &QueueLook,
    ) -> Result<Option<Pose>> {
        if look.waiting() > 0 {
            return Ok(None);
        }
        let was_left_there = self.arm.picture().standing().was_left_at(&there, look);
        if !was_left_there && !self.is_still_at(there, rest).await? {
            return Ok(None);
        }
        self.note_standing(look.current, there);
        Ok(Some(there))
    }

    /// True if the arm is at rest at `there`. Two equal poses prove it only if enough time lies
    /// between them, so this waits for the clock of `rest`.
    async fn is_still_at(self, there: Pose, mut rest: RestDetector) -> Result<bool> {
        #[cfg(feature = "sim")]
        if let Some(arm) = self
            .arm
            .virtual_arm()
            .filter(|arm| arm.passes_time_itself())
        {
            // In virtual time waiting does not pass the arm's time, so a second pose would prove
            // nothing.
            return Ok(self.arm.get::<Pose>().await? == there && !arm.state().moving);
        }
        while !rest.is_at_rest() {
            let now = self.arm.clock();
            let next = rest.next_read().unwrap_or(now);
            sleep(Duration::from_micros(next.saturating_sub(now))).await;
            let pose = self.arm.get::<Pose>().await?;
            if pose != there {
                return Ok(false);
            }
            rest.see(self.arm.clock(), pose);
        }
        Ok(true)
    }

    /// Notes that the queue is done, its last command had this index, and the arm is at rest at
    /// `pose`.
    pub(super) fn note_standing(self, index: u64, pose: Pose) {
        let now = self.arm.clock();
        self.arm.picture().note_left_at(now, index, pose);
    }
}

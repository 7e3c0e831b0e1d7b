//! What is read of an arm again, and what the picture knows without a read.

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
    /// Reads that are spared where the picture has the answer.
    pub(super) fn known(&self) -> Known<'_> {
        Known { arm: self }
    }

    pub(super) fn clock(&self) -> Micros {
        micros(self.inner.shared.begun.elapsed())
    }

    /// Returns tool, laser, suction cup, gripper and speed, as they follow from the commands that were sent over this
    /// connection and from what the arm has answered; each is `None` if not known. No frame is sent.
    ///
    /// A queued command counts when the arm has finished it, which shows in the current index. The laser counts as lit as
    /// soon as a command that may burn goes out, and until one that puts it out was answered or has finished. Outputs that
    /// another program has switched are seen when they are read: [`read_outputs`](Self::read_outputs).
    #[must_use]
    pub fn outputs(&self) -> ArmOutputs {
        self.picture().outputs()
    }

    /// Reads [`outputs`](Self::outputs) and returns them; each is `None` if the arm does not answer.
    ///
    /// # Errors
    /// As [`get`](Self::get), but for answers that some arms do not give.
    pub async fn read_outputs(&self) -> Result<ArmOutputs> {
        // Commands of other programs that have finished void what was read before they were seen.
        self.known().look_at_queue().await?;
        answered(self.get::<EndEffectorSuctionCup>().await)?;
        answered(self.get::<EndEffectorGripper>().await)?;
        answered(self.get::<EndEffectorParams>().await)?;
        answered(self.get::<PtpCommonParams>().await)?;
        self.laser().is_on().await?;
        self.laser().learn_pins().await?;
        Ok(self.outputs())
    }

    /// Returns all that is shown of the arm, by the answers that have come over this connection. No frame is sent.
    #[must_use]
    pub fn snapshot(&self) -> ArmSnapshot {
        self.picture().snapshot()
    }
}

/// The arm, as far as it need not be read again.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    arm: &'a Arm,
}

impl Known<'_> {
    /// A setting: as it is known, or read.
    pub(super) async fn setting<T: Readable<Query = NoArgs>>(self) -> Result<T> {
        self.setting_with(&NoArgs).await
    }

    /// As [`setting`](Self::setting), of what depends on something.
    pub(super) async fn setting_with<T: Readable>(self, query: &T::Query) -> Result<T> {
        let known = self.arm.picture().setting(self.arm.clock(), query);
        match known {
            Some(value) => Ok(value),
            None => self.arm.get_with(query).await,
        }
    }

    /// The alarms, as they were read lately, or are read now.
    pub(super) async fn alarms(self) -> Result<AlarmSet> {
        let known = self.arm.picture().harmless_alarms(self.arm.clock());
        match known {
            Some(alarms) => Ok(alarms),
            None => self.arm.alarms().await,
        }
    }

    /// A look at the queue, left space before index. The steps of one call share it as long as nothing goes out but reads.
    pub(super) async fn look_at_queue(self) -> Result<QueueLook> {
        let known = self.arm.picture().standing().fresh_look(self.arm.clock());
        match known {
            Some(look) => Ok(look),
            None => self.read_queue().await,
        }
    }

    pub(super) async fn read_queue(self) -> Result<QueueLook> {
        let orders = self.arm.picture().standing().orders();
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

    /// Where the arm stands that was seen at `there`, by this look at its queue: unknown while commands wait in it, or while it
    /// moves. `rest` has seen that pose.
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

    /// True if the arm is at rest at `there`, where `rest` has seen it. What was read since then took some time, and no line says
    /// how much: the clock does.
    async fn is_still_at(self, there: Pose, mut rest: RestDetector) -> Result<bool> {
        #[cfg(feature = "sim")]
        if let Some(arm) = self
            .arm
            .virtual_arm()
            .filter(|arm| arm.passes_time_itself())
        {
            // No wait of this clock is one of its own.
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

    /// All that it had is finished, the last of it under this index, and it stands there.
    pub(super) fn note_standing(self, index: u64, pose: Pose) {
        let now = self.arm.clock();
        self.arm.picture().note_left_at(now, index, pose);
    }
}

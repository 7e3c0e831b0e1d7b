use magician_protocol::commands::{
    AlarmsState, ClearAlarmsState, EndEffectorParams, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
    QueuedCmdStartExec,
};
use magician_protocol::{Alarm, AlarmSet, QueuedCmdIndex};

use super::Arm;
use crate::{Error, ErrorCode, QueueIndex, Result};

/// The queue and the alarms.
impl Arm {
    /// Lets the queue run (document 1.19.1). A start may end the motion under way (model section 14): none is sent while a
    /// queue runs that was started over this connection, and none before the arm stands.
    ///
    /// # Errors
    /// [`ErrorCode::Busy`] if the arm moves and still does after five seconds, else as [`get`](Self::get). On
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) the queue may run: nothing is sent twice.
    pub async fn start_queue(&self) -> Result<()> {
        if !self.stands().await? {
            if self.picture().motion().started() == Some(true) {
                return Ok(());
            }
            self.wait_still()
                .await
                .map_err(|error| match error.code() {
                    ErrorCode::StopUnconfirmed => Error::new(ErrorCode::Busy, "the arm moves"),
                    _ => error,
                })?;
        }
        self.start_standing().await
    }

    /// Lets the queue of an arm that stands run.
    pub(super) async fn start_standing(&self) -> Result<()> {
        self.set(&QueuedCmdStartExec {}).await
    }

    /// Lets the queue run if it is empty, and says whether it was: nothing moves by that. An arm is switched on with its queue
    /// stopped, and programs that were written on one that was started long ago wait for their first command for ever.
    ///
    /// # Errors
    /// As [`start_queue`](Self::start_queue).
    pub async fn start_empty_queue(&self) -> Result<bool> {
        // What another program has left there is not set going.
        let empty = self.waiting().await? == 0;
        if empty {
            // The arm may move all the same: by an immediate motion of another program.
            self.start_queue().await?;
        }
        Ok(empty)
    }

    /// How many places of the arm's queue are taken.
    pub(super) async fn waiting(&self) -> Result<u32> {
        let room = self.left_space().await?;
        let (_, capacity) = self.stats().await?;
        Ok(capacity.saturating_sub(room))
    }

    /// Free places in the arm's queue.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn left_space(&self) -> Result<u32> {
        let read = self.get::<QueuedCmdLeftSpace>().await?;
        Ok(read.left_space)
    }

    /// Index of the queued command that was finished last, 0 before the first.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn current_index(&self) -> Result<QueueIndex> {
        let read = self.get::<QueuedCmdCurrentIndex>().await?;
        Ok(QueuedCmdIndex(read.queued_cmd_current_index))
    }

    /// The alarms that stand. That some stand is no error.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn alarms(&self) -> Result<AlarmSet> {
        let read = self.get::<AlarmsState>().await?;
        Ok(read.alarms_state)
    }

    /// Whether these alarms may come from a tool that the arm was never told of: one of them says that a pose is out of
    /// reach, and the tool bias is 0. [`Alarm::TOOL_UNKNOWN`] is the sentence for it.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn tool_is_unknown(&self, alarms: &AlarmSet) -> Result<bool> {
        if !alarms.codes().any(Alarm::is_kinematic) {
            return Ok(false);
        }
        Ok(self.get::<EndEffectorParams>().await?.is_zero())
    }

    /// The error for a wait that ends with these alarms.
    pub(super) async fn stopped_by(&self, alarms: AlarmSet) -> Error {
        // Where the bias cannot be read the alarms speak for themselves.
        let tool_unknown = self.tool_is_unknown(&alarms).await.unwrap_or(false);
        Error::alarm(alarms, tool_unknown)
    }

    /// Clears the alarms, and with them the hold on the queue if no cause stands any more.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn clear_alarms(&self) -> Result<()> {
        self.set(&ClearAlarmsState {}).await
    }
}

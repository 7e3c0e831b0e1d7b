use magician_protocol::commands::{
    AlarmsState, ClearAlarmsState, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, QueuedCmdStartExec,
};
use magician_protocol::{AlarmSet, QueuedCmdIndex};

use super::Arm;
use crate::{QueueIndex, Result};

/// The queue and the alarms.
impl Arm {
    /// Lets the queue run (document 1.19.1).
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn start_queue(&self) -> Result<()> {
        self.set(&QueuedCmdStartExec {}).await
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

    /// Clears the alarms, and with them the hold on the queue if no cause stands any more.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn clear_alarms(&self) -> Result<()> {
        self.set(&ClearAlarmsState {}).await
    }
}

//! Stops that no client requests: at the end of the station, and of outputs without a lease holder.

use magician::{Arm, ErrorCode, message};
use serde_json::Value;
use tokio::sync::oneshot;

use super::{EngineTask, TaskResult};

/// Most stops of an arm when the station ends. Another host may send commands after the first one.
const MAX_FINAL_STOPS: u32 = 3;

impl EngineTask {
    /// Carries out the last stop. No action starts after it.
    pub(super) fn end(&mut self, is_read_only: bool, reply: oneshot::Sender<magician::Result<()>>) {
        self.ended = true;
        self.drop_actions();
        self.waiting.clear();
        let arm = self.arm.clone();
        self.side.spawn(async move {
            // Fails only if the station is gone already.
            let _ = reply.send(stop_completely(&arm, is_read_only).await);
            TaskResult::Stopped(None, Ok(Value::Null))
        });
    }

    /// Switches off motor outputs and the laser if they would stay on without a lease holder.
    /// Queued commands that would switch them on are dropped.
    pub(super) fn end_unattended(&mut self) {
        // What a running job switched on belongs to the job until it pauses or ends.
        self.end_unattended_with_job();
        if self.is_job_moving() || !has_unattended(&self.arm) {
            return;
        }
        self.stops += 1;
        let arm = self.arm.clone();
        self.side.spawn(async move {
            // A queued command may still start a motor or light the laser, so a moving arm is
            // stopped as a whole.
            let ended = if arm.moving() {
                arm.stop().await
            } else {
                switch_unattended_off(&arm).await
            };
            if let Err(error) = ended {
                tracing::warn!(%error, "a motor or the laser may stay on after the lease");
            }
            TaskResult::Stopped(None, Ok(Value::Null))
        });
    }
}

/// True if a motor output runs or the laser is known to be on. Neither ends by itself.
fn has_unattended(arm: &Arm) -> bool {
    arm.outputs().laser == Some(true) || !arm.motors().running().is_empty()
}

/// Switches motor outputs and the laser off where they are on.
pub(super) async fn switch_unattended_off(arm: &Arm) -> magician::Result<()> {
    let dark = if arm.outputs().laser == Some(true) {
        arm.laser().switch_off().await
    } else {
        Ok(())
    };
    // The motors are stopped even if the laser did not answer.
    let stopped = arm.motors().stop().await;
    dark.and(stopped)
}

/// Stops an arm until it stands, laser and motor outputs are off, and its queue is empty. With
/// `is_read_only` the queue is not checked.
async fn stop_completely(arm: &Arm, is_read_only: bool) -> magician::Result<()> {
    let (_, places) = arm.stats().await?;
    for stops in 0.. {
        let is_busy = arm.moving() || has_unattended(arm);
        // The driver does not know commands that another host sent, so the arm's queue is asked.
        if !is_busy && (is_read_only || arm.queue().left_space().await? >= places) {
            break;
        }
        if stops == MAX_FINAL_STOPS {
            // Gives up, so that the station can end.
            let message = message!("commands come to the arm's queue again after each stop");
            return Err(magician::Error::new(ErrorCode::StopUnconfirmed, message));
        }
        arm.stop().await?;
    }
    arm.laser().switch_off_after().await
}

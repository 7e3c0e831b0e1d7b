//! Readings and events of the driver as reports of the arm.

use std::time::Duration;

use magician::{Arm, Event, Link};
use magician_job::{Access, RecoveredSettings, SavedSettings};
use magician_protocol::visible;
use serde_json::json;
use tokio::time::sleep;

use super::reads::Known;
use super::{EngineTask, TaskResult};
use crate::api::ArmEvent;
use crate::order::ArmReport;

/// Limit and interval of the attempts to restore the settings that a job had changed when its line
/// was lost. An attempt succeeds only when the arm's queue is empty. The queue holds two seconds of
/// motion, or one long command, so half a minute suffices.
const MAX_RESTORE_ATTEMPTS: u32 = 30;
const RESTORE_INTERVAL: Duration = Duration::from_secs(1);

impl EngineTask {
    /// Reads in the background the values that the driver's status does not contain.
    pub(super) fn refresh_known(&mut self) {
        self.lapses = self.arm.snapshot().lapses;
        let arm = self.arm.clone();
        let before = self.known.rail;
        self.side.spawn(async move {
            let known = Known::read(&arm).await;
            TaskResult::Known(known.map_or(before, |known| known.rail))
        });
    }

    pub(super) fn handle_status(&mut self, status: &magician::Status) {
        // While the line is down the status is outdated, so no reading is reported.
        if status.link == Link::Up
            && let Some(reading) = self.known.reading(status, &self.arm)
        {
            (self.report)(ArmReport::Reading(Box::new(reading)));
        }
    }

    pub(super) fn report_event(&mut self, event: Event) {
        let tell = |event, fields| (self.report)(ArmReport::Event { event, fields });
        match event {
            Event::AlarmRaised { code } => tell(ArmEvent::AlarmRaised, vec![("code", json!(code))]),
            Event::AlarmCleared { code } => {
                tell(ArmEvent::AlarmCleared, vec![("code", json!(code))])
            }
            Event::CommandFinished { last, .. } => {
                tell(ArmEvent::CommandFinished, vec![("index", json!(last.0))]);
            }
            Event::Unaccounted { to, .. } => {
                tell(ArmEvent::Unaccounted, vec![("index", json!(to.0))])
            }
            Event::LinkLost { .. } => (self.report)(ArmReport::Link(false)),
            Event::LinkFound { .. } => {
                (self.report)(ArmReport::Link(true));
                self.side.spawn(restore_after_job(self.arm.clone()));
                self.refresh_known();
            }
            Event::Reset { .. } => {
                tell(ArmEvent::Reset, Vec::new());
                self.refresh_known();
            }
            Event::Missed { events } => tell(ArmEvent::Missed, vec![("count", json!(events))]),
            // Events that a newer driver adds: the API has no form for them.
            other => tracing::debug!(event = %visible(&format!("{other:?}")), "unknown event"),
        }
    }
}

/// Restores the settings of a job whose line was lost, once the arm's queue is empty.
async fn restore_after_job(arm: Arm) -> TaskResult {
    for _ in 0..MAX_RESTORE_ATTEMPTS {
        match SavedSettings::recover(&arm, Access::Sets).await {
            RecoveredSettings::Deferred(_) => sleep(RESTORE_INTERVAL).await,
            // Restored, or nothing to restore.
            _ => break,
        }
    }
    TaskResult::Nothing
}

//! End of all motion when the program ends.

use std::time::Duration;

use tokio::time::timeout;

use super::RunningStation;
use crate::engine::ArmEngine;
use crate::station::EndReport;

/// Longest wait for running jobs and for holders when the station ends: the 5 s that holders have
/// ([`Station::end`](crate::Station::end)) plus 1 s for the station's own jobs.
const END_TIMEOUT: Duration = Duration::from_secs(6);
/// The same wait after a second call of [`RunningStation::end_runs`], which starts no motion.
const SECOND_END_TIMEOUT: Duration = Duration::from_secs(1);
/// Longest wait for the final stop of an arm. An arm that is connected confirms within a tenth of
/// this.
const FINAL_STOP_TIMEOUT: Duration = Duration::from_secs(2);

/// Longest wait for the final reports of jobs whose arms have stopped.
const JOB_REPORT_TIMEOUT: Duration = Duration::from_millis(500);

impl RunningStation {
    /// Ends all motion for the end of the program.
    ///
    /// Jobs are stopped in order: pens go up and settings are restored. Clients are notified and
    /// have a few seconds to end what they run in the same way
    /// ([`Station::end`](crate::Station::end)); nothing new begins. Then the station itself stops
    /// every arm. On return the queues are empty, lasers and motors are off, and no command of a
    /// client is accepted any more.
    ///
    /// A second call ends everything at once. Takes at most 9 s.
    pub async fn end_runs(&self) -> EndReport {
        let (again, jobs) = self.shared.with(|inner, now| {
            #[cfg(feature = "class")]
            inner.station.close_queue();
            let again = inner.station.is_ending();
            inner.station.end(now);
            let jobs: Vec<_> = inner.engines.iter().map(ArmEngine::end_job).collect();
            (again, jobs)
        });
        let runs = async {
            for job in jobs {
                job.await;
            }
            self.wait_for_release().await;
        };
        // The limit is needed because a job of an arm that does not answer does not end.
        let _ = timeout(
            if again {
                SECOND_END_TIMEOUT
            } else {
                END_TIMEOUT
            },
            runs,
        )
        .await;
        let stops: Vec<_> = self.shared.with(|inner, now| {
            // `Station::end` again: sessions that still hold a lease lose it now.
            inner.station.end(now);
            let is_read_only = inner.station.is_read_only();
            // All arms at once: an arm that does not answer must not delay the stop of the others.
            let stops = inner.engines.iter().map(|engine| engine.end(is_read_only));
            stops
                .map(|stop| timeout(FINAL_STOP_TIMEOUT, stop))
                .collect()
        });
        let mut unconfirmed = Vec::new();
        // The stops run side by side: each was started above and has its own limit.
        let names = self.shared.lock().station.arm_names();
        for (arm, stop) in names.into_iter().zip(stops) {
            match stop.await {
                Ok(Ok(())) => {}
                Ok(Err(error)) => unconfirmed.push((arm, error.to_string())),
                Err(_) => unconfirmed.push((arm, "it took too long".to_owned())),
            }
        }
        // Final states of jobs are reported and saved before the sockets close.
        let _ = timeout(JOB_REPORT_TIMEOUT, self.wait_for_jobs()).await;
        self.shared.with(|inner, now| {
            // Jobs of arms that did not confirm are recorded as interrupted.
            let lost: Vec<_> = unconfirmed.iter().map(|(arm, _)| arm.clone()).collect();
            inner.station.end_jobs(now, &lost);
        });
        let forced_stops = self.shared.lock().station.forced_stops().to_vec();
        EndReport {
            forced_stops,
            unconfirmed,
        }
    }

    /// Waits until no job is running.
    async fn wait_for_jobs(&self) {
        loop {
            let changed = self.shared.changed.notified();
            tokio::pin!(changed);
            changed.as_mut().enable();
            if !self.shared.lock().station.has_jobs_under_way() {
                return;
            }
            changed.await;
        }
    }

    /// Waits until no session holds an arm of a station that ends.
    async fn wait_for_release(&self) {
        loop {
            let released = self.shared.released.notified();
            tokio::pin!(released);
            released.as_mut().enable();
            if self.shared.lock().station.is_released() {
                return;
            }
            released.await;
        }
    }
}

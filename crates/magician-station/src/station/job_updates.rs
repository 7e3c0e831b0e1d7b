//! Reports about jobs from the arms: they change the record of a job and answer the requests that
//! wait for its state.

use std::sync::Arc;

use magician::message;
use magician_job::JobState;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::jobs::{AwaitedJobState, is_under_way};
use super::newest::{Newest, PROGRESS_INTERVAL};
use super::{Awaited, Station};
use crate::api::{ArmEvent, RpcError};
use crate::control::{ArmId, JobId, JobPhase, RequestId, WorkEnd};
use crate::order::JobUpdate;

impl Station {
    /// Takes a report about a job.
    pub(super) fn apply_job_update(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        job: JobId,
        update: JobUpdate,
    ) {
        let t = self.unix(now);
        let Some(record) = self.records.numbered(job) else {
            return;
        };
        // The station may have ended the job before the arm reported.
        if !is_under_way(&record.state) {
            return;
        }
        match update {
            JobUpdate::Read {
                title,
                steps,
                start,
                digest,
            } => {
                record.digest = Some(digest);
                (record.title, record.steps) = (Some(title), Some(steps));
                record.is_read = true;
                if let Some((order, start)) = record.order.as_mut().zip(start) {
                    // A later resume starts from here, wherever the arm is then.
                    Arc::make_mut(order).start.get_or_insert(start);
                }
                record.first_step = record.order.as_ref().map(|order| order.from + 1);
            }
            JobUpdate::Burns => self.control.mark_job_burning(arm, job),
            JobUpdate::Starts(steps) => {
                record.first_step = Some(steps + 1);
                record.set_done(steps);
            }
            JobUpdate::Progress(progress) => {
                record.set_done(progress.step);
                record.seconds_left = progress.remaining.map(|left| left.as_secs_f64());
                self.records.note_progress(now, arm);
                self.notice_rates
                    .changed(Newest::Job(job), PROGRESS_INTERVAL);
            }
            JobUpdate::State(state, text) => {
                let name = match state {
                    // Still moving: the pen rises and settings are restored.
                    JobState::Ending => "running",
                    state => state.name(),
                };
                let paused = match state {
                    JobState::Paused { reason, part } => Some((reason.name(), part)),
                    _ => None,
                };
                if record.state == name {
                    return;
                }
                let mut was_resumed = false;
                if matches!(state, JobState::Running | JobState::Paused { .. }) {
                    // A resumed job has moved now, so its earlier state cannot be restored any
                    // more.
                    was_resumed = record.before.take().is_some();
                    record.hidden.ran = true;
                    record.hidden.went_on = record.hidden.run.is_some();
                }
                name.clone_into(&mut record.state);
                record.reason = paused.map(|(reason, _)| reason.to_owned());
                record.part = paused.and_then(|(_, part)| part);
                record.text = text.filter(|_| paused.is_some());
                self.job_changed(now, arm, job);
                match state {
                    JobState::Running if was_resumed => {
                        self.answer_resumed_when_saved(now, arm, job);
                    }
                    JobState::Running => {
                        self.answer_job(
                            now,
                            job,
                            &[AwaitedJobState::Checked, AwaitedJobState::Running],
                        );
                    }
                    JobState::Paused { .. } => {
                        self.answer_job(
                            now,
                            job,
                            &[AwaitedJobState::Checked, AwaitedJobState::Paused],
                        );
                    }
                    _ => {}
                }
            }
            JobUpdate::Over(end) => {
                #[cfg(feature = "class")]
                let order = record.order.clone();
                #[cfg(feature = "class")]
                let is_resumed = record.before.is_some();
                #[cfg(feature = "class")]
                if !is_resumed && self.finish_queued(now, job, &end) {
                    return;
                }
                if let Some(record) = self.records.numbered(job) {
                    match record.before.take() {
                        // A resume that ended before any motion changes nothing.
                        Some(before) if end.state != "done" => {
                            *record = *before;
                            record.number = Some(job);
                        }
                        // A job that ran, or a first start that failed.
                        _ => record.mark_over(t, &end),
                    }
                }
                #[cfg(feature = "class")]
                self.store_result(arm, job, order.as_ref());
                self.job_changed(now, arm, job);
                self.answer_end(now, arm, job, end.state, end.error);
                // A stop may wait for the end of this job.
                self.answer_stands(now);
            }
        }
    }

    /// Answers the requests that wait for one of these states of a job.
    fn answer_job(&mut self, now: HostInstant, job: JobId, wanted: &[AwaitedJobState]) {
        let shown = self.shown(job);
        for (request, wants) in self.waiting_for(job) {
            if !wanted.contains(&wants) {
                continue;
            }
            let result = match wants {
                AwaitedJobState::Checked => json!({"job": shown["job"]}),
                _ => shown.clone(),
            };
            self.finish(now, request, Ok(result));
        }
    }

    /// Answers all requests that wait for a job that is over.
    pub(super) fn answer_end(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        job: JobId,
        state: &str,
        error: Option<RpcError>,
    ) {
        let shown = self.shown(job);
        for (request, wants) in self.waiting_for(job) {
            let outcome = match (wants, state) {
                (AwaitedJobState::End, _) => Ok(shown.clone()),
                (AwaitedJobState::Checked, "done") => Ok(json!({"job": shown["job"]})),
                (_, "done") => Err(RpcError::arm(
                    magician::ErrorKind::InvalidInput,
                    message!("the job is over"),
                )),
                // Independent of who stopped it, the requester learns that its request did not
                // finish.
                (_, "stopped") => Err(self.ended_error(arm, WorkEnd::Stop(None))),
                _ => Err(error
                    .clone()
                    .unwrap_or_else(|| RpcError::internal("the job failed"))),
            };
            self.finish(now, request, outcome);
        }
    }

    pub(super) fn waiting_for(&self, job: JobId) -> Vec<(RequestId, AwaitedJobState)> {
        let waiting = self
            .pending
            .iter()
            .filter_map(|(request, pending)| match pending.awaits {
                Awaited::Job(_, of, wants) if of == job => Some((*request, wants)),
                _ => None,
            });
        waiting.collect()
    }

    /// Takes the result of an order about a job. Its effects follow as reports.
    pub(super) fn note_job_order_result(
        &mut self,
        now: HostInstant,
        request: RequestId,
        wants: AwaitedJobState,
        job: JobId,
        outcome: Result<Value, RpcError>,
    ) {
        let state = self.shown(job)["state"].clone();
        match (outcome, wants) {
            (Err(error), _) => self.finish(now, request, Err(error)),
            (Ok(_), AwaitedJobState::Paused) if state == "paused" => {
                self.answer_job(now, job, &[AwaitedJobState::Paused]);
            }
            (Ok(_), AwaitedJobState::Running) if state == "running" => {
                self.answer_job(now, job, &[AwaitedJobState::Running]);
            }
            (Ok(_), _) => {}
        }
    }

    /// Publishes a change of a job: to control, the store, subscribers and the event log.
    pub(super) fn job_changed(&mut self, now: HostInstant, arm: ArmId, job: JobId) {
        let Some(record) = self.records.numbered(job) else {
            return;
        };
        let phase = match record.state.as_str() {
            "paused" => Some(JobPhase::Paused),
            state if is_under_way(state) => Some(JobPhase::Active),
            _ => None,
        };
        let (on_lost, shown) = (record.on_lost, record.shown());
        // A queued job has no arm yet, and a job that ended before it began must not touch the arm
        // of another one.
        if phase.is_some() || self.control.has_job(arm, job) {
            self.control.set_job_phase(now, arm, job, on_lost, phase);
        }
        self.records.note_change(arm);
        self.notify_job(now, job);
        let fields = vec![
            ("job", shown["job"].clone()),
            ("state", shown["state"].clone()),
        ];
        self.event(now, arm, ArmEvent::Job, fields);
        self.mark_state_changed(arm);
    }
}

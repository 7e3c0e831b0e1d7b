//! Durability of jobs: answers and starts that wait for the disk.
//!
//! Three promises hold whenever the program dies. A job whose start was answered is on the disk. A
//! job that moves the arm is on the disk as started, so the next station does not list it as
//! waiting. A resume that was answered is on the disk. To keep them, an answer or a start order is
//! held back until [`Station::jobs_written`] reports the revision that contains it. Stops are never
//! held back.

use std::collections::BTreeMap;
use std::time::Duration;

use magician::{ErrorKind, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::records::JobRecord;
use super::store::JobTotals;
use super::{Awaited, AwaitedJobState, Station};
use crate::api::RpcError;
use crate::control::{ArmId, JobId, RequestId};
use crate::order::{ArmOrder, JobEnd};

/// Longest time that the answer to a stop waits for the end of the stopped job. The arm already
/// stands by then.
const MAX_STOPPED_JOB_WAIT: Duration = Duration::from_secs(2);

/// Everything that waits for the disk, or for the end of a job.
#[derive(Debug, Default)]
pub(super) struct HeldWork {
    answers: Vec<HeldAnswer>,
    /// New jobs not yet on the disk: arm, revision, job.
    fresh: Vec<(ArmId, u64, JobId)>,
    starts: Vec<HeldStart>,
    stands: Vec<HeldStand>,
}

/// Answer that promises durability.
#[derive(Debug)]
struct HeldAnswer {
    request: RequestId,
    /// Revision of each arm's jobs that has to be on the disk.
    needs: BTreeMap<ArmId, u64>,
    result: Value,
    or: WriteFailurePolicy,
}

/// Consequence if the disk refuses a change.
#[derive(Debug)]
pub(super) enum WriteFailurePolicy {
    /// The change is undone and the answer is the error.
    Refuse,
    /// The change stays. The answer says that the next station may not know it.
    Keep,
    /// The deleted job returns to this position, with the earlier totals.
    Restore(usize, Box<JobRecord>, JobTotals),
    /// The queued job returns to this position, from 0.
    #[cfg(feature = "class")]
    Reorder(JobId, usize),
}

/// Start of a job, held until the disk has the job as started.
#[derive(Debug)]
struct HeldStart {
    arm: ArmId,
    job: JobId,
    revision: u64,
    start: ArmOrder,
    /// Orders about the job that came meanwhile.
    then: Vec<ArmOrder>,
}

/// Stop of an arm that stands, while its job is not over yet.
#[derive(Debug)]
struct HeldStand {
    arm: ArmId,
    request: RequestId,
    stood: Value,
    due: HostInstant,
}

impl Station {
    /// Takes the result of writing an arm's jobs up to this revision.
    pub fn jobs_written(
        &mut self,
        now: HostInstant,
        arm: usize,
        revision: u64,
        outcome: Result<(), String>,
    ) {
        let arm = ArmId(arm as u64);
        self.records
            .note_written(now, arm, revision, outcome.is_ok());
        match outcome {
            Ok(()) => self.note_jobs_saved(now, arm, revision),
            Err(why) => self.note_jobs_unsaved(now, arm, revision, &why),
        }
        self.carry_out_effects(now);
    }

    fn note_jobs_saved(&mut self, now: HostInstant, arm: ArmId, revision: u64) {
        let work = &mut self.held_work;
        work.fresh
            .retain(|(of, at, _)| *of != arm || *at > revision);
        let starts: Vec<_> = { &mut work.starts }
            .extract_if(.., |start| start.arm == arm && start.revision <= revision)
            .collect();
        for held in starts {
            // The start first, then what came meanwhile, such as a pause.
            self.order(arm, held.start);
            for order in held.then {
                self.order(arm, order);
            }
        }
        let records = &self.records;
        let is_written = |answer: &mut HeldAnswer| {
            { answer.needs.iter() }.all(|(arm, revision)| records.is_written(*arm, *revision))
        };
        let answers: Vec<_> = { &mut self.held_work.answers }
            .extract_if(.., is_written)
            .collect();
        for answer in answers {
            self.finish(now, answer.request, Ok(answer.result));
        }
    }

    fn note_jobs_unsaved(&mut self, now: HostInstant, arm: ArmId, revision: u64, why: &str) {
        let error = refused_change_error(why);
        let needs = |answer: &mut HeldAnswer| {
            { answer.needs.get(&arm) }.is_some_and(|needed| *needed <= revision)
        };
        let answers: Vec<_> = { &mut self.held_work.answers }
            .extract_if(.., needs)
            .collect();
        for answer in answers {
            let outcome = match answer.or {
                WriteFailurePolicy::Keep => Err(unsaved_change_error(why)),
                WriteFailurePolicy::Refuse => Err(error.clone()),
                WriteFailurePolicy::Restore(at, record, totals) => {
                    self.records.restore_job(at, *record, totals);
                    Err(error.clone())
                }
                #[cfg(feature = "class")]
                WriteFailurePolicy::Reorder(job, place) => {
                    self.move_queued(now, job, place);
                    Err(error.clone())
                }
            };
            self.finish(now, answer.request, outcome);
        }
        let fresh: Vec<_> = { &mut self.held_work.fresh }
            .extract_if(.., |(of, at, _)| *of == arm && *at <= revision)
            .collect();
        for (_, _, job) in fresh {
            // A job must not start before it is on the disk.
            self.held_work.starts.retain(|start| start.job != job);
            #[cfg(feature = "class")]
            self.drop_queued(now, arm, job);
            let mut end = JobEnd::new("failed");
            end.error = Some(error.clone());
            let t = self.unix(now);
            if let Some(record) = self.records.numbered(job) {
                record.mark_over(t, &end);
                // Without the key the caller may try again.
                (record.hidden.key, record.order, record.place) = (None, None, None);
            }
            self.job_changed(now, arm, job);
            self.answer_end(now, arm, job, "failed", end.error);
        }
        let starts: Vec<_> = { &mut self.held_work.starts }
            .extract_if(.., |start| start.arm == arm && start.revision <= revision)
            .collect();
        for held in starts {
            // Stopped while it waited for the disk.
            let stopped = { held.then.iter() }.any(|order| matches!(order, ArmOrder::StopJob(_)));
            #[cfg(feature = "class")]
            if !stopped && self.requeue(now, held.job) {
                continue;
            }
            let mut end = JobEnd::new(if stopped { "stopped" } else { "failed" });
            end.error = Some(error.clone()).filter(|_| !stopped);
            let update = crate::order::JobUpdate::Over(Box::new(end));
            self.apply_job_update(now, arm, held.job, update);
        }
    }

    /// Registers a new job, which is refused if the disk does not take it.
    pub(super) fn note_fresh(&mut self, arm: ArmId, job: JobId) {
        let revision = self.records.revision(arm);
        self.held_work.fresh.push((arm, revision, job));
    }

    /// Holds the start of a job until the disk has the job as started.
    pub(super) fn order_start(&mut self, arm: ArmId, job: JobId, start: ArmOrder) {
        let revision = self.records.revision(arm);
        self.held_work.starts.push(HeldStart {
            arm,
            job,
            revision,
            start,
            then: Vec::new(),
        });
    }

    /// Holds an order about a job whose start is held. Returns the order if it does not concern
    /// one.
    pub(super) fn hold_behind_start(&mut self, arm: ArmId, order: ArmOrder) -> Option<ArmOrder> {
        let mut starts = self.held_work.starts.iter_mut();
        let Some(held) = starts.find(|held| held.arm == arm) else {
            return Some(order);
        };
        let is_of_it = match &order {
            ArmOrder::PauseJob { job, .. }
            | ArmOrder::ResumeJob { job, .. }
            | ArmOrder::StopJob(job) => *job == held.job,
            // A stop goes to the arm at once, and also ends the job once it reaches the arm.
            ArmOrder::Stop { .. } => {
                held.then.push(ArmOrder::StopJob(held.job));
                false
            }
            ArmOrder::EndUnattended => {
                held.then.push(ArmOrder::EndUnattended);
                false
            }
            _ => false,
        };
        if is_of_it {
            held.then.push(order);
            return None;
        }
        Some(order)
    }

    /// Answers a request once the current jobs of these arms are on the disk.
    pub(super) fn answer_when_saved(
        &mut self,
        call: &Call<'_>,
        arms: impl IntoIterator<Item = ArmId>,
        result: Value,
        or: WriteFailurePolicy,
    ) -> Handled {
        let revisions = arms
            .into_iter()
            .map(|arm| (arm, self.records.revision(arm)));
        let needs: BTreeMap<_, _> = revisions
            // Arms whose jobs are on the disk already need no wait.
            .filter(|(arm, revision)| !self.records.is_written(*arm, *revision))
            .collect();
        if needs.is_empty() {
            return Handled::Now(result);
        }
        self.held_work.answers.push(HeldAnswer {
            request: call.request,
            needs,
            result,
            or,
        });
        Handled::Later(call.request, Awaited::Saved)
    }

    /// Answers the requests that wait for a resumed job once the disk has it as running. Until then
    /// the file has the job as it was before.
    pub(super) fn answer_resumed_when_saved(&mut self, now: HostInstant, arm: ArmId, job: JobId) {
        let needs = BTreeMap::from([(arm, self.records.revision(arm))]);
        let result = self.shown(job);
        for (request, wants) in self.waiting_for(job) {
            if !matches!(wants, AwaitedJobState::Running) {
                continue;
            }
            // The work of the request is done; only its answer is held.
            self.control.finish(now, arm, request);
            if let Some(pending) = self.pending.get_mut(&request) {
                pending.awaits = Awaited::Saved;
            }
            self.held_work.answers.push(HeldAnswer {
                request,
                needs: needs.clone(),
                result: result.clone(),
                or: WriteFailurePolicy::Keep,
            });
        }
    }

    /// Holds the answer to a stop until the job is over. Returns the answer if it need not wait.
    pub(super) fn hold_behind_job(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        request: RequestId,
        stood: Value,
    ) -> Option<Value> {
        let job = self.records.under_way(arm);
        // While a program is read there is no motion to wait for.
        if !job.is_some_and(|job| job.is_read) {
            return Some(stood);
        }
        self.held_work.stands.push(HeldStand {
            arm,
            request,
            stood,
            due: now + MAX_STOPPED_JOB_WAIT,
        });
        None
    }

    /// Answers stops whose job is over, or has had its time.
    pub(super) fn answer_stands(&mut self, now: HostInstant) {
        let records = &self.records;
        let is_over = |held: &mut HeldStand| {
            held.due <= now || records.under_way(held.arm).is_none_or(|job| !job.is_read)
        };
        let stands: Vec<_> = { &mut self.held_work.stands }
            .extract_if(.., is_over)
            .collect();
        for HeldStand {
            arm,
            request,
            stood,
            ..
        } in stands
        {
            self.stood(now, arm, request, Ok(stood));
        }
    }

    /// Returns the next deadline.
    pub(super) fn held_due(&self) -> Option<HostInstant> {
        let stands = self.held_work.stands.iter().map(|held| held.due);
        stands.chain(self.records.due()).min()
    }

    /// Ends the jobs that are left at the end of the program, after the last stop. Jobs of arms
    /// that did not confirm the stop count as interrupted. Changes that the disk has refused are
    /// tried once more.
    pub(crate) fn end_jobs(&mut self, now: HostInstant, unconfirmed: &[String]) {
        for arm in self.arm_ids() {
            let Some(job) = self.records.under_way(arm).and_then(|record| record.number) else {
                continue;
            };
            let is_lost = unconfirmed.contains(&self.arm(arm).entry.name);
            let state = if is_lost { "interrupted" } else { "stopped" };
            let update = crate::order::JobUpdate::Over(Box::new(JobEnd::new(state)));
            self.apply_job_update(now, arm, job, update);
        }
        // The last chance: the program ends.
        self.records.retry_writes(now, true);
        self.carry_out_effects(now);
    }

    /// True if a job of the station is not over.
    pub(crate) fn has_jobs_under_way(&self) -> bool {
        let mut arms = self.arm_ids();
        arms.any(|arm| self.records.under_way(arm).is_some())
    }
}

/// Error of a change that was made but is not on the disk.
fn unsaved_change_error(why: &str) -> RpcError {
    let message = message!(
        "it is done, but not kept: after a power failure it is as before: {why}",
        why
    );
    RpcError::arm(ErrorKind::Closed, message).with("reason", json!("unkept"))
}

/// Error of a change that the disk refused.
pub(super) fn refused_change_error(why: &str) -> RpcError {
    let message = message!("the change is not kept, so it does not count: {why}", why);
    RpcError::arm(ErrorKind::Closed, message).with("reason", json!("unkept"))
}

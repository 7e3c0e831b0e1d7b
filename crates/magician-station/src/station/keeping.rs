//! What waits for the disk. A start that is answered is on the disk first, and so is one that moves the arm: whatever ends
//! this program, nothing answered is lost, and nothing that the next station lists as waiting has moved before. A resume
//! that is answered is on the disk as well.

use std::collections::BTreeMap;
use std::time::Duration;

use magician::ErrorKind;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::records::JobRecord;
use super::store::JobTotals;
use super::{Awaited, Station, Wants};
use crate::api::RpcError;
use crate::control::{ArmId, JobId, RequestId};
use crate::order::{ArmOrder, JobEnd};

/// Longest time that the answer to a stop waits for the end of the job that it stopped. The arm stands by then.
const STOPPED_JOB: Duration = Duration::from_secs(2);

/// What waits for the disk, or for a job to be over.
#[derive(Debug, Default)]
pub(super) struct Keeping {
    answers: Vec<HeldAnswer>,
    /// Jobs that are not on the disk yet.
    fresh: Vec<(ArmId, u64, JobId)>,
    starts: Vec<HeldStart>,
    stands: Vec<HeldStand>,
}

/// An answer that promises something.
#[derive(Debug)]
struct HeldAnswer {
    request: RequestId,
    /// Change of each arm that has to be on the disk.
    needs: BTreeMap<ArmId, u64>,
    result: Value,
    or: IfUnkept,
}

/// What becomes of a change that the disk does not take.
#[derive(Debug)]
pub(super) enum IfUnkept {
    /// The answer is the error.
    Refuse,
    /// It stands, and the answer says that the next station may not know it.
    Stand,
    /// A job is back at this place, with the totals as they were.
    PutBack(usize, Box<JobRecord>, JobTotals),
    /// A job that waits is back at this place of its queue, from 0.
    #[cfg(feature = "class")]
    Reorder(JobId, usize),
}

/// A job that begins once it is on the disk that it does.
#[derive(Debug)]
struct HeldStart {
    arm: ArmId,
    job: JobId,
    revision: u64,
    start: ArmOrder,
    /// Orders about it that came meanwhile.
    then: Vec<ArmOrder>,
}

/// An arm that stands after a stop, and whose job is not over yet.
#[derive(Debug)]
struct HeldStand {
    arm: ArmId,
    request: RequestId,
    stood: Value,
    due: HostInstant,
}

impl Station {
    /// What came of writing the jobs of an arm, up to this change of them.
    pub fn jobs_kept(
        &mut self,
        now: HostInstant,
        arm: usize,
        revision: u64,
        outcome: Result<(), String>,
    ) {
        let arm = ArmId(arm as u64);
        self.records
            .was_written(now, arm, revision, outcome.is_ok());
        match outcome {
            Ok(()) => self.were_kept(now, arm, revision),
            Err(why) => self.were_not_kept(now, arm, revision, &why),
        }
        self.settle(now);
    }

    fn were_kept(&mut self, now: HostInstant, arm: ArmId, revision: u64) {
        let keeping = &mut self.keeping;
        keeping
            .fresh
            .retain(|(of, at, _)| *of != arm || *at > revision);
        let starts: Vec<_> = { &mut keeping.starts }
            .extract_if(.., |start| start.arm == arm && start.revision <= revision)
            .collect();
        for held in starts {
            self.order(arm, held.start);
            for order in held.then {
                self.order(arm, order);
            }
        }
        let records = &self.records;
        let is_kept = |answer: &mut HeldAnswer| {
            { answer.needs.iter() }.all(|(arm, revision)| records.is_kept(*arm, *revision))
        };
        let answers: Vec<_> = { &mut self.keeping.answers }
            .extract_if(.., is_kept)
            .collect();
        for answer in answers {
            self.finish(now, answer.request, Ok(answer.result));
        }
    }

    fn were_not_kept(&mut self, now: HostInstant, arm: ArmId, revision: u64, why: &str) {
        let error = unkept(why);
        let needs = |answer: &mut HeldAnswer| {
            { answer.needs.get(&arm) }.is_some_and(|needed| *needed <= revision)
        };
        let answers: Vec<_> = { &mut self.keeping.answers }
            .extract_if(.., needs)
            .collect();
        for answer in answers {
            let outcome = match answer.or {
                IfUnkept::Stand => Err(forgotten(why)),
                IfUnkept::Refuse => Err(error.clone()),
                IfUnkept::PutBack(at, record, totals) => {
                    self.records.put_back(at, *record, totals);
                    Err(error.clone())
                }
                #[cfg(feature = "class")]
                IfUnkept::Reorder(job, place) => {
                    self.move_queued(now, job, place);
                    Err(error.clone())
                }
            };
            self.finish(now, answer.request, outcome);
        }
        let fresh: Vec<_> = { &mut self.keeping.fresh }
            .extract_if(.., |(of, at, _)| *of == arm && *at <= revision)
            .collect();
        for (_, _, job) in fresh {
            self.keeping.starts.retain(|start| start.job != job);
            #[cfg(feature = "class")]
            self.drop_queued(now, arm, job);
            let mut end = JobEnd::new("failed");
            end.error = Some(error.clone());
            let t = self.unix(now);
            if let Some(record) = self.records.numbered(job) {
                record.is_over(t, &end);
                // Its caller may try again.
                (record.hidden.key, record.order, record.place) = (None, None, None);
            }
            self.job_changed(now, arm, job);
            self.answer_end(now, arm, job, "failed", end.error);
        }
        let starts: Vec<_> = { &mut self.keeping.starts }
            .extract_if(.., |start| start.arm == arm && start.revision <= revision)
            .collect();
        for held in starts {
            let stopped = { held.then.iter() }.any(|order| matches!(order, ArmOrder::StopJob(_)));
            #[cfg(feature = "class")]
            if !stopped && self.wait_again(now, held.job) {
                continue;
            }
            let mut end = JobEnd::new(if stopped { "stopped" } else { "failed" });
            end.error = Some(error.clone()).filter(|_| !stopped);
            let news = crate::order::JobNews::Over(Box::new(end));
            self.job_news(now, arm, held.job, news);
        }
    }

    /// Notes a job that is new: it is refused if the disk does not take it.
    pub(super) fn note_fresh(&mut self, arm: ArmId, job: JobId) {
        let revision = self.records.revision(arm);
        self.keeping.fresh.push((arm, revision, job));
    }

    /// Orders the start of a job once it is on the disk that it begins.
    pub(super) fn order_start(&mut self, arm: ArmId, job: JobId, start: ArmOrder) {
        let revision = self.records.revision(arm);
        self.keeping.starts.push(HeldStart {
            arm,
            job,
            revision,
            start,
            then: Vec::new(),
        });
    }

    /// An order that is about a job which has not begun waits for it. `None` if it waits.
    pub(super) fn behind_start(&mut self, arm: ArmId, order: ArmOrder) -> Option<ArmOrder> {
        let mut starts = self.keeping.starts.iter_mut();
        let Some(held) = starts.find(|held| held.arm == arm) else {
            return Some(order);
        };
        let is_of_it = match &order {
            ArmOrder::PauseJob { job, .. }
            | ArmOrder::ResumeJob { job, .. }
            | ArmOrder::StopJob(job) => *job == held.job,
            ArmOrder::Stop { .. } => {
                held.then.push(ArmOrder::StopJob(held.job));
                false
            }
            ArmOrder::StopMotors => {
                held.then.push(ArmOrder::StopMotors);
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

    /// Answers a request once the jobs of these arms are on the disk as they are now.
    pub(super) fn answer_when_kept(
        &mut self,
        call: &Call<'_>,
        arms: impl IntoIterator<Item = ArmId>,
        result: Value,
        or: IfUnkept,
    ) -> Handled {
        let revisions = arms
            .into_iter()
            .map(|arm| (arm, self.records.revision(arm)));
        let needs: BTreeMap<_, _> = revisions
            .filter(|(arm, revision)| !self.records.is_kept(*arm, *revision))
            .collect();
        if needs.is_empty() {
            return Handled::Now(result);
        }
        self.keeping.answers.push(HeldAnswer {
            request: call.request,
            needs,
            result,
            or,
        });
        Handled::Later(call.request, Awaited::Kept)
    }

    /// Answers those who wait for a job to go on once it is on the disk that it does: until then the file has the job as it
    /// was before its resume.
    pub(super) fn answer_resumed_when_kept(&mut self, now: HostInstant, arm: ArmId, job: JobId) {
        let needs = BTreeMap::from([(arm, self.records.revision(arm))]);
        let result = self.shown(job);
        for (request, wants) in self.waiting_for(job) {
            if !matches!(wants, Wants::Running) {
                continue;
            }
            // It has begun; what is left is its answer.
            self.control.finish(now, arm, request);
            if let Some(pending) = self.pending.get_mut(&request) {
                pending.waits = Awaited::Kept;
            }
            self.keeping.answers.push(HeldAnswer {
                request,
                needs: needs.clone(),
                result: result.clone(),
                or: IfUnkept::Stand,
            });
        }
    }

    /// An arm stands after a stop, as its job will be: that is answered when the job is over. `None` if it waits.
    pub(super) fn behind_job(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        request: RequestId,
        stood: Value,
    ) -> Option<Value> {
        let job = self.records.under_way(arm);
        // Reading a program may take its time, and has nothing to stop.
        if !job.is_some_and(|job| job.is_read) {
            return Some(stood);
        }
        self.keeping.stands.push(HeldStand {
            arm,
            request,
            stood,
            due: now + STOPPED_JOB,
        });
        None
    }

    /// Tells of arms that stand whose job is over, or has had its time.
    pub(super) fn tell_stands(&mut self, now: HostInstant) {
        let records = &self.records;
        let is_over = |held: &mut HeldStand| {
            held.due <= now || records.under_way(held.arm).is_none_or(|job| !job.is_read)
        };
        let stands: Vec<_> = { &mut self.keeping.stands }
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

    /// When something of this is due.
    pub(super) fn keeping_due(&self) -> Option<HostInstant> {
        let stands = self.keeping.stands.iter().map(|held| held.due);
        stands.chain(self.records.due()).min()
    }

    /// Jobs that are not over at the end of the program, after the last stop: those of arms that did not confirm it are
    /// interrupted. What the disk has not taken up to now is tried once more.
    pub(crate) fn end_jobs(&mut self, now: HostInstant, unconfirmed: &[String]) {
        for arm in self.arm_ids() {
            let Some(job) = self.records.under_way(arm).and_then(|record| record.number) else {
                continue;
            };
            let is_lost = unconfirmed.contains(&self.arm(arm).entry.name);
            let state = if is_lost { "interrupted" } else { "stopped" };
            let news = crate::order::JobNews::Over(Box::new(JobEnd::new(state)));
            self.job_news(now, arm, job, news);
        }
        self.records.try_again(now, true);
        self.settle(now);
    }

    /// True if a job of the station is not over.
    pub(crate) fn has_jobs_under_way(&self) -> bool {
        let mut arms = self.arm_ids();
        arms.any(|arm| self.records.under_way(arm).is_some())
    }
}

/// The error of what was done, and is not on the disk.
fn forgotten(why: &str) -> RpcError {
    let message = format!("it is done, but not kept: after a power failure it is as before: {why}");
    RpcError::arm(ErrorKind::Closed, message).with("reason", json!("unkept"))
}

/// The error of what the disk did not take.
pub(super) fn unkept(why: &str) -> RpcError {
    let message = format!("the change is not kept, so it does not count: {why}");
    RpcError::arm(ErrorKind::Closed, message).with("reason", json!("unkept"))
}

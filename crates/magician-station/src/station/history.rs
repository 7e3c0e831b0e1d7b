//! Jobs that are over: history, deletion, and taking over those of earlier stations.

use magician::ErrorKind;
use magician::message;
use serde_json::Value;

use super::Station;
use super::dispatch::{Call, Handled};
use super::held_work::WriteFailurePolicy;
use super::jobs::is_under_way;
use super::records::{JobOwner, JobRecord};
use crate::api::{Role, RpcError};
use crate::control::{ArmId, JobId};

/// Default number of jobs in an answer to `job.history`.
const DEFAULT_PAGE_SIZE: usize = 50;

impl Station {
    /// Takes over the jobs of earlier stations, and interrupted runs of the command line.
    pub(super) fn load_jobs(&mut self) {
        let runs: Vec<_> = { 0..self.arms.len() }
            .map(|arm| self.config.jobs.runs(arm))
            .collect();
        // Runs of the command line that were finished or started again meanwhile are dropped.
        self.records.retain(|record| {
            let run = record.hidden.run.as_deref();
            let there = &runs[record.at.0 as usize];
            let is_there = |run: &str| there.iter().any(|kept| kept.name == run);
            record.hidden.went_on || run.is_none_or(is_there)
        });
        for (at, runs) in (0..).map(ArmId).zip(runs) {
            for run in runs {
                // Taken over by an earlier start of this station.
                let is_known =
                    |record: &JobRecord| record.hidden.run.as_deref() == Some(run.name.as_str());
                if let Some(known) = { self.records.each() }.find(|record| is_known(record)) {
                    // Known from an earlier start; the run may have progressed since.
                    known.update_from_run(&run);
                    continue;
                }
                let number = JobId(self.next_id());
                let id = self.text_id('j', number.0);
                let of = (at, self.arm(at).entry.name.clone());
                self.records.push(JobRecord::of_run(id, of, run));
            }
        }
        #[cfg(feature = "class")]
        {
            self.restore_queue();
            self.restore_freezes();
        }
    }

    /// `job.history`: returns a part of the stored jobs, and totals over all that ran.
    pub(super) fn job_history(&self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let number = |name| {
            let given = call.params.integer(name).map(usize::try_from);
            given.and_then(Result::ok)
        };
        let (skip, limit) = (number("skip"), number("limit"));
        let page =
            { &self.records }.history(arm, skip.unwrap_or(0), limit.unwrap_or(DEFAULT_PAGE_SIZE));
        Ok(Handled::Now(page))
    }

    /// `job.delete`: removes a job that is over. The totals do not change.
    pub(super) fn delete_job(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let record = self.job_named(call)?;
        let (id, arm) = (record.id.clone(), record.at);
        if is_under_way(&record.state) || record.state == "queued" {
            let why = message!("the job is not over: stop it first");
            return Err(RpcError::new(RpcError::BUSY, why).with("job", id));
        }
        if record.hidden.run.is_some() {
            let why = message!(
                "the job is a run of the command line, whose journal keeps it: \
                finish it, or run it anew"
            );
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        }
        let totals = self.records.earlier(arm);
        let Some((at, record)) = self.records.remove(&id) else {
            return Err(RpcError::internal("a job that is not there"));
        };
        // Deleting takes effect at once; if the disk refuses, the job is put back.
        let or = WriteFailurePolicy::Restore(at, Box::new(record), totals);
        Ok(self.answer_when_saved(call, [arm], Value::Null, or))
    }

    /// Returns the owner of a job of this request. `None` for a teacher.
    pub(super) fn owner_of(&self, call: &Call<'_>) -> Option<JobOwner> {
        if call.grant.role == Role::Teacher {
            return None;
        }
        let session = self.sessions.get(&call.session)?;
        #[cfg(feature = "class")]
        if let Some(name) = &session.pupil {
            return Some(JobOwner::Pupil(name.clone()));
        }
        session.grant.token.clone().map(JobOwner::Token)
    }
}

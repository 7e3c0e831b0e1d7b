//! What is kept of jobs that are over: told, deleted, and taken up by the next station.

use magician::ErrorKind;
use magician::message;
use serde_json::Value;

use super::Station;
use super::dispatch::{Call, Handled};
use super::jobs::is_under_way;
use super::keeping::IfUnkept;
use super::records::{JobOwner, JobRecord};
use crate::api::{Role, RpcError};
use crate::control::{ArmId, JobId};

/// Jobs that `job.history` tells of at once, unless it is asked for less.
const TOLD: usize = 50;

impl Station {
    /// Takes up what earlier stations and runs of the command line have left.
    pub(super) fn take_up_jobs(&mut self) {
        let runs: Vec<_> = { 0..self.arms.len() }
            .map(|arm| self.config.jobs.runs(arm))
            .collect();
        // A run that is over by now, or that begins anew elsewhere, is not there any more.
        self.records.retain(|record| {
            let run = record.hidden.run.as_deref();
            let there = &runs[record.at.0 as usize];
            let is_there = |run: &str| there.iter().any(|kept| kept.name == run);
            record.hidden.went_on || run.is_none_or(is_there)
        });
        for (at, runs) in (0..).map(ArmId).zip(runs) {
            for run in runs {
                let is_known =
                    |record: &JobRecord| record.hidden.run.as_deref() == Some(run.name.as_str());
                if let Some(known) = { self.records.each() }.find(|record| is_known(record)) {
                    // It may have come further since.
                    known.ran_on(&run);
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
            self.take_up_queue();
            self.take_up_freezes();
        }
    }

    /// `job.history`: the jobs that are kept, in parts, and the sums over all that ran.
    pub(super) fn job_history(&self, call: &Call<'_>, arm: ArmId) -> Result<Handled, RpcError> {
        let number = |name| {
            let given = call.params.integer(name).map(usize::try_from);
            given.and_then(Result::ok)
        };
        let (skip, limit) = (number("skip"), number("limit"));
        let told = { &self.records }.history(arm, skip.unwrap_or(0), limit.unwrap_or(TOLD));
        Ok(Handled::Now(told))
    }

    /// `job.delete`: takes a job that is over out of the list. The totals stay.
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
        let or = IfUnkept::PutBack(at, Box::new(record), totals);
        Ok(self.answer_when_kept(call, [arm], Value::Null, or))
    }

    /// Whose a job of this request is; `None`: a teacher's.
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

//! Methods of jobs.
//!
//! A job has a record ([`JobRecord`]) from its start on. A request about a job waits for a state
//! (`AwaitedJobState`); reports of the arm (`job_updates`) change the record and answer the
//! requests that wait for it. `job.start` may wait three times: for the library, for the disk, for
//! the check.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::{Message, message};
use magician_job::PauseReason;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::held_work::WriteFailurePolicy;
use super::library::program;
use super::long_requests::LongRequest;
use super::records::{JobRecord, digest};
use super::rights::{Risk, may_endanger};
use super::{Awaited, Station};
use crate::api::{Danger, RpcError};
#[cfg(feature = "class")]
use crate::control::QueuedChange;
use crate::control::{ArmId, JobId, LeaseLossPolicy, WorkKind};
use crate::job::{Source, SourceBytes, setup_and_preset};
use crate::order::{ArmOrder, JobOrder, JobStart};

/// State of a job for which a request waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AwaitedJobState {
    /// The check is over. The answer is the id of the job.
    Checked,
    /// The job is paused.
    Paused,
    /// The job runs.
    Running,
    /// The job is over.
    End,
}

impl Station {
    pub(super) fn job_call(&mut self, name: &str, call: &Call<'_>) -> Result<Handled, RpcError> {
        match (name, call.arm) {
            ("job.check", Some(arm)) => {
                let order = ArmOrder::CheckJob {
                    request: call.request,
                    source: Box::new(source(call)?),
                    preview: call.params.is_on("preview"),
                };
                self.queue_long_request(call, LongRequest::Check(arm, order))
            }
            ("job.start", Some(arm)) => self.start_job(call, arm, false),
            ("job.list", Some(arm)) => Ok(Handled::Now(json!({"jobs": self.records.of(arm)}))),
            ("job.history", Some(arm)) => self.job_history(call, arm),
            ("job.delete", _) => self.delete_job(call),
            #[cfg(feature = "class")]
            ("job.reorder", _) => self.reorder_job(call),
            #[cfg(not(feature = "class"))]
            ("job.reorder", _) => Ok(Handled::Now(self.job_named(call)?.shown())),
            ("job.get", _) => Ok(Handled::Now(self.job_named(call)?.shown())),
            ("job.pause", _) => self.pause_job(call),
            ("job.resume", _) => self.resume_job(call),
            ("job.stop", _) => self.stop_job(call),
            _ => Err(RpcError::internal(format!("{name} does nothing"))),
        }
    }

    /// Starts a job. `found` is true if program and preset are known to exist.
    pub(super) fn start_job(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        found: bool,
    ) -> Result<Handled, RpcError> {
        let params = call.params;
        if params.is_on("require_homed") && params.is_on("unhomed") {
            let why = message!("`require_homed` and `unhomed` contradict each other");
            return Err(RpcError::param("unhomed", why));
        }
        let source = source(call)?;
        let order = JobOrder {
            source,
            // 0 means endless in the API.
            loops: Some(params.integer("loops").unwrap_or(1)).filter(|loops| *loops > 0),
            // Clients count steps from 1. The parameter's range excludes 0.
            from: params.integer("from").map_or(0, |step| step - 1),
            keep: params.is_on("keep"),
            require_homed: params.is_on("require_homed"),
            unhomed: params.is_on("unhomed"),
            start: None,
            digest: params.text("digest").map(str::to_owned),
        };
        let key = params.text("key");
        if key == Some("") {
            return Err(RpcError::param("key", message!("`key` must not be empty")));
        }
        // A repeated start with the same key starts nothing.
        if let Some(again) = key.and_then(|key| self.started_before(call, arm, key, &order)) {
            return again;
        }
        let named = match order.source.bytes {
            SourceBytes::Program(_) => Some(program(call, "program")?),
            _ => None,
        };
        if !found && (named.is_some() || order.source.preset.is_some()) {
            return self.check_program_exists(call, arm, named, order.source.preset);
        }
        let on_lost = match params.text("on_lost") {
            Some("stop") => LeaseLossPolicy::Stop,
            Some("continue") => LeaseLossPolicy::Continue,
            Some(_) => LeaseLossPolicy::Pause,
            // The lease of a single request ends with the request, and the job must not end with
            // it.
            None if self.is_one_shot(call) => LeaseLossPolicy::Continue,
            None => LeaseLossPolicy::Pause,
        };
        self.acquire_free_lease(call, arm);
        #[cfg(feature = "class")]
        if params.is_on("queue") && self.has_to_wait(call, arm) {
            let job = self.queue_job(call, arm, order, on_lost)?;
            self.assign_key(job, key);
            let result = json!({"job": self.job_id(job)});
            return Ok(self.answer_when_saved(call, [arm], result, WriteFailurePolicy::Refuse));
        }
        #[cfg(not(feature = "class"))]
        if params.is_on("queue") {
            return Err(RpcError::param(
                "queue",
                "this station has no queue of jobs",
            ));
        }
        self.begin_for_job(call, arm, WorkKind::StartJob)?;
        let job = JobId(self.next_id());
        let id = self.text_id('j', job.0);
        let of = (arm, self.arm(arm).entry.name.clone());
        let mut record = JobRecord::new(id.clone(), of, job, order.clone());
        record.on_lost = on_lost;
        record.hidden.owner = self.owner_of(call);
        self.records.push(record);
        self.assign_key(job, key);
        self.begin_job(call, arm, job, order, None);
        // After the record changed, so that the revision includes it.
        self.note_fresh(arm, job);
        // The caller does not want to wait for the check.
        if call.params.switch("after_check") == Some(false) {
            self.control.finish(call.now, arm, call.request);
            let result = json!({"job": id});
            return Ok(self.answer_when_saved(call, [arm], result, WriteFailurePolicy::Refuse));
        }
        Ok(Handled::Later(
            call.request,
            Awaited::Job(arm, job, AwaitedJobState::Checked),
        ))
    }

    /// Returns the answer to a start whose key is known at this arm. `None` if the key is new.
    fn started_before(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        key: &str,
        order: &JobOrder,
    ) -> Option<Result<Handled, RpcError>> {
        let record = self.records.keyed(arm, key)?;
        let result = json!({"job": record.id});
        // Same key and same order is a retry; another order is a mistake of the caller.
        if record.hidden.digest != Some(digest(order)) {
            let why = message!(
                "the key is of {id}, which does something else: each job has a key of its own",
                id = record.id
            );
            return Some(Err(
                RpcError::param("key", why).with("job", record.id.clone())
            ));
        }
        if let Some(refusal) = record.refusal() {
            return Some(Err(refusal));
        }
        if let (Some(job), "checking", true) = (
            record.number,
            record.state.as_str(),
            call.params.switch("after_check") != Some(false),
        ) {
            let waits = Awaited::Job(arm, job, AwaitedJobState::Checked);
            return Some(Ok(Handled::Later(call.request, waits)));
        }
        Some(Ok(self.answer_when_saved(
            call,
            [arm],
            result,
            WriteFailurePolicy::Refuse,
        )))
    }

    /// Assigns the caller's key to a new job.
    fn assign_key(&mut self, job: JobId, key: Option<&str>) {
        if let (Some(record), Some(key)) = (self.records.numbered(job), key) {
            record.hidden.digest = record.order.as_deref().map(digest);
            record.hidden.key = Some(key.to_owned());
        }
    }

    /// Starts a job that has a record. `resumes` is `Some` for a resumed job: the distance before
    /// the place of interruption at which it starts again, mm.
    fn begin_job(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        job: JobId,
        order: JobOrder,
        resumes: Option<f64>,
    ) {
        let now = call.now;
        let started = self.unix(now);
        let holder = self.name_of(Some(call.session));
        #[cfg(feature = "class")]
        let pupil = self.pupil_of(call);
        #[cfg(feature = "class")]
        let endless = order.loops.is_none();
        if let Some(record) = self.records.numbered(job) {
            record.mark_started(started, holder);
            #[cfg(feature = "class")]
            {
                record.pupil = pupil;
            }
        }
        let start = JobStart {
            job,
            order,
            resumes: resumes.is_some(),
            overlap: resumes.unwrap_or_default(),
            laser: self.job_laser(call, arm),
            danger: job_danger(call),
        };
        // A new job is written to disk before the arm moves.
        let is_new = resumes.is_none();
        let start = ArmOrder::StartJob(Box::new(start));
        self.job_changed(now, arm, job);
        if is_new {
            self.order_start(arm, job, start);
        } else {
            // A resumed job has a journal already, so nothing is done twice if the program dies
            // now.
            self.order(arm, start);
        }
        #[cfg(feature = "class")]
        if endless {
            self.control.mark_job_endless(arm, job);
        }
    }

    fn pause_job(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let record = self.job_named(call)?;
        let (number, state) = (record.number, record.state.clone());
        let arm = record.at;
        self.acquire_free_lease(call, arm);
        self.begin_for_job(call, arm, WorkKind::SteerJob)?;
        let Some(job) = number.filter(|_| is_under_way(&state)) else {
            return Err(self.not_steerable_error(call, arm, message!("the job is over")));
        };
        // Pausing is idempotent.
        if state == "paused" {
            self.control.finish(call.now, arm, call.request);
            return Ok(Handled::Now(self.shown(job)));
        }
        let order = ArmOrder::PauseJob {
            request: Some(call.request),
            job,
            reason: PauseReason::Person,
        };
        self.order(arm, order);
        Ok(Handled::Later(
            call.request,
            Awaited::Job(arm, job, AwaitedJobState::Paused),
        ))
    }

    fn resume_job(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let record = self.job_named(call)?;
        let (id, number, state) = (record.id.clone(), record.number, record.state.clone());
        let order = record.order.clone();
        let arm = record.at;
        #[cfg(feature = "class")]
        if let ("queued", Some(job)) = (state.as_str(), number) {
            return self.resume_queued(call, job);
        }
        let goes_on = ["stopped", "failed", "interrupted"].contains(&state.as_str());
        let overlap = call.params.number("overlap");
        if overlap.is_some() && state == "paused" {
            let why = message!(
                "`overlap` is for a job that ended before its end; a paused one goes on where it is"
            );
            return Err(RpcError::param("overlap", why));
        }
        self.acquire_free_lease(call, arm);
        let kind = if goes_on {
            WorkKind::StartJob
        } else {
            WorkKind::SteerJob
        };
        self.begin_for_job(call, arm, kind)?;
        let one_shot = self.is_one_shot(call);
        if goes_on {
            let Some(order) = order else {
                return Err(self.not_steerable_error(
                    call,
                    arm,
                    message!("the program of the job is not kept"),
                ));
            };
            let job = JobId(self.next_id());
            if let Some(record) = self.records.named(&id) {
                // If the resume fails, the record returns to this state.
                record.before = Some(Box::new(record.clone()));
                record.number = Some(job);
                if one_shot {
                    record.on_lost = LeaseLossPolicy::Continue;
                }
            }
            let overlap = overlap.unwrap_or_default();
            self.begin_job(call, arm, job, (*order).clone(), Some(overlap));
            return Ok(Handled::Later(
                call.request,
                Awaited::Job(arm, job, AwaitedJobState::Running),
            ));
        }
        let Some(job) = number.filter(|_| state == "paused") else {
            return Err(self.not_steerable_error(call, arm, message!("the job is not paused")));
        };
        if let Some(record) = self.records.numbered(job)
            && one_shot
        {
            record.on_lost = LeaseLossPolicy::Continue;
        }
        let laser = self.job_laser(call, arm);
        let order = ArmOrder::ResumeJob {
            request: call.request,
            job,
            // Approaching is safe in any case, so it is the default.
            approach: call.params.switch("approach").unwrap_or(true),
            laser,
        };
        self.order(arm, order);
        Ok(Handled::Later(
            call.request,
            Awaited::Job(arm, job, AwaitedJobState::Running),
        ))
    }

    fn stop_job(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let record = self.job_named(call)?;
        let (number, state) = (record.number, record.state.clone());
        #[cfg(feature = "class")]
        if let ("queued", Some(job)) = (state.as_str(), number) {
            let arm = record.at;
            self.check_queued_job(call, job, QueuedChange::Stop)?;
            self.stop_queued(call.now, job);
            let shown = self.shown(job);
            return Ok(self.answer_when_saved(call, [arm], shown, WriteFailurePolicy::Keep));
        }
        let Some(job) = number.filter(|_| is_under_way(&state)) else {
            return Ok(Handled::Now(record.shown()));
        };
        let arm = record.at;
        self.order(arm, ArmOrder::StopJob(job));
        Ok(Handled::Later(
            call.request,
            Awaited::Job(arm, job, AwaitedJobState::End),
        ))
    }

    /// Starts a request about a job: it needs the lease, and an arm that nothing else occupies.
    fn begin_for_job(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        kind: WorkKind,
    ) -> Result<(), RpcError> {
        let begun = self
            .control
            .begin(call.now, call.session, arm, call.request, kind);
        begun.map_err(|refusal| self.refused(arm, refusal))
    }

    fn not_steerable_error(&mut self, call: &Call<'_>, arm: ArmId, why: Message) -> RpcError {
        self.control.finish(call.now, arm, call.request);
        RpcError::arm(magician::ErrorKind::InvalidInput, why)
    }

    /// Checks whether a job may burn. `Err` holds the refusal.
    fn job_laser(&self, call: &Call<'_>, arm: ArmId) -> Result<(), Box<RpcError>> {
        let may = self.may_burn(call, arm, Risk::of_job("job.start"));
        may.map_err(Box::new)
    }

    /// Returns the record of the job named in a request.
    pub(super) fn job_named(&self, call: &Call<'_>) -> Result<&JobRecord, RpcError> {
        let id = call.params.text("job").unwrap_or_default();
        let found = self.records.find(id);
        found.ok_or_else(|| RpcError::param("job", message!("there is no such job")))
    }

    pub(super) fn shown(&mut self, job: JobId) -> Value {
        let record = self.records.numbered(job);
        record.map_or(Value::Null, |record| record.shown())
    }

    /// Returns the current job of an arm, and true if it is running.
    pub(super) fn job_at(&self, arm: ArmId) -> Option<(&JobRecord, bool)> {
        let record = self.records.under_way(arm)?;
        Some((record, record.state == "running"))
    }

    /// Returns the id of a job as known to clients.
    pub(super) fn job_id(&self, job: JobId) -> String {
        let known = self.records.id_of(job);
        known.unwrap_or_else(|| self.text_id('j', job.0))
    }
}

/// True for the states of a job that has begun and is not over.
pub(super) fn is_under_way(state: &str) -> bool {
    ["checking", "running", "pausing", "paused", "stopping"].contains(&state)
}

/// Checks whether a job may contain dangerous commands. `Err` holds the refusal.
fn job_danger(call: &Call<'_>) -> Result<(), Box<RpcError>> {
    may_endanger(call, Risk::of_dangerous_job(), Danger::JOB).map_err(Box::new)
}

/// Returns the program of a request. Exactly one form must be given.
pub(super) fn source(call: &Call<'_>) -> Result<Source, RpcError> {
    let params = call.params;
    let given = ["program", "text", "data"].map(|name| params.text(name));
    let bytes = match given {
        [Some(_), None, None] => {
            SourceBytes::Program(program(call, "program")?.as_str().to_owned())
        }
        [None, Some(text), None] => SourceBytes::Text(text.to_owned()),
        [None, None, Some(data)] => {
            // Checked here, so that the error comes before the job is created.
            let wrong = |_| RpcError::param("data", message!("`data` must be bytes in base64"));
            STANDARD.decode(data).map_err(wrong)?;
            SourceBytes::Data(data.to_owned())
        }
        _ => {
            let why = message!("one of `program`, `text` and `data` has to be given");
            return Err(RpcError::param("text", why));
        }
    };
    let (setup, preset) = setup_and_preset(params.object("setup"))?;
    Ok(Source {
        bytes,
        format: params.text("format").map(str::to_owned),
        setup,
        preset,
    })
}

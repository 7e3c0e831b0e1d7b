//! Methods of jobs, and reports about jobs from the arms.
//!
//! A job has a record ([`JobRecord`]) from its start on. A request about a job waits for a state
//! (`AwaitedJobState`); reports of the arm change the record and answer the requests that wait for
//! it. `job.start` may wait three times: for the library, for the disk, for the check.

use magician::message;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician_job::{JobState, PauseReason};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::dispatch::{Call, Handled};
use super::held_work::WriteFailurePolicy;
use super::long_requests::LongRequest;
use super::library::program;
use super::newest::{Newest, PROGRESS_INTERVAL};
use super::records::{JobRecord, digest};
use super::rights::{Risk, may_endanger};
use super::{Awaited, Station};
use crate::api::{ArmEvent, Danger, RpcError};
#[cfg(feature = "class")]
use crate::control::QueuedChange;
use crate::control::{ArmId, JobId, JobPhase, LeaseLossPolicy, RequestId, WorkEnd, WorkKind};
use crate::job::{Source, SourceBytes, setup_and_preset};
use crate::order::{ArmOrder, JobUpdate, JobOrder, JobStart};

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
            let why = "`require_homed` and `unhomed` contradict each other";
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
            return Err(RpcError::param("key", "`key` must not be empty"));
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
        let record = self.records.assign_key(arm, key)?;
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
            return Err(self.not_steerable_error(call, arm, "the job is over"));
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
            let why = "`overlap` is for a job that ended before its end; a paused one goes on where it is";
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
                return Err(self.not_steerable_error(call, arm, "the program of the job is not kept"));
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
            return Err(self.not_steerable_error(call, arm, "the job is not paused"));
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

    fn not_steerable_error(&mut self, call: &Call<'_>, arm: ArmId, why: &str) -> RpcError {
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
        found.ok_or_else(|| RpcError::param("job", "there is no such job"))
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

    /// Takes a report about a job.
    pub(super) fn apply_job_update(&mut self, now: HostInstant, arm: ArmId, job: JobId, update: JobUpdate) {
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
                self.notice_rates.changed(Newest::Job(job), PROGRESS_INTERVAL);
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
                        self.answer_job(now, job, &[AwaitedJobState::Checked, AwaitedJobState::Running]);
                    }
                    JobState::Paused { .. } => {
                        self.answer_job(now, job, &[AwaitedJobState::Checked, AwaitedJobState::Paused]);
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
            let wrong = |_| RpcError::param("data", "`data` must be bytes in base64");
            STANDARD.decode(data).map_err(wrong)?;
            SourceBytes::Data(data.to_owned())
        }
        _ => {
            let why = "one of `program`, `text` and `data` has to be given";
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

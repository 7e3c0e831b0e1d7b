//! Queue of jobs: jobs that wait for their arm.
//!
//! Order and owner of a waiting job are in [`control`](crate::control); this module holds its
//! program and starts it when control says so. A job may wait for a person's word (`held`): after a
//! stop, after a restart of the station, or because it burns. Nothing in the queue starts by itself
//! after a stop.

use magician::message;
use magician_program::Format;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::Station;
use super::class::Person;
use super::dispatch::{Call, Handled};
use super::held_work::WriteFailurePolicy;
use super::jobs::source;
use super::newest::{LIST_INTERVAL, Newest};
use super::records::{JobOwner, JobRecord};
use super::rights::{Risk, may_endanger};
use crate::api::{Danger, RpcError};
use crate::control::{ArmId, JobClaim, JobId, LeaseLossPolicy, PersonId, QueuedChange};
use crate::order::{ArmOrder, JobEnd, JobOrder, JobStart};

/// Most jobs that wait for an arm.
const MAX_WAITING_JOBS: usize = 20;
/// Position after all others.
const LAST_POSITION: usize = usize::MAX;

/// Waiting job, without its position and owner.
#[derive(Clone, Debug)]
pub(super) struct QueuedJob {
    order: JobOrder,
    on_lost: LeaseLossPolicy,
    pupil: Option<String>,
    holder: Value,
    /// True if a client that may burn has allowed it.
    may_burn: bool,
    /// True if a teacher has confirmed its dangerous commands.
    may_endanger: bool,
    /// Reason why the job waits for a person. `yes`: confirmation that it may burn, or that its
    /// dangerous commands are intended. `stopped`: its owner, since the arm was stopped. `restart`:
    /// its owner, since the station was restarted. `unkept`: its owner, since the disk refused to
    /// record its start.
    pub(super) held: Option<&'static str>,
}

impl Station {
    /// True if a job of this request would have to wait for the arm.
    pub(super) fn has_to_wait(&self, call: &Call<'_>, arm: ArmId) -> bool {
        let kind = crate::control::WorkKind::StartJob;
        self.control.check_work(call.session, arm, kind).is_err()
    }

    /// Appends a job to the queue of an arm.
    pub(super) fn queue_job(
        &mut self,
        call: &Call<'_>,
        arm: ArmId,
        order: JobOrder,
        on_lost: LeaseLossPolicy,
    ) -> Result<JobId, RpcError> {
        if self.control.jobs(arm).count() >= MAX_WAITING_JOBS {
            let why = message!(
                "{count} jobs wait for the arm already",
                count = MAX_WAITING_JOBS
            );
            return Err(RpcError::new(RpcError::TOO_MANY, why).with("limit", MAX_WAITING_JOBS));
        }
        let bound = self.control.is_bound(call.session);
        let person = self.control.person(call.session);
        if bound && person.is_none() {
            let why = message!("jobs that wait are of persons: sign in with name and code first");
            return Err(RpcError::new(RpcError::FORBIDDEN, why));
        }
        if let Some(why) = person.and_then(|person| self.barred(arm, person)) {
            return Err(RpcError::new(RpcError::FORBIDDEN, why));
        }
        let job = JobId(self.next_id());
        let id = self.text_id('j', job.0);
        let of = (arm, self.arm(arm).entry.name.clone());
        let mut record = JobRecord::new(id, of, job, order.clone());
        // The program is read when the job starts. Until then the name of its file serves as the
        // title.
        let title = Format::title(order.source.bytes.name());
        record.title = Some(title.to_owned()).filter(|title| !title.is_empty());
        "queued".clone_into(&mut record.state);
        record.on_lost = on_lost;
        record.hidden.owner = self.owner_of(call);
        record.holder = self.name_of(Some(call.session));
        let holder = record.holder.clone();
        self.records.push(record);
        self.note_fresh(arm, job);
        let pupil = self.pupil_of(call);
        let queued = QueuedJob {
            order,
            on_lost,
            pupil,
            holder,
            may_burn: self.may_burn(call, arm, Risk::of_job("job.start")).is_ok(),
            may_endanger: may_endanger(call, Risk::of_dangerous_job(), Danger::JOB).is_ok(),
            held: None,
        };
        self.put_in_queue(
            call.now,
            JobClaim { job, arm, person },
            LAST_POSITION,
            queued,
        );
        Ok(job)
    }

    fn put_in_queue(&mut self, now: HostInstant, claim: JobClaim, place: usize, queued: QueuedJob) {
        self.control.queue_job(claim, place);
        self.class.queue.insert(claim.job, queued);
        self.notify_queue(now, claim.arm);
    }

    /// Removes a job from the queue. `None` if it does not wait.
    fn take_from_queue(&mut self, job: JobId) -> Option<(JobClaim, QueuedJob)> {
        let claim = self.control.take_job(job);
        self.notice_rates.changed(Newest::Turns, LIST_INTERVAL);
        claim.zip(self.class.queue.remove(&job))
    }

    pub(super) fn pupil_of(&self, call: &Call<'_>) -> Option<String> {
        self.sessions.get(&call.session)?.pupil.clone()
    }

    /// Prevents all further starts from the queue. It is kept for the next start of the station.
    pub(crate) fn close_queue(&mut self) {
        self.class.closed = true;
    }

    /// Starts jobs whose arm is free. Returns true if any started.
    pub(super) fn begin_queued(&mut self, now: HostInstant) -> bool {
        let mut started = false;
        if self.class.closed {
            return false;
        }
        for arm in self.arm_ids() {
            let held = |job| {
                self.class
                    .queue
                    .get(&job)
                    .is_none_or(|job| job.held.is_some())
            };
            let next = { self.control.next_job(now, arm, |job| !held(job)) }
                // Without a line the start would only fail.
                .filter(|_| self.arm(arm).link)
                .and_then(|claim| self.take_from_queue(claim.job));
            if let Some((claim, queued)) = next {
                self.begin_from_queue(now, claim, queued);
                self.notify_queue(now, arm);
                started = true;
            }
        }
        started
    }

    fn begin_from_queue(&mut self, now: HostInstant, claim: JobClaim, queued: QueuedJob) {
        let JobClaim { job, arm, person } = claim;
        // The fence of the owner, not of the current holder: the job may start without one.
        let fence = self.fence_for(arm, person.is_none());
        self.order_fence(arm, fence);
        let holder = self.control.holder(arm);
        let t = self.unix(now);
        if let Some(record) = self.records.numbered(job) {
            record.mark_started(t, queued.holder.clone());
            (record.place, record.reason) = (None, None);
            record.pupil.clone_from(&queued.pupil);
            // Without a holder there is no lease whose end could end the job.
            record.on_lost = holder.map_or(LeaseLossPolicy::Continue, |_| queued.on_lost);
        }
        let needs = |what, danger| Box::new(RpcError::dangerous(what, "job.start", danger));
        let start = JobStart {
            job,
            order: queued.order.clone(),
            resumes: false,
            overlap: 0.0,
            laser: { queued.may_burn.then_some(()) }.ok_or_else(|| needs("the job", Danger::Laser)),
            danger: { queued.may_endanger.then_some(()) }
                .ok_or_else(|| needs("a command", Danger::JOB)),
        };
        self.class.from_queue.insert(job, (claim, queued));
        self.job_changed(now, arm, job);
        self.order_start(arm, job, ArmOrder::StartJob(Box::new(start)));
        // No lease will end, so motors have to end with the job.
        if self.control.holder(arm).is_none() {
            self.order(arm, ArmOrder::EndUnattended);
        }
    }

    /// Handles the end of a job that came from the queue. A job that must not burn goes back to the
    /// queue and waits for a teacher. Returns true if it did.
    pub(super) fn finish_queued(&mut self, now: HostInstant, job: JobId, end: &JobEnd) -> bool {
        let queued = self.class.from_queue.remove(&job);
        let code = end.error.as_ref().map(|error| error.code);
        let arm = self
            .records
            .numbered(job)
            .map_or(ArmId(0), |record| record.at);
        // After a stop nothing else starts to move by itself. A job that failed its check has moved
        // nothing.
        if end.state != "done"
            && !matches!(code, Some(RpcError::CHECK_FAILED | RpcError::DANGEROUS))
        {
            self.hold_queue(now, arm);
        }
        let Some((claim, queued)) = queued.filter(|_| code == Some(RpcError::DANGEROUS)) else {
            return false;
        };
        if queued.may_burn && queued.may_endanger {
            return false;
        }
        self.put_back_in_queue(now, claim, queued, "yes");
        true
    }

    /// Puts a job that was about to start at the front of its arm's queue, where it waits for a
    /// person.
    fn put_back_in_queue(
        &mut self,
        now: HostInstant,
        claim: JobClaim,
        queued: QueuedJob,
        held: &'static str,
    ) {
        let JobClaim { job, arm, .. } = claim;
        if let Some(record) = self.records.numbered(job) {
            "queued".clone_into(&mut record.state);
            record.started = None;
        }
        let held = Some(held);
        self.job_changed(now, arm, job);
        self.put_in_queue(now, claim, 0, QueuedJob { held, ..queued });
    }

    /// Holds all jobs that wait for an arm until a person resumes them.
    pub(super) fn hold_queue(&mut self, now: HostInstant, arm: ArmId) {
        for claim in self.control.jobs(arm) {
            if let Some(queued) = self.class.queue.get_mut(&claim.job) {
                queued.held.get_or_insert("stopped");
            }
        }
        self.notify_queue(now, arm);
    }

    /// Checks whether a request may change a waiting job.
    ///
    /// # Errors
    /// The refusal, with the roles that may.
    pub(super) fn check_queued_job(
        &self,
        call: &Call<'_>,
        job: JobId,
        change: QueuedChange,
    ) -> Result<(), RpcError> {
        let claim = self.control.waiting_job(job);
        claim.map_or(Ok(()), |claim| self.check_queued(call, &claim, change))
    }

    /// Resumes a waiting job. A job that burns can be resumed only by a client that may burn, at
    /// the moment at which it can start, because that client watches it.
    pub(super) fn resume_queued(
        &mut self,
        call: &Call<'_>,
        job: JobId,
    ) -> Result<Handled, RpcError> {
        let unknown = || RpcError::internal("a job that waits in no queue");
        let claim = self.control.waiting_job(job).ok_or_else(unknown)?;
        self.check_queued(call, &claim, QueuedChange::Resume)?;
        let arm = claim.arm;
        let queued = self.class.queue.get_mut(&job).ok_or_else(unknown)?;
        if queued.held == Some("yes") {
            let may_endanger_already = queued.may_endanger;
            self.may_burn(call, arm, Risk::of_job("job.resume"))?;
            if !may_endanger_already && self.arm(arm).entry.is_virtual {
                may_endanger(call, Risk::of_job("job.resume"), Danger::JOB)?;
            }
            // The confirming person must be there when the laser starts, not some time later.
            if !self.control.may_begin(call.now, &claim) {
                let why = message!("the arm is not free for it: say yes when it can begin");
                return Err(RpcError::new(RpcError::BUSY, why).with("job", self.job_id(job)));
            }
            let (claim, mut queued) = self.take_from_queue(job).ok_or_else(unknown)?;
            queued.held = None;
            queued.may_burn = true;
            queued.may_endanger |=
                may_endanger(call, Risk::of_dangerous_job(), Danger::JOB).is_ok();
            self.begin_from_queue(call.now, claim, queued);
        } else {
            queued.held = None;
        }
        self.notify_queue(call.now, arm);
        let shown = self.records.numbered(job).map(|record| record.shown());
        Ok(Handled::Now(shown.unwrap_or_default()))
    }

    /// Removes a job from the queue and ends it.
    pub(super) fn stop_queued(&mut self, now: HostInstant, job: JobId) {
        let Some((claim, _)) = self.take_from_queue(job) else {
            return;
        };
        let t = self.unix(now);
        if let Some(record) = self.records.numbered(job) {
            record.mark_over(t, &JobEnd::new("stopped"));
            (record.place, record.order) = (None, None);
        }
        self.job_changed(now, claim.arm, job);
        self.notify_queue(now, claim.arm);
    }

    /// Removes all jobs of a person from the queues.
    pub(super) fn stop_queued_of(&mut self, now: HostInstant, person: PersonId) {
        let of = |claim: &&JobClaim| claim.person == Some(person);
        let arms = self.arm_ids();
        let jobs: Vec<_> = { arms.flat_map(|arm| self.control.jobs(arm).filter(of)) }
            .map(|claim| claim.job)
            .collect();
        for job in jobs {
            self.stop_queued(now, job);
        }
    }

    /// Ends the job of a person that started from the queue and runs without a lease, in the way
    /// the end of a turn does. Returns false without such a job.
    pub(super) fn end_queued_job(&mut self, arm: ArmId, of: Option<PersonId>) -> bool {
        let mut started = self.class.from_queue.values();
        let own = started.find(|(claim, _)| {
            claim.arm == arm
                && claim.person.is_some()
                && (of.is_none() || claim.person == of)
                && self.control.has_job(arm, claim.job)
        });
        // `continue` applies to a lost lease. Here a person has ended the turn.
        let stops = own.map(|(_, queued)| queued.on_lost == LeaseLossPolicy::Stop);
        stops.is_some_and(|stops| self.control.end_unattended_job(arm, stops))
    }

    /// Restores the queue of an earlier station in its order. No job starts before a person resumes
    /// it.
    pub(super) fn restore_queue(&mut self) {
        let mut left: Vec<_> = { self.records.each() }
            .filter(|record| record.state == "queued")
            .map(|record| (record.at, record.place, record.id.clone()))
            .collect();
        left.sort_by_key(|(arm, place, _)| (*arm, place.unwrap_or(u64::MAX)));
        for (arm, _, id) in left {
            let job = JobId(self.next_id());
            let Some(record) = self.records.named(&id) else {
                continue;
            };
            record.number = Some(job);
            let Some(order) = record.order.as_deref().cloned() else {
                // Stored by another version, whose program this one cannot read.
                "interrupted".clone_into(&mut record.state);
                record.place = None;
                self.records.note_change(arm);
                continue;
            };
            let (owner, on_lost) = (record.hidden.owner.clone(), record.on_lost);
            let (holder, reason) = (record.holder.clone(), record.reason.clone());
            let pupil = match &owner {
                Some(JobOwner::Pupil(name)) => Some(name.clone()),
                _ => None,
            };
            let person = owner.map(|owner| match owner {
                JobOwner::Pupil(name) => self.number_of(Person::Pupil(name)),
                JobOwner::Token(name) => self.number_of(Person::Token(name)),
            });
            let held = match reason.as_deref() {
                Some("yes") => "yes",
                // After a restart a person has to look at the arm first, whatever the reason was.
                _ => "restart",
            };
            let is_virtual = self.arm(arm).entry.is_virtual;
            let queued = QueuedJob {
                order,
                on_lost,
                pupil,
                holder,
                // A confirmation given to an earlier station is not carried over.
                may_burn: is_virtual,
                may_endanger: false,
                held: Some(held),
            };
            let claim = JobClaim { job, arm, person };
            self.put_in_queue(HostInstant::ZERO, claim, LAST_POSITION, queued);
        }
    }

    /// Removes a job whose start was never answered.
    pub(super) fn drop_queued(&mut self, now: HostInstant, arm: ArmId, job: JobId) {
        self.take_from_queue(job);
        self.class.from_queue.remove(&job);
        self.notify_queue(now, arm);
    }

    /// Returns a job to the queue because the disk refused to record its start. Returns false for a
    /// job from elsewhere.
    pub(super) fn requeue(&mut self, now: HostInstant, job: JobId) -> bool {
        let queued = self.class.from_queue.remove(&job);
        let waits = queued.is_some();
        if let Some((claim, queued)) = queued {
            self.put_back_in_queue(now, claim, queued, "unkept");
        }
        waits
    }

    /// Moves a waiting job within the queue of its arm.
    pub(super) fn reorder_job(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let record = self.job_named(call)?;
        let (arm, number, state) = (record.at, record.number, record.state.clone());
        let Some(job) = number.filter(|_| state == "queued") else {
            return Ok(Handled::Now(record.shown()));
        };
        self.check_queued_job(call, job, QueuedChange::Reorder)?;
        let place = call
            .params
            .integer("position")
            .unwrap_or(1)
            .saturating_sub(1);
        let before = self.move_queued(call.now, job, usize::try_from(place).unwrap_or(usize::MAX));
        let shown = self.shown(job);
        let or = before.map_or(WriteFailurePolicy::Refuse, |before| {
            WriteFailurePolicy::Reorder(job, before)
        });
        Ok(self.answer_when_saved(call, [arm], shown, or))
    }

    /// Moves a job to a position, from 0. Returns the position before. `None` if it does not wait.
    pub(super) fn move_queued(
        &mut self,
        now: HostInstant,
        job: JobId,
        place: usize,
    ) -> Option<usize> {
        let claim = self.control.waiting_job(job)?;
        let before = { self.control.jobs(claim.arm) }.position(|other| other.job == job);
        self.control.queue_job(claim, place);
        self.notify_queue(now, claim.arm);
        before
    }

    /// Publishes changed positions and states of an arm's queue.
    fn notify_queue(&mut self, now: HostInstant, arm: ArmId) {
        let held = |job| self.class.queue.get(&job).and_then(|queued| queued.held);
        let jobs = self
            .control
            .jobs(arm)
            .map(|claim| (claim.job, held(claim.job)));
        let places: Vec<_> = (1..).zip(jobs).collect();
        for (place, (job, held)) in places {
            let Some(record) = self.records.numbered(job) else {
                continue;
            };
            let before = (record.place, record.reason.clone());
            let after = (Some(place), held.map(str::to_owned));
            if before == after {
                continue;
            }
            self.notice_rates.changed(Newest::Turns, LIST_INTERVAL);
            let moves_alone = before.0.is_some() && before.1 == after.1;
            (record.place, record.reason) = after;
            if moves_alone {
                // A changed position is not a change of state, so it stays out of the event log.
                self.records.note_change(arm);
                self.notice_rates.changed(Newest::Job(job), LIST_INTERVAL);
            } else {
                self.job_changed(now, arm, job);
            }
        }
    }

    /// Queues a program at several arms, for a teacher.
    pub(super) fn send_to_arms(&mut self, call: &Call<'_>) -> Result<Handled, RpcError> {
        let source = source(call)?;
        let arms = self.selected_arms(call)?;
        let mut jobs = Vec::new();
        for arm in arms.iter().copied() {
            let order = JobOrder {
                source: source.clone(),
                loops: Some(1),
                from: 0,
                keep: false,
                require_homed: false,
                unhomed: false,
                start: None,
                digest: None,
            };
            let name = self.arm(arm).entry.name.clone();
            // One refusal does not stop the others: each arm gets its own result.
            let queued = self.queue_job(call, arm, order, LeaseLossPolicy::Continue);
            jobs.push((name, queued));
        }
        self.begin_queued(call.now);
        let jobs = jobs.into_iter().map(|(arm, queued)| match queued {
            Ok(job) => {
                let record = self.records.numbered(job);
                let state = record.map(|record| record.state.clone());
                json!({"arm": arm, "job": self.job_id(job), "state": state, "error": null})
            }
            Err(error) => json!({"arm": arm, "job": null, "state": null, "error": error.message}),
        });
        let result = json!({"jobs": jobs.collect::<Vec<_>>()});
        Ok(self.answer_when_saved(call, arms, result, WriteFailurePolicy::Refuse))
    }
}

//! Users of an arm: requests in progress, a jog, a job; and which of them excludes which.

use std::time::Duration;

use magician_protocol::HostInstant;

use super::{ArmId, Control, Effect, JobId, JogEnd, JogId, Refusal, RequestId, SessionId};

/// Time after which a jog that the arm has not answered is given up. The driver answers earlier, if
/// only with an error: it may wait up to 5 s for the arm to come to rest, and its call times out
/// after another 5 s.
const JOG_START_TIMEOUT: Duration = Duration::from_secs(10);

/// Effect of a request on the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WorkKind {
    /// Sets something and leaves nothing behind.
    Setting,
    /// Sets something that is allowed during a job: its speed.
    JobSetting,
    /// Moves the arm, and is over when the arm has arrived.
    Motion,
    /// Leaves a command in the arm's queue.
    Queued,
    /// Starts a job.
    StartJob,
    /// Pauses or resumes a job.
    SteerJob,
}

impl WorkKind {
    /// True if the request concerns a job and neither moves nor sets anything itself.
    const fn is_of_jobs(self) -> bool {
        matches!(self, Self::JobSetting | Self::StartJob | Self::SteerJob)
    }
}

/// Current user of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Busy {
    /// A job.
    Job(JobId),
    /// A jog.
    Jog(JogId),
}

/// Phase of a job, as far as others have to wait for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JobPhase {
    /// The job checks, runs, pauses or ends.
    Active,
    /// The arm may be moved until the job is resumed.
    Paused,
}

impl JobPhase {
    pub(super) const fn is_under_way(self) -> bool {
        matches!(self, Self::Active)
    }
}

/// Policy for a job when the lease under which it runs ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LeaseLossPolicy {
    /// The job pauses. Any later holder may resume it.
    #[default]
    Pause,
    /// The job stops.
    Stop,
    /// The job continues.
    Continue,
}

impl LeaseLossPolicy {
    /// Returns the name used in messages and files.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Pause => "pause",
            Self::Stop => "stop",
            Self::Continue => "continue",
        }
    }

    /// Returns the policy with this name. [`Pause`](Self::Pause) without a name or for an unknown
    /// one.
    pub(crate) fn named(name: Option<&str>) -> Self {
        match name {
            Some("stop") => Self::Stop,
            Some("continue") => Self::Continue,
            // The safe choice, also for a name of a later version.
            _ => Self::Pause,
        }
    }
}

/// Request in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Work {
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    kind: WorkKind,
}

/// Jog in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Jog {
    pub(super) id: JogId,
    pub(super) session: SessionId,
    /// Keep-alive period: the jog ends if it is not kept for this long.
    pub(super) keep: Duration,
    /// Instant at which the jog ends unless it is kept.
    pub(super) ends: HostInstant,
}

/// Current job of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Job {
    pub(super) id: JobId,
    pub(super) on_lost: LeaseLossPolicy,
    pub(super) phase: JobPhase,
    /// True if the job burns: then it does not outlast the socket of its holder.
    pub(super) burns: bool,
    /// True if the job runs until it is stopped.
    pub(super) endless: bool,
    /// True if the job was already paused or stopped because the holder's socket closed.
    ended_for_socket: bool,
}

impl Control {
    /// Starts a request that needs the lease. [`finish`](Self::finish) ends it.
    ///
    /// # Errors
    /// [`Refusal`] if the request must not start; nothing has changed then.
    pub fn begin(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        kind: WorkKind,
    ) -> Result<(), Refusal> {
        self.check_work(session, arm, kind)?;
        self.note_message(now, session);
        let state = self.arm_mut(arm);
        state.queued |= kind == WorkKind::Queued;
        state.work.push(Work {
            session,
            request,
            kind,
        });
        Ok(())
    }

    /// Checks whether a request could start.
    ///
    /// # Errors
    /// The same as [`begin`](Self::begin).
    pub fn check_work(
        &self,
        session: SessionId,
        arm: ArmId,
        kind: WorkKind,
    ) -> Result<(), Refusal> {
        #[cfg(feature = "class")]
        if self.refuses_frozen(session, arm) {
            return Err(Refusal::Frozen);
        }
        let holder = self.holder(arm);
        if holder != Some(session) {
            return Err(Refusal::Lease(holder));
        }
        let state = self.arm(arm);
        if self.is_ending && kind == WorkKind::StartJob {
            return Err(Refusal::Closed);
        }
        // A jog excludes everything else, except a stop, which does not pass through here.
        if let Some(jog) = state.jog {
            return Err(Refusal::Busy(Busy::Jog(jog.id)));
        }
        match (state.job, kind) {
            // A paused job blocks another one too: both would have to share the arm.
            (Some(job), WorkKind::StartJob) => Err(Refusal::Busy(Busy::Job(job.id))),
            // Steering is what a running job allows.
            (_, WorkKind::SteerJob | WorkKind::JobSetting) => Ok(()),
            (Some(job), _) if job.phase.is_under_way() => Err(Refusal::Busy(Busy::Job(job.id))),
            // No job, or a paused one, during which the arm may be moved.
            _ => Ok(()),
        }
    }

    /// Ends a request. Returns false if it was ended before; then its outcome is to be dropped.
    pub fn finish(&mut self, now: HostInstant, arm: ArmId, request: RequestId) -> bool {
        let work = &mut self.arm_mut(arm).work;
        let Some(at) = work.iter().position(|work| work.request == request) else {
            return false;
        };
        let session = work.remove(at).session;
        // The request counted as a sign of life until now.
        self.note_message(now, session);
        true
    }

    /// Switches reporting of the unlock key on or off. It ends with the lease.
    pub fn guide(&mut self, arm: ArmId, on: bool) {
        self.arm_mut(arm).guided = on;
    }

    /// Starts a jog. A jog of the same session is replaced.
    ///
    /// # Errors
    /// The same as [`begin`](Self::begin), and [`Refusal::Closed`] while the station ends.
    pub fn start_jog(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        keep: Duration,
    ) -> Result<JogId, Refusal> {
        let replaces = self.arm(arm).jog.is_some_and(|jog| jog.session == session);
        if !replaces {
            self.check_work(session, arm, WorkKind::Motion)?;
        }
        if self.is_ending {
            return Err(Refusal::Closed);
        }
        self.note_message(now, session);
        // The stop of the old jog is emitted before the start of the new one.
        self.end_jog_of(arm, JogEnd::Replaced, |_| true);
        let id = JogId(self.next_id());
        self.arm_mut(arm).jog = Some(Jog {
            id,
            session,
            keep,
            // The client learns the id with the answer, so it cannot keep the jog before.
            ends: now + keep.max(JOG_START_TIMEOUT),
        });
        Ok(id)
    }

    /// Starts the keep-alive period of a jog, because the arm has answered.
    pub fn note_jog_started(&mut self, now: HostInstant, jog: JogId) {
        let under_way = self.arms.iter_mut().filter_map(|arm| arm.jog.as_mut());
        for jogging in under_way.filter(|jogging| jogging.id == jog) {
            jogging.ends = now + jogging.keep;
        }
    }

    /// Keeps a jog of a session alive. Returns false if the jog is over or belongs to another
    /// session.
    pub fn keep_jog(&mut self, now: HostInstant, session: SessionId, jog: JogId) -> bool {
        // The clock decides before the message does: a browser that was suspended finds its jog
        // over.
        self.handle_timeout(now);
        self.note_message(now, session);
        for arm in &mut self.arms {
            if let Some(jogging) = &mut arm.jog
                && (jogging.id, jogging.session) == (jog, session)
            {
                jogging.ends = now + jogging.keep;
                return true;
            }
        }
        false
    }

    /// Stops a jog; any session may. Returns false if it is over.
    pub fn stop_jog(&mut self, jog: JogId) -> bool {
        let arm = self
            .arm_ids()
            .find(|arm| self.jog(*arm).is_some_and(|(id, _)| id == jog));
        match arm {
            Some(arm) => {
                self.end_jog_of(arm, JogEnd::Released, |_| true);
                true
            }
            None => false,
        }
    }

    /// Records that a jog has ended by itself.
    pub fn note_jog_ended(&mut self, arm: ArmId, jog: JogId, why: JogEnd) {
        self.end_jog_of(arm, why, |under_way| under_way.id == jog);
    }

    /// Stops an arm and returns the requests that this ends. The lease stays. The caller has to
    /// stop the job and the arm itself.
    pub fn stop(&mut self, now: HostInstant, arm: ArmId) -> Vec<RequestId> {
        self.end_jog_of(arm, JogEnd::Stopped, |_| true);
        self.arm_mut(arm).queued = false;
        self.end_work(now, arm, |_| true)
    }

    /// Ends requests in progress.
    fn end_work(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        wanted: impl Fn(&Work) -> bool,
    ) -> Vec<RequestId> {
        let work = &mut self.arm_mut(arm).work;
        let ended: Vec<_> = work.extract_if(.., |work| wanted(work)).collect();
        for work in &ended {
            // A request counts as a sign of life until its end, also if it ends early.
            self.note_message(now, work.session);
        }
        ended.iter().map(|work| work.request).collect()
    }

    /// Ends what a former holder has in progress. Returns its requests, and true if the arm has to
    /// be stopped; a stop ends the requests of all sessions.
    pub(super) fn end_work_of(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        holder: SessionId,
    ) -> (Vec<RequestId>, bool) {
        let state = self.arm_mut(arm);
        // Requests that only steer a job do not make the arm move.
        let mut own = state.work.iter().filter(|work| work.session == holder);
        let moves = own.any(|work| !work.kind.is_of_jobs());
        let stop = std::mem::take(&mut state.queued) || moves;
        let ended = self.end_work(now, arm, |work| stop || work.session == holder);
        (ended, stop)
    }

    /// Records the phase of the arm's job. `None` if the job is over.
    pub fn set_job_phase(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        job: JobId,
        on_lost: LeaseLossPolicy,
        phase: Option<JobPhase>,
    ) {
        let state = self.arm_mut(arm);
        if phase.is_some_and(JobPhase::is_under_way) {
            // The job waits for what was queued before, so the end of the lease must not stop the
            // arm under it.
            state.queued = false;
        }
        let before = state.job.filter(|before| before.id == job);
        state.job = phase.map(|phase| Job {
            id: job,
            on_lost,
            phase,
            // Facts about the job survive a change of its phase.
            burns: before.is_some_and(|before| before.burns),
            endless: before.is_some_and(|before| before.endless),
            ended_for_socket: phase.is_under_way()
                && before.is_some_and(|before| before.ended_for_socket),
        });
        #[cfg(feature = "class")]
        self.advance(now);
        #[cfg(not(feature = "class"))]
        let _ = now;
    }

    /// True if this is the current job of the arm.
    #[must_use]
    pub fn has_job(&self, arm: ArmId, job: JobId) -> bool {
        self.arm(arm).job.is_some_and(|known| known.id == job)
    }

    /// Marks the arm's job as burning. Such a job pauses or stops as soon as the holder's socket
    /// closes, not only when the lease ends, because the laser may then be unattended.
    pub fn mark_job_burning(&mut self, arm: ArmId, job: JobId) {
        if let Some(under_way) = { &mut self.arm_mut(arm).job }.as_mut()
            && under_way.id == job
        {
            under_way.burns = true;
            self.end_unattended_burn(arm);
        }
    }

    /// Ends a job that burns if the holder has no socket.
    pub(super) fn end_unattended_burn(&mut self, arm: ArmId) {
        let is_alone = self.holder(arm).is_some_and(|holder| {
            let presence = self.sessions.get(&holder);
            presence.is_none_or(|presence| presence.left.is_some())
        });
        if is_alone && self.arm(arm).job.is_some_and(|job| job.burns) {
            self.end_job(arm);
            if let Some(job) = &mut self.arm_mut(arm).job {
                job.ended_for_socket = true;
            }
        }
    }

    /// Ends a running job by the policy of its starter.
    pub(super) fn end_job(&mut self, arm: ArmId) {
        let job = self.arm(arm).job;
        let job = job.filter(|job| job.phase.is_under_way() && !job.ended_for_socket);
        if let Some(job) = job
            && job.on_lost != LeaseLossPolicy::Continue
        {
            let pause = job.on_lost == LeaseLossPolicy::Pause;
            let job = job.id;
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
    }

    pub(super) fn end_jog_of(&mut self, arm: ArmId, why: JogEnd, wanted: impl Fn(&Jog) -> bool) {
        let jog = &mut self.arm_mut(arm).jog;
        if let Some(jog) = jog.take_if(|jog| wanted(jog)) {
            let jog = jog.id;
            self.effects.push_back(Effect::EndJog { arm, jog, why });
        }
    }
}

//! What has an arm: requests under way, a jog, a job; and what gives way to what.

use std::time::Duration;

use magician_protocol::HostInstant;

use super::{ArmId, Control, Effect, JobId, JogEnd, JogId, Refusal, RequestId, SessionId};

/// An arm that has not answered to a jog within this does not begin it any more. The driver answers before, with an error at
/// the latest: it may have to see the arm come to rest first, which takes up to 5 s, and its call ends after 5 s.
const BEGINS: Duration = Duration::from_secs(10);

/// What a request does with the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WorkKind {
    /// It sets something, and nothing of it is left behind.
    Setting,
    /// It sets something that a job lets through: its speed.
    JobSetting,
    /// It moves the arm, and is over when the arm is there.
    Motion,
    /// It leaves a command in the arm's queue.
    Queued,
    /// It starts a job.
    StartJob,
    /// It pauses or resumes one.
    SteerJob,
}

impl WorkKind {
    /// Whether it steers a job, and moves and sets nothing itself.
    const fn is_of_jobs(self) -> bool {
        matches!(self, Self::JobSetting | Self::StartJob | Self::SteerJob)
    }
}

/// What has the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Busy {
    /// A job.
    Job(JobId),
    /// A jog.
    Jog(JogId),
}

/// What a job does, as far as others have to wait for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JobPhase {
    /// It checks, runs, pauses, or comes to its end.
    Active,
    /// The arm is free to be moved until the job is resumed.
    Paused,
}

impl JobPhase {
    pub(super) const fn is_under_way(self) -> bool {
        matches!(self, Self::Active)
    }
}

/// What becomes of a job when the lease ends under which it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OnLost {
    /// It pauses, and any later holder may resume it.
    #[default]
    Pause,
    /// It stops.
    Stop,
    /// It goes on.
    Continue,
}

impl OnLost {
    /// Name in messages and files.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Pause => "pause",
            Self::Stop => "stop",
            Self::Continue => "continue",
        }
    }

    /// The policy of a name; the usual one without one.
    pub(crate) fn named(name: Option<&str>) -> Self {
        match name {
            Some("stop") => Self::Stop,
            Some("continue") => Self::Continue,
            _ => Self::Pause,
        }
    }
}

/// A request under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Work {
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    kind: WorkKind,
}

/// A jog under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Jog {
    pub(super) id: JogId,
    pub(super) session: SessionId,
    /// It ends when it was not kept up for so long.
    pub(super) keep: Duration,
    /// When it ends unless it is kept up before.
    pub(super) ends: HostInstant,
}

/// The job of an arm that is not over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Job {
    pub(super) id: JobId,
    pub(super) on_lost: OnLost,
    pub(super) phase: JobPhase,
    /// Whether it burns: it does not outlast the socket of its holder.
    pub(super) burns: bool,
    /// Whether it has no end of its own.
    pub(super) endless: bool,
    /// Whether it was paused or stopped because that has ended.
    let_go: bool,
}

impl Control {
    /// A request that needs the lease begins. [`finish`](Self::finish) says that it is over.
    ///
    /// # Errors
    /// [`Refusal::Lease`], then [`Refusal::Busy`]; nothing begins then.
    pub fn begin(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        kind: WorkKind,
    ) -> Result<(), Refusal> {
        self.may(session, arm, kind)?;
        self.heard(now, session);
        let state = self.arm_mut(arm);
        state.queued |= kind == WorkKind::Queued;
        state.work.push(Work {
            session,
            request,
            kind,
        });
        Ok(())
    }

    /// Whether a request could begin.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub fn may(&self, session: SessionId, arm: ArmId, kind: WorkKind) -> Result<(), Refusal> {
        #[cfg(feature = "class")]
        if self.refuses_frozen(session, arm) {
            return Err(Refusal::Frozen);
        }
        let holder = self.holder(arm);
        if holder != Some(session) {
            return Err(Refusal::Lease(holder));
        }
        let state = self.arm(arm);
        if self.closed && kind == WorkKind::StartJob {
            return Err(Refusal::Closed);
        }
        if let Some(jog) = state.jog {
            return Err(Refusal::Busy(Busy::Jog(jog.id)));
        }
        match (state.job, kind) {
            (Some(job), WorkKind::StartJob) => Err(Refusal::Busy(Busy::Job(job.id))),
            (_, WorkKind::SteerJob | WorkKind::JobSetting) => Ok(()),
            (Some(job), _) if job.phase.is_under_way() => Err(Refusal::Busy(Busy::Job(job.id))),
            _ => Ok(()),
        }
    }

    /// A request is over. False where it was ended before, so that its outcome is nobody's any more.
    pub fn finish(&mut self, now: HostInstant, arm: ArmId, request: RequestId) -> bool {
        let work = &mut self.arm_mut(arm).work;
        let Some(at) = work.iter().position(|work| work.request == request) else {
            return false;
        };
        let session = work.remove(at).session;
        // It was a word up to now.
        self.heard(now, session);
        true
    }

    /// The holder has the arm tell where a hand leaves it, or no more. It ends with the lease.
    pub fn guide(&mut self, arm: ArmId, on: bool) {
        self.arm_mut(arm).guided = on;
    }

    /// A jog begins, in the place of one of the same session.
    ///
    /// # Errors
    /// As [`begin`](Self::begin); another session's jog is none of the holder's and cannot be.
    pub fn start_jog(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        keep: Duration,
    ) -> Result<JogId, Refusal> {
        let replaces = self.arm(arm).jog.is_some_and(|jog| jog.session == session);
        if !replaces {
            self.may(session, arm, WorkKind::Motion)?;
        }
        if self.closed {
            return Err(Refusal::Closed);
        }
        self.heard(now, session);
        self.end_jog_of(arm, JogEnd::Replaced, |_| true);
        let id = JogId(self.next_id());
        self.arm_mut(arm).jog = Some(Jog {
            id,
            session,
            keep,
            // Nobody can keep up what the arm has not answered to: its id is not told before.
            ends: now + keep.max(BEGINS),
        });
        Ok(id)
    }

    /// The arm has answered to a jog: from now on it has to be kept up.
    pub fn jog_begun(&mut self, now: HostInstant, jog: JogId) {
        let under_way = self.arms.iter_mut().filter_map(|arm| arm.jog.as_mut());
        for jogging in under_way.filter(|jogging| jogging.id == jog) {
            jogging.ends = now + jogging.keep;
        }
    }

    /// A jog is kept up by its session. False where it is over, or another session's.
    pub fn keep_jog(&mut self, now: HostInstant, session: SessionId, jog: JogId) -> bool {
        // The clock decides before the message does: a browser that wakes finds its jog over.
        self.handle_timeout(now);
        self.heard(now, session);
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

    /// A jog is stopped, by any session. False where it is over.
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

    /// A jog has ended by itself.
    pub fn jog_ended(&mut self, arm: ArmId, jog: JogId, why: JogEnd) {
        self.end_jog_of(arm, why, |under_way| under_way.id == jog);
    }

    /// A stop of the arm came: the requests under way, which are over by it. The lease stays. The job, and the stop
    /// itself, are the caller's.
    pub fn stop(&mut self, now: HostInstant, arm: ArmId) -> Vec<RequestId> {
        self.end_jog_of(arm, JogEnd::Stopped, |_| true);
        self.arm_mut(arm).queued = false;
        self.end_work(now, arm, |_| true)
    }

    /// Ends requests under way.
    fn end_work(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        wanted: impl Fn(&Work) -> bool,
    ) -> Vec<RequestId> {
        let work = &mut self.arm_mut(arm).work;
        let ended: Vec<_> = work.extract_if(.., |work| wanted(work)).collect();
        for work in &ended {
            // It was a word up to now, as one that comes to its end.
            self.heard(now, work.session);
        }
        ended.iter().map(|work| work.request).collect()
    }

    /// Ends what a holder has under way whose lease has ended: the requests, and whether the arm has to be stopped, which
    /// ends those of others, too.
    pub(super) fn end_work_of(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        holder: SessionId,
    ) -> (Vec<RequestId>, bool) {
        let state = self.arm_mut(arm);
        let mut own = state.work.iter().filter(|work| work.session == holder);
        let moves = own.any(|work| !work.kind.is_of_jobs());
        let stop = std::mem::take(&mut state.queued) || moves;
        let ended = self.end_work(now, arm, |work| stop || work.session == holder);
        (ended, stop)
    }

    /// The arm's job is in this phase now; none: it is over.
    pub fn job_is(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        job: JobId,
        on_lost: OnLost,
        phase: Option<JobPhase>,
    ) {
        let state = self.arm_mut(arm);
        if phase.is_some_and(JobPhase::is_under_way) {
            // What was queued before is the job's to wait for: the end of the lease is not to stop the arm under it.
            state.queued = false;
        }
        let before = state.job.filter(|before| before.id == job);
        state.job = phase.map(|phase| Job {
            id: job,
            on_lost,
            phase,
            burns: before.is_some_and(|before| before.burns),
            endless: before.is_some_and(|before| before.endless),
            let_go: phase.is_under_way() && before.is_some_and(|before| before.let_go),
        });
        #[cfg(feature = "class")]
        self.advance(now);
        #[cfg(not(feature = "class"))]
        let _ = now;
    }

    /// Whether this is the job of an arm.
    #[must_use]
    pub fn has_job(&self, arm: ArmId, job: JobId) -> bool {
        self.arm(arm).job.is_some_and(|known| known.id == job)
    }

    /// The arm's job burns: it is paused or stopped at once where the socket of its holder ends, and not only when the lease does.
    /// Nobody may look after the laser then.
    pub fn job_burns(&mut self, arm: ArmId, job: JobId) {
        if let Some(under_way) = { &mut self.arm_mut(arm).job }.as_mut()
            && under_way.id == job
        {
            under_way.burns = true;
            self.let_go_of_burning(arm);
        }
    }

    /// Ends a job that burns, if the holder has no socket.
    pub(super) fn let_go_of_burning(&mut self, arm: ArmId) {
        let is_alone = self.holder(arm).is_some_and(|holder| {
            let presence = self.sessions.get(&holder);
            presence.is_none_or(|presence| presence.left.is_some())
        });
        if is_alone && self.arm(arm).job.is_some_and(|job| job.burns) {
            self.end_job(arm);
            if let Some(job) = &mut self.arm_mut(arm).job {
                job.let_go = true;
            }
        }
    }

    /// Ends a job that is under way as its starter said.
    pub(super) fn end_job(&mut self, arm: ArmId) {
        let job = self.arm(arm).job;
        let job = job.filter(|job| job.phase.is_under_way() && !job.let_go);
        if let Some(job) = job
            && job.on_lost != OnLost::Continue
        {
            let pause = job.on_lost == OnLost::Pause;
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

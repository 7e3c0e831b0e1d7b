//! Control with a planted bug.

use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ArmId, Control, Effect, JobId, JobPhase, JogEnd, JogId, LeaseId, LeaseLossPolicy, Refusal,
    RequestId, SessionId, WorkKind,
};

/// Planted bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Bug {
    /// A stop takes effect only after the job has ended.
    StopBehindJob,
    /// The end of a socket does not limit its lease.
    LeaseOutlivesHolder,
    /// A jog survives the end of its lease.
    JogOutlivesLease,
    /// Taking a lease releases it first and acquires it with the next event.
    GrantInTwoSteps,
    /// A session whose socket closed while it waited gets no answer.
    WaiterForgotten,
    /// Motion of the former holder continues.
    MotionContinues,
    /// Any session keeps a jog alive.
    KeptByOtherSession,
    /// A granted request is answered twice.
    AnsweredTwice,
    /// The new holder is notified before the arm is stopped.
    GrantBeforeStop,
    /// The last to wait is served first.
    WaitersInReverse,
    /// A stop ends the lease.
    StopTakesLease,
    /// A jog survives the end of its socket.
    JogOutlivesSocket,
    /// A lease has the id of the one before.
    NumberTwice,
    /// A wait that is over is not answered.
    WaitWithoutEnd,
    /// A motor or the laser stays on after a lease is given back.
    UnattendedOutlivesLease,
}

/// Each bug, and the invariant that it breaks first.
pub(crate) const BUGS: [(Bug, &str); 15] = [
    (Bug::StopBehindJob, "after a stop nothing moves"),
    (Bug::LeaseOutlivesHolder, "a lease ends with its holder"),
    (Bug::JogOutlivesLease, "a jog belongs to the holder"),
    (Bug::GrantInTwoSteps, "a lease passes in one step"),
    (Bug::WaiterForgotten, "who has left is answered"),
    (
        Bug::MotionContinues,
        "the arm is stopped before the next holder is told",
    ),
    (Bug::KeptByOtherSession, "a jog ends when it is not kept up"),
    (Bug::AnsweredTwice, "a request is answered once"),
    (
        Bug::GrantBeforeStop,
        "the arm is stopped before the next holder is told",
    ),
    (Bug::WaitersInReverse, "who waits was told the place"),
    (Bug::StopTakesLease, "a lease ends for a reason"),
    (Bug::JogOutlivesSocket, "a jog ends with its socket"),
    (Bug::NumberTwice, "a number is used once"),
    (Bug::WaitWithoutEnd, "a request is answered in time"),
    (
        Bug::UnattendedOutlivesLease,
        "what has no end of its own belongs to the holder",
    ),
];

/// Methods of [`Control`], with at most one bug.
#[derive(Clone)]
pub(crate) struct Mutant {
    pub(crate) control: Control,
    bug: Option<Bug>,
    /// Waiting sessions by arm and arrival.
    waiting: Vec<(ArmId, SessionId, RequestId)>,
    /// Grants postponed to the next event.
    pub(crate) postponed: Vec<(ArmId, SessionId, RequestId)>,
    /// True while an event whose effects must be wrong is processed.
    wrong: bool,
}

impl Mutant {
    pub(crate) fn new(arms: usize, bug: Option<Bug>) -> Self {
        Self {
            control: Control::new(arms),
            bug,
            waiting: Vec::new(),
            postponed: Vec::new(),
            wrong: false,
        }
    }

    fn has(&self, bug: Bug) -> bool {
        self.bug == Some(bug)
    }

    /// Carries out what was postponed.
    pub(crate) fn next_event(&mut self, now: HostInstant) {
        for (arm, session, request) in std::mem::take(&mut self.postponed) {
            self.control
                .acquire(now, session, arm, request, Duration::ZERO);
        }
    }

    pub(crate) fn acquire(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        wait: Duration,
    ) {
        let before = { self.waiting.iter() }.position(|(of, ..)| *of == arm);
        if self.has(Bug::WaitersInReverse) && !wait.is_zero() {
            if let Some(before) = before {
                let (_, first, first_request) = self.waiting[before];
                self.control.leave(now, first);
                self.control.rejoin(now, first);
                while self.control.poll_effect().is_some() {}
                self.control.acquire(now, session, arm, request, wait);
                return self.control.acquire(now, first, arm, first_request, wait);
            }
            if self
                .control
                .holder(arm)
                .is_some_and(|holder| holder != session)
            {
                self.waiting.push((arm, session, request));
            }
        }
        self.control.acquire(now, session, arm, request, wait);
    }

    pub(crate) fn release(&mut self, now: HostInstant, session: SessionId, lease: LeaseId) {
        self.control.release(now, session, lease);
    }

    pub(crate) fn ask(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
    ) {
        self.control.ask(now, session, arm, request);
    }

    pub(crate) fn answer(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        asker: SessionId,
        grant: bool,
    ) -> Result<(), Refusal> {
        let holder = self.control.holder(arm).ok_or(Refusal::Unknown)?;
        self.control.answer(now, holder, arm, asker, grant)
    }

    pub(crate) fn take(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        lease: Option<(SessionId, LeaseId)>,
        request: RequestId,
    ) {
        if self.has(Bug::GrantInTwoSteps)
            && let Some((holder, lease)) = lease
        {
            self.control.release(now, holder, lease);
            self.postponed.push((arm, session, request));
            return;
        }
        self.control.take(now, session, arm, request);
    }

    pub(crate) fn leave(&mut self, now: HostInstant, session: SessionId) {
        self.wrong = self.has(Bug::WaiterForgotten) || self.has(Bug::JogOutlivesSocket);
        self.control.leave(now, session);
        if self.has(Bug::LeaseOutlivesHolder) {
            self.control.rejoin(now, session);
        }
    }

    pub(crate) fn begin(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        kind: WorkKind,
    ) -> Result<(), Refusal> {
        self.control.begin(now, session, arm, request, kind)
    }

    pub(crate) fn keep_jog(&mut self, now: HostInstant, session: SessionId, jog: JogId) -> bool {
        let of = (0..2).find_map(|arm| {
            let (id, session) = self.control.jog(ArmId(arm))?;
            (id == jog).then_some(session)
        });
        let session = of
            .filter(|_| self.has(Bug::KeptByOtherSession))
            .unwrap_or(session);
        self.control.keep_jog(now, session, jog)
    }

    /// Returns `None` if the stop was ignored.
    pub(crate) fn stop(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        lease: Option<(SessionId, LeaseId)>,
        job_runs: bool,
    ) -> Option<Vec<RequestId>> {
        if self.has(Bug::StopBehindJob) && job_runs {
            return None;
        }
        let ended = self.control.stop(now, arm);
        if self.has(Bug::StopTakesLease)
            && let Some((holder, lease)) = lease
        {
            self.control.release(now, holder, lease);
        }
        Some(ended)
    }

    pub(crate) fn set_job_phase(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        on_lost: LeaseLossPolicy,
        phase: Option<JobPhase>,
    ) {
        self.control
            .set_job_phase(now, arm, JobId(arm.0), on_lost, phase);
    }

    pub(crate) fn handle_timeout(&mut self, now: HostInstant) {
        self.wrong = self.has(Bug::WaitWithoutEnd);
        self.control.handle_timeout(now);
    }

    /// Returns all effects of an event.
    pub(crate) fn effects(&mut self) -> Vec<Effect> {
        let mut out = Vec::new();
        while let Some(effect) = self.control.poll_effect() {
            match (&effect, self.bug) {
                (
                    Effect::EndJog {
                        why: JogEnd::Lease, ..
                    },
                    Some(Bug::JogOutlivesLease),
                )
                | (Effect::EndWork { .. }, Some(Bug::MotionContinues))
                | (Effect::EndUnattended { .. }, Some(Bug::UnattendedOutlivesLease)) => {}
                (Effect::EndJog { .. }, Some(Bug::JogOutlivesSocket))
                | (Effect::Denied { .. }, Some(Bug::WaiterForgotten | Bug::WaitWithoutEnd))
                    if self.wrong => {}
                (Effect::Granted { .. }, Some(Bug::AnsweredTwice)) => {
                    out.extend([effect.clone(), effect]);
                }
                (Effect::Granted { .. }, Some(Bug::GrantBeforeStop)) => out.insert(0, effect),
                (Effect::Granted { request, arm, .. }, Some(Bug::NumberTwice)) => {
                    out.push(Effect::Granted {
                        request: *request,
                        arm: *arm,
                        lease: LeaseId(1),
                    });
                }
                _ => out.push(effect),
            }
        }
        self.wrong = false;
        for effect in &out {
            if let Effect::Granted { request, .. } | Effect::Denied { request, .. } = effect {
                self.waiting.retain(|(_, _, waits)| waits != request);
            }
        }
        out
    }
}

//! Smallest possible station around control: sessions, requests, and arms that follow the effects.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ArmId, JobPhase, JogId, LEASE_TIMEOUT, LeaseId, LeaseLossPolicy, RECONNECT_GRACE, RequestId,
    SessionId, WorkKind,
};

use crate::mutant::{Bug, Mutant};
use crate::search::Explored;
use crate::step::Checked;

pub(crate) const SESSIONS: u64 = 3;
pub(crate) const ARMS: u64 = 2;
/// Longer than the lease timeout, shorter than the time for a question.
pub(crate) const WAIT: Duration = Duration::from_secs(8);
pub(crate) const KEEP: Duration = Duration::from_millis(250);
pub(crate) const SHORT_PAUSE: Duration = Duration::from_millis(125);

/// Event of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    Acquire(SessionId, ArmId),
    Wait(SessionId, ArmId),
    Release(SessionId, ArmId),
    Ask(SessionId, ArmId),
    /// The holder answers the asking session.
    Answer(ArmId, SessionId, bool),
    Take(SessionId, ArmId),
    KeepAlive(SessionId),
    Leave(SessionId),
    Return(SessionId),
    Begin(SessionId, ArmId, WorkKind),
    Finish(ArmId, RequestId),
    StartJog(SessionId, ArmId),
    KeepJog(SessionId, ArmId),
    StopJog(SessionId, ArmId),
    /// The holder starts a motor or lights the laser.
    SwitchOn(SessionId, ArmId),
    StartJob(SessionId, ArmId, LeaseLossPolicy),
    PauseJob(SessionId, ArmId),
    EndJob(ArmId),
    Stop(SessionId, ArmId),
    /// Time passes until the next deadline.
    Pass,
    /// Time passes, but too little to end a jog.
    ShortPause,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Session {
    /// Instant of the last sign of life.
    pub(crate) heard: HostInstant,
    /// Instant at which the socket closed. `None` while there is one.
    pub(crate) left: Option<HostInstant>,
    /// True if control knows the session.
    pub(crate) joined: bool,
}

/// Request without an answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Request {
    pub(crate) session: SessionId,
    pub(crate) arm: ArmId,
    /// For requests of the lease: the instant at which they must be answered.
    pub(crate) until: Option<HostInstant>,
    pub(crate) asks: bool,
    /// Session that was asked last.
    pub(crate) asked: Option<SessionId>,
}

/// Motion of the arm. Free if the lease under which it began was given back.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct RunningRequest {
    pub(crate) session: SessionId,
    pub(crate) free: bool,
    pub(crate) request: RequestId,
    pub(crate) queued: bool,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RunningJog {
    pub(crate) id: JogId,
    pub(crate) session: SessionId,
    pub(crate) until: HostInstant,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Arm {
    pub(crate) lease: Option<(SessionId, LeaseId)>,
    pub(crate) running: Vec<RunningRequest>,
    /// Sessions with commands in the queue, and true if those are free.
    pub(crate) queue: BTreeSet<(SessionId, bool)>,
    pub(crate) jog: Option<RunningJog>,
    /// Session that switched on what has no end of its own: a motor or the laser.
    pub(crate) unattended: Option<SessionId>,
    pub(crate) job: Option<(LeaseLossPolicy, JobPhase)>,
    /// Waiting requests by arrival.
    pub(crate) line: Vec<RequestId>,
    /// Positions reported last.
    pub(crate) places: BTreeMap<SessionId, usize>,
}

/// State of the search.
#[derive(Clone)]
pub(crate) struct Model {
    pub(crate) control: Mutant,
    pub(crate) now: HostInstant,
    pub(crate) sessions: Vec<Session>,
    pub(crate) arms: Vec<Arm>,
    pub(crate) requests: BTreeMap<RequestId, Request>,
    /// Last id of a lease or a jog.
    pub(crate) last: u64,
    /// Number of sessions and arms used so far. Unused ones are interchangeable.
    used: (u64, u64),
}

impl Model {
    pub(crate) fn new(bug: Option<Bug>) -> Self {
        let now = HostInstant::from_micros(60_000_000);
        let session = Session {
            heard: now,
            left: None,
            joined: true,
        };
        let mut control = Mutant::new(ARMS as usize, bug);
        for session in 0..SESSIONS {
            control.control.join(now, SessionId(session));
        }
        Self {
            control,
            now,
            sessions: vec![session; SESSIONS as usize],
            arms: vec![Arm::default(); ARMS as usize],
            requests: BTreeMap::new(),
            last: 0,
            used: (0, 0),
        }
    }

    pub(crate) fn arm(&self, arm: ArmId) -> &Arm {
        &self.arms[arm.0 as usize]
    }

    pub(crate) fn session(&self, session: SessionId) -> &Session {
        &self.sessions[session.0 as usize]
    }

    /// True if a request of the session is in progress, which counts as a permanent sign of life.
    pub(crate) fn works(&self, session: SessionId) -> bool {
        let mut all = self.arms.iter().flat_map(|arm| &arm.running);
        all.any(|running| running.session == session)
    }

    /// True if the session has lost its right to a lease by silence.
    pub(crate) fn is_silent(&self, session: SessionId) -> bool {
        let known = self.session(session);
        match known.left {
            Some(left) => self.now - left >= RECONNECT_GRACE,
            None => !self.works(session) && self.now - known.heard >= LEASE_TIMEOUT,
        }
    }

    /// Returns an unused request id.
    pub(crate) fn free_request(&self) -> RequestId {
        let free = (0..).map(RequestId);
        { free }
            .find(|id| !self.requests.contains_key(id))
            .expect("numbers do not end")
    }

    /// True if the session or arm may be used next. Symmetry: the first one used is always the
    /// first by number.
    pub(crate) fn is_next(&self, session: u64, arm: Option<u64>) -> bool {
        session <= self.used.0 && arm.is_none_or(|arm| arm <= self.used.1)
    }

    pub(crate) fn uses(&mut self, session: Option<SessionId>, arm: Option<ArmId>) {
        self.used.0 = self.used.0.max(session.map_or(0, |session| session.0 + 1));
        self.used.1 = self.used.1.max(arm.map_or(0, |arm| arm.0 + 1));
    }

    fn events_at(&self, id: SessionId, at: ArmId, out: &mut Vec<Event>) {
        use Event::*;
        let arm = self.arm(at);
        let pending = |asks: bool| {
            let mut all = self.requests.values();
            all.any(|one| (one.session, one.arm, one.asks) == (id, at, asks) && one.until.is_some())
        };
        let holds = arm.lease.is_some_and(|(holder, _)| holder == id);
        out.extend([Acquire(id, at), Take(id, at), Stop(id, at)]);
        if !pending(false) && !holds {
            out.push(Wait(id, at));
        }
        if !pending(true) && !holds {
            out.push(Ask(id, at));
        }
        if holds {
            out.push(Release(id, at));
            if arm.unattended.is_none() {
                out.push(SwitchOn(id, at));
            }
        }
        // A single request at a time suffices. Requests without the lease are refused.
        if !arm.running.iter().any(|running| running.session == id) {
            out.extend([WorkKind::Motion, WorkKind::Queued].map(|kind| Begin(id, at, kind)));
            out.extend(
                [LeaseLossPolicy::Pause, LeaseLossPolicy::Continue]
                    .map(|lost| StartJob(id, at, lost)),
            );
        }
        if arm.job.is_some() {
            out.push(PauseJob(id, at));
        }
        out.push(StartJog(id, at));
        if arm.jog.is_some() {
            out.extend([KeepJog(id, at), StopJog(id, at)]);
        }
    }
}

impl Explored for Model {
    type Event = Event;

    fn events(&self) -> Vec<Event> {
        use Event::*;
        let mut out = Vec::new();
        for session in (0..SESSIONS).filter(|session| self.is_next(*session, None)) {
            let id = SessionId(session);
            let known = self.session(id);
            if known.left.is_some() {
                out.push(Return(id));
                continue;
            }
            out.extend([KeepAlive(id), Leave(id)]);
            for arm in (0..ARMS).filter(|arm| self.is_next(session, Some(*arm))) {
                self.events_at(id, ArmId(arm), &mut out);
            }
        }
        for (id, arm) in (0..).map(ArmId).zip(&self.arms) {
            out.extend(
                arm.running
                    .iter()
                    .map(|running| Finish(id, running.request)),
            );
            if arm.job.is_some() {
                out.push(EndJob(id));
            }
            let asking = self
                .requests
                .values()
                .filter(|one| one.arm == id && one.asks);
            let holds = arm
                .lease
                .is_some_and(|(holder, _)| self.session(holder).left.is_none());
            for asking in asking.filter(|_| holds) {
                out.extend([true, false].map(|grant| Answer(id, asking.session, grant)));
            }
        }
        out.push(Pass);
        let due = self.control.control.poll_timeout();
        let soon = due.is_some_and(|due| due <= self.now + SHORT_PAUSE);
        if !soon && self.arms.iter().any(|arm| arm.jog.is_some()) {
            out.push(ShortPause);
        }
        out
    }

    fn step(&mut self, before: &Self, event: Event) -> Checked {
        self.check_step(before, event)
    }

    fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.control.control.canonical(self.now).hash(&mut hasher);
        (&self.control.postponed, self.used).hash(&mut hasher);
        let age = |at: HostInstant, most: Duration| (self.now - at).min(most);
        for (id, session) in (0..).map(SessionId).zip(&self.sessions) {
            let holds = { self.arms.iter() }.any(|arm| arm.lease.is_some_and(|(of, _)| of == id));
            let word = if holds {
                age(session.heard, LEASE_TIMEOUT)
            } else {
                LEASE_TIMEOUT
            };
            let left = session.left.map(|left| age(left, RECONNECT_GRACE));
            (word, left, session.joined).hash(&mut hasher);
        }
        for arm in &self.arms {
            arm.lease.map(|(session, _)| session).hash(&mut hasher);
            (&arm.running, &arm.queue, arm.job, &arm.line, &arm.places).hash(&mut hasher);
            arm.unattended.hash(&mut hasher);
            let jog = { arm.jog.as_ref() }.map(|jog| (jog.session, jog.until - self.now));
            jog.hash(&mut hasher);
        }
        for (id, request) in &self.requests {
            let until = request.until.map(|until| until - self.now);
            (id, request.session, request.arm, until, request.asked).hash(&mut hasher);
        }
        hasher.finish()
    }
}

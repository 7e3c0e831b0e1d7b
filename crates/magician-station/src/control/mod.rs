//! Arbitration of the arms: the lease, the dead man of a jog, and the precedence of requests. Without I/O, clock or text.
//!
//! All decisions of a station about who moves an arm are made here; what follows from them comes out as [`Effect`]s, in
//! their order. Time is what the caller says. The whole state is values, so that every interleaving of what sessions do
//! can be tried (`tests/lease`).

mod canonical;
mod claims;
#[cfg(feature = "class")]
mod class;
#[cfg(feature = "class")]
mod codes;
mod lease;
#[cfg(feature = "class")]
mod policy;
#[cfg(feature = "class")]
mod turns;
mod work;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::HostInstant;

use self::claims::{Claims, LeaseRequest};
#[cfg(feature = "class")]
pub use self::claims::{JobClaim, Place};
#[cfg(feature = "class")]
use self::class::Class;
#[cfg(feature = "class")]
pub use self::class::{NoQueue, Slot, TOLD, Turn, TurnRules, TurnState};
#[cfg(feature = "class")]
pub use self::codes::{
    ADDRESS_TRIES, CodeBound, CodeTry, NAME_TRIES, TooManyCodes, WINDOW, WrongCodes,
};
use self::lease::Held;
pub use self::lease::{ASK, GRACE, TTL};
#[cfg(feature = "class")]
pub use self::policy::{Hindrance, QueuedChange};
pub use self::work::{Busy, JobPhase, OnLost, WorkKind};
use self::work::{Job, Jog, Work};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u64);
    };
}

id! {
    /// A session: a program or a person with a page.
    SessionId
}
id! {
    /// An arm of the station, by its place in the list.
    ArmId
}
id! {
    /// A lease that was given; the next one of the same arm has another id.
    LeaseId
}
id! {
    /// A request that is answered later.
    RequestId
}
id! {
    /// A jog.
    JogId
}
id! {
    /// A job.
    JobId
}
#[cfg(feature = "class")]
id! {
    /// A person of a class, at however many sockets.
    PersonId
}

/// Consequence of a decision. The caller carries them out in their order.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Effect {
    /// The request for a lease is granted.
    Granted {
        /// The request.
        request: RequestId,
        /// The arm.
        arm: ArmId,
        /// The lease.
        lease: LeaseId,
    },
    /// The request for a lease is not granted.
    Denied {
        /// The request.
        request: RequestId,
        /// The session that has the lease.
        holder: Option<SessionId>,
    },
    /// A session that waits for a lease has another place.
    Place {
        /// The session.
        session: SessionId,
        /// The arm.
        arm: ArmId,
        /// The place, from 1.
        place: usize,
    },
    /// An arm has another holder, or none.
    Holder {
        /// The arm.
        arm: ArmId,
        /// The new holder. `None` if the lease is free.
        holder: Option<SessionId>,
    },
    /// A session asks the holder for the lease.
    Asked {
        /// The arm.
        arm: ArmId,
        /// The holder.
        holder: SessionId,
        /// The session that asks.
        session: SessionId,
        /// The request that is answered when the holder has answered.
        request: RequestId,
    },
    /// The jog has to be stopped, and its session told why.
    EndJog {
        /// The arm.
        arm: ArmId,
        /// The jog.
        jog: JogId,
        /// Why it ends.
        why: JogEnd,
    },
    /// The arm is to tell no more where a hand leaves it.
    EndGuide {
        /// The arm.
        arm: ArmId,
    },
    /// The motors that run by what the holder did have to be switched off: they have no end of their own. Where the arm is
    /// stopped by [`EndWork`](Self::EndWork), that stop does it.
    EndMotors {
        /// The arm.
        arm: ArmId,
    },
    /// Requests under way have to be answered as ended, and the arm stopped if `stop`.
    EndWork {
        /// The arm.
        arm: ArmId,
        /// The requests.
        requests: Vec<RequestId>,
        /// True if the arm has to be stopped, so that nothing of them, and of what is in its queue, is done. False for
        /// requests that steer a job, which ends in its own way.
        stop: bool,
        /// Why.
        why: WorkEnd,
    },
    /// The job has to pause or to stop, because the lease under which it runs has ended.
    EndJob {
        /// The arm.
        arm: ArmId,
        /// The job.
        job: JobId,
        /// True if it has to pause, so that it can be resumed; false if it has to stop.
        pause: bool,
    },
    /// A session is over: it did not come back.
    SessionOver(SessionId),
    /// Turns, queue or what is frozen are not as they were.
    #[cfg(feature = "class")]
    Turns,
    /// A turn ends soon.
    #[cfg(feature = "class")]
    TurnEnding {
        /// The arm.
        arm: ArmId,
        /// Whose.
        person: PersonId,
        /// In so much time.
        left: Duration,
    },
    /// A session got the lease because it is its person's turn.
    #[cfg(feature = "class")]
    TurnLease {
        /// The arm.
        arm: ArmId,
        /// The session.
        session: SessionId,
        /// The lease.
        lease: LeaseId,
    },
}

/// Why a jog ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum JogEnd {
    /// Stop by its session, or end of that session's socket.
    Released,
    /// Missing keep within its deadline.
    NotKept,
    /// A stop of the arm came.
    Stopped,
    /// The lease ended.
    Lease,
    /// The line to the arm broke.
    Link,
    /// The same session began another one.
    Replaced,
    /// The arm came to a limit, or to its fence.
    Limit,
}

impl JogEnd {
    /// Name in interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Released => "released",
            Self::NotKept => "not-kept",
            Self::Stopped => "stopped",
            Self::Lease => "lease",
            Self::Link => "link",
            Self::Replaced => "replaced",
            Self::Limit => "limit",
        }
    }
}

/// Why requests under way are over before their end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WorkEnd {
    /// The lease ended; the holder from now on.
    Lease(Option<SessionId>),
    /// A stop came from this session, or from outside of all of them.
    Stop(Option<SessionId>),
}

/// Why nothing is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// Another session has the lease, or none has: it has to be acquired.
    Lease(Option<SessionId>),
    /// Something else has the arm.
    Busy(Busy),
    /// A teacher has frozen the arm.
    #[cfg(feature = "class")]
    Frozen,
    /// Unknown lease, jog or question.
    Unknown,
    /// The station ends: nothing begins any more.
    Closed,
}

/// A session as far as control goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Presence {
    /// The last word of it.
    heard: HostInstant,
    /// When its socket ended, if it has none.
    left: Option<HostInstant>,
}

/// An arm as far as control goes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct ArmControl {
    lease: Option<Held>,
    jog: Option<Jog>,
    work: Vec<Work>,
    /// True if commands of the holder may wait in the arm's queue.
    queued: bool,
    /// True while the arm tells its holder where a hand leaves it.
    guided: bool,
    job: Option<Job>,
}

/// The arms of a station and who moves them.
///
/// ```
/// use std::time::Duration;
/// use magician_protocol::HostInstant;
/// use magician_station::control::{ArmId, Control, RequestId, SessionId, WorkKind};
///
/// let now = HostInstant::ZERO;
/// let mut control = Control::new(1);
/// let (arm, anna, ben) = (ArmId(0), SessionId(1), SessionId(2));
/// control.join(now, anna);
/// control.join(now, ben);
/// control.acquire(now, anna, arm, RequestId(1), Duration::ZERO);
/// assert_eq!(control.holder(arm), Some(anna));
/// assert!(control.begin(now, ben, arm, RequestId(2), WorkKind::Motion).is_err());
/// assert!(control.begin(now, anna, arm, RequestId(3), WorkKind::Motion).is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Control {
    arms: Vec<ArmControl>,
    sessions: BTreeMap<SessionId, Presence>,
    effects: VecDeque<Effect>,
    claims: Claims,
    #[cfg(feature = "class")]
    class: Class,
    /// True once the station ends: no lease is given any more, and no jog or job begins.
    closed: bool,
    /// Leases and jogs that were given an id.
    ids: u64,
}

impl Control {
    /// Creates control of `arms` arms, without sessions.
    #[must_use]
    pub fn new(arms: usize) -> Self {
        Self {
            arms: vec![ArmControl::default(); arms],
            sessions: BTreeMap::new(),
            effects: VecDeque::new(),
            claims: Claims::default(),
            #[cfg(feature = "class")]
            class: Class::new(arms),
            closed: false,
            ids: 0,
        }
    }

    /// What has to be done next.
    pub fn poll_effect(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// A session begins.
    pub fn join(&mut self, now: HostInstant, session: SessionId) {
        let presence = Presence {
            heard: now,
            left: None,
        };
        self.sessions.insert(session, presence);
    }

    /// A word of a session: a message, or the answer to a ping.
    pub fn keep_alive(&mut self, now: HostInstant, session: SessionId) {
        self.heard(now, session);
        #[cfg(feature = "class")]
        self.person_is_here(now, session);
    }

    fn heard(&mut self, now: HostInstant, session: SessionId) {
        if let Some(presence) = self.sessions.get_mut(&session) {
            presence.heard = now;
        }
    }

    /// The socket of a session has ended. A jog and a job that burns end at once; the lease waits for the session to come back.
    pub fn leave(&mut self, now: HostInstant, session: SessionId) {
        let Some(presence) = self.sessions.get_mut(&session) else {
            return;
        };
        presence.left.get_or_insert(now);
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::Released, |jog| jog.session == session);
            self.deny_session(arm, session);
            if self.holder(arm) == Some(session) {
                self.let_go_of_burning(arm);
            }
        }
    }

    /// A session that had no socket has one again. False where it is over.
    pub fn rejoin(&mut self, now: HostInstant, session: SessionId) -> bool {
        match self.sessions.get_mut(&session) {
            Some(presence) => {
                *presence = Presence {
                    heard: now,
                    left: None,
                };
                #[cfg(feature = "class")]
                self.person_is_here(now, session);
                true
            }
            None => false,
        }
    }

    /// A session ends for good, and at once: its token was revoked, or its server says so.
    pub fn expel(&mut self, now: HostInstant, session: SessionId) {
        self.leave(now, session);
        self.over(now, session);
    }

    /// Takes back that a session was [identified](Self::identify): turns, slots and freezes bind it no more.
    #[cfg(feature = "class")]
    pub fn unbind(&mut self, session: SessionId) {
        self.class.forget(session);
    }

    /// The station begins to end: jogs end, and no lease is given any more. Who holds one keeps it,
    /// to end what it runs, until [`evict`](Self::evict).
    pub fn close(&mut self) {
        self.closed = true;
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::Stopped, |_| true);
            self.deny_requests(arm, |request| request.arm == arm);
        }
    }

    /// Ends the lease of an arm, as if its holder had gone silent: what it has under way is
    /// stopped.
    pub fn evict(&mut self, now: HostInstant, arm: ArmId) {
        if self.holder(arm).is_some() {
            self.end_lease(now, arm, LeaseEnd::Silent);
        }
    }

    /// The session that has the lease of an arm.
    #[must_use]
    pub fn holder(&self, arm: ArmId) -> Option<SessionId> {
        self.arm(arm).lease.map(|held| held.session)
    }

    /// The sessions that wait for it, in their order, and those that ask its holder: whether they ask.
    pub fn waiting(&self, arm: ArmId) -> impl Iterator<Item = (SessionId, bool)> + '_ {
        let requests = self.claims.requests(arm);
        requests.map(|request| (request.session, request.asks))
    }

    /// The jog under way, and its session.
    #[must_use]
    pub fn jog(&self, arm: ArmId) -> Option<(JogId, SessionId)> {
        self.arm(arm).jog.map(|jog| (jog.id, jog.session))
    }

    /// The arms whose lease a session has.
    pub fn held_by(&self, session: SessionId) -> impl Iterator<Item = ArmId> + '_ {
        self.arm_ids()
            .filter(move |arm| self.holder(*arm) == Some(session))
    }

    /// Instant at which a session without a socket is over, and its leases are free, unless it comes
    /// back. `None` for one that has a socket.
    #[must_use]
    pub fn back_until(&self, session: SessionId) -> Option<HostInstant> {
        Some(self.sessions.get(&session)?.left? + GRACE)
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let arms = self.arms.iter().flat_map(|arm| {
            let jog = arm.jog.map(|jog| jog.ends);
            [self.lease_ends(arm), jog]
        });
        let sessions = self.sessions.values().map(|presence| presence.left);
        let sessions = sessions.map(|left| left.map(|left| left + GRACE));
        let all = arms.chain(sessions).chain([self.claims.next()]);
        let due = all.flatten().min();
        #[cfg(feature = "class")]
        let due = due.into_iter().chain(self.class.next()).min();
        due
    }

    /// Ends what is over by now.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::NotKept, |jog| jog.ends <= now);
        }
        let gone: Vec<_> = { self.sessions.iter() }
            .filter(|(_, presence)| presence.left.is_some_and(|left| left + GRACE <= now))
            .map(|(session, _)| *session)
            .collect();
        for session in gone {
            self.over(now, session);
        }
        for arm in self.arm_ids() {
            if self.lease_ends(self.arm(arm)).is_some_and(|end| end <= now) {
                self.end_lease(now, arm, LeaseEnd::Silent);
            }
            let due = |request: &LeaseRequest| request.arm == arm && request.until <= now;
            if self.deny_requests(arm, |request| due(request) && !request.asks) {
                self.tell_places(arm);
            }
            // A question that was not answered in time is granted.
            while let Some(ask) = self
                .claims
                .take_first(|request| due(request) && request.asks)
            {
                self.grant_ask(now, arm, ask.session, ask.request);
            }
        }
        #[cfg(feature = "class")]
        self.class_timeout(now);
    }

    /// A session did not come back.
    fn over(&mut self, now: HostInstant, session: SessionId) {
        if self.sessions.remove(&session).is_none() {
            return;
        }
        for arm in self.arm_ids() {
            if self.holder(arm) == Some(session) {
                self.end_lease(now, arm, LeaseEnd::Gone);
            }
        }
        #[cfg(feature = "class")]
        self.class.forget(session);
        self.effects.push_back(Effect::SessionOver(session));
    }

    /// When the lease of an arm ends unless its holder says something.
    fn lease_ends(&self, arm: &ArmControl) -> Option<HostInstant> {
        let held = arm.lease?;
        let presence = self.sessions.get(&held.session)?;
        match presence.left {
            Some(left) => Some(left + GRACE),
            // A request under way is a word all the time.
            None if self.works(held.session) => None,
            None => Some(presence.heard + TTL),
        }
    }

    /// Whether a request of a session is under way, at whatever arm.
    fn works(&self, session: SessionId) -> bool {
        let mut work = self.arms.iter().flat_map(|arm| &arm.work);
        work.any(|work| work.session == session)
    }

    fn arm_ids(&self) -> impl Iterator<Item = ArmId> + use<> {
        (0..self.arms.len() as u64).map(ArmId)
    }

    fn arm(&self, arm: ArmId) -> &ArmControl {
        &self.arms[arm.0 as usize]
    }

    fn arm_mut(&mut self, arm: ArmId) -> &mut ArmControl {
        &mut self.arms[arm.0 as usize]
    }

    fn next_id(&mut self) -> u64 {
        self.ids += 1;
        self.ids
    }
}

/// How a lease ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LeaseEnd {
    /// Its holder gave it back: what it queued goes on.
    Released,
    /// It passed to another session.
    Passed,
    /// Its holder did not say anything for too long.
    Silent,
    /// Its holder did not come back.
    Gone,
    /// The turn or the slot of its holder is over.
    #[cfg(feature = "class")]
    Over,
}

/// How long a session may wait for a lease.
pub const LONGEST_WAIT: Duration = Duration::from_secs(3600);

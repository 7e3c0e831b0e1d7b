//! Arbitration of the arms: leases, and the precedence of jogs, jobs and stops. No I/O, no clock,
//! no text.
//!
//! All decisions of a station about motion are made here: leases, the keep-alive of a jog, jobs,
//! turns of a class, and the order between them. Methods take the current instant and change the
//! state; consequences come out of [`Control::poll_effect`] in their order, and the station carries
//! them out.
//!
//! The state consists of values only. So a test can clone it, try every interleaving of what a few
//! sessions may do, and compare with an independent model (`tests/lease`).

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
pub use self::claims::{JobClaim, TurnPlace};
#[cfg(feature = "class")]
use self::class::ClassState;
#[cfg(feature = "class")]
pub use self::class::{QueueRefusal, Slot, TURN_END_WARNINGS, Turn, TurnRules, TurnState};
#[cfg(feature = "class")]
pub use self::codes::{
    CodeLimit, CodeTry, MAX_TRIES_PER_ADDRESS, MAX_TRIES_PER_NAME, TRY_WINDOW, TooManyCodes,
    WrongCodes,
};
use self::lease::LeaseHolder;
pub use self::lease::{ASK_TIMEOUT, LEASE_TIMEOUT, RECONNECT_GRACE};
#[cfg(feature = "class")]
pub use self::policy::{Hindrance, QueuedChange};
pub use self::work::{Busy, JobPhase, LeaseLossPolicy, WorkKind};
use self::work::{Job, Jog, Work};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u64);
    };
}

id! {
    /// Session: a program, or a page.
    SessionId
}
id! {
    /// Arm of the station, by its index.
    ArmId
}
id! {
    /// Lease. Each lease of an arm has another id.
    LeaseId
}
id! {
    /// Request that is answered later.
    RequestId
}
id! {
    /// Jog.
    JogId
}
id! {
    /// Job.
    JobId
}
#[cfg(feature = "class")]
id! {
    /// Person of a class, with any number of pages.
    PersonId
}

/// Consequence of a decision. The caller must carry effects out in their order.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Effect {
    /// A request for the lease is granted.
    Granted {
        /// The request.
        request: RequestId,
        /// The arm.
        arm: ArmId,
        /// The lease.
        lease: LeaseId,
    },
    /// A request for the lease is denied.
    Denied {
        /// The request.
        request: RequestId,
        /// Current holder. `None` if the arm has no holder.
        holder: Option<SessionId>,
    },
    /// A waiting session has moved in the queue.
    Place {
        /// The session.
        session: SessionId,
        /// The arm.
        arm: ArmId,
        /// Position, from 1.
        place: usize,
    },
    /// The holder of an arm has changed.
    Holder {
        /// The arm.
        arm: ArmId,
        /// New holder. `None` if the lease is free.
        holder: Option<SessionId>,
    },
    /// A session asks the holder for the lease.
    Asked {
        /// The arm.
        arm: ArmId,
        /// The holder.
        holder: SessionId,
        /// Session that asks.
        session: SessionId,
        /// Request that is answered when the holder has answered.
        request: RequestId,
    },
    /// Stop a jog and notify its session.
    EndJog {
        /// The arm.
        arm: ArmId,
        /// The jog.
        jog: JogId,
        /// Reason.
        why: JogEnd,
    },
    /// Stop reporting releases of the unlock key.
    EndGuide {
        /// The arm.
        arm: ArmId,
    },
    /// Switch off what the holder started and what has no end of its own: motor outputs and a lit
    /// laser. Not emitted together with a stop of [`EndWork`](Self::EndWork), which does the same.
    EndUnattended {
        /// The arm.
        arm: ArmId,
    },
    /// Answer requests in progress as ended, and stop the arm if `stop`.
    EndWork {
        /// The arm.
        arm: ArmId,
        /// Requests to answer.
        requests: Vec<RequestId>,
        /// True to stop the arm, so that neither these requests nor its queue continue. False if
        /// the requests only steered a job, which ends in its own way.
        stop: bool,
        /// Reason.
        why: WorkEnd,
    },
    /// Pause or stop a job, because the lease under which it runs has ended.
    EndJob {
        /// The arm.
        arm: ArmId,
        /// The job.
        job: JobId,
        /// True to pause, so that it can be resumed; false to stop.
        pause: bool,
    },
    /// A session is over: it did not come back in time.
    SessionOver(SessionId),
    /// Turns, queue or frozen arms have changed.
    #[cfg(feature = "class")]
    Turns,
    /// A turn is about to end.
    #[cfg(feature = "class")]
    TurnEnding {
        /// The arm.
        arm: ArmId,
        /// The person whose turn it is.
        person: PersonId,
        /// Time left.
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

/// Reason for the end of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum JogEnd {
    /// Stopped by its session, or the session's socket closed.
    Released,
    /// No `jog.keep` within the keep-alive period.
    NotKept,
    /// The arm was stopped.
    Stopped,
    /// The lease ended.
    Lease,
    /// The line to the arm broke.
    Link,
    /// The same session started another jog.
    Replaced,
    /// The arm reached a limit or its fence.
    Limit,
}

impl JogEnd {
    /// Returns the name used in interfaces.
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

/// Reason why requests in progress ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WorkEnd {
    /// The lease ended. Contains the new holder.
    Lease(Option<SessionId>),
    /// The arm was stopped, by this session or from outside all sessions.
    Stop(Option<SessionId>),
}

/// Reason why nothing is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// The session does not hold the lease. Contains the holder, if any.
    Lease(Option<SessionId>),
    /// A job or a jog occupies the arm.
    Busy(Busy),
    /// A teacher has frozen the arm.
    #[cfg(feature = "class")]
    Frozen,
    /// Unknown lease, jog or question.
    Unknown,
    /// The station is ending: nothing starts any more.
    Closed,
}

/// State of a session within control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Presence {
    /// Instant of its last message.
    heard: HostInstant,
    /// Instant at which its socket closed. `None` while it has one.
    left: Option<HostInstant>,
}

/// State of an arm within control.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct ArmControl {
    lease: Option<LeaseHolder>,
    jog: Option<Jog>,
    work: Vec<Work>,
    /// True if commands of the holder may wait in the arm's queue.
    queued: bool,
    /// True while the arm reports releases of its unlock key to the holder.
    guided: bool,
    job: Option<Job>,
}

/// State of all arms of a station and who moves them.
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
    class: ClassState,
    /// True once the station ends: no lease is granted, no jog or job starts.
    is_ending: bool,
    /// Last id assigned to a lease or a jog.
    ids: u64,
}

impl Control {
    /// Creates the state for `arms` arms, without sessions.
    #[must_use]
    pub fn new(arms: usize) -> Self {
        Self {
            arms: vec![ArmControl::default(); arms],
            sessions: BTreeMap::new(),
            effects: VecDeque::new(),
            claims: Claims::default(),
            #[cfg(feature = "class")]
            class: ClassState::new(arms),
            is_ending: false,
            ids: 0,
        }
    }

    /// Returns the next effect. `None` without one.
    pub fn poll_effect(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// Adds a session.
    pub fn join(&mut self, now: HostInstant, session: SessionId) {
        let presence = Presence {
            heard: now,
            left: None,
        };
        self.sessions.insert(session, presence);
    }

    /// Records a sign of life of a session: a message, or a reply to a ping.
    pub fn keep_alive(&mut self, now: HostInstant, session: SessionId) {
        self.note_message(now, session);
        #[cfg(feature = "class")]
        self.note_person_present(now, session);
    }

    fn note_message(&mut self, now: HostInstant, session: SessionId) {
        if let Some(presence) = self.sessions.get_mut(&session) {
            presence.heard = now;
        }
    }

    /// Handles the end of a session's socket. A jog, and a job that burns, end at once; the lease
    /// is kept until the session comes back or [`RECONNECT_GRACE`] is over.
    pub fn leave(&mut self, now: HostInstant, session: SessionId) {
        let Some(presence) = self.sessions.get_mut(&session) else {
            return;
        };
        // The first end counts: a session is left only once until it rejoins.
        presence.left.get_or_insert(now);
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::Released, |jog| jog.session == session);
            // No socket is left to receive the answer.
            self.deny_session(arm, session);
            if self.holder(arm) == Some(session) {
                self.end_unattended_burn(arm);
            }
        }
    }

    /// Gives a session without a socket a new one. Returns false if the session is over.
    pub fn rejoin(&mut self, now: HostInstant, session: SessionId) -> bool {
        match self.sessions.get_mut(&session) {
            Some(presence) => {
                *presence = Presence {
                    heard: now,
                    left: None,
                };
                #[cfg(feature = "class")]
                self.note_person_present(now, session);
                true
            }
            None => false,
        }
    }

    /// Ends a session at once and for good: its token was revoked, or its server demands it.
    pub fn expel(&mut self, now: HostInstant, session: SessionId) {
        // Jogs and burning jobs end as if the socket had closed.
        self.leave(now, session);
        self.end_session(now, session);
    }

    /// Undoes [`identify`](Self::identify): turns, slots and freezes no longer bind the session.
    #[cfg(feature = "class")]
    pub fn unbind(&mut self, session: SessionId) {
        self.class.forget(session);
    }

    /// Starts the end of the station. Jogs end and no lease is granted any more. A holder keeps its
    /// lease, to end what it runs, until [`evict`](Self::evict).
    pub fn close(&mut self) {
        self.is_ending = true;
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::Stopped, |_| true);
            self.deny_requests(arm, |request| request.arm == arm);
        }
    }

    /// Ends the lease of an arm as if its holder were silent: what it has in progress is stopped.
    pub fn evict(&mut self, now: HostInstant, arm: ArmId) {
        if self.holder(arm).is_some() {
            self.end_lease(now, arm, LeaseEnd::Silent);
        }
    }

    /// Returns the holder of an arm. `None` if the lease is free.
    #[must_use]
    pub fn holder(&self, arm: ArmId) -> Option<SessionId> {
        self.arm(arm).lease.map(|held| held.session)
    }

    /// Returns the sessions that want an arm: first the waiting ones, in order, then the ones
    /// asking the holder. The flag is true if the session asks.
    pub fn waiting(&self, arm: ArmId) -> impl Iterator<Item = (SessionId, bool)> + '_ {
        let requests = self.claims.requests(arm);
        requests.map(|request| (request.session, request.is_ask))
    }

    /// Returns the jog in progress and its session. `None` without a jog.
    #[must_use]
    pub fn jog(&self, arm: ArmId) -> Option<(JogId, SessionId)> {
        self.arm(arm).jog.map(|jog| (jog.id, jog.session))
    }

    /// Returns the arms whose lease a session holds.
    pub fn held_by(&self, session: SessionId) -> impl Iterator<Item = ArmId> + '_ {
        self.arm_ids()
            .filter(move |arm| self.holder(*arm) == Some(session))
    }

    /// Returns the instant at which a session without a socket is over unless it comes back. `None`
    /// if it has a socket.
    #[must_use]
    pub fn back_until(&self, session: SessionId) -> Option<HostInstant> {
        Some(self.sessions.get(&session)?.left? + RECONNECT_GRACE)
    }

    /// Returns the instant at which [`handle_timeout`](Self::handle_timeout) is due. `None` if
    /// nothing is pending.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let arms = self.arms.iter().flat_map(|arm| {
            let jog = arm.jog.map(|jog| jog.ends);
            [self.lease_ends(arm), jog]
        });
        let sessions = self.sessions.values().map(|presence| presence.left);
        let sessions = sessions.map(|left| left.map(|left| left + RECONNECT_GRACE));
        let all = arms.chain(sessions).chain([self.claims.next()]);
        let due = all.flatten().min();
        #[cfg(feature = "class")]
        let due = due.into_iter().chain(self.class.next()).min();
        due
    }

    /// Ends everything whose time is over.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        // Jogs first, so that their stop is the first effect to leave.
        for arm in self.arm_ids() {
            self.end_jog_of(arm, JogEnd::NotKept, |jog| jog.ends <= now);
        }
        let gone: Vec<_> = { self.sessions.iter() }
            .filter(|(_, presence)| {
                presence
                    .left
                    .is_some_and(|left| left + RECONNECT_GRACE <= now)
            })
            .map(|(session, _)| *session)
            .collect();
        for session in gone {
            self.end_session(now, session);
        }
        for arm in self.arm_ids() {
            if self.lease_ends(self.arm(arm)).is_some_and(|end| end <= now) {
                self.end_lease(now, arm, LeaseEnd::Silent);
            }
            let due = |request: &LeaseRequest| request.arm == arm && request.until <= now;
            // A wait that is over is denied; a question that is over is granted (below).
            if self.deny_requests(arm, |request| due(request) && !request.is_ask) {
                self.notify_places(arm);
            }
            // Silence of the holder for ASK grants the request.
            while let Some(ask) = self
                .claims
                .take_first(|request| due(request) && request.is_ask)
            {
                self.grant_to_asker(now, arm, ask.session, ask.request);
            }
        }
        #[cfg(feature = "class")]
        self.class_timeout(now);
    }

    /// Ends a session that did not come back.
    fn end_session(&mut self, now: HostInstant, session: SessionId) {
        // May be called twice for a session, by its expulsion and by the clock.
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

    /// Returns the instant at which a lease ends if its holder stays silent.
    fn lease_ends(&self, arm: &ArmControl) -> Option<HostInstant> {
        let held = arm.lease?;
        let presence = self.sessions.get(&held.session)?;
        match presence.left {
            // Without a socket the grace period decides alone, whatever is in progress.
            Some(left) => Some(left + RECONNECT_GRACE),
            // A request in progress counts as a permanent sign of life.
            None if self.has_request(held.session) => None,
            None => Some(presence.heard + LEASE_TIMEOUT),
        }
    }

    /// True if a request of the session is in progress at any arm.
    fn has_request(&self, session: SessionId) -> bool {
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

/// Way in which a lease ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LeaseEnd {
    /// The holder gave it back: what it queued continues.
    Released,
    /// The lease passed to another session.
    Passed,
    /// The holder sent nothing for [`LEASE_TIMEOUT`].
    Silent,
    /// The holder's socket closed and the session did not come back.
    Gone,
    /// The turn or the slot of the holder is over.
    #[cfg(feature = "class")]
    Over,
}

/// Longest time for which a session may wait for a lease. Bounds the queue; clients can wait again.
pub const MAX_LEASE_WAIT: Duration = Duration::from_secs(3600);

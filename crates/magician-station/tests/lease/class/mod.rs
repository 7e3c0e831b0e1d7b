//! Exhaustive search over a class at two arms: persons, turns, slots and freezes in every order.
//! Two pupils, one with two pages, and a teacher.

mod laws;
mod mutant;
mod step;

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ArmId, JobId, LeaseId, PersonId, RequestId, SessionId, Slot, TurnRules, TurnState,
};

use self::mutant::{BUGS, Bug, Mutant};
use crate::search::{Explored, finds_all, search};
use crate::step::Checked;

pub(crate) const TEACHER: SessionId = SessionId(0);
pub(crate) const ANNA: PersonId = PersonId(1);
pub(crate) const BEN: PersonId = PersonId(2);
/// Two pages of Anna, one of Ben.
pub(crate) const PAGES: [(SessionId, PersonId); 3] = [
    (SessionId(1), ANNA),
    (SessionId(2), ANNA),
    (SessionId(3), BEN),
];
pub(crate) const ARMS: [ArmId; 2] = [ArmId(0), ArmId(1)];
const LENGTH: Duration = Duration::from_secs(20);
const GRACE: Duration = Duration::from_secs(8);
/// Most jobs that wait for an arm.
const JOBS: usize = 2;
/// Depth at which each planted bug is found, and at which control has none.
const DEPTH: usize = 5;
const FURTHER: usize = 5;

/// Event of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// Joins for the first arm, or for any.
    Join(PersonId, bool),
    Leave(PersonId),
    Acquire(SessionId, ArmId),
    Release(SessionId, ArmId),
    Take(ArmId),
    KeepAlive(SessionId),
    /// A page is closed, or its connection breaks.
    Gone(SessionId),
    /// A page comes back: with its session while that lasts, otherwise with a new one.
    Back(SessionId),
    Move(SessionId, ArmId),
    StartJob(SessionId, ArmId),
    EndJob(ArmId),
    /// Queues a job for when the arm is free.
    QueueJob(SessionId, ArmId),
    Freeze(ArmId),
    Free(ArmId),
    /// A teacher ends the turn at an arm.
    EndTurn(ArmId),
    /// A teacher passes the turn to the next person.
    NextTurn(ArmId),
    /// Time passes until the next deadline.
    Pass,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Arm {
    pub(crate) lease: Option<SessionId>,
    /// Requests in progress and their sessions.
    pub(crate) moves: BTreeMap<RequestId, SessionId>,
    /// Session of the running job.
    pub(crate) job: Option<SessionId>,
    pub(crate) paused: bool,
    pub(crate) frozen: bool,
    /// Waiting jobs by arrival, and their sessions.
    pub(crate) queue: Vec<(JobId, SessionId)>,
}

#[derive(Clone)]
pub(crate) struct Model {
    pub(crate) control: Mutant,
    pub(crate) now: HostInstant,
    pub(crate) begun: HostInstant,
    /// True if the session has a socket, and if control knows it.
    pub(crate) sockets: BTreeMap<SessionId, (bool, bool)>,
    pub(crate) arms: Vec<Arm>,
    pub(crate) last: LeaseId,
    pub(crate) requests: u64,
}

/// Slots of the second arm: Anna's, followed by Ben's.
pub(crate) fn slots(begun: HostInstant) -> Vec<Slot> {
    let at = |seconds| begun + Duration::from_secs(seconds);
    let slot = |from, until, person| Slot {
        from: Some(at(from)),
        until: at(until),
        who: BTreeSet::from([person]),
    };
    vec![slot(0, 15, ANNA), slot(15, 60, BEN)]
}

impl Model {
    fn new(bug: Option<Bug>, finish_job: bool) -> Self {
        let now = HostInstant::from_micros(60_000_000);
        let mut control = Mutant::new(ARMS.len(), bug);
        control.control.join(now, TEACHER);
        for (session, person) in PAGES {
            control.control.join(now, session);
            control.identify(now, session, person);
        }
        let (length, grace) = (Some(LENGTH), GRACE);
        let rules = TurnRules {
            length,
            grace,
            finish_job,
        };
        control.control.set_turns(now, Some(rules));
        control.control.set_slots(now, ARMS[1], Some(slots(now)));
        while control.control.poll_effect().is_some() {}
        let sessions = PAGES.iter().map(|(session, _)| *session);
        let sessions = sessions.chain([TEACHER]);
        Self {
            control,
            now,
            begun: now,
            sockets: sessions.map(|session| (session, (true, true))).collect(),
            arms: vec![Arm::default(); ARMS.len()],
            last: LeaseId(0),
            requests: 0,
        }
    }

    pub(crate) fn arm(&self, arm: ArmId) -> &Arm {
        &self.arms[arm.0 as usize]
    }

    pub(crate) fn arm_mut(&mut self, arm: ArmId) -> &mut Arm {
        &mut self.arms[arm.0 as usize]
    }

    /// Returns the person of a session. `None` for the teacher's.
    pub(crate) fn person(session: SessionId) -> Option<PersonId> {
        let found = PAGES.iter().find(|(page, _)| *page == session);
        found.map(|(_, person)| *person)
    }

    /// Returns person, state and rest of the turn at an arm.
    pub(crate) fn turn(&self, arm: ArmId) -> Option<(PersonId, TurnState, Option<Duration>)> {
        let (turn, left) = self.control.control.turn(self.now, arm)?;
        Some((mutant::known(turn.person), turn.state, left))
    }
}

impl Explored for Model {
    type Event = Event;

    fn events(&self) -> Vec<Event> {
        use Event::*;
        let mut out = vec![Pass];
        for person in [ANNA, BEN] {
            out.extend([Join(person, false), Join(person, true), Leave(person)]);
        }
        for (session, (socket, _)) in &self.sockets {
            let session = *session;
            if !socket {
                out.push(Back(session));
                continue;
            }
            // The second page matters only for what follows from the end of the first.
            let second = session == PAGES[1].0;
            out.extend([KeepAlive(session), Gone(session)]);
            for arm in ARMS {
                let holds = self.arm(arm).lease == Some(session);
                out.push(Acquire(session, arm));
                if holds {
                    out.push(Release(session, arm));
                }
                if !second && self.arm(arm).moves.is_empty() {
                    out.push(Move(session, arm));
                }
                if !second && self.arm(arm).queue.len() < JOBS {
                    out.push(QueueJob(session, arm));
                }
                if !second && self.arm(arm).job.is_none() && !self.arm(arm).paused {
                    out.push(StartJob(session, arm));
                }
            }
        }
        for arm in ARMS {
            out.push(Take(arm));
            let frozen = self.arm(arm).frozen;
            out.push(if frozen { Free(arm) } else { Freeze(arm) });
            if self.turn(arm).is_some() {
                out.extend([EndTurn(arm), NextTurn(arm)]);
            }
            if self.arm(arm).job.is_some() {
                out.push(EndJob(arm));
            }
        }
        out
    }

    fn step(&mut self, before: &Self, event: Event) -> Checked {
        self.check_step(before, event)
    }

    fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.control.control.canonical(self.now).hash(&mut hasher);
        (&self.sockets, self.now - self.begun).hash(&mut hasher);
        for arm in &self.arms {
            let moves: Vec<_> = arm.moves.values().collect();
            (arm.lease, moves, arm.job, arm.paused, arm.frozen).hash(&mut hasher);
            arm.queue.hash(&mut hasher);
        }
        hasher.finish()
    }
}

#[test]
fn class_invariants_hold_for_every_event_sequence() {
    for finish_job in [false, true] {
        let (found, states) = search(Model::new(None, finish_job), FURTHER);
        println!("class, states at each depth: {states:?}");
        assert!(found.is_none(), "{found:#?}");
    }
}

#[test]
fn every_planted_class_bug_is_found() {
    finds_all(&BUGS, DEPTH, |bug| Model::new(Some(bug), false));
}

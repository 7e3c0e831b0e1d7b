//! Policies of the queue: who may have an arm, who is next at one that is free, and what the end of a turn leaves.
//!
//! | claim | who may have the arm | its place | ends |
//! |---|---|---|---|
//! | a request that waits | whoever is in a slot of the schedule, is not barred from the arm, and has the turn where there are turns | by arrival | by `until` |
//! | a request that asks | the same | behind those that wait, if the holder is gone | granted by `until` |
//! | a person's turn | whoever is in a slot, at one arm at a time | by arrival; who missed a turn comes first when back | by leaving |
//! | a job | at an idle arm that nobody else has or has the turn at, in a slot of its owner | by arrival, or as it was moved | by stopping it |
//!
//! A teacher, who is no person of the class, is bound by none of it but the lease. Nothing here changes the state.

use std::time::Duration;

use magician_protocol::HostInstant;

use super::claims::{JobClaim, Place};
use super::class::{Turn, TurnState};
use super::{ArmId, Control, LeaseEnd, PersonId, SessionId};

/// What a request changes of a job that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueuedChange {
    /// Takes it out.
    Stop,
    /// Gives it another place.
    Reorder,
    /// Lets it go on after a stop, whose reason its owner knows.
    Resume,
}

/// What keeps a job or a person waiting for an arm, beside those in front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hindrance {
    /// A teacher has frozen the arm.
    Frozen,
    /// The schedule: no slot of the person is open.
    Schedule,
    /// The arm waits for somebody else's turn to end.
    Turn,
    /// Something moves the arm, or somebody else has its lease.
    Busy,
    /// The person is not there.
    Away,
}

impl Control {
    /// Whether a session may have the lease of an arm now, were nobody else to have it.
    #[must_use]
    pub fn may_hold(&self, now: HostInstant, session: SessionId, arm: ArmId) -> bool {
        let Some(person) = self.class.persons.get(&session) else {
            return true;
        };
        if !self.is_in_slot(now, arm, *person) {
            return false;
        }
        if self.class.rules.is_none() {
            return true;
        }
        let Some(person) = *person else {
            return false;
        };
        match &self.class(arm).turn {
            Some(turn) => turn.person == person,
            None => {
                let mut places = self.claims.places();
                let behind =
                    places.any(|place| place.person != person && self.is_next(now, arm, place));
                !behind && self.turn_of(person).is_none() && !self.job_runs(arm)
            }
        }
    }

    /// Whether a job that waits may begin now.
    #[must_use]
    pub fn may_begin(&self, now: HostInstant, claim: &JobClaim) -> bool {
        self.job_hindrance(now, claim).is_none()
    }

    /// What keeps a job from beginning now, beside the jobs in front of it.
    #[must_use]
    pub fn job_hindrance(&self, now: HostInstant, claim: &JobClaim) -> Option<Hindrance> {
        let JobClaim { arm, person, .. } = *claim;
        if self.is_frozen(arm) {
            return Some(Hindrance::Frozen);
        }
        if person.is_some() && !self.is_in_slot(now, arm, person) {
            return Some(Hindrance::Schedule);
        }
        let turn = self.class(arm).turn.as_ref();
        if turn.is_some_and(|turn| Some(turn.person) != person) {
            return Some(Hindrance::Turn);
        }
        let state = self.arm(arm);
        let idle = state.job.is_none() && state.jog.is_none() && state.work.is_empty();
        let own = self.holder(arm).is_none_or(|holder| {
            self.person(holder) == person && self.is_bound(holder) == person.is_some()
        });
        let begins = idle && !state.queued && own;
        (!begins).then_some(Hindrance::Busy)
    }

    /// What keeps a place in the queue from becoming a turn, beside the turns and places in front of it, and when the schedule
    /// lets it, if that is what keeps it and the time is known.
    #[must_use]
    pub fn place_hindrance(
        &self,
        now: HostInstant,
        place: &Place,
    ) -> Option<(Hindrance, Option<HostInstant>)> {
        if place.missed {
            return Some((Hindrance::Away, None));
        }
        let person = place.person;
        let open = |arm: &&ArmId| self.is_in_slot(now, **arm, Some(person));
        let mut open = place.arms.iter().filter(open).peekable();
        if open.peek().is_none() {
            let arms = place.arms.iter();
            let from = arms.filter_map(|arm| self.opens(now, *arm, person)).min();
            return Some((Hindrance::Schedule, from));
        }
        open.all(|arm| self.is_frozen(*arm))
            .then_some((Hindrance::Frozen, None))
    }

    /// When a person may have an arm by the schedule: now, or from the begin of a slot on. `None`: in no slot that is known,
    /// or [barred](Self::bar) from it.
    #[must_use]
    pub fn opens(&self, now: HostInstant, arm: ArmId, person: PersonId) -> Option<HostInstant> {
        if self.is_barred(arm, person) {
            return None;
        }
        let Some(slots) = &self.class(arm).slots else {
            return Some(now);
        };
        let own = slots.iter();
        let own = own.filter(|slot| slot.who.contains(&person) && now < slot.until);
        own.map(|slot| slot.from.map_or(now, |from| from.max(now)))
            .min()
    }

    /// Whether a session may change a job that waits so: a teacher, its owner, and the holder of the arm's lease, who has it
    /// in the way.
    #[must_use]
    pub fn may_change(&self, session: SessionId, claim: &JobClaim, change: QueuedChange) -> bool {
        if !self.is_bound(session) {
            return true;
        }
        let person = self.person(session);
        let owns = claim.person.is_some() && person == claim.person;
        let holds = self.holder(claim.arm).is_some_and(|holder| {
            // Two pages of a person are one person.
            holder == session || person.is_some() && self.person(holder) == person
        });
        owns || holds && change != QueuedChange::Resume
    }

    /// Whether the job of an arm goes on although the lease ends so.
    pub(super) fn finishes_job(&self, arm: ArmId, end: LeaseEnd) -> bool {
        let rules = self.class.rules;
        let job = self.arm(arm).job;
        end == LeaseEnd::Over
            && rules.is_some_and(|rules| rules.finish_job)
            && job.is_some_and(|job| !job.burns && !job.endless)
    }

    pub(super) fn refuses_frozen(&self, session: SessionId, arm: ArmId) -> bool {
        self.is_frozen(arm) && self.is_bound(session)
    }

    pub(super) fn is_in_slot(
        &self,
        now: HostInstant,
        arm: ArmId,
        person: Option<PersonId>,
    ) -> bool {
        if person.is_some_and(|person| self.is_barred(arm, person)) {
            return false;
        }
        self.class(arm).slots.as_ref().is_none_or(|slots| {
            let mut open = slots.iter().filter(|slot| slot.is_open(now));
            open.any(|slot| person.is_some_and(|person| slot.who.contains(&person)))
        })
    }

    /// Whether a place in the queue may become the turn at an arm.
    pub(super) fn is_next(&self, now: HostInstant, arm: ArmId, place: &Place) -> bool {
        !place.missed && place.arms.contains(&arm) && self.is_in_slot(now, arm, Some(place.person))
    }

    /// The clock of a turn stands while its arm is frozen.
    pub(super) fn clock(&self, now: HostInstant, arm: ArmId) -> HostInstant {
        self.class(arm).frozen.unwrap_or(now)
    }

    pub(super) fn left(&self, now: HostInstant, arm: ArmId, turn: &Turn) -> Option<Duration> {
        match turn.state {
            TurnState::Running { ends } => ends.map(|ends| ends - self.clock(now, arm)),
            TurnState::Kept { left, .. } | TurnState::Suspended { left } => left,
        }
    }
}

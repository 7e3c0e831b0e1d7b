//! Policies of the queue: who may have an arm, who is next at a free one, and what keeps a claim
//! waiting.
//!
//! | claim | may have the arm | position | ends |
//! |---|---|---|---|
//! | request that waits | if in a slot of the schedule, not barred from the arm, and on turn where
//! turns are set | by arrival | at `until` |
//! | request that asks | the same | after waiting requests, if the holder is gone | granted at
//! `until` |
//! | turn of a person | if in a slot; at one arm at a time | by arrival; first when back after a
//! missed turn | when the person leaves |
//! | job | at an idle arm that no other person holds or has the turn at, in a slot of its owner |
//! by arrival, or as moved | when stopped |
//!
//! A teacher is not a person of the class and is bound by the lease alone. The functions here only
//! read the state.

use std::time::Duration;

use magician_protocol::HostInstant;

use super::claims::{JobClaim, TurnPlace};
use super::class::{Turn, TurnState};
use super::{ArmId, Control, LeaseEnd, PersonId, SessionId};

/// Change of a waiting job by a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueuedChange {
    /// Remove it.
    Stop,
    /// Move it within the queue.
    Reorder,
    /// Let the job continue after a stop. Only its owner knows why it was stopped.
    Resume,
}

/// Reason why a job or a person waits for an arm, besides claims further in front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hindrance {
    /// A teacher has frozen the arm.
    Frozen,
    /// No slot of the person is open.
    Schedule,
    /// Another person has the turn at the arm.
    Turn,
    /// Something moves the arm, or another session holds its lease.
    Busy,
    /// The person is away.
    Away,
}

impl Control {
    /// True if a session may hold the lease of an arm now, assuming that it is free.
    #[must_use]
    pub fn may_hold(&self, now: HostInstant, session: SessionId, arm: ArmId) -> bool {
        // Not identified: a teacher, whom nothing here binds.
        let Some(person) = self.class.persons.get(&session) else {
            return true;
        };
        if !self.is_in_slot(now, arm, *person) {
            return false;
        }
        if self.class.rules.is_none() {
            return true;
        }
        // Turns need a known person.
        let Some(person) = *person else {
            return false;
        };
        match &self.class(arm).turn {
            Some(turn) => turn.person == person,
            None => {
                let mut places = self.claims.places();
                // A free arm belongs to the person at the head of the queue, not to the fastest
                // click.
                let behind =
                    places.any(|place| place.person != person && self.is_next(now, arm, place));
                !behind && self.turn_of(person).is_none() && !self.is_job_running(arm)
            }
        }
    }

    /// True if a waiting job may start now.
    #[must_use]
    pub fn may_begin(&self, now: HostInstant, claim: &JobClaim) -> bool {
        self.job_hindrance(now, claim).is_none()
    }

    /// Returns the reason why a job cannot start now, besides the jobs in front of it. `None` if it
    /// can.
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
        // The owner's own lease is no obstacle, on whichever page.
        let own = self.holder(arm).is_none_or(|holder| {
            self.person(holder) == person && self.is_bound(holder) == person.is_some()
        });
        // Queued commands of a holder would run into the job.
        let begins = idle && !state.queued && own;
        (!begins).then_some(Hindrance::Busy)
    }

    /// Returns the reason why a place cannot become a turn, besides turns and places in front of
    /// it. `None` if it can. If the schedule is the reason, also the instant at which it opens, if
    /// known.
    #[must_use]
    pub fn place_hindrance(
        &self,
        now: HostInstant,
        place: &TurnPlace,
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

    /// Returns the instant from which the schedule grants a person the arm: `now` or the start of a
    /// slot. `None` if no known slot does, or the person is [barred](Self::bar).
    #[must_use]
    pub fn opens(&self, now: HostInstant, arm: ArmId, person: PersonId) -> Option<HostInstant> {
        if self.is_barred(arm, person) {
            return None;
        }
        let Some(slots) = &self.class(arm).slots else {
            return Some(now);
        };
        let own = slots.iter();
        // Slots that are over may still be listed until the next timeout.
        let own = own.filter(|slot| slot.who.contains(&person) && now < slot.until);
        own.map(|slot| slot.from.map_or(now, |from| from.max(now)))
            .min()
    }

    /// True if a session may make this change to a waiting job. A teacher and the owner may make
    /// any; the holder of the arm's lease may remove or move it, because the job is in its way.
    #[must_use]
    pub fn may_change(&self, session: SessionId, claim: &JobClaim, change: QueuedChange) -> bool {
        if !self.is_bound(session) {
            return true;
        }
        let person = self.person(session);
        let owns = claim.person.is_some() && person == claim.person;
        let holds = self.holder(claim.arm).is_some_and(|holder| {
            // Two pages of a person count as one.
            holder == session || person.is_some() && self.person(holder) == person
        });
        owns || holds && change != QueuedChange::Resume
    }

    /// True if the arm's job continues although the lease ends in this way.
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

    /// True if a place may become the turn at an arm.
    pub(super) fn is_next(&self, now: HostInstant, arm: ArmId, place: &TurnPlace) -> bool {
        !place.missed && place.arms.contains(&arm) && self.is_in_slot(now, arm, Some(place.person))
    }

    /// Returns the time on the clock of a turn, which stands still while the arm is frozen.
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

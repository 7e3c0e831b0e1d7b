//! Turns: how they start, pause, pass and end.
//!
//! A turn is bound to a person, not to a session. When the person's page disappears the turn is
//! kept for a grace period; when a teacher takes the arm the turn is suspended; in both cases its
//! clock keeps the rest. `advance` starts every turn that can start and is called after each
//! change.

use std::collections::BTreeSet;

use magician_protocol::HostInstant;

use super::claims::TurnPlace;
use super::class::*;
use super::{ArmId, Control, Effect, JobPhase, LeaseEnd, PersonId, RequestId, SessionId};

impl Control {
    /// Decides whether a request for the lease may proceed. A request that may not is answered
    /// here; returns false then.
    pub(super) fn admits(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
    ) -> bool {
        if !self.may_hold(now, session, arm) {
            self.deny(arm, vec![request]);
            return false;
        }
        // Another page of the same person takes over without asking.
        let holder = self.holder(arm).filter(|holder| *holder != session);
        if let Some(holder) = holder
            && self.person(session).is_some()
            && self.person(holder) == self.person(session)
        {
            // The lease passes in one step, so the turn is not interrupted.
            self.pass(now, arm, session, Some(request));
            return false;
        }
        true
    }

    /// Updates the turn of an arm after a session got the lease.
    pub(super) fn note_turn_granted(&mut self, now: HostInstant, arm: ArmId, session: SessionId) {
        let Some(rules) = self.class.rules else {
            return;
        };
        let clock = self.clock(now, arm);
        let before = self.class(arm).turn.clone();
        let left = before
            .as_ref()
            .map_or(rules.length, |turn| self.left(now, arm, turn));
        let state = if self.is_bound(session) {
            match before.as_ref().map(|turn| turn.state) {
                // A new page of the same person does not restart the clock.
                Some(running @ TurnState::Running { .. }) => running,
                // The clock starts with the rest that was left, or with a full turn.
                _ => TurnState::Running {
                    ends: left.map(|left| clock + left),
                },
            }
        } else {
            TurnState::Suspended { left }
        };
        let turn = match (before, self.person(session)) {
            // A turn that exists keeps its person, even if a teacher takes the arm.
            (Some(turn), _) => Turn { state, ..turn },
            (None, Some(person)) => {
                self.claims.drop_places(|place| place.person == person);
                Turn {
                    person,
                    state,
                    arms: BTreeSet::from([arm]),
                    warnings_given: rules.skipped_warnings(),
                }
            }
            // A teacher at an arm without a turn has no turn.
            (None, None) => return,
        };
        self.class_mut(arm).turn = Some(turn);
        self.emit_turns_changed();
    }

    /// Updates the turn of an arm after a lease ended in another way than by passing.
    pub(super) fn note_turn_lease_ended(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        session: SessionId,
        end: LeaseEnd,
    ) {
        let (Some(rules), true) = (self.class.rules, self.is_bound(session)) else {
            return;
        };
        let Some(turn) = self.class(arm).turn.clone() else {
            return;
        };
        let turn = match end {
            LeaseEnd::Silent | LeaseEnd::Gone => {
                let state = TurnState::Kept {
                    until: now + rules.grace,
                    left: self.left(now, arm, &turn),
                };
                Some(Turn { state, ..turn })
            }
            // Given back on purpose, or over: nothing is kept.
            LeaseEnd::Released | LeaseEnd::Passed | LeaseEnd::Over => None,
        };
        self.class_mut(arm).turn = turn;
        self.emit_turns_changed();
    }

    /// Handles a sign of life of a person: missed places and kept turns become valid again.
    pub(super) fn note_person_present(&mut self, now: HostInstant, session: SessionId) {
        let Some(person) = self.person(session).filter(|_| !self.is_ending) else {
            return;
        };
        if let Some(place) = self.claims.missed_mut(person) {
            place.missed = false;
            self.emit_turns_changed();
            self.advance(now);
        }
        let Some(arm) = self.turn_of(person) else {
            return;
        };
        let waits = { self.class(arm).turn.as_ref() }
            .is_some_and(|turn| matches!(turn.state, TurnState::Kept { .. }));
        match self.holder(arm) {
            None if waits => self.grant(now, arm, session, None),
            // The page that held the lease has lost its socket.
            Some(holder)
                if holder != session
                    && self.person(holder) == Some(person)
                    && !self.has_socket(holder) =>
            {
                self.pass(now, arm, session, None);
            }
            _ => {}
        }
    }

    /// Gives a kept turn to another page of its person, after the page that had it is gone.
    pub(super) fn hand_to_other_page(&mut self, now: HostInstant, arm: ArmId) {
        let turn = { self.class(arm).turn.as_ref() }
            .filter(|turn| matches!(turn.state, TurnState::Kept { .. }));
        let person = turn.map(|turn| turn.person);
        if self.holder(arm).is_none()
            && !self.is_ending
            && let Some(session) = person.and_then(|person| self.session_of_person(person))
        {
            self.grant(now, arm, session, None);
        }
    }

    /// Starts all turns that can start.
    pub(super) fn advance(&mut self, now: HostInstant) {
        let Some(rules) = self.class.rules.filter(|_| !self.is_ending) else {
            return;
        };
        for arm in self.arm_ids() {
            if self.holder(arm).is_some() || self.is_job_running(arm) {
                continue;
            }
            let turn = match self.class(arm).turn.clone() {
                // Kept for its person: only the person or the end of the grace period continues it.
                Some(turn) if matches!(turn.state, TurnState::Kept { .. }) => continue,
                Some(turn) => turn,
                None => {
                    let next = { self.claims.places() }.find(|place| self.is_next(now, arm, place));
                    let Some(person) = next.map(|place| place.person) else {
                        continue;
                    };
                    let Some(place) = self.claims.take_place(person) else {
                        continue;
                    };
                    let left = place.left.unwrap_or(rules.length);
                    Turn {
                        person: place.person,
                        state: TurnState::Suspended { left },
                        arms: place.arms,
                        warnings_given: rules.skipped_warnings(),
                    }
                }
            };
            let here = self.session_of_person(turn.person);
            let left = self.left(now, arm, &turn);
            // Even for a person who is present: the grant below replaces it.
            let until = now + rules.grace;
            self.class_mut(arm).turn = Some(Turn {
                state: TurnState::Kept { until, left },
                ..turn
            });
            self.emit_turns_changed();
            if let Some(session) = here {
                self.grant(now, arm, session, None);
            }
        }
    }

    /// Handles everything of the class that is due.
    pub(super) fn class_timeout(&mut self, now: HostInstant) {
        for arm in self.arm_ids() {
            self.end_passed_slots(now, arm);
            let Some(turn) = self.class(arm).turn.clone() else {
                continue;
            };
            match turn.state {
                TurnState::Running { ends: Some(ends) } if self.class(arm).frozen.is_none() => {
                    if ends <= now {
                        self.end_turn(now, arm);
                        continue;
                    }
                    let due = TURN_END_WARNINGS
                        .iter()
                        .filter(|before| ends <= now + **before)
                        .count();
                    if due > turn.warnings_given
                        && let Some(turn) = &mut self.class_mut(arm).turn
                    {
                        turn.warnings_given = due;
                        let (person, left) = (turn.person, ends - now);
                        self.effects
                            .push_back(Effect::TurnEnding { arm, person, left });
                    }
                }
                TurnState::Kept { until, left } if until <= now => {
                    self.class_mut(arm).turn = None;
                    // The place goes to the front: the person is first again when back.
                    let place = TurnPlace {
                        person: turn.person,
                        arms: turn.arms,
                        left: Some(left),
                        missed: true,
                    };
                    self.claims.put_place_first(place);
                    self.emit_turns_changed();
                }
                _ => {}
            }
        }
        self.advance(now);
    }

    /// Ends leases, waits and turns of persons whose slot is over.
    pub(super) fn end_passed_slots(&mut self, now: HostInstant, arm: ArmId) {
        let class = self.class_mut(arm);
        if class.slots.is_none() && class.barred.is_empty() {
            return;
        }
        let mut none = Vec::new();
        let slots = class.slots.as_mut().unwrap_or(&mut none);
        let before = slots.len();
        slots.retain(|slot| now < slot.until);
        let mut has_changed = slots.len() != before;
        for slot in slots.iter_mut() {
            has_changed |= slot.from.take_if(|from| *from <= now).is_some();
        }
        let turn = class.turn.as_ref().map(|turn| turn.person);
        if has_changed {
            self.emit_turns_changed();
        }
        if turn.is_some_and(|person| !self.is_in_slot(now, arm, Some(person))) {
            self.end_turn(now, arm);
        }
        let holder = self.holder(arm);
        if holder.is_some_and(|holder| !self.may_hold(now, holder, arm)) {
            self.end_lease(now, arm, LeaseEnd::Over);
        }
        self.deny_unadmitted(now, arm);
    }

    /// Denies waiting requests of sessions that may not hold the arm.
    pub(super) fn deny_unadmitted(&mut self, now: HostInstant, arm: ArmId) {
        let waiting: BTreeSet<_> = self.waiting(arm).map(|(session, _)| session).collect();
        for session in waiting {
            if !self.may_hold(now, session, arm) {
                self.deny_session(arm, session);
            }
        }
    }

    /// Ends the turn at an arm.
    pub(super) fn end_turn(&mut self, now: HostInstant, arm: ArmId) {
        let holder = self.holder(arm).filter(|holder| self.is_bound(*holder));
        self.class_mut(arm).turn = None;
        self.emit_turns_changed();
        if holder.is_some() {
            self.end_lease(now, arm, LeaseEnd::Over);
        }
    }

    /// Ends the job of an arm without a holder in the way the end of a turn does: it pauses, or
    /// continues with [`finish_job`](TurnRules::finish_job).
    ///
    /// Needed because a job of the queue runs without a lease whose end would end it. With `stops`
    /// it stops instead of pausing. Returns false if no such job is running.
    pub fn end_unattended_job(&mut self, arm: ArmId, stops: bool) -> bool {
        let job = { self.arm(arm).job }
            .filter(|job| job.phase.is_under_way() && self.holder(arm).is_none());
        let Some(job) = job else {
            return false;
        };
        if !self.finishes_job(arm, LeaseEnd::Over) {
            let (job, pause) = (job.id, !stops);
            self.effects.push_back(Effect::EndJob { arm, job, pause });
        }
        true
    }

    /// Returns the arm at which a person has the turn.
    pub(super) fn turn_of(&self, person: PersonId) -> Option<ArmId> {
        let of = |class: &ArmClass| class.turn.as_ref().map(|turn| turn.person);
        self.arm_ids()
            .find(|arm| of(self.class(*arm)) == Some(person))
    }

    /// Returns the newest session of a person that has a socket.
    pub(super) fn session_of_person(&self, person: PersonId) -> Option<SessionId> {
        // Ids grow, so the last session is the newest page.
        let mut sessions = self.class.persons.iter().rev();
        let of = |(session, of): &(&SessionId, &Option<PersonId>)| {
            **of == Some(person) && self.has_socket(**session)
        };
        sessions.find(of).map(|(session, _)| *session)
    }

    pub(super) fn has_socket(&self, session: SessionId) -> bool {
        let presence = self.sessions.get(&session);
        presence.is_some_and(|presence| presence.left.is_none())
    }

    pub(super) fn is_job_running(&self, arm: ArmId) -> bool {
        { self.arm(arm).job }.is_some_and(|job| job.phase == JobPhase::Active)
    }

    pub(super) fn emit_turns_changed(&mut self) {
        // One effect for several changes in a row.
        if self.effects.back() != Some(&Effect::Turns) {
            self.effects.push_back(Effect::Turns);
        }
    }
}

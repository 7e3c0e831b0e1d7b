//! Invariants of a class, checked after every event.

use magician_station::control::{ArmId, JobClaim, JobId, PersonId, SessionId, TurnState};

use super::{ANNA, ARMS, BEN, Event, Model, TEACHER, mutant, slots};
use crate::step::{Checked, must};

impl Model {
    pub(crate) fn check(&self, before: &Self, event: Event) -> Checked {
        let control = &self.control.control;
        for person in [ANNA, BEN] {
            must(self.places(person) <= 1, "a person has at most one place")?;
            if before.places(person) == 1 && self.places(person) == 0 {
                let good = match event {
                    Event::Leave(whose) => whose == person,
                    Event::Release(session, _) => Self::person(session) == Some(person),
                    // The turn or the slot has ended.
                    Event::Pass => before.waits(person).is_none(),
                    Event::EndTurn(arm) => before.turn(arm).is_some_and(|turn| turn.0 == person),
                    _ => false,
                };
                let law = match event {
                    Event::Gone(_) | Event::Back(_) | Event::KeepAlive(_) => {
                        "a reload keeps the place"
                    }
                    _ => "a turn and a place are kept",
                };
                must(good, law)?;
            }
        }
        for arm in ARMS {
            let model = self.arm(arm);
            must(
                control.holder(arm) == model.lease,
                "the holder is the one who was told so",
            )?;
            let pupil = model.lease.and_then(Self::person);
            if let Some(person) = pupil {
                must(
                    self.is_in_slot(arm, person),
                    "nobody holds outside of a slot",
                )?;
                let turn = self.turn(arm);
                let runs = turn.is_some_and(|(whose, state, _)| {
                    whose == person && matches!(state, TurnState::Running { .. })
                });
                must(runs, "who holds an arm has its turn")?;
            }
            for session in model.moves.values() {
                must(
                    model.lease == Some(*session),
                    "what moves belongs to the holder",
                )?;
            }
            if model.frozen {
                let mut moves = model.moves.values().chain(&model.job);
                must(
                    !moves.any(|session| *session != TEACHER),
                    "frozen arms do not move",
                )?;
            }
            self.check_turn(arm, before, event)?;
            let mut queue = model.queue.iter();
            let ready = queue.any(|(_, session)| self.is_in_slot_of(arm, *session));
            let idle = self.is_idle(arm) && model.lease.is_none() && self.turn(arm).is_none();
            must(
                !ready || !idle || model.frozen,
                "an arm is not idle while a job waits",
            )?;
        }
        let order = |model: &Self| [ANNA, BEN].map(|person| model.waits(person));
        if let ([Some(a), Some(b)], [Some(then_a), Some(then_b)]) = (order(before), order(self)) {
            let joins = matches!(event, Event::Join(..));
            must(
                joins || (a < b) == (then_a < then_b) || matches!(event, Event::Pass),
                "the queue keeps its order",
            )?;
        }
        self.check_teacher_actions(before, event)?;
        if let (Event::Join(person, _), Some(at)) = (event, self.waits(event_person(event))) {
            let new = before.waits(person).is_none();
            let last = self.control.control.places().count() - 1;
            must(!new || at == last, "the queue keeps its order")?;
        }
        Ok(())
    }

    /// Checks the effects of a teacher's decision about a turn.
    fn check_teacher_actions(&self, before: &Self, event: Event) -> Checked {
        let (arm, ends) = match event {
            Event::EndTurn(arm) => (arm, true),
            Event::NextTurn(arm) => (arm, false),
            _ => return Ok(()),
        };
        // Effects of the teacher's message itself come before.
        let Some((person, ..)) = before.turn(arm) else {
            return Ok(());
        };
        let now = self.turn(arm).map(|(person, ..)| person);
        if ends {
            let over = now != Some(person) && self.places(person) == 0;
            return must(over, "a turn that is ended is over");
        }
        let mut queue = before.control.control.places();
        let next = queue.find(|place| {
            let of = mutant::known(place.person);
            let mut pages = before.sockets.iter().filter(|(_, (open, _))| *open);
            let is_here = pages.any(|(session, _)| Self::person(*session) == Some(of));
            is_here && !place.missed && place.arms.contains(&arm) && before.is_in_slot(arm, of)
        });
        let Some(next) = next.map(|place| mutant::known(place.person)) else {
            return must(now == Some(person), "a turn is passed to the next");
        };
        let model = self.arm(arm);
        let waits = model.lease == Some(TEACHER) || model.job.is_some();
        must(waits || now == Some(next), "a turn is passed to the next")
    }

    fn check_turn(&self, arm: ArmId, before: &Self, event: Event) -> Checked {
        let turn = self.turn(arm);
        if let Some((_, TurnState::Running { .. }, left)) = turn {
            must(
                self.arm(arm).frozen || left.is_some_and(|left| !left.is_zero()),
                "a turn ends in time",
            )?;
        }
        let was = before.turn(arm);
        if let (Event::Take(at), Some((person, _, left))) = (event, was)
            && at == arm
            && self.arm(arm).lease == Some(TEACHER)
        {
            let now = turn.filter(|(whose, ..)| *whose == person);
            let suspended =
                now.is_some_and(|(_, state, then)| state == TurnState::Suspended { left: then });
            must(suspended, "a teacher suspends a turn")?;
            let then = now.and_then(|(.., left)| left);
            must(then == left, "a turn that is suspended keeps its time")?;
        }
        // A free arm waits only for the person whose turn is kept.
        let idle = turn.is_none() && self.arm(arm).lease.is_none() && self.arm(arm).job.is_none();
        let mut queue = self.control.control.places();
        let wanted = queue.any(|place| {
            let person = mutant::known(place.person);
            !place.missed && place.arms.contains(&arm) && self.is_in_slot(arm, person)
        });
        must(!(idle && wanted), "an arm is not idle while somebody waits")
    }

    /// Checks a job that starts from the queue.
    pub(super) fn check_begun(&self, claim: JobClaim) -> Checked {
        let arm = self.arm(claim.arm);
        must(!arm.frozen, "frozen arms do not move")?;
        must(self.is_idle(claim.arm), "a job begins at an idle arm")?;
        let own = arm
            .lease
            .is_none_or(|holder| Self::person(holder) == claim.person);
        let turn = self.turn(claim.arm);
        let turn = turn.is_none_or(|(person, ..)| Some(person) == claim.person);
        must(own && turn, "a job begins beside nobody else's turn")?;
        let of = |(_, session): &&(JobId, SessionId)| Self::person(*session) == claim.person;
        let first = arm.queue.iter().find(of).map(|(job, _)| *job);
        must(first == Some(claim.job), "jobs keep their order")
    }

    fn is_idle(&self, arm: ArmId) -> bool {
        let arm = self.arm(arm);
        arm.job.is_none() && !arm.paused && arm.moves.is_empty()
    }

    fn is_in_slot_of(&self, arm: ArmId, session: SessionId) -> bool {
        Self::person(session).is_none_or(|person| self.is_in_slot(arm, person))
    }

    fn is_in_slot(&self, arm: ArmId, person: PersonId) -> bool {
        arm == ARMS[0]
            || slots(self.begun).iter().any(|slot| {
                let from = slot.from.is_none_or(|from| from <= self.now);
                from && self.now < slot.until && slot.who.contains(&person)
            })
    }

    /// Counts places and turns of a person.
    fn places(&self, person: PersonId) -> usize {
        let queue = self.control.control.places();
        let waits = queue.filter(|place| mutant::known(place.person) == person);
        let turns = ARMS.iter().filter_map(|arm| self.turn(*arm));
        waits.count() + turns.filter(|(whose, ..)| *whose == person).count()
    }

    fn waits(&self, person: PersonId) -> Option<usize> {
        let mut queue = self.control.control.places();
        queue.position(|place| mutant::known(place.person) == person)
    }
}

fn event_person(event: Event) -> PersonId {
    match event {
        Event::Join(person, _) => person,
        _ => ANNA,
    }
}

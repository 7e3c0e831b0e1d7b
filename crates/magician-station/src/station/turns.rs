//! Methods and notifications of turns.

use std::collections::BTreeSet;

use magician::{Message, message};
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::Station;
use super::class::no_class;
use super::dispatch::{Call, forbidden};
use super::newest::Newest;
use super::schedule::SlotNow;
use crate::api::{Notice, Role, RpcError};
use crate::control::{
    ArmId, Effect, Hindrance, JobClaim, LEASE_TIMEOUT, PersonId, QueueRefusal, SessionId, TurnState,
};

impl Station {
    pub(super) fn turn_call(&mut self, name: &str, call: &Call<'_>) -> Result<Value, RpcError> {
        let now = call.now;
        match name {
            "turn.list" => {
                let mut turns = self.turns(now);
                if let Some(person) = self.control.person(call.session) {
                    // A group without arms here gives an empty list. Joining reports the reason.
                    let arms: Vec<_> = self.turn_arms(call).into_iter().flatten().collect();
                    let (person, arms) = (self.person_name(person), self.names_of(&arms));
                    turns["you"] = json!({"person": person, "arms": arms});
                }
                Ok(turns)
            }
            "turn.join" => {
                let arms = self.turn_arms(call)?;
                // Sessions not bound by turns, such as a teacher's, do not queue and get the list.
                if self.control.is_bound(call.session) {
                    let Some(person) = self.control.person(call.session) else {
                        let why =
                            message!("turns are of persons: sign in with name and code first");
                        return Err(RpcError::new(RpcError::FORBIDDEN, why));
                    };
                    let joined = self.control.join_turn(now, person, arms.clone());
                    joined.map_err(|why| match why {
                        QueueRefusal::NoTurns => no_class(),
                        QueueRefusal::Schedule => self.schedule_refusal(now, person, &arms),
                    })?;
                }
                Ok(self.turns(now))
            }
            "turn.leave" => {
                // A name may stand for a pupil and for a token.
                for person in self.leaving_persons(call)? {
                    self.control.leave_turn(now, person);
                }
                Ok(Value::Null)
            }
            "turn.end" => {
                let mut arms = self.selected_arms(call)?;
                arms.retain(|arm| {
                    let ends_job = self.end_queued_job(*arm, None);
                    let has_turn = self.control.turn(now, *arm).is_some();
                    self.control.finish_turn(now, *arm);
                    ends_job || has_turn
                });
                Ok(json!({"arms": self.names_of(&arms)}))
            }
            "turn.next" => {
                let mut arms = self.selected_arms(call)?;
                arms.retain(|arm| self.control.pass_turn(now, *arm).is_ok());
                // With several arms, those without a successor are left out silently.
                if let (Some(arm), true) = (call.arm, arms.is_empty()) {
                    let name = &self.arm(arm).entry.name;
                    let why =
                        message!("nobody who is there waits to follow a turn at {name}", name);
                    return Err(RpcError::param("arm", why));
                }
                Ok(json!({"arms": self.names_of(&arms)}))
            }
            _ => Err(RpcError::internal(format!("{name} does nothing"))),
        }
    }

    /// Returns the persons who leave the queue: the client's own, or for a teacher all with the
    /// given name.
    fn leaving_persons(&self, call: &Call<'_>) -> Result<Vec<PersonId>, RpcError> {
        let own = self.control.person(call.session);
        let Some(name) = call.params.text("person") else {
            return Ok(own.into_iter().collect());
        };
        if self.control.is_bound(call.session) && own.map(|own| self.person_name(own)) != Some(name)
        {
            return Err(forbidden(
                &call.grant,
                Role::Teacher,
                message!("the place of somebody else"),
            ));
        }
        let persons = (0..).map(PersonId).zip(&self.class.persons);
        let named: Vec<_> = { persons.filter(|(_, person)| person.name() == name) }
            .map(|(id, _)| id)
            .collect();
        if named.is_empty() {
            let name = magician_protocol::visible(name).to_string();
            return Err(RpcError::param(
                "person",
                message!("nobody is called {name}", name),
            ));
        }
        Ok(named)
    }

    /// Returns the error for a person whom the schedule grants none of these arms.
    fn schedule_refusal(
        &self,
        now: HostInstant,
        person: PersonId,
        arms: &BTreeSet<ArmId>,
    ) -> RpcError {
        if let Some(why) = self.schedule_error_sentence() {
            return RpcError::new(RpcError::FORBIDDEN, why);
        }
        // A bar is the reason only if it applies at every arm.
        let barred = arms.iter().map(|arm| self.barred(*arm, person));
        if let Some(why) = barred.reduce(Option::and).flatten() {
            return RpcError::new(RpcError::FORBIDDEN, why);
        }
        let own = arms
            .iter()
            .filter(|arm| !self.control.is_barred(**arm, person));
        let slots = own.map(|arm| match self.slot(now, *arm) {
            SlotNow::Open(slot) => (*arm, Some(slot)),
            SlotNow::Free | SlotNow::Closed(_) => (*arm, None),
        });
        // An arm with an open slot gives the better message: it names the others and the end.
        let Some((arm, slot)) = slots.min_by_key(|(_, slot)| slot.is_none()) else {
            return no_class();
        };
        let name = &self.arm(arm).entry.name;
        let until = slot.as_ref().and_then(|slot| slot.until);
        let who = slot.map_or_else(
            || message!("others"),
            |slot| Message::from(slot.who.join(", ")),
        );
        let until_when = until.map(|until| self.local_time(until));
        let why = match (until_when, arms.len() > 1) {
            (None, false) => {
                message!("{name} is for {who}: ask the teacher for a slot", name, who)
            }
            (None, true) => message!(
                "{name} is for {who}, and none of the others is for you: ask the teacher for a slot",
                name,
                who
            ),
            (Some(until), false) => message!(
                "{name} is for {who} until {until}: ask the teacher for a slot",
                name,
                who,
                until
            ),
            (Some(until), true) => message!(
                "{name} is for {who} until {until}, and none of the others is for you: ask the teacher for a slot",
                name,
                who,
                until
            ),
        };
        { RpcError::new(RpcError::FORBIDDEN, why).with("arm", name.clone()) }
            .with("until", json!(until))
    }

    /// Returns turns and queue as clients see them.
    pub(super) fn turns(&self, now: HostInstant) -> Value {
        let rules = self.control.turn_rules();
        let arms = self.arm_ids().map(|arm| {
            let turn = self.control.turn(now, arm);
            let state = turn.map(|(turn, _)| match turn.state {
                TurnState::Running { .. } => "running",
                TurnState::Kept { .. } => "kept",
                TurnState::Suspended { .. } => "suspended",
            });
            let left = turn
                .and_then(|(_, left)| left)
                .map(|left| left.as_secs_f64());
            let (slot, free_at) = match self.slot(now, arm) {
                SlotNow::Free => (None, None),
                SlotNow::Open(slot) => (Some(slot), None),
                SlotNow::Closed(from) => (None, from),
            };
            let jobs = self.control.jobs(arm).map(|claim| {
                let record = self.records.with_number(claim.job);
                json!({
                    "job": self.job_id(claim.job),
                    "title": record.and_then(|record| record.title.as_deref()),
                    "person": claim.person.map(|person| self.person_name(person)),
                    "reason": self.job_wait_reason(now, claim),
                })
            });
            json!({
                "arm": self.arm(arm).entry.name,
                "person": turn.map(|(turn, _)| self.person_name(turn.person)),
                "state": state,
                "left_s": left,
                "frozen": self.control.is_frozen(arm),
                "jobs": jobs.collect::<Vec<_>>(),
                "slot": slot.map(|slot| json!({"who": slot.who, "until": slot.until})),
                "free_at": free_at,
            })
        });
        let queue = (1..).zip(self.control.places()).map(|(at, place)| {
            let arms: Vec<_> = place.arms.iter().copied().collect();
            let hindrance = self.control.place_hindrance(now, place);
            let from = hindrance.and_then(|(_, from)| from);
            json!({
                "place": at, "person": self.person_name(place.person),
                "arms": self.names_of(&arms), "missed": place.missed,
                "reason": hindrance.map(|(why, _)| reason(why)),
                "from": from.map(|from| self.unix(from).round()),
            })
        });
        let queue: Vec<Value> = queue.collect();
        json!({
            // 0 stands for turns without a limit, null for a station without turns.
            "turn_s": rules.map(|rules| rules.length.map_or(0, |length| length.as_secs())),
            "arms": arms.collect::<Vec<_>>(),
            "queue": queue,
        })
    }

    /// Returns the reason why a job waits, besides the jobs in front of it.
    fn job_wait_reason(&self, now: HostInstant, claim: &JobClaim) -> Option<&'static str> {
        let queued = self.class.queue.get(&claim.job);
        if let Some(held) = queued.and_then(|queued| queued.held) {
            return Some(held);
        }
        if !self.arm(claim.arm).link {
            return Some("lost");
        }
        self.control.job_hindrance(now, claim).map(reason)
    }

    /// Sends the turns to all sessions if they have changed.
    pub(super) fn notify_turns(&mut self, now: HostInstant) {
        if std::mem::take(&mut self.class.turns_changed) {
            let turns = self.turns(now);
            self.notice_rates.mark_sent(now, Newest::Turns);
            self.notify_all(Notice::TurnChanged, &turns);
        }
    }

    pub(super) fn notify_turn(&mut self, now: HostInstant, effect: Effect) {
        match effect {
            // Sent later: one change often causes several of these effects.
            Effect::Turns => self.class.turns_changed = true,
            Effect::TurnEnding { arm, person, left } => {
                let (arm, person) = (&self.arm(arm).entry.name, self.person_name(person));
                let params = json!({"arm": arm, "person": person, "left_s": left.as_secs_f64()});
                self.notify_all(Notice::TurnEnding, &params);
            }
            Effect::TurnLease {
                arm,
                session,
                lease,
            } => {
                let left = self.control.turn(now, arm).and_then(|(_, left)| left);
                let params = json!({
                    "arm": self.arm(arm).entry.name, "lease": self.lease_id(lease),
                    "ttl_s": LEASE_TIMEOUT.as_secs(), "left_s": left.map(|left| left.as_secs_f64()),
                });
                self.notify(session, Notice::TurnGranted, &params);
            }
            // Not about turns: handled by the caller.
            _ => {}
        }
    }

    /// Returns the arms at which a turn is wanted: the one named, those of a group, those of the
    /// pupil's group, or all.
    pub(super) fn turn_arms(&self, call: &Call<'_>) -> Result<BTreeSet<ArmId>, RpcError> {
        if let Some(arm) = call.arm {
            return Ok(BTreeSet::from([arm]));
        }
        let file = self.class.file.as_ref();
        let asked = call.params.text("group");
        let pupil = self
            .sessions
            .get(&call.session)
            .and_then(|session| session.pupil.as_deref());
        let own = file.and_then(|file| file.named(pupil?)?.group.as_deref());
        let arms = asked.or(own).and_then(|group| file?.groups.get(group));
        if let (Some(group), None) = (asked, arms) {
            let why = message!(
                "no arms belong to the group {group}: [groups] of the class file says which",
                group = magician_protocol::visible(group).to_string()
            );
            return Err(RpcError::param("group", why));
        }
        // No group, or a group without a list: any arm.
        let Some(arms) = arms else {
            return Ok(self.arm_ids().collect());
        };
        let known = arms.iter().filter_map(|arm| self.arm_named(Some(arm)).ok());
        let known: BTreeSet<_> = known.collect();
        if known.is_empty() {
            let group = magician_protocol::visible(asked.or(own).unwrap_or_default());
            let why = message!(
                "the group {group} has no arm at this station",
                group = group.to_string()
            );
            return Err(RpcError::param("group", why));
        }
        Ok(known)
    }

    /// Returns the reason why a session may not have a lease although no other session holds it.
    /// `None` if it may.
    pub(super) fn admission_refusal(
        &self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
    ) -> Option<Message> {
        if self.control.may_hold(now, session, arm) {
            return None;
        }
        if let Some(why) = self.schedule_error_sentence() {
            return Some(why);
        }
        let person = self.control.person(session);
        if let Some(why) = person.and_then(|person| self.barred(arm, person)) {
            return Some(why);
        }
        let name = &self.arm(arm).entry.name;
        Some(match self.control.turn_rules() {
            Some(_) if self.control.person(session).is_none() => {
                message!("turns are of persons: sign in with name and code first")
            }
            Some(_) => message!(
                "it is not your turn at {name}: join the queue, and wait for the turn or for your slot",
                name
            ),
            None => message!("the schedule gives {name} to others now", name),
        })
    }
}

const fn reason(hindrance: Hindrance) -> &'static str {
    match hindrance {
        Hindrance::Frozen => "frozen",
        Hindrance::Schedule => "schedule",
        Hindrance::Turn => "turn",
        Hindrance::Busy => "busy",
        Hindrance::Away => "away",
    }
}

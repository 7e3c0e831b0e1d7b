//! Turns, as clients see them, and the arms that are meant by them.

use std::collections::BTreeSet;

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::Station;
use super::dispatch::Call;
use crate::api::{Notice, RpcError};
use crate::control::{ArmId, Effect, SessionId, TTL, TurnState};

impl Station {
    /// Turns and queue, as clients see them.
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
            json!({
                "arm": self.arm(arm).entry.name,
                "person": turn.map(|(turn, _)| self.person_name(turn.person)),
                "state": state,
                "left_s": left,
                "frozen": self.control.is_frozen(arm),
            })
        });
        let queue = (1..).zip(self.control.places()).map(|(at, place)| {
            let arms: Vec<_> = place.arms.iter().copied().collect();
            json!({
                "place": at, "person": self.person_name(place.person),
                "arms": self.names_of(&arms), "missed": place.missed,
            })
        });
        let queue: Vec<Value> = queue.collect();
        json!({
            "turn_s": rules.map(|rules| rules.length.map_or(0, |length| length.as_secs())),
            "arms": arms.collect::<Vec<_>>(),
            "queue": queue,
        })
    }

    /// Tells all sessions of turns, once all that followed from what happened has followed.
    pub(super) fn tell_turns(&mut self, now: HostInstant) {
        if std::mem::take(&mut self.class.turns_changed) {
            let turns = self.turns(now);
            self.notify_all(Notice::TurnChanged, &turns);
        }
    }

    pub(super) fn tell_turn(&mut self, now: HostInstant, effect: Effect) {
        match effect {
            // One change has several: a turn is kept for a person, who is there and gets the lease.
            Effect::Turns => self.class.turns_changed = true,
            Effect::TurnEnding { arm, person, left } => {
                let (arm, person) = (&self.arm(arm).entry.name, self.person_name(person));
                let told = json!({"arm": arm, "person": person, "left_s": left.as_secs_f64()});
                self.notify_all(Notice::TurnEnding, &told);
            }
            Effect::TurnLease {
                arm,
                session,
                lease,
            } => {
                let left = self.control.turn(now, arm).and_then(|(_, left)| left);
                let told = json!({
                    "arm": self.arm(arm).entry.name, "lease": self.lease_id(lease),
                    "ttl_s": TTL.as_secs(), "left_s": left.map(|left| left.as_secs_f64()),
                });
                self.notify(session, Notice::TurnGranted, &told);
            }
            _ => {}
        }
    }

    /// The arms that a turn is wanted at: one, those of a group, those of the pupil's group, or any.
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
            let group = magician_protocol::visible(group);
            let why = format!(
                "no arms belong to the group {group}: [groups] of the class file says which"
            );
            return Err(RpcError::param("group", why));
        }
        let Some(arms) = arms else {
            return Ok(self.arm_ids().collect());
        };
        let known = arms.iter().filter_map(|arm| self.arm_named(Some(arm)).ok());
        let known: BTreeSet<_> = known.collect();
        if known.is_empty() {
            let group = magician_protocol::visible(asked.or(own).unwrap_or_default());
            let why = format!("the group {group} has no arm at this station");
            return Err(RpcError::param("group", why));
        }
        Ok(known)
    }

    /// Why a session may not have a lease that nobody else keeps it from; none where that is not why.
    pub(super) fn not_admitted(
        &self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
    ) -> Option<String> {
        if self.control.may_hold(now, session, arm) {
            return None;
        }
        let name = &self.arm(arm).entry.name;
        Some(match self.control.turn_rules() {
            Some(_) if self.control.person(session).is_none() => {
                "turns are of persons: sign in with name and code first".to_owned()
            }
            Some(_) => format!(
                "it is not your turn at {name}: join the queue, and wait for the turn or for your slot"
            ),
            None => format!("the schedule gives {name} to others now"),
        })
    }
}

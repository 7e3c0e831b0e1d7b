//! Reports of arms.

use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::calls::line_lost;
use super::{Awaited, Station};
use crate::api::{ArmEvent, Notice, RpcError};
use crate::control::{ArmId, JogEnd, RequestId};
use crate::order::{ArmReport, Outcome, jog_end};

impl Station {
    pub(super) fn take_report(&mut self, now: HostInstant, arm: ArmId, report: ArmReport) {
        match report {
            ArmReport::Done { request, outcome } => self.done(now, arm, request, outcome),
            ArmReport::Reading(reading) => {
                let place = self.arm_mut(arm);
                let read_at = now - reading.age;
                // A reading from before the line broke says nothing about the arm that is connected
                // now.
                if !place.link || read_at < place.link_changed_at {
                    return;
                }
                place.read_at = read_at;
                let mut reading = reading;
                // A single reading, made for an answer, has no pins. The last known ones stay.
                if reading.pins.is_empty()
                    && !place.watched.1.is_empty()
                    && let Some(before) = place.reading.take()
                {
                    reading.pins = before.pins;
                }
                (place.reading, place.state) = (Some(*reading), None);
                self.distribute_reading(now, arm);
                self.record_reading(now, arm);
            }
            ArmReport::Outputs { tool, speed } => {
                let place = self.arm_mut(arm);
                if let Some(reading) = &mut place.reading {
                    (reading.tool, reading.speed) = (tool, speed);
                    place.state = None;
                }
            }
            ArmReport::JogEnded { jog, why } => self.control.note_jog_ended(arm, jog, why),
            ArmReport::Job { job, update } => self.apply_job_update(now, arm, job, update),
            ArmReport::Event { event, fields } => self.event(now, arm, event, fields),
            ArmReport::Surface(surface) => {
                let params = json!({"arm": self.arm(arm).entry.name, "surface": surface});
                self.notify_all(Notice::SurfaceChanged, &params);
            }
            ArmReport::Link(up) => {
                let place = self.arm_mut(arm);
                let was = std::mem::replace(&mut place.link, up);
                if was != up {
                    // Another arm may be behind the line when it is found.
                    (place.reading, place.state) = (None, None);
                    place.link_changed_at = now;
                }
                if was && !up {
                    if let Some((jog, _)) = self.control.jog(arm) {
                        // The arm itself goes on jogging to its limit; no stop can reach it.
                        self.control.note_jog_ended(arm, jog, JogEnd::Link);
                    }
                    self.notify_line_loss(now, arm);
                }
                if was != up {
                    let event = if up {
                        ArmEvent::LinkFound
                    } else {
                        ArmEvent::LinkLost
                    };
                    self.event(now, arm, event, Vec::new());
                }
            }
        }
    }

    fn done(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        request: RequestId,
        outcome: Result<Outcome, RpcError>,
    ) {
        self.finish_long_request(request);
        #[cfg(feature = "class")]
        {
            let value = outcome.as_ref().ok().and_then(|outcome| match outcome {
                Outcome::Value(value) => Some(value),
                Outcome::State => None,
            });
            if self.store_picture(request, value) {
                return;
            }
        }
        let outcome = outcome.and_then(|outcome| match outcome {
            Outcome::Value(value) => Ok(value),
            // The line broke after the reading, so it is no longer the state.
            Outcome::State => self.whole_state(arm).ok_or_else(line_lost),
        });
        let Some(pending) = self.pending.get_mut(&request) else {
            // Answered already, because the lease ended or the arm was stopped.
            self.control.finish(now, arm, request);
            return;
        };
        match &mut pending.awaits {
            Awaited::Stops { .. } => {
                let outcome = match outcome {
                    Ok(stood) => match self.hold_behind_job(now, arm, request, stood) {
                        Some(stood) => Ok(stood),
                        None => return,
                    },
                    Err(error) => Err(error),
                };
                self.stood(now, arm, request, outcome);
            }
            Awaited::Jog(_, jog) => {
                let jog = *jog;
                let id = self.jog_id(jog);
                match outcome {
                    Ok(_) => {
                        // The keep-alive period starts with the answer that carries the id.
                        self.control.note_jog_started(now, jog);
                        self.finish(now, request, Ok(json!({"jog": id})));
                    }
                    Err(error) => {
                        let code = error.data.get("code").and_then(Value::as_str);
                        let why = jog_end(code.unwrap_or_default());
                        self.finish(now, request, Err(error));
                        self.control.note_jog_ended(arm, jog, why);
                    }
                }
            }
            Awaited::Job(_, job, wants) => {
                let (job, wants) = (*job, *wants);
                self.note_job_order_result(now, request, wants, job, outcome);
            }
            Awaited::Arm(_)
            | Awaited::Saved
            | Awaited::Library
            | Awaited::Program(..)
            | Awaited::Lease { .. }
            | Awaited::Record(_) => self.finish(now, request, outcome),
        }
    }
    /// Records that an arm stands after a stop. The request is answered when all its arms do.
    pub(super) fn stood(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        let name = self.arm(arm).entry.name.clone();
        let Some(pending) = self.pending.get_mut(&request) else {
            return;
        };
        let Awaited::Stops { left, arms, failed } = &mut pending.awaits else {
            return;
        };
        left.remove(&arm);
        match outcome {
            Ok(mut stood) => {
                // A stop of several arms has one answer, so each part names its arm.
                if let Value::Object(stood) = &mut stood {
                    stood.insert("arm".to_owned(), name.into());
                }
                arms.push(stood);
            }
            // The answer waits for the other arms even then.
            Err(error) => *failed = Some(error),
        }
        if left.is_empty() {
            let arms = std::mem::take(arms);
            let outcome = match failed.take() {
                Some(error) => Err(error.with("arms", arms)),
                None => Ok(json!({ "arms": arms })),
            };
            self.finish(now, request, outcome);
        }
    }
}

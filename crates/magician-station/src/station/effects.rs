//! Carries out the effects of [`Control`](crate::control::Control): orders, answers, notifications.

use magician::message;
use magician_job::PauseReason;
use magician_protocol::HostInstant;
use serde_json::{Value, json};

use super::{Awaited, Station};
use crate::api::{ArmEvent, Notice, RpcError};
use crate::control::{ArmId, Effect, JogEnd, JogId, LEASE_TIMEOUT, SessionId, WorkEnd};
use crate::order::ArmOrder;

impl Station {
    pub(super) fn carry_out(&mut self, now: HostInstant, effect: Effect) {
        match effect {
            Effect::Granted {
                request,
                arm,
                lease,
            } => {
                let asked = { self.pending.get(&request) }.is_some_and(|pending| {
                    matches!(pending.awaits, Awaited::Lease { asked: true })
                });
                let lease = self.lease_id(lease);
                let ttl = LEASE_TIMEOUT.as_secs();
                // `lease.ask` answers `granted`, the other methods answer with the lease alone or
                // an error.
                let result = if asked {
                    json!({"granted": true, "lease": lease, "ttl_s": ttl})
                } else {
                    json!({"arm": self.arm(arm).entry.name, "lease": lease, "ttl_s": ttl})
                };
                self.finish(now, request, Ok(result));
            }
            Effect::Denied { request, holder } => {
                let Some(pending) = self.pending.get(&request) else {
                    return;
                };
                #[cfg(feature = "class")]
                let admission_refusal = {
                    let line = pending.line.as_ref().and_then(|line| line.arm.as_deref());
                    let arm = self.arm_named(line).ok();
                    let session = self.session_of(pending.socket);
                    { session.zip(arm) }
                        .and_then(|(session, arm)| self.admission_refusal(now, session, arm))
                };
                // The end of the station explains a denial better than any other reason.
                let outcome = match (self.ending_error(), &pending.awaits) {
                    (Some(ends), _) => Err(ends),
                    (None, Awaited::Lease { asked: true }) => Ok(json!({"granted": false})),
                    (None, _) => {
                        let line = pending.line.as_ref().and_then(|line| line.arm.as_deref());
                        let held = self.arm_named(line).ok();
                        let held = held.and_then(|arm| self.holder_sentence(arm, holder));
                        let why = match held {
                            #[cfg(feature = "class")]
                            _ if admission_refusal.is_some() => {
                                admission_refusal.unwrap_or_default()
                            }
                            // Names the holder, whom a person can go and ask.
                            Some(held) => held,
                            None => message!("the lease was not granted"),
                        };
                        let error = RpcError::new(RpcError::LEASE, why);
                        let error = error.with("holder", self.name_of(holder));
                        Err(
                            match holder.and_then(|holder| self.control.back_until(holder)) {
                                // A holder without a socket loses the lease by itself: asking it
                                // would be in vain.
                                Some(until) => error.with("free_in_s", (until - now).as_secs_f64()),
                                None if holder.is_some() => error.with("method", "lease.ask"),
                                None => error,
                            },
                        )
                    }
                };
                self.finish(now, request, outcome);
            }
            Effect::Place {
                session,
                arm,
                place,
            } => {
                let params = json!({"arm": self.arm(arm).entry.name, "place": place});
                self.notify(session, Notice::LeaseQueue, &params);
            }
            Effect::Holder { arm, .. } => {
                let holder = self.holder(arm);
                let params = json!({"arm": self.arm(arm).entry.name, "holder": holder});
                self.notify_all(Notice::LeaseChanged, &params);
                self.event(now, arm, ArmEvent::Lease, vec![("holder", holder)]);
                self.mark_state_changed(arm);
            }
            Effect::Asked {
                arm,
                holder,
                session,
                request,
            } => {
                let message = { self.pending.get(&request) }
                    .and_then(|pending| pending.line.as_ref())
                    .and_then(|line| line.params.get("message").cloned());
                let mut params = self.name_of(Some(session));
                params["arm"] = json!(self.arm(arm).entry.name);
                params["message"] = message.unwrap_or(Value::Null);
                self.notify(holder, Notice::LeaseAsked, &params);
            }
            Effect::EndJog { arm, jog, why } => {
                self.order(arm, ArmOrder::EndJog(jog));
                self.notify_jog_end(now, arm, jog, why);
            }
            Effect::EndGuide { arm } => {
                let (request, on, unhomed) = (None, false, false);
                self.order(
                    arm,
                    ArmOrder::Guide {
                        request,
                        on,
                        unhomed,
                    },
                );
            }
            Effect::EndUnattended { arm } => self.order(arm, ArmOrder::EndUnattended),
            Effect::EndWork {
                arm,
                requests,
                stop,
                why,
            } => {
                if stop {
                    // The stop first, then the answers.
                    self.order(arm, ArmOrder::Stop { request: None });
                    // Only a stop counts: a holder that let go in time was not cut off.
                    self.record_forced_stop(arm);
                }
                for request in requests {
                    let error = self.ended_error(arm, why);
                    self.finish(now, request, Err(error));
                }
                // The stop of a client was logged with its session already.
                if stop && let WorkEnd::Lease(_) = why {
                    self.event(now, arm, ArmEvent::Stop, vec![("by", Value::Null)]);
                }
            }
            Effect::EndJob { arm, job, pause } => {
                let order = if pause {
                    let reason = PauseReason::Lease;
                    ArmOrder::PauseJob {
                        request: None,
                        job,
                        reason,
                    }
                } else {
                    ArmOrder::StopJob(job)
                };
                self.order(arm, order);
            }
            Effect::SessionOver(session) => self.remove_session(session),
            #[cfg(feature = "class")]
            effect @ (Effect::Turns | Effect::TurnEnding { .. } | Effect::TurnLease { .. }) => {
                self.notify_turn(now, effect);
            }
        }
    }

    /// Returns the error for a request that was ended early.
    pub(super) fn ended_error(&self, arm: ArmId, why: WorkEnd) -> RpcError {
        match why {
            WorkEnd::Lease(holder) => {
                if let Some(ends) = self.ending_error() {
                    return ends;
                }
                let name = &self.arm(arm).entry.name;
                let message = message!("the lease of {name} has ended", name);
                let error = RpcError::new(RpcError::LEASE, message);
                error.with("holder", self.name_of(holder))
            }
            WorkEnd::Stop(by) => {
                let message = message!("a stop ended it");
                RpcError::new(RpcError::STOPPED, message).with("by", self.session_id_value(by))
            }
        }
    }

    /// Returns the id of a session as JSON. Null without a session.
    pub(super) fn session_id_value(&self, session: Option<SessionId>) -> Value {
        session.map_or(Value::Null, |session| json!(self.session_id(session)))
    }

    /// Sends the end of a jog.
    fn notify_jog_end(&mut self, now: HostInstant, arm: ArmId, jog: JogId, why: JogEnd) {
        let beginning = self.pending.iter().find_map(|(request, pending)| {
            matches!(pending.awaits, Awaited::Jog(_, id) if id == jog).then_some(*request)
        });
        let id = self.jog_id(jog);
        if let Some(request) = beginning {
            // The jog ended before the arm answered, so its start is answered with an error.
            let error = match why {
                JogEnd::Lease => self.ended_error(arm, WorkEnd::Lease(self.control.holder(arm))),
                JogEnd::Stopped => self.ended_error(arm, WorkEnd::Stop(None)),
                why => {
                    let message =
                        message!("the jog ended as it began: {reason}", reason = why.name());
                    RpcError::new(RpcError::STOPPED, message).with("by", Value::Null)
                }
            };
            self.finish(now, request, Err(error));
        }
        let name = self.arm(arm).entry.name.clone();
        let params = json!({"arm": name, "jog": id, "why": why.name()});
        self.notify_all(Notice::JogEnded, &params);
        let fields = vec![("jog", json!(id)), ("why", json!(why.name()))];
        self.event(now, arm, ArmEvent::Jog, fields);
        self.mark_state_changed(arm);
    }

    /// Appends an event to the log of an arm and sends it to the subscribers.
    pub(super) fn event(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        event: ArmEvent,
        fields: Vec<(&'static str, Value)>,
    ) {
        let t = self.unix(now);
        self.record_event(now, arm, event.name(), &fields);
        let place = self.arm_mut(arm);
        let event = place
            .events
            .push(&place.entry.name, t, event.name(), fields);
        let subscribed = self.sockets.iter().filter(|(_, socket)| {
            { socket.subscriptions.iter() }.any(|subscription| subscription.arm == arm)
        });
        let subscribed: Vec<_> = subscribed.map(|(id, _)| *id).collect();
        let text = Notice::ArmEvent.message(&event);
        for socket in subscribed {
            self.notify_socket(socket, text.clone());
        }
    }
}

//! Dispatch of messages: parsing, the common checks in a fixed order, and the answer.
//!
//! The order of the checks is part of the API, because the first check that fails is the answer:
//! rate, JSON, method, id, hello, parameters, arm, role, requests in flight; then the checks of the
//! method itself. Methods marked `always` (stops, and keeping a jog alive) skip the limits: a
//! client that floods the station can still stop the arm.

use magician::message;
use std::collections::BTreeSet;

use magician_protocol::HostInstant;
use serde_json::Value;

use super::socket::{CloseCode, MAX_MESSAGES_PER_SECOND, MAX_REQUESTS_IN_FLIGHT};
use super::throttle::RateVerdict;
use super::{Awaited, Grant, JournalLine, Pending, SocketId, Station};
use crate::api::{Message, MessageId, Method, Needs, Params, Role, RpcError, answer_due};
use crate::control::{ArmId, Busy, RequestId, SessionId};

/// Result of handling a request.
pub(super) enum Handled {
    /// Answered now.
    Now(Value),
    /// Answered later, under this id.
    Later(RequestId, Awaited),
}

/// Request that has passed the common checks.
pub(super) struct Call<'a> {
    pub(super) now: HostInstant,
    pub(super) socket: SocketId,
    pub(super) session: SessionId,
    pub(super) grant: Grant,
    /// Arm of the request. `None` for methods without an arm, or that mean all.
    pub(super) arm: Option<ArmId>,
    pub(super) params: &'a Params,
    pub(super) request: RequestId,
}

impl Call<'_> {
    /// True if the request confirms a dangerous command.
    pub(super) fn is_confirmed(&self) -> bool {
        self.params.is_on("yes")
    }
}

impl Station {
    /// Processes a message of a socket.
    pub(super) fn handle_message(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        // After a fatal error nothing more is processed, though messages may be in flight.
        if open.outbox.is_closing() {
            return;
        }
        // Every message counts, even without valid JSON.
        let pace = open.count_message(now);
        let session = open.session;
        if let Some(session) = session {
            // Before parsing: even an invalid message proves that the client is alive.
            self.control.keep_alive(now, session);
        }
        let parsed = Message::parse(text);
        let overtakes = matches!(&parsed, Ok(message)
            if Method::named(&message.method).is_some_and(|method| method.always));
        // Stops, and messages that keep a jog alive, are exempt from the rate limit.
        if !overtakes {
            match pace {
                RateVerdict::Accept => {}
                RateVerdict::Refuse => {
                    let why = message!(
                        "more than {rate} messages a second",
                        rate = MAX_MESSAGES_PER_SECOND
                    );
                    let error = RpcError::new(RpcError::TOO_MANY, why)
                        .with("limit", MAX_MESSAGES_PER_SECOND);
                    let id = match &parsed {
                        Ok(message) => message.id.as_ref(),
                        Err(bad) => bad.id.as_ref(),
                    };
                    return self.answer(socket, id, &Err(error));
                }
                // A client that ignored refusals for seconds will not slow down.
                RateVerdict::Close => return self.end_socket(socket, CloseCode::TOO_MANY),
            }
        }
        let message = match parsed {
            Ok(message) => message,
            Err(bad) => {
                self.answer(socket, bad.id.as_ref(), &Err(bad.error));
                // Without a session this is not a client of this API: close the socket.
                if session.is_none() {
                    self.end_socket(socket, CloseCode::BAD_HELLO);
                }
                return;
            }
        };
        self.dispatch(now, socket, message);
    }

    /// Processes the only message of a one-shot socket. Returns true if an answer follows.
    pub(super) fn handle_single_message(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        text: &str,
    ) -> bool {
        let message = match Message::parse(text) {
            Ok(message) => message,
            Err(bad) => {
                self.answer(socket, bad.id.as_ref(), &Err(bad.error));
                return true;
            }
        };
        let answered = message.id.is_some()
            || Method::named(&message.method).is_none_or(|method| !method.always);
        if let Some(method) = Method::named(&message.method)
            && method.session
        {
            let why = message!(
                "{method} needs a session: use a WebSocket",
                method = method.name
            );
            let error = RpcError::request(why).with("method", method.name);
            self.answer(socket, message.id.as_ref(), &Err(error));
            return true;
        }
        match self.join_one_shot(now, socket) {
            Ok(()) => self.dispatch(now, socket, message),
            Err(error) => self.answer(socket, message.id.as_ref(), &Err(error)),
        }
        answered
    }

    pub(super) fn is_one_shot(&self, call: &Call<'_>) -> bool {
        let session = self.sessions.get(&call.session);
        session.is_some_and(|session| session.one_shot)
    }

    /// Acquires the lease for a request without its own session, if the lease is free.
    pub(super) fn acquire_free_lease(&mut self, call: &Call<'_>, arm: ArmId) {
        if self.is_one_shot(call) && self.control.holder(arm).is_none() {
            let request = RequestId(self.next_id());
            self.control.take(call.now, call.session, arm, request);
            self.carry_out_effects(call.now);
        }
    }

    fn dispatch(&mut self, now: HostInstant, socket: SocketId, message: Message) {
        let Message { id, method, params } = message;
        let is_link = self.sockets.get(&socket).is_some_and(|open| open.link);
        let of_link = || Method::of_link(&method).filter(|_| is_link);
        let Some(method) = Method::named(&method).or_else(of_link) else {
            let shown = magician_protocol::visible(&method).to_string();
            let error = RpcError::new(
                RpcError::METHOD,
                message!("unknown method `{shown}`", shown),
            );
            return self.answer(socket, id.as_ref(), &Err(error));
        };
        // A client that forgets the id would never learn of an error.
        if id.is_none() && !method.always {
            let why = format!("{} needs an `id`", method.name);
            return self.answer(socket, None, &Err(RpcError::request(why)));
        }
        if method.name == "session.hello" {
            return self.greet(now, socket, id, params);
        }
        let Some(session) = self.session_of(socket) else {
            let why = message!("`session.hello` comes first");
            let error = RpcError::new(RpcError::FORBIDDEN, why);
            return self.answer(socket, id.as_ref(), &Err(error));
        };
        let request = RequestId(self.next_id());
        // Checked before the rights, so that a wrong parameter is reported by name.
        let params = Params::check(method.params, params);
        let mut line = self.journal_line(now, session, method, params.as_ref().ok());
        // A link translates calls of its program: the journal names the call and not the method.
        let calls = self
            .sockets
            .get_mut(&socket)
            .and_then(|open| open.calls.take());
        if let (Some(line), Some(calls)) = (&mut line, calls) {
            line.method = calls;
        }
        let handled =
            params.and_then(|params| self.handle(now, socket, session, method, &params, request));
        self.conclude(now, socket, id, line, handled);
        // After the answer, so that the client knows the id of its subscription.
        if method.name == "arm.subscribe" {
            self.first_states(now, socket);
        }
    }

    /// Handles `session.hello`, the first message of a socket.
    fn greet(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        id: Option<MessageId>,
        params: serde_json::Map<String, Value>,
    ) {
        if self.session_of(socket).is_some() {
            let error = RpcError::request("`session.hello` came already");
            return self.answer(socket, id.as_ref(), &Err(error));
        }
        let Some(method) = Method::named("session.hello") else {
            return;
        };
        let params = Params::check(method.params, params);
        let shown = params.as_ref().map_or(Value::Null, Params::for_journal);
        let outcome = params.and_then(|params| self.hello(now, socket, &params));
        let session = self.session_of(socket);
        let mut line = self.line(now, session, method.name, shown);
        if let Some(open) = self.sockets.get(&socket) {
            open.peer.address.clone_into(&mut line.peer);
        }
        self.write(now, now, line, &outcome);
        self.answer(socket, id.as_ref(), &outcome);
        if outcome.is_ok() {
            self.notify_end(now, socket);
        } else {
            // Ignored if a more specific code was set before.
            self.end_socket(socket, CloseCode::BAD_HELLO);
        }
    }

    /// Makes the checks after those of the parameters, then calls the method.
    fn handle(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        session: SessionId,
        method: &'static Method,
        params: &Params,
        request: RequestId,
    ) -> Result<Handled, RpcError> {
        // Without the parameter `arm` these methods apply to all arms.
        let arm = match (method.takes_arm(), method.name) {
            (false, _) => None,
            (true, "arm.stop" | "turn.join" | "turn.end" | "turn.next" | "jog.stop")
                if params.text("arm").is_none() =>
            {
                None
            }
            (true, _) => Some(self.arm_named(params.text("arm"))?),
        };
        let grant = { self.sessions.get(&session) }.map(|session| session.grant.clone());
        let grant = grant.ok_or_else(|| RpcError::internal("the session is gone"))?;
        if grant.role < method.role {
            return Err(forbidden(&grant, method.role, method.name));
        }
        // A link has its own limit on unanswered calls, in `magician-link`.
        let open = self.sockets.get(&socket).filter(|open| !open.link);
        let under_way = open.map_or(0, |open| open.under_way);
        if under_way >= MAX_REQUESTS_IN_FLIGHT && !method.always {
            let why = message!(
                "{under_way} requests are under way on this socket",
                under_way = MAX_REQUESTS_IN_FLIGHT
            );
            let error =
                RpcError::new(RpcError::TOO_MANY, why).with("limit", MAX_REQUESTS_IN_FLIGHT);
            return Err(error);
        }
        self.note_message_at_end(now, session, method.name == "arm.stop");
        let call = Call {
            now,
            socket,
            session,
            grant,
            arm,
            params,
            request,
        };
        self.call(method, &call)
    }

    /// Answers a request, or stores it until its answer is known.
    fn conclude(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        id: Option<MessageId>,
        line: Option<JournalLine>,
        handled: Result<Handled, RpcError>,
    ) {
        let outcome = match handled {
            Ok(Handled::Later(request, waits)) => {
                if let Some(open) = self.sockets.get_mut(&socket) {
                    open.under_way += 1;
                }
                let pending = Pending {
                    socket,
                    id,
                    awaits: waits,
                    line,
                    began: now,
                };
                self.pending.insert(request, pending);
                return;
            }
            Ok(Handled::Now(result)) => Ok(result),
            Err(error) => Err(error),
        };
        if let Some(line) = line {
            self.write(now, now, line, &outcome);
        }
        self.answer(socket, id.as_ref(), &outcome);
    }

    /// Answers a stored request.
    pub(super) fn finish(
        &mut self,
        now: HostInstant,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        let Some(pending) = self.pending.remove(&request) else {
            return;
        };
        if let Awaited::Arm(arm) | Awaited::Jog(arm, _) | Awaited::Job(arm, ..) = pending.awaits {
            self.control.finish(now, arm, request);
        }
        if let Some(line) = pending.line {
            self.write(now, pending.began, line, &outcome);
        }
        if let Some(session) = self.session_of(pending.socket) {
            self.note_message_at_end(now, session, false);
        }
        if let Some(open) = self.sockets.get_mut(&pending.socket) {
            // Saturating, because a link does not count.
            open.under_way = open.under_way.saturating_sub(1);
        }
        self.answer(pending.socket, pending.id.as_ref(), &outcome);
    }

    /// Sends an answer, unless the message was a notification.
    fn answer(
        &mut self,
        socket: SocketId,
        id: Option<&MessageId>,
        outcome: &Result<Value, RpcError>,
    ) {
        if let Some(text) = answer_due(id, outcome)
            && let Some(open) = self.sockets.get_mut(&socket)
        {
            open.outbox.answer(text);
            self.awake.insert(socket);
        }
    }

    /// Returns the journal line of a request that is recorded: stops, and everything that needs the
    /// lease or changes rights.
    fn journal_line(
        &self,
        now: HostInstant,
        session: SessionId,
        method: &Method,
        params: Option<&Params>,
    ) -> Option<JournalLine> {
        let sets_fence =
            method.name == "arm.fence" && params.is_some_and(|params| params.get("set").is_some());
        let counts = method.needs != Needs::Nothing
            || sets_fence
            || method.name.starts_with("lease.")
            || method.is_of_class()
            || matches!(method.name, "job.delete" | "job.reorder")
            // `jog.keep` comes many times per second and says nothing new.
            || (method.always && method.name != "jog.keep");
        if !counts {
            return None;
        }
        let shown = params.map_or(Value::Null, Params::for_journal);
        let mut line = self.line(now, Some(session), method.name, shown);
        let named = params.and_then(|params| params.text("arm"));
        let of_job = params.and_then(|params| self.records.find(params.text("job")?));
        // Methods of jobs name the arm through the job.
        let named = named.or_else(|| Some(of_job?.arm.as_str()));
        line.arm = self
            .arm_named(named)
            .ok()
            .map(|arm| self.arm(arm).entry.name.clone());
        Some(line)
    }

    fn write(
        &mut self,
        now: HostInstant,
        began: HostInstant,
        mut line: JournalLine,
        outcome: &Result<Value, RpcError>,
    ) {
        let result = outcome.as_ref().map_or_else(RpcError::outcome, |_| "ok");
        result.clone_into(&mut line.result);
        line.ms = now.micros_since(began) as f64 / 1e3;
        self.lines.push_back(line);
    }

    /// Returns the arm with this name. Without a name, the only arm.
    pub(super) fn arm_named(&self, name: Option<&str>) -> Result<ArmId, RpcError> {
        let found = match name {
            Some(name) => self.arm_ids().find(|arm| self.arm(*arm).entry.name == name),
            None if self.arms.len() == 1 => Some(ArmId(0)),
            None => None,
        };
        found.ok_or_else(|| {
            let names: Vec<_> = self
                .arms
                .iter()
                .map(|arm| arm.entry.name.as_str())
                .collect();
            let names = names.join(", ");
            let message = match name {
                Some(name) => {
                    let name = magician_protocol::visible(name).to_string();
                    message!(
                        "there is no arm `{name}`: the station has {names}",
                        name,
                        names
                    )
                }
                None => message!("`arm` is missing: the station has {names}", names),
            };
            RpcError::param("arm", message)
        })
    }

    /// Converts a refusal of control to an error.
    pub(super) fn refused(&self, arm: ArmId, refusal: crate::control::Refusal) -> RpcError {
        use crate::control::Refusal;
        match refusal {
            Refusal::Lease(holder) => self.lease_error(arm, holder),
            Refusal::Busy(Busy::Job(job)) => {
                let job = self.job_id(job);
                RpcError::new(RpcError::BUSY, message!("a job has the arm")).with("job", job)
            }
            Refusal::Busy(Busy::Jog(jog)) => {
                let jog = self.jog_id(jog);
                RpcError::new(RpcError::BUSY, message!("a jog has the arm")).with("jog", jog)
            }
            #[cfg(feature = "class")]
            Refusal::Frozen => self.frozen(arm),
            Refusal::Closed => self.lease_error(arm, None),
            Refusal::Unknown => RpcError::param("session", message!("that session does not ask")),
        }
    }

    pub(super) fn lease_error(&self, arm: ArmId, holder: Option<SessionId>) -> RpcError {
        if let Some(ends) = self.ending_error() {
            return ends;
        }
        let message = self.holder_sentence(arm, holder).unwrap_or_else(|| {
            let name = &self.arm(arm).entry.name;
            message!("moving {name} needs its lease", name)
        });
        // The method to call is for programs, so it is a field. People read the sentence alone.
        let method = match holder {
            Some(_) => "lease.ask",
            None => "lease.acquire",
        };
        let error = RpcError::new(RpcError::LEASE, message).with("method", method);
        error.with("holder", self.name_of(holder))
    }

    /// Returns a sentence that names the holder of a lease. `None` without a holder.
    pub(super) fn holder_sentence(
        &self,
        arm: ArmId,
        holder: Option<SessionId>,
    ) -> Option<magician::Message> {
        let holder = self.sessions.get(&holder?)?;
        let arm = &self.arm(arm).entry.name;
        Some(message!(
            "{name} has the lease of {arm}",
            name = holder.name,
            arm
        ))
    }

    /// Returns the arm, or all arms if `None`.
    pub(super) fn arm_or_all(&self, arm: Option<ArmId>) -> BTreeSet<ArmId> {
        match arm {
            Some(arm) => BTreeSet::from([arm]),
            None => self.arm_ids().collect(),
        }
    }
}

/// Returns the error for a role that is too low.
pub(super) fn forbidden(
    grant: &Grant,
    needs: Role,
    what: impl Into<magician::Message>,
) -> RpcError {
    RpcError::forbidden(grant.role, needs, what)
}

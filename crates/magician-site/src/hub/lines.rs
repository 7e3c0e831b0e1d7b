//! Lines to stations: opening on demand, hello, probing, messages, loss, and reopening with
//! backoff.

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, Notification, RpcError, notification};
use magician_station::{CloseCode, RateVerdict};
use serde_json::{Value, json};

use super::answers::parse_answer;
use super::requests::encode_request;
use super::socket::{Line, Pending, Purpose, Route, Via};
use super::{Hub, HubAction, LINE_TIMEOUT, LineId, LineMessage, RequestId, SocketId, keys_where};
use crate::site::StationId;

/// Largest message of a station, bytes. Equal to the outbox of a socket, in which the reply has to
/// fit.
const MAX_MESSAGE_SIZE: usize = 8 * 1024 * 1024;
/// Most messages of a station for one client in a second, before the line is closed. A choice: far
/// above the rate of real stations, so only a faulty or hostile one reaches it.
const MAX_MESSAGES_PER_SECOND: usize = 2000;

impl Line {
    /// Time at which the line is given up if nothing arrives. `None` if the station owes no reply.
    pub(super) fn reply_deadline(&self) -> Option<HostInstant> {
        let since = if self.up {
            self.probed
        } else {
            Some(self.opened)
        };
        since.map(|since| since + LINE_TIMEOUT)
    }
}

impl Hub {
    /// Returns the line of a client to a station, and opens it if necessary. Fails during the
    /// backoff after a loss.
    pub(super) fn line_to(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        station: StationId,
    ) -> Result<LineId, RpcError> {
        let gone = || RpcError::arm(ErrorKind::Port, "the station cannot be reached");
        let (slot, _) = *self.stations.get(&station).ok_or_else(gone)?;
        let line = LineId(self.next_id());
        let open = self.sockets.get_mut(&socket).ok_or_else(gone)?;
        let tries = match open.routes.get(&station) {
            Some(Route::Line(line)) => return Ok(*line),
            Some(Route::Waiting { until, why, .. }) if now < *until => return Err(why.clone()),
            Some(Route::Waiting { tries, .. }) => *tries,
            None => 0,
        };
        // Before the hello of the client its rights are unknown.
        if (open.session.is_none() && !open.is_single_request) || open.outbox.is_closing() {
            return Err(gone());
        }
        let made = Line {
            socket,
            station,
            slot,
            opened: now,
            hello: None,
            up: false,
            queue: Default::default(),
            keep_alive_due: false,
            probed: None,
            throttle: Default::default(),
            tries,
            sessions: Value::Null,
            recording: false,
        };
        open.routes.insert(station, Route::Line(line));
        self.lines.insert(line, made);
        self.actions.push_back(HubAction::Open(line, station));
        Ok(line)
    }

    /// A line is open. Sends the hello of its client first.
    pub fn line_opened(&mut self, line: LineId) {
        let Some(known) = self.lines.get(&line) else {
            return self.actions.push_back(HubAction::Drop(line));
        };
        let station = known.station;
        let Some(open) = self.sockets.get(&known.socket) else {
            return;
        };
        let client =
            { open.session.as_ref() }.and_then(|session| self.client_sessions.get(session));
        let name = client.map_or("hub", |client| client.name.as_str());
        // Ask for no more rights than the client has at the hub, even if the station would grant
        // them.
        let mut params = json!({"client": {"name": name}, "role": open.role.name()});
        if let Some(token) = &open.token {
            params["token"] = json!(token);
        }
        if let Some((secret, _)) = client.and_then(|client| client.at.get(&station)) {
            params["resume"] = json!(secret);
        }
        self.request_on_line(line, "session.hello", params, Purpose::LineHello);
    }

    /// Sends a request of the hub itself over a line.
    pub(super) fn request_on_line(
        &mut self,
        line: LineId,
        method: &'static str,
        params: Value,
        purpose: Purpose,
    ) -> Option<RequestId> {
        let method = Method::named(method)?;
        let socket = self.lines.get(&line)?.socket;
        let request = RequestId(self.next_id());
        let text = encode_request(Some(request), method.name, &params);
        let is_hello = matches!(purpose, Purpose::LineHello);
        let pending = Pending {
            socket,
            id: None,
            method,
            arm: None,
            via: Via::Line(line),
            sent: false,
            purpose,
        };
        self.pending.insert(request, pending);
        if !is_hello {
            self.queue(line, Some(request), text, false);
        } else if let Some(open) = self.lines.get_mut(&line) {
            open.hello = Some((request, text));
            self.actions.push_back(HubAction::Awake(line));
        }
        Some(request)
    }

    /// Queues a message on a line. `first` lets it overtake the others.
    pub(super) fn queue(
        &mut self,
        line: LineId,
        request: Option<RequestId>,
        text: String,
        first: bool,
    ) {
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        if first {
            open.queue.push_front((request, text));
        } else {
            open.queue.push_back((request, text));
        }
        self.actions.push_back(HubAction::Awake(line));
    }

    /// Sends a probe to a station, unless one is unanswered.
    pub(super) fn probe(&mut self, now: HostInstant, line: LineId) {
        if let Some(open) = self.lines.get_mut(&line)
            && open.probed.is_none()
        {
            open.probed = Some(now);
            self.request_on_line(line, "server.info", json!({}), Purpose::Probe);
        }
    }

    /// Returns the next message of a line. Call it only when the line can take a message, so that a
    /// stop can still overtake.
    pub fn poll_line(&mut self, line: LineId) -> Option<LineMessage> {
        let open = self.lines.get_mut(&line)?;
        if std::mem::take(&mut open.keep_alive_due) {
            return Some(LineMessage::KeepAlive);
        }
        let hello = open
            .hello
            .take()
            .map(|(request, text)| (Some(request), text));
        let (request, text) = match hello {
            None if open.up => open.queue.pop_front(),
            hello => hello,
        }?;
        if let Some(pending) = request.and_then(|request| self.pending.get_mut(&request)) {
            pending.sent = true;
        }
        Some(LineMessage::Text(text))
    }

    /// Handles a message of a station. A malformed or excessive one ends the line and nothing else.
    pub fn receive_from_line(&mut self, now: HostInstant, line: LineId, text: &str) {
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        let slot = open.slot;
        let over = open.throttle.check(now, MAX_MESSAGES_PER_SECOND) == RateVerdict::Close
            || text.len() > MAX_MESSAGE_SIZE;
        let mut message = match serde_json::from_str::<Value>(text) {
            Ok(Value::Object(message)) if !over => message,
            _ => {
                // Only this client loses the station: other clients have lines of their own.
                let why = "its station does not speak as a station does";
                return self.lose_line(now, line, RpcError::arm(ErrorKind::Unexpected, why));
            }
        };
        if let Some(Value::String(method)) = message.remove("method") {
            let params = message.remove("params").unwrap_or_default();
            return self.handle_notification(now, line, &method, params);
        }
        let Some((request, outcome)) = parse_answer(message) else {
            return;
        };
        // A station may only answer requests that were sent over this line.
        let is_asked = |pending: &Pending| pending.sent && pending.via == Via::Line(line);
        if self.pending.get(&request).is_some_and(is_asked) {
            self.complete(now, request, Some(slot), outcome);
        }
    }

    /// A line has ended or could not be opened.
    pub fn line_ended(&mut self, now: HostInstant, line: LineId, why: &str, code: Option<u16>) {
        let refused = [CloseCode::BAD_TOKEN.0, CloseCode::REVOKED.0];
        let error = if code.is_some_and(|code| refused.contains(&code)) {
            let why = "its station does not take the token of this session";
            RpcError::new(RpcError::FORBIDDEN, why)
        } else if why.is_empty() {
            RpcError::arm(ErrorKind::Port, "its station has ended the connection")
        } else {
            RpcError::arm(ErrorKind::Port, visible(why).to_string())
        };
        self.lose_line(now, line, error);
    }

    /// Gives up a line. Its pending requests fail and are never retransmitted.
    pub(super) fn lose_line(&mut self, now: HostInstant, line: LineId, why: RpcError) {
        let Some(lost) = self.lines.remove(&line) else {
            return;
        };
        self.actions.push_back(HubAction::Drop(line));
        if let Some(open) = self.sockets.get_mut(&lost.socket) {
            // A line that was up restarts the backoff.
            let tries = if lost.up { 0 } else { lost.tries };
            let route = Route::after(now, tries, why.clone());
            open.routes.insert(lost.station, route);
        }
        let arms = self.names.arms_of(lost.slot);
        for request in keys_where(&self.pending, |pending| pending.via == Via::Line(line)) {
            let Some(pending) = self.pending.get(&request) else {
                continue;
            };
            let arm = pending.arm.as_ref().unwrap_or(&arms);
            let end = if pending.sent {
                "whether the request was carried out is not known"
            } else {
                "the request was not sent"
            };
            let message = format!("{arm}: {}; {end}", why.message);
            let error = RpcError {
                message,
                ..why.clone()
            };
            self.complete(now, request, None, Err(error));
        }
        self.lose_subscriptions(now, lost.socket, line);
        if let Some(open) = self.sockets.get_mut(&lost.socket) {
            let jogs = keys_where(&open.jogs, |(_, station)| *station == lost.station);
            for jog in jogs {
                let arm = open.jogs.remove(&jog).map(|(arm, _)| arm);
                let params = json!({"arm": arm, "jog": jog, "why": "link"});
                open.outbox.notice(notification("jog.ended", &params));
                self.awake.insert(lost.socket);
            }
        }
        self.sessions_changed(now, lost.socket);
    }

    /// Times at which lines are opened again after a loss.
    pub(super) fn reopen_times(&self) -> impl Iterator<Item = HostInstant> + '_ {
        let waiting = |route: &Route| match route {
            Route::Waiting { until, .. } => Some(*until),
            Route::Line(_) => None,
        };
        let routes = self.sockets.values().flat_map(|open| open.routes.values());
        routes.filter_map(waiting)
    }

    pub(super) fn reopen_lines(&mut self, now: HostInstant) {
        let is_due = |route: &Route| matches!(route, Route::Waiting { until, .. } if *until <= now);
        let due = self.sockets.iter().flat_map(|(socket, open)| {
            let stations = keys_where(&open.routes, is_due).into_iter();
            stations.map(|station| (*socket, station))
        });
        for (socket, station) in due.collect::<Vec<_>>() {
            if self.line_to(now, socket, station).is_err()
                && let Some(open) = self.sockets.get_mut(&socket)
            {
                open.routes.remove(&station);
            }
        }
    }

    /// Handles the reply of a station to the hello of a line.
    pub(super) fn line_hello_answered(
        &mut self,
        now: HostInstant,
        line: LineId,
        outcome: Result<Value, RpcError>,
    ) {
        let hello = match outcome {
            Ok(hello) => hello,
            Err(mut error) => {
                let why = visible(&error.message);
                error.message = format!("its station refuses the session: {why}");
                return self.lose_line(now, line, error);
            }
        };
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        open.up = true;
        self.actions.push_back(HubAction::Awake(line));
        let session = { self.sockets.get(&open.socket) }.and_then(|open| open.session.as_ref());
        let there = (hello["resume"].as_str(), hello["session"].as_str());
        if let (Some(session), (Some(secret), Some(there))) = (session, there) {
            self.names.record_session(open.slot, there, session);
            if let Some(client) = self.client_sessions.get_mut(session) {
                let at = (secret.to_owned(), there.to_owned());
                client.at.insert(open.station, at);
            }
        }
        self.request_on_line(line, "turn.list", json!({}), Purpose::Turns);
        self.resubscribe(line);
    }

    /// Handles a notification of a station for the client of a line.
    fn handle_notification(
        &mut self,
        now: HostInstant,
        line: LineId,
        method: &str,
        mut params: Value,
    ) {
        let (Some(known), Some(open)) = (Notification::named(method), self.lines.get_mut(&line))
        else {
            return;
        };
        let (slot, socket, station) = (open.slot, open.socket, open.station);
        match method {
            "arm.state" => return self.receive_state(line, params),
            "session.changed" => {
                open.sessions = params["sessions"].take();
                return self.sessions_changed(now, socket);
            }
            // Not forwarded: it concerns one station, and the client would take it for an end of
            // the hub with all arms.
            "server.ending" => return,
            "turn.changed" => return self.note_turns(station, &params),
            _ => {}
        }
        if let Some(path) = known.arm {
            let arm = params.pointer(&format!("/{}", path.replace('.', "/")));
            let arm = arm.and_then(Value::as_str).unwrap_or_default();
            if !self.is_sole_owner(station, arm) {
                return;
            }
        }
        self.names.rename(slot, &mut params, known.ids);
        if let Some(open) = self.sockets.get_mut(&socket) {
            if method == "jog.ended"
                && let Some(jog) = params["jog"].as_str()
            {
                open.jogs.remove(jog);
            }
            open.outbox.notice(notification(method, &params));
            self.awake.insert(socket);
        }
    }
}

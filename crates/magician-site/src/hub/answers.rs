//! Replies to requests that the hub passed on: from home, from lines, and to single requests.

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::CloseCode;
use magician_station::api::RpcError;
use serde_json::{Map, Value, json};

use super::gather::GatherPurpose;
use super::socket::{Pending, Purpose, Via};
use super::{Hub, RequestId, SocketId};
use crate::site::SiteError;

impl Hub {
    /// Handles a message of home for a client.
    pub fn receive_from_home(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        let Ok(Value::Object(mut message)) = serde_json::from_str::<Value>(text) else {
            return;
        };
        let method = message.get("method").and_then(Value::as_str);
        if method == Some("session.changed") {
            let mut params = message.remove("params").unwrap_or_default();
            self.sessions = params["sessions"].take();
            return self.sessions_changed(now, socket);
        }
        let request = message.get("id").and_then(Value::as_u64).map(RequestId);
        let ours = |pending: &Pending| pending.via == Via::Home && pending.socket == socket;
        let is_ours = |id: &RequestId| self.pending.get(id).is_some_and(ours);
        if method.is_none()
            && let Some(request) = request.filter(is_ours)
        {
            if let Some((_, outcome)) = parse_answer(message) {
                self.complete(now, request, None, outcome);
            }
            return;
        }
        if let Some(open) = self.sockets.get_mut(&socket) {
            if method.is_some() {
                open.outbox.notice(text.to_owned());
            } else {
                // Reply to a message that was passed on unchanged: its id is the client's.
                open.outbox.answer(text.to_owned());
            }
            self.awake.insert(socket);
        }
    }

    /// Home closes a client's session. Its lines to stations close too.
    pub fn home_closed(&mut self, socket: SocketId, code: CloseCode) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.close(code);
            self.awake.insert(socket);
        }
        self.drop_lines(socket);
    }

    /// Handles the result of a single request, [`HubAction::Call`](super::HubAction::Call).
    pub fn call_completed(
        &mut self,
        now: HostInstant,
        request: RequestId,
        answer: Result<Option<String>, SiteError>,
    ) {
        let Some(pending) = self.pending.get(&request) else {
            return;
        };
        let Via::Call(station) = pending.via else {
            return;
        };
        let slot = self.stations.get(&station).map(|(slot, _)| *slot);
        let named = pending.arm.clone().unwrap_or_default();
        let outcome = match answer {
            Ok(Some(text)) => {
                let message = serde_json::from_str(&text).ok();
                let answered = message.and_then(parse_answer);
                let answered = answered.filter(|(of, _)| *of == request);
                answered.map(|(_, outcome)| outcome).unwrap_or_else(|| {
                    let why = format!("{named}: the station does not answer as a station does");
                    Err(RpcError::arm(ErrorKind::Unexpected, why))
                })
            }
            Ok(None) => Ok(Value::Null),
            Err(SiteError::Refused(why)) => {
                let why = format!("{named}: the station refuses it: {}", visible(&why));
                Err(RpcError::new(RpcError::FORBIDDEN, why))
            }
            Err(error) => {
                let why = format!("{named}: {}", visible(&error.to_string()));
                Err(RpcError::arm(ErrorKind::Port, why))
            }
        };
        self.complete(now, request, slot, outcome);
    }

    /// Completes a request. `slot` is set if the reply contains ids of a station, which are then
    /// renamed.
    pub(super) fn complete(
        &mut self,
        now: HostInstant,
        request: RequestId,
        slot: Option<u32>,
        outcome: Result<Value, RpcError>,
    ) {
        let Some(mut pending) = self.pending.remove(&request) else {
            return;
        };
        let purpose = std::mem::replace(&mut pending.purpose, Purpose::Nothing);
        let outcome = match (outcome, slot) {
            // Not renamed: the hub needs the station's own ids to resume its session there.
            (outcome, _) if matches!(purpose, Purpose::LineHello) => outcome,
            (Ok(mut value), Some(slot)) => {
                let ids = pending.method.result_ids();
                self.names.rename(slot, &mut value, ids);
                Ok(value)
            }
            (Err(error), Some(slot)) => Err(self.names.rename_error(slot, error)),
            (outcome, None) => outcome,
        };
        match (purpose, pending.via) {
            (Purpose::Answer, _) => self.send_answer(&pending, outcome),
            (Purpose::Hello(name, token), _) => {
                self.hello_answered(now, &pending, name, token, outcome)
            }
            (Purpose::LineHello, Via::Line(line)) => self.line_hello_answered(now, line, outcome),
            (Purpose::Probe, Via::Line(line)) => {
                if let Some(open) = self.lines.get_mut(&line) {
                    open.probed = None;
                    open.recording = outcome.is_ok_and(|info| info["recording"] == true);
                }
            }
            (Purpose::Turns, Via::Line(line)) => {
                if let (Some(line), Ok(turns)) = (self.lines.get(&line), outcome) {
                    self.note_turns(line.station, &turns);
                }
            }
            (Purpose::Part(gather), _) => self.store_part(now, gather, request, outcome),
            (Purpose::Subscribe(params), Via::Line(line)) => {
                self.subscribed(line, &pending, params, outcome);
            }
            (Purpose::Resubscribe(id), Via::Line(line)) => {
                self.resubscribed(line, pending.socket, id, outcome);
            }
            (Purpose::Program(call), _) => self.program_fetched(now, call, outcome),
            (Purpose::Sessions(mut call), _) => {
                if let Ok(mut home) = outcome {
                    self.sessions = home["sessions"].take();
                }
                self.request_finished(call.socket);
                call.now = now;
                let _ = self.gather_all(call, GatherPurpose::Sessions, "session.list");
            }
            // `Purpose::Nothing`. The other purposes occur only with the paths above.
            _ => {}
        }
    }

    /// Sends the reply to the client, with the changes that the hub has to make or remember.
    fn send_answer(&mut self, pending: &Pending, mut outcome: Result<Value, RpcError>) {
        match (pending.method.name, pending.via, &mut outcome) {
            // Home has no arms: put in those of the site.
            ("server.info", _, Ok(info)) => {
                info["arms"] = json!(self.arms.keys().collect::<Vec<_>>());
                let mut lines = self.lines.values();
                info["recording"] = json!(lines.any(|line| line.recording));
            }
            // Remember the jog, so that its end can be reported if the line is lost.
            ("jog.start", Via::Line(line), Ok(started)) => {
                if let Some(jog) = started["jog"].as_str()
                    && let Some(line) = self.lines.get(&line)
                    && let Some(open) = self.sockets.get_mut(&pending.socket)
                {
                    let arm = pending.arm.clone().unwrap_or_default();
                    open.jogs.insert(jog.to_owned(), (arm, line.station));
                }
            }
            _ => {}
        }
        self.finish(pending.socket, pending.id.as_ref(), &outcome);
    }
}

/// Parses a reply into its request and outcome. Returns `None` if it is malformed.
pub(super) fn parse_answer(
    mut message: Map<String, Value>,
) -> Option<(RequestId, Result<Value, RpcError>)> {
    let request = RequestId(message.get("id")?.as_u64()?);
    let outcome = match (message.remove("result"), message.remove("error")) {
        (Some(result), None) => Ok(result),
        (None, Some(error)) => Err(RpcError::from_value(error)?),
        // JSON-RPC allows exactly one of result and error.
        _ => return None,
    };
    Some((request, outcome))
}

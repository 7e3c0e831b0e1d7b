//! Lines to stations: opened when they are needed, found again, and what comes by them.

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, Notification, RpcError, notification};
use magician_station::{CloseCode, Pace};
use serde_json::{Map, Value, json};

use super::requests::text_of;
use super::socket::{Line, Pending, Via, Wants, Way};
use super::{Hub, HubAct, LineId, LineMessage, RequestId, SILENT, SocketId};
use crate::site::{SiteError, StationId};

/// Bytes of a message of a station, at most: its answers wait in as much.
const LARGEST: usize = 8 * 1024 * 1024;
/// Messages of a station for one client in any second.
const RATE: usize = 2000;

impl Line {
    /// When it is given up, if nothing comes until then.
    pub(super) fn silent_at(&self) -> Option<HostInstant> {
        if self.up {
            self.probed.map(|at| at + SILENT)
        } else {
            Some(self.opened + SILENT)
        }
    }
}

impl Hub {
    /// The line of a client to a station, opened if it has none.
    pub(super) fn line_to(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        station: StationId,
    ) -> Result<LineId, RpcError> {
        let gone = || RpcError::arm(ErrorKind::Port, "the station cannot be reached");
        let slot = self.stations.get(&station).map(|(slot, _)| *slot);
        let slot = slot.ok_or_else(gone)?;
        let open = self.sockets.get(&socket).ok_or_else(gone)?;
        let tries = match open.ways.get(&station) {
            Some(Way::Line(line)) => return Ok(*line),
            Some(Way::Waiting { until, why, .. }) if now < *until => return Err(why.clone()),
            Some(Way::Waiting { tries, .. }) => *tries,
            None => 0,
        };
        if (open.session.is_none() && !open.once) || open.outbox.is_closing() {
            return Err(gone());
        }
        let line = LineId(self.next_id());
        let made = Line {
            socket,
            station,
            slot,
            opened: now,
            up: false,
            queue: Default::default(),
            held: Default::default(),
            alive: false,
            probed: None,
            throttle: Default::default(),
            tries,
            sessions: Value::Null,
            recording: false,
        };
        self.lines.insert(line, made);
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.ways.insert(station, Way::Line(line));
        }
        self.acts.push_back(HubAct::Open(line, station));
        Ok(line)
    }

    /// A line is there: the hello of its client goes first.
    pub fn line_opened(&mut self, line: LineId) {
        let Some(known) = self.lines.get(&line) else {
            return self.acts.push_back(HubAct::Drop(line));
        };
        let (socket, station) = (known.socket, known.station);
        let Some(open) = self.sockets.get(&socket) else {
            return;
        };
        let person = { open.session.as_ref() }.and_then(|session| self.people.get(session));
        let name = person.map_or("hub", |person| person.name.as_str());
        // Not more than here, whatever the station would allow.
        let mut params = json!({"client": {"name": name}, "role": open.role.name()});
        if let Some(token) = &open.token {
            params["token"] = json!(token);
        }
        if let Some((secret, _)) = person.and_then(|person| person.at.get(&station)) {
            params["resume"] = json!(secret);
        }
        let params = params.as_object().cloned().unwrap_or_default();
        self.ask_line(line, "session.hello", params, Wants::LineHello);
    }

    /// A request of the hub's own by a line.
    pub(super) fn ask_line(
        &mut self,
        line: LineId,
        method: &'static str,
        params: Map<String, Value>,
        wants: Wants,
    ) -> Option<RequestId> {
        let method = Method::named(method)?;
        let socket = self.lines.get(&line)?.socket;
        let request = RequestId(self.next_id());
        let text = text_of(Some(request), method.name, &params);
        let pending = Pending {
            socket,
            id: None,
            method,
            arm: None,
            via: Via::Line(line),
            sent: false,
            wants,
        };
        let is_hello = method.name == "session.hello";
        self.pending.insert(request, pending);
        if is_hello && let Some(line) = self.lines.get_mut(&line) {
            line.queue.push_back((Some(request), text));
            self.acts.push_back(HubAct::Awake(self.line_of(request)?));
        } else {
            self.queue(line, request, text, false);
        }
        Some(request)
    }

    fn line_of(&self, request: RequestId) -> Option<LineId> {
        match self.pending.get(&request)?.via {
            Via::Line(line) => Some(line),
            _ => None,
        }
    }

    /// What is to be sent by a line; what overtakes goes first.
    pub(super) fn queue(&mut self, line: LineId, request: RequestId, text: String, first: bool) {
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        let queue = if open.up {
            &mut open.queue
        } else {
            &mut open.held
        };
        if first {
            queue.push_front((Some(request), text));
        } else {
            queue.push_back((Some(request), text));
        }
        self.acts.push_back(HubAct::Awake(line));
    }

    /// Asks a station for a word, unless it owes one.
    pub(super) fn probe(&mut self, now: HostInstant, line: LineId) {
        if let Some(open) = self.lines.get_mut(&line)
            && open.probed.is_none()
        {
            open.probed = Some(now);
            self.ask_line(line, "server.info", Map::new(), Wants::Probe);
        }
    }

    /// What a line carries next. Ask when it can take it.
    pub fn poll_line(&mut self, line: LineId) -> Option<LineMessage> {
        let open = self.lines.get_mut(&line)?;
        if std::mem::take(&mut open.alive) {
            return Some(LineMessage::Alive);
        }
        let (request, text) = open.queue.pop_front()?;
        if let Some(pending) = request.and_then(|request| self.pending.get_mut(&request)) {
            pending.sent = true;
        }
        Some(LineMessage::Text(text))
    }

    /// A message of a station by a line. Nothing that a station sends does more than end its own line.
    pub fn line_says(&mut self, now: HostInstant, line: LineId, text: &str) {
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        let over = open.throttle.hears(now, RATE) == Pace::Close || text.len() > LARGEST;
        let message = match serde_json::from_str::<Value>(text) {
            Ok(Value::Object(message)) if !over => message,
            _ => {
                let why = "its station does not speak as a station does";
                return self.lose_line(now, line, RpcError::arm(ErrorKind::Unexpected, why));
            }
        };
        let (slot, socket) = (open.slot, open.socket);
        match message.get("method").and_then(Value::as_str) {
            Some(method) => {
                let params = message.get("params").cloned().unwrap_or_default();
                self.hears_notice(now, line, method, params);
            }
            None => {
                let Some((request, outcome)) = answered(message) else {
                    return;
                };
                // An answer to what another one was asked is none.
                if self.line_of(request) == Some(line)
                    && self
                        .pending
                        .get(&request)
                        .is_some_and(|pending| pending.sent && pending.socket == socket)
                {
                    self.outcome(now, request, Some(slot), outcome);
                }
            }
        }
    }

    /// A frame of a station by a line.
    pub fn line_shows(&mut self, line: LineId, bytes: &[u8]) {
        self.hears_frame(line, bytes);
    }

    /// A line has ended, or was not opened.
    pub fn line_ended(&mut self, now: HostInstant, line: LineId, why: &str, code: Option<u16>) {
        let (kind, why) = match code {
            Some(code) if [CloseCode::TOKEN.0, CloseCode::REVOKED.0].contains(&code) => {
                let error = "its station does not take the token of this session";
                return self.lose_line(now, line, RpcError::new(RpcError::FORBIDDEN, error));
            }
            _ if why.is_empty() => (
                ErrorKind::Port,
                "its station has ended the connection".to_owned(),
            ),
            _ => (ErrorKind::Port, visible(why).to_string()),
        };
        self.lose_line(now, line, RpcError::arm(kind, why));
    }

    /// A line is given up: what waits for an answer gets none, and nothing of it is sent again.
    pub(super) fn lose_line(&mut self, now: HostInstant, line: LineId, why: RpcError) {
        let Some(lost) = self.lines.remove(&line) else {
            return;
        };
        self.acts.push_back(HubAct::Drop(line));
        let tries = if lost.up { 0 } else { lost.tries };
        if let Some(open) = self.sockets.get_mut(&lost.socket) {
            let way = Way::after(now, tries, why.clone());
            open.ways.insert(lost.station, way);
        }
        let of =
            |(id, pending): (&RequestId, &Pending)| (pending.via == Via::Line(line)).then_some(*id);
        let arms = self.names.arms_of(lost.slot);
        for request in self.pending.iter().filter_map(of).collect::<Vec<_>>() {
            let sent = self
                .pending
                .get(&request)
                .is_some_and(|pending| pending.sent);
            let mut error = why.clone();
            let arm = self
                .pending
                .get(&request)
                .and_then(|pending| pending.arm.clone());
            let arm = arm.unwrap_or_else(|| arms.clone());
            error.message = if sent {
                format!(
                    "{arm}: {}; whether the request was carried out is not known",
                    why.message
                )
            } else {
                format!("{arm}: {}; the request was not sent", why.message)
            };
            self.outcome(now, request, None, Err(error));
        }
        self.lose_subscriptions(now, lost.socket, line);
        let Some(open) = self.sockets.get_mut(&lost.socket) else {
            return;
        };
        let of = |(_, station): &(String, StationId)| *station == lost.station;
        let jogs = open.jogs.iter().filter(|(_, jog)| of(jog));
        let jogs: Vec<_> = jogs
            .map(|(id, (arm, _))| (id.clone(), arm.clone()))
            .collect();
        for (jog, arm) in jogs {
            open.jogs.remove(&jog);
            let params = json!({"arm": arm, "jog": jog, "why": "link"});
            open.outbox.notice(notification("jog.ended", &params));
            self.awake.insert(lost.socket);
        }
        self.sessions_changed(now, lost.socket);
    }

    /// When a line is opened again.
    pub(super) fn opens_at(&self) -> impl Iterator<Item = HostInstant> + '_ {
        let waiting = |way: &Way| match way {
            Way::Waiting { until, .. } => Some(*until),
            Way::Line(_) => None,
        };
        self.sockets
            .values()
            .flat_map(move |open| open.ways.values().filter_map(waiting))
    }

    pub(super) fn open_again(&mut self, now: HostInstant) {
        let mut due = Vec::new();
        for (socket, open) in &self.sockets {
            for (station, way) in &open.ways {
                if matches!(way, Way::Waiting { until, .. } if *until <= now) {
                    due.push((*socket, *station));
                }
            }
        }
        for (socket, station) in due {
            if self.line_to(now, socket, station).is_err()
                && let Some(open) = self.sockets.get_mut(&socket)
            {
                open.ways.remove(&station);
            }
        }
    }

    /// A message of home for a client.
    pub fn home_says(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        let Ok(Value::Object(message)) = serde_json::from_str::<Value>(text) else {
            return;
        };
        match message.get("method").and_then(Value::as_str) {
            Some("session.changed") => {
                self.sessions = message["params"]["sessions"].clone();
                self.sessions_changed(now, socket);
            }
            Some(_) => {
                if let Some(open) = self.sockets.get_mut(&socket) {
                    open.outbox.notice(text.to_owned());
                    self.awake.insert(socket);
                }
            }
            None => {
                let request = message.get("id").and_then(Value::as_u64).map(RequestId);
                let ours = |pending: &Pending| pending.via == Via::Home && pending.socket == socket;
                match request.filter(|id| self.pending.get(id).is_some_and(ours)) {
                    Some(request) => {
                        if let Some((_, outcome)) = answered(message) {
                            self.outcome(now, request, None, outcome);
                        }
                    }
                    // To what was passed on as it came: its id is the client's.
                    None => {
                        if let Some(open) = self.sockets.get_mut(&socket) {
                            open.outbox.answer(text.to_owned());
                            self.awake.insert(socket);
                        }
                    }
                }
            }
        }
    }

    /// Home ends a session: so do the stations.
    pub fn home_closes(&mut self, socket: SocketId, code: CloseCode) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.close(code);
            self.awake.insert(socket);
        }
        self.drop_lines(socket);
    }

    /// What became of a request beside all lines.
    pub fn called(
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
            Ok(Some(text)) => match serde_json::from_str::<Value>(&text) {
                Ok(Value::Object(message)) => answered(message)
                    .filter(|(of, _)| *of == request)
                    .map(|(_, outcome)| outcome),
                _ => None,
            },
            Ok(None) => Some(Ok(Value::Null)),
            Err(SiteError::Refused(why)) => {
                let why = format!("{named}: the station refuses it: {}", visible(&why));
                Some(Err(RpcError::new(RpcError::FORBIDDEN, why)))
            }
            Err(error) => {
                let why = format!("{named}: {}", visible(&error.to_string()));
                Some(Err(RpcError::arm(ErrorKind::Port, why)))
            }
        };
        let outcome = outcome.unwrap_or_else(|| {
            let why = format!("{named}: the station does not answer as a station does");
            Err(RpcError::arm(ErrorKind::Unexpected, why))
        });
        self.outcome(now, request, slot, outcome);
    }

    /// What became of a request, by ids of a station if one says it.
    pub(super) fn outcome(
        &mut self,
        now: HostInstant,
        request: RequestId,
        slot: Option<u32>,
        outcome: Result<Value, RpcError>,
    ) {
        let Some(pending) = self.pending.remove(&request) else {
            return;
        };
        if let (Wants::LineHello, Via::Line(line)) = (&pending.wants, pending.via) {
            return self.line_greeted(now, line, outcome);
        }
        let outcome = match (outcome, slot) {
            (Ok(mut value), Some(slot)) => {
                self.names
                    .rename(slot, &mut value, pending.method.result_ids());
                Ok(value)
            }
            (Err(error), Some(slot)) => Err(self.names.rename_error(slot, error)),
            (outcome, None) => outcome,
        };
        let Pending { wants, .. } = pending;
        let pending = |wants| Pending { wants, ..pending };
        match wants {
            Wants::Answer => self.answers(pending(Wants::Answer), outcome),
            Wants::Hello(name, token) => {
                self.greeted(now, pending(Wants::Nothing), name, token, outcome)
            }
            Wants::Probe => {
                let Via::Line(line) = pending(Wants::Nothing).via else {
                    return;
                };
                if let Some(open) = self.lines.get_mut(&line) {
                    open.probed = None;
                    open.recording = outcome.is_ok_and(|info| info["recording"] == true);
                }
            }
            Wants::Part(gather) => self.part(now, gather, request, outcome),
            Wants::Subscribe(params) => self.subscribed(pending(Wants::Nothing), params, outcome),
            Wants::Resubscribe(id) => self.subscribed_again(pending(Wants::Nothing), id, outcome),
            Wants::Program(station, params) => {
                self.fetched(now, pending(Wants::Nothing), station, params, outcome);
            }
            Wants::Nothing | Wants::LineHello => {}
        }
    }

    /// The answer to a request of a client.
    fn answers(&mut self, pending: Pending, mut outcome: Result<Value, RpcError>) {
        if let (Ok(value), Some(open)) = (&mut outcome, self.sockets.get_mut(&pending.socket)) {
            match (pending.method.name, pending.via) {
                ("server.info", _) => {
                    value["arms"] = json!(self.arms.keys().collect::<Vec<_>>());
                    let mut lines = self.lines.values();
                    value["recording"] = json!(lines.any(|line| line.recording));
                }
                ("jog.start", Via::Line(line)) => {
                    let station = self.lines.get(&line).map(|line| line.station);
                    if let (Some(jog), Some(station)) = (value["jog"].as_str(), station) {
                        let arm = pending.arm.clone().unwrap_or_default();
                        open.jogs.insert(jog.to_owned(), (arm, station));
                    }
                }
                _ => {}
            }
        }
        self.finish(pending.socket, pending.id.as_ref(), &outcome);
    }

    /// Home has answered the hello of a client.
    fn greeted(
        &mut self,
        now: HostInstant,
        pending: Pending,
        name: String,
        token: Option<String>,
        mut outcome: Result<Value, RpcError>,
    ) {
        let socket = pending.socket;
        let mut stations = Vec::new();
        if let Ok(hello) = &mut outcome {
            let names: Vec<_> = self.arms.keys().collect();
            hello["arms"] = json!(names);
            hello["limits"]["rate"] = json!(magician_station::RATE + 2 * names.len());
            let session = hello["session"].as_str().unwrap_or_default().to_owned();
            let role = hello["role"]
                .as_str()
                .and_then(magician_station::Role::named);
            let person = self.people.entry(session.clone()).or_default();
            (person.name, person.gone) = (name, None);
            // Where it had sessions before it came back, its leases wait.
            stations.extend(person.at.keys().copied());
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.session = Some(session);
                open.role = role.unwrap_or(magician_station::Role::Viewer);
                // A token that is given counts; clients of this machine have the hub's.
                open.token = token.or(open.bearer.clone()).or(self.token.clone());
            }
        }
        self.finish(socket, pending.id.as_ref(), &outcome);
        for station in stations {
            let _ = self.line_to(now, socket, station);
        }
    }

    /// A station has answered the hello of a line.
    fn line_greeted(&mut self, now: HostInstant, line: LineId, outcome: Result<Value, RpcError>) {
        let Some(open) = self.lines.get_mut(&line) else {
            return;
        };
        let hello = match outcome {
            Ok(hello) => hello,
            Err(mut error) => {
                error.message = format!(
                    "its station refuses the session: {}",
                    visible(&error.message)
                );
                return self.lose_line(now, line, error);
            }
        };
        open.up = true;
        let held = std::mem::take(&mut open.held);
        open.queue.extend(held);
        let (socket, station, slot) = (open.socket, open.station, open.slot);
        self.acts.push_back(HubAct::Awake(line));
        let session = { self.sockets.get(&socket) }.and_then(|open| open.session.clone());
        let there = (hello["resume"].as_str(), hello["session"].as_str());
        if let (Some(session), (Some(secret), Some(there))) = (session, there) {
            self.names.is_own(slot, there, &session);
            if let Some(person) = self.people.get_mut(&session) {
                let at = (secret.to_owned(), there.to_owned());
                person.at.insert(station, at);
            }
        }
        self.subscribe_again(line);
    }

    /// A notification of a station, for the client of a line.
    fn hears_notice(&mut self, now: HostInstant, line: LineId, method: &str, mut params: Value) {
        let (Some(known), Some(open)) = (Notification::named(method), self.lines.get_mut(&line))
        else {
            return;
        };
        let (slot, socket, station) = (open.slot, open.socket, open.station);
        match method {
            "arm.state" => return self.hears_state(line, params),
            "session.changed" => {
                open.sessions = params["sessions"].take();
                return self.sessions_changed(now, socket);
            }
            // These are about this station alone, and the client is the hub's: it would take them for all arms.
            "server.ending" | "turn.changed" => return,
            _ => {}
        }
        // A station has a say on its own arms alone.
        let place = known
            .arm
            .map(|place| format!("/{}", place.replace('.', "/")));
        if let Some(place) = place {
            let arm = params
                .pointer(&place)
                .and_then(Value::as_str)
                .unwrap_or_default();
            if !self.has_alone(station, arm) {
                return;
            }
        }
        self.names.rename(slot, &mut params, known.ids);
        if method == "jog.ended"
            && let (Some(open), Some(jog)) = (self.sockets.get_mut(&socket), params["jog"].as_str())
        {
            open.jogs.remove(jog);
        }
        self.notice(socket, method, &params);
    }

    /// Whether an arm is of this station, and of no other.
    pub(super) fn has_alone(&self, station: StationId, arm: &str) -> bool {
        let place = self.arms.get(arm);
        place.is_some_and(|place| place.at.len() == 1 && place.at.contains_key(&station))
    }
}

/// The request that a message answers, and how.
fn answered(mut message: Map<String, Value>) -> Option<(RequestId, Result<Value, RpcError>)> {
    let request = RequestId(message.get("id")?.as_u64()?);
    let outcome = match (message.remove("result"), message.remove("error")) {
        (Some(result), None) => Ok(result),
        (None, Some(error)) => Err(RpcError::from_value(error)?),
        _ => return None,
    };
    Some((request, outcome))
}

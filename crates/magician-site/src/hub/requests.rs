//! From a client's message to whom it goes.

use magician::ErrorKind;
use magician_protocol::{HostInstant, visible};
use magician_station::api::{IdKind, Message, MessageId, Method, Needs, Params, RpcError};
use magician_station::{CloseCode, MESSAGE, Pace, RATE, UNDER_WAY};
use serde_json::{Map, Value, json};

use super::socket::{Pending, Socket, Via, Wants};
use super::{Hub, HubAct, LineId, RequestId, SocketId};
use crate::site::{ArmAt, StationId};

/// A request that has passed its checks.
#[derive(Debug)]
pub(super) struct Call {
    pub(super) now: HostInstant,
    pub(super) socket: SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) method: &'static Method,
    pub(super) params: Map<String, Value>,
}

/// What becomes of a request: an answer now, or later.
type Handled = Result<Option<Value>, RpcError>;

impl Hub {
    /// Whether home answers a method as it is: it is about no arm, and about nothing of one.
    #[must_use]
    pub fn is_of_home(method: &str) -> bool {
        Method::named(method).is_none_or(|method| {
            let of_class = OF_CLASS.iter().any(|of| method.name.starts_with(of));
            let merged = of_class || MERGED.contains(&method.name);
            !method.takes_arm() && method.id_param().is_none() && !merged
        })
    }

    /// A text message of a client.
    pub fn receive(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        self.handle_timeout(now);
        let rate = RATE + 2 * self.arms.len();
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if open.outbox.is_closing() {
            return;
        }
        let pace = open.throttle.hears(now, rate);
        let greeted = open.session.is_some() || open.once;
        let parsed = Message::parse(text);
        let named = parsed
            .as_ref()
            .ok()
            .and_then(|message| Method::named(&message.method));
        // As at a station: stops, and what keeps a jog up, are obeyed in any number.
        if !named.is_some_and(|method| method.always) {
            match pace {
                Pace::Fine => {}
                Pace::TooMany => {
                    let why = format!("more than {rate} messages a second");
                    let error = RpcError::new(RpcError::TOO_MANY, why).with("limit", rate);
                    let id = match &parsed {
                        Ok(message) => message.id.as_ref(),
                        Err(bad) => bad.id.as_ref(),
                    };
                    return self.respond(socket, id, &Err(error));
                }
                Pace::Close => {
                    open.outbox.close(CloseCode::TOO_MANY);
                    self.awake.insert(socket);
                    return;
                }
            }
        }
        let (message, method) = match (parsed, named) {
            (Ok(message), Some(method)) if greeted || method.name == "session.hello" => {
                (message, method)
            }
            // What is no request, and what comes before hello, home has the words for.
            _ => {
                self.acts.push_back(HubAct::Home(socket, text.to_owned()));
                return;
            }
        };
        if message.id.is_none() && !method.always {
            let why = format!("{} needs an `id`", method.name);
            return self.respond(socket, None, &Err(RpcError::request(why)));
        }
        let Message { id, params, .. } = message;
        let call = Call {
            now,
            socket,
            id: id.clone(),
            method,
            params,
        };
        match self.handle(call) {
            Ok(None) => {}
            Ok(Some(value)) => self.respond(socket, id.as_ref(), &Ok(value)),
            Err(error) => self.respond(socket, id.as_ref(), &Err(error)),
        }
    }

    fn handle(&mut self, mut call: Call) -> Handled {
        let method = call.method;
        if method.name == "session.hello" {
            return self.greet(call);
        }
        let params = Params::check(method.params, std::mem::take(&mut call.params))?;
        let Some(open) = self.sockets.get(&call.socket) else {
            return Ok(None);
        };
        if open.role < method.role {
            return Err(RpcError::forbidden(open.role, method.role, method.name));
        }
        let arm = params.text("arm").map(str::to_owned);
        if method.name == "arm.state"
            && let Some(state) = self.state_now(call.now, &self.station_of(arm.as_deref())?)
        {
            return state.map(Some);
        }
        if open.under_way >= UNDER_WAY && !method.always {
            let why = format!("{UNDER_WAY} requests are under way on this socket");
            return Err(RpcError::new(RpcError::TOO_MANY, why).with("limit", UNDER_WAY));
        }
        call.params = params.into_map();
        match method.name {
            "arm.list" => Ok(self.list_arms(&call)),
            "session.list" => Ok(self.list_sessions(&call)),
            "class.send" if call.params.contains_key("program") => {
                let of = self.stations.iter().next();
                let station = of.map_or(StationId(0), |(station, _)| *station);
                let arm = String::new();
                self.fetch_program(call, &ArmAt { arm, station })
            }
            "class.freeze" | "class.free" | "class.send" => self.by_arms(&call),
            "class.codes" => Err(self.at_station(method.name, None)),
            name if name.starts_with("turn.") => Err(self.at_station(name, arm.as_deref())),
            "schedule.set" => self.set_schedule(call),
            "class.results" | "class.get" | "class.set" | "schedule.get" => self.of_class(call),
            "arm.stop" => self.stop(&call, arm.as_deref()),
            "arm.unsubscribe" => self.unsubscribe(&call),
            _ if Self::is_of_home(method.name) || method.name == "server.info" => {
                self.ask_home(&call, Wants::Answer);
                Ok(None)
            }
            // The jog says more than the arm, which need not be named then.
            "jog.stop" if call.params.contains_key("jog") => self.of_id(call),
            _ if method.takes_arm() => self.of_arm(call, arm.as_deref()),
            _ => self.of_id(call),
        }
    }

    /// The first message of a client.
    fn greet(&mut self, call: Call) -> Handled {
        let token = call
            .params
            .get("token")
            .and_then(Value::as_str)
            .map(str::to_owned);
        let name = call
            .params
            .get("client")
            .and_then(|client| client["name"].as_str());
        let name = visible(name.unwrap_or_default().trim()).to_string();
        if call.params.contains_key("pupil") {
            let why = format!("pupils sign in {}", self.page_of(None));
            return Err(RpcError::param("pupil", why));
        }
        self.ask_home(&call, Wants::Hello(name, token));
        Ok(None)
    }

    /// Home answers.
    pub(super) fn ask_home(&mut self, call: &Call, wants: Wants) {
        let request = self.pends(call, None, Via::Home, wants);
        let text = text_of(Some(request), call.method.name, &call.params);
        self.acts.push_back(HubAct::Home(call.socket, text));
    }

    /// The arm that is meant, and its station.
    pub(super) fn station_of(&self, arm: Option<&str>) -> Result<ArmAt, RpcError> {
        let known = match arm {
            Some(arm) => self.arms.get_key_value(arm),
            None if self.arms.len() == 1 => self.arms.first_key_value(),
            None => None,
        };
        let Some((arm, place)) = known else {
            let names = self.arm_names().join(", ");
            let why = match arm {
                Some(arm) => format!("there is no arm `{}`: the site has {names}", visible(arm)),
                None => format!("`arm` is missing: the site has {names}"),
            };
            return Err(RpcError::param("arm", why));
        };
        let mut at = place.at.keys();
        match (at.next(), at.next()) {
            (Some(station), None) => Ok(ArmAt {
                arm: arm.clone(),
                station: *station,
            }),
            (None, _) => {
                let why = format!("the station of {arm} cannot be reached");
                Err(RpcError::arm(ErrorKind::Port, why))
            }
            _ => {
                let why = format!("two stations have an arm named {arm}: only a stop reaches both");
                Err(RpcError::arm(ErrorKind::Port, why))
            }
        }
    }

    fn of_arm(&mut self, mut call: Call, arm: Option<&str>) -> Handled {
        let at = self.station_of(arm)?;
        call.params.insert("arm".to_owned(), json!(at.arm));
        match call.method.name {
            "arm.subscribe" => {
                let wants = Wants::Subscribe(call.params.clone());
                self.pass_on(&call, &at, wants)
            }
            "lease.answer" => {
                let id = self.id_there(&call, at.station, IdKind::Session, "session")?;
                call.params.insert("session".to_owned(), json!(id));
                self.pass_on(&call, &at, Wants::Answer)
            }
            "job.start" | "job.check" if call.params.contains_key("program") => {
                self.fetch_program(call, &at)
            }
            _ => self.pass_on(&call, &at, Wants::Answer),
        }
    }

    /// What is about a lease, a jog or a job: its id tells the station.
    fn of_id(&mut self, mut call: Call) -> Handled {
        let Some((param, kind)) = call.method.id_param() else {
            return Err(RpcError::new(
                RpcError::INTERNAL,
                format!("{} does nothing", call.method.name),
            ));
        };
        let id = call
            .params
            .get(param)
            .and_then(Value::as_str)
            .unwrap_or_default();
        let unknown = || RpcError::param(param, format!("there is no such {param}"));
        let (slot, station, _) = self.names.split(id).ok_or_else(unknown)?;
        let Some(station) = station else {
            let why = format!(
                "the station of {} cannot be reached",
                self.names.arms_of(slot)
            );
            return Err(RpcError::arm(ErrorKind::Port, why));
        };
        let there = self.id_there(&call, station, kind, param)?;
        call.params.insert(param.to_owned(), json!(there));
        // Any of its arms leads to a station.
        let arm = self
            .stations
            .get(&station)
            .and_then(|(_, arms)| arms.first().cloned());
        let arm = arm.unwrap_or_default();
        self.pass_on(&call, &ArmAt { arm, station }, Wants::Answer)
    }

    /// An id as the station has it.
    fn id_there(
        &self,
        call: &Call,
        station: StationId,
        kind: IdKind,
        param: &str,
    ) -> Result<String, RpcError> {
        let id = call
            .params
            .get(param)
            .and_then(Value::as_str)
            .unwrap_or_default();
        if kind == IdKind::Session
            && let Some(person) = self.people.get(id)
            && let Some((_, session)) = person.at.get(&station)
        {
            return Ok(session.clone());
        }
        match self.names.split(id) {
            Some((_, Some(of), there)) if of == station => Ok(there.to_owned()),
            _ => Err(RpcError::param(param, format!("there is no such {param}"))),
        }
    }

    /// Sends a request on: beside all lines where it overtakes or has no session, else by the client's line.
    pub(super) fn pass_on(&mut self, call: &Call, at: &ArmAt, wants: Wants) -> Handled {
        let calls = self.sockets.get(&call.socket).is_some_and(Socket::calls);
        if calls || (call.method.always && !call.method.session) {
            self.call_beside(call, at, wants);
            return Ok(None);
        }
        let line = self.line_to(call.now, call.socket, at.station)?;
        self.send_on(call, at, line, wants)?;
        Ok(None)
    }

    /// A request by itself.
    pub(super) fn call_beside(&mut self, call: &Call, at: &ArmAt, wants: Wants) -> RequestId {
        let request = self.pends(call, Some(at.arm.clone()), Via::Call(at.station), wants);
        let text = text_of(Some(request), call.method.name, &call.params);
        let token = self
            .sockets
            .get(&call.socket)
            .and_then(|open| open.token.clone());
        self.acts.push_back(HubAct::Call {
            request,
            socket: call.socket,
            at: at.clone(),
            token,
            text,
            ends: !call.method.always,
        });
        request
    }

    /// A request by a line.
    pub(super) fn send_on(
        &mut self,
        call: &Call,
        at: &ArmAt,
        line: LineId,
        wants: Wants,
    ) -> Result<(), RpcError> {
        // The keep of a jog that waits says what another one would.
        let is_keep = call.method.name == "jog.keep" && call.id.is_none();
        let text = |request| text_of(request, call.method.name, &call.params);
        if is_keep {
            let text = text(None);
            if let Some(open) = self.lines.get_mut(&line)
                && !open.queue.iter().any(|(_, waiting)| *waiting == text)
            {
                open.queue.push_back((None, text));
                self.acts.push_back(HubAct::Awake(line));
            }
            return Ok(());
        }
        let request = RequestId(self.ids + 1);
        let message = text(Some(request));
        if message.len() > MESSAGE {
            let why = "the message is larger than a station takes: 1 MiB";
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        }
        let request = self.pends(call, Some(at.arm.clone()), Via::Line(line), wants);
        self.queue(line, request, message, call.method.always);
        Ok(())
    }

    /// Remembers a request that is sent on.
    fn pends(&mut self, call: &Call, arm: Option<String>, via: Via, wants: Wants) -> RequestId {
        let request = RequestId(self.next_id());
        let counts = !matches!(wants, Wants::Part(_) | Wants::Nothing);
        if counts && let Some(open) = self.sockets.get_mut(&call.socket) {
            open.under_way += 1;
        }
        let pending = Pending {
            socket: call.socket,
            id: call.id.clone(),
            method: call.method,
            arm,
            via,
            sent: matches!(via, Via::Call(_)),
            wants,
        };
        self.pending.insert(request, pending);
        request
    }

    /// The program of a job lies in the hub's library: it goes along as bytes.
    fn fetch_program(&mut self, mut call: Call, at: &ArmAt) -> Handled {
        let name = call.params.remove("program");
        if let Some(other) = ["text", "data"]
            .into_iter()
            .find(|name| call.params.contains_key(*name))
        {
            let why = format!("one of `program` and `{other}` has to be given");
            return Err(RpcError::param("program", why));
        }
        let params = std::mem::take(&mut call.params);
        call.params
            .insert("name".to_owned(), name.unwrap_or_default());
        let wants = Wants::Program(at.station, params);
        let request = self.pends(&call, Some(at.arm.clone()), Via::Home, wants);
        let text = text_of(Some(request), "program.get", &call.params);
        self.acts.push_back(HubAct::Home(call.socket, text));
        Ok(None)
    }

    /// The program of a job is there, or is not.
    pub(super) fn fetched(
        &mut self,
        now: HostInstant,
        pending: Pending,
        station: StationId,
        mut params: Map<String, Value>,
        outcome: Result<Value, RpcError>,
    ) {
        let socket = pending.socket;
        let program = match outcome {
            Ok(program) => program,
            Err(mut error) => {
                if error.data.get("param").is_some_and(|param| param == "name") {
                    error = error.with("param", "program");
                } else if error
                    .data
                    .get("kind")
                    .is_some_and(|kind| kind == ErrorKind::InvalidInput.name())
                {
                    let why = "the program is too large to be sent to another station, which takes 700 KiB: keep it in the library of the arm's own station, and start it there";
                    error = RpcError::arm(ErrorKind::InvalidInput, why);
                }
                return self.finish(socket, pending.id.as_ref(), &Err(error));
            }
        };
        params.insert("data".to_owned(), program["data"].clone());
        if !params.contains_key("format") && program["format"].is_string() {
            params.insert("format".to_owned(), program["format"].clone());
        }
        let (id, arm) = (pending.id, pending.arm.unwrap_or_default());
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.under_way = open.under_way.saturating_sub(1);
        }
        let call = Call {
            now,
            socket,
            id: id.clone(),
            method: pending.method,
            params,
        };
        let outcome = match call.method.name {
            "class.send" => self.by_arms(&call),
            _ => self.pass_on(&call, &ArmAt { arm, station }, Wants::Answer),
        };
        if let Err(error) = outcome {
            self.respond(socket, id.as_ref(), &Err(error));
        }
    }

    /// Whether a request moves, or may: what was handed over before a stop does not go out after it.
    pub(super) fn is_ended_by_stop(pending: &Pending, arm: &str, of_station: bool) -> bool {
        let of_arm = match (&pending.arm, pending.method.takes_arm()) {
            (Some(of), true) => of == arm,
            // A job is named by its id alone: it may be of this arm.
            _ => of_station,
        };
        of_arm && matches!(pending.method.needs, Needs::Lease(_))
    }
}

/// Answered from the answers of several stations.
const MERGED: [&str; 3] = ["session.list", "server.info", "arm.list"];
/// Groups of methods that are about the class of all stations.
const OF_CLASS: [&str; 3] = ["class.", "schedule.", "turn."];

/// A request as text.
pub(super) fn text_of(
    request: Option<RequestId>,
    method: &str,
    params: &Map<String, Value>,
) -> String {
    match request {
        Some(RequestId(id)) => {
            json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params})
        }
        None => json!({"jsonrpc": "2.0", "method": method, "params": params}),
    }
    .to_string()
}

//! Dispatch of client requests: to home, to the station of an arm or id, or to several stations.

use magician::ErrorKind;
use magician_protocol::HostInstant;
use magician_station::api::{IdKind, Message, MessageId, Method, Params, RpcError};
use magician_station::{
    CloseCode, MAX_MESSAGE_SIZE, MAX_MESSAGES_PER_SECOND, MAX_REQUESTS_IN_FLIGHT, RateVerdict,
};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::gather::GatherPurpose;
use super::socket::{Pending, Purpose, Socket, Via};
use super::{Hub, HubAction, LineId, RequestId, SocketId};
use crate::site::{ArmAt, StationId};

/// Request of a client that passed the checks of its shape.
#[derive(Clone, Debug)]
pub(super) struct Call {
    pub(super) now: HostInstant,
    pub(super) socket: SocketId,
    pub(super) id: Option<MessageId>,
    pub(super) method: &'static Method,
    pub(super) params: Map<String, Value>,
}

/// Outcome of a request: the reply, or `None` if it follows later.
pub(super) type Handled = Result<Option<Value>, RpcError>;

impl Call {
    fn text(&self, name: &str) -> Option<&str> {
        self.params.get(name).and_then(Value::as_str)
    }

    /// Record of this request while its reply is outstanding elsewhere.
    fn pending(&self, arm: Option<&str>, via: Via, purpose: Purpose) -> Pending {
        Pending {
            socket: self.socket,
            id: self.id.clone(),
            method: self.method,
            arm: arm.map(str::to_owned),
            via,
            sent: matches!(via, Via::Call(_)),
            purpose,
        }
    }
}

impl Hub {
    /// True if home answers the method unchanged, because it concerns no arm and nothing that
    /// belongs to one.
    #[must_use]
    pub fn is_home_method(method: &str) -> bool {
        Method::named(method).is_none_or(|method| {
            let of_all = SITE_METHOD_PREFIXES
                .iter()
                .any(|of| method.name.starts_with(of));
            let merged = of_all || MERGED_METHODS.contains(&method.name);
            !method.takes_arm() && method.id_param().is_none() && !merged
        })
    }

    /// Handles a text message of a client.
    pub fn receive(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        self.handle_timeout(now);
        // A client of a hub watches more arms than a client of a station.
        let rate = MAX_MESSAGES_PER_SECOND + 2 * self.arms.len();
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if open.outbox.is_closing() {
            return;
        }
        let pace = open.throttle.check(now, rate);
        let greeted = open.session.is_some() || open.is_single_request;
        let parsed = Message::parse(text);
        let named = parsed
            .as_ref()
            .ok()
            .and_then(|message| Method::named(&message.method));
        // Stops and jog keep-alives are exempt from the rate limit, as at a station.
        if !named.is_some_and(|method| method.always) {
            match pace {
                RateVerdict::Accept => {}
                RateVerdict::Refuse => {
                    let why = format!("more than {rate} messages a second");
                    let error = RpcError::new(RpcError::TOO_MANY, why).with("limit", rate);
                    let id = match &parsed {
                        Ok(message) => message.id.as_ref(),
                        Err(bad) => bad.id.as_ref(),
                    };
                    return self.respond(socket, id, &Err(error));
                }
                RateVerdict::Close => {
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
            // Home knows the errors for malformed messages and for messages before the hello.
            _ => {
                self.actions
                    .push_back(HubAction::Home(socket, text.to_owned()));
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
            return self.handle_hello(&call);
        }
        let params = Params::check(method.params, std::mem::take(&mut call.params))?;
        let Some(open) = self.sockets.get_mut(&call.socket) else {
            return Ok(None);
        };
        if open.role < method.role {
            return Err(RpcError::forbidden(open.role, method.role, method.name));
        }
        open.lists_all_arms |= method.name == "arm.list";
        let is_full = open.in_flight >= MAX_REQUESTS_IN_FLIGHT && !method.always;
        let arm = params.text("arm").map(str::to_owned);
        if method.name == "arm.state"
            && let Some(state) = self.state_now(call.now, &self.station_of(arm.as_deref())?)
        {
            return state.map(Some);
        }
        if is_full {
            let why = format!("{MAX_REQUESTS_IN_FLIGHT} requests are under way on this socket");
            return Err(
                RpcError::new(RpcError::TOO_MANY, why).with("limit", MAX_REQUESTS_IN_FLIGHT)
            );
        }
        call.params = params.into_map();
        match method.name {
            "arm.list" => self.gather_all(call, GatherPurpose::Arms, method.name),
            "session.list" => {
                self.request_home(&call, Purpose::Sessions(call.clone()));
                Ok(None)
            }
            "class.send" if call.params.contains_key("program") => self.fetch_program(call, None),
            "class.freeze" | "class.free" | "class.send" => self.call_by_arms(call),
            "class.get" | "schedule.get" => {
                self.gather_all(call, GatherPurpose::Alike, method.name)
            }
            "class.results" => self.gather_all(call, GatherPurpose::Results, method.name),
            "class.set" => self.gather_all(call, GatherPurpose::Class, "class.get"),
            "schedule.set" => self.set_schedule(call),
            "site.roster" => self.gather_all(call, GatherPurpose::Roster, method.name),
            "site.expect" => {
                let params = call.params.clone();
                let purpose = GatherPurpose::Everywhere(Vec::new());
                let mut addressed = self.addressed(None);
                // Do not wait for missing arms: this request may remove them from the roster.
                addressed.unreachable.clear();
                self.gather(call, purpose, method.name, params, addressed)
            }
            "class.codes" => Err(self.station_only_error(method.name, None)),
            name if name.starts_with("turn.") => Err(self.station_only_error(name, arm.as_deref())),
            "arm.stop" => self.stop(call, arm.as_deref()),
            "arm.unsubscribe" => self.unsubscribe(&call),
            name if Self::is_home_method(name) || name == "server.info" => {
                self.request_home(&call, Purpose::Answer);
                Ok(None)
            }
            // A jog id determines the arm, so `arm` may be missing.
            "jog.stop" if call.params.contains_key("jog") => self.handle_for_id(call),
            _ if method.takes_arm() => self.handle_for_arm(call, arm.as_deref()),
            // Methods of leases, jogs and jobs: the prefix of the id names the station.
            _ => self.handle_for_id(call),
        }
    }

    /// Passes a request to home.
    pub(super) fn request_home(&mut self, call: &Call, purpose: Purpose) {
        let request = self.add_pending(call.pending(None, Via::Home, purpose));
        let text = encode_request(Some(request), call.method.name, &call.params);
        self.actions.push_back(HubAction::Home(call.socket, text));
    }

    fn handle_for_arm(&mut self, mut call: Call, arm: Option<&str>) -> Handled {
        let at = self.station_of(arm)?;
        call.params.insert("arm".to_owned(), json!(at.arm));
        let purpose = match call.method.name {
            "arm.subscribe" => Purpose::Subscribe(call.params.clone()),
            "lease.answer" => {
                let id = self.id_at_station(&call, at.station, IdKind::Session, "session")?;
                call.params.insert("session".to_owned(), json!(id));
                Purpose::Answer
            }
            "job.start" | "job.check" if call.params.contains_key("program") => {
                return self.fetch_program(call, Some(&at.arm));
            }
            _ => Purpose::Answer,
        };
        self.forward(&call, &at, purpose)
    }

    /// Passes on a request about a lease, jog or job. The prefix of its id determines the station.
    fn handle_for_id(&mut self, mut call: Call) -> Handled {
        let Some((param, kind)) = call.method.id_param() else {
            let why = format!("{} does nothing", call.method.name);
            return Err(RpcError::new(RpcError::INTERNAL, why));
        };
        let known = self.names.split(call.text(param).unwrap_or_default());
        let (slot, station, _) = known.ok_or_else(|| unknown(param))?;
        let Some(station) = station else {
            let arms = self.names.arms_of(slot);
            let why = format!("the station of {arms} cannot be reached");
            return Err(RpcError::arm(ErrorKind::Port, why));
        };
        let there = self.id_at_station(&call, station, kind, param)?;
        call.params.insert(param.to_owned(), json!(there));
        // A request needs the name of some arm to find the station; any of them will do.
        let arm = self.any_arm(station).unwrap_or_default();
        self.forward(&call, &ArmAt { arm, station }, Purpose::Answer)
    }

    /// Translates an id of the hub to the id at the station.
    fn id_at_station(
        &self,
        call: &Call,
        station: StationId,
        kind: IdKind,
        param: &str,
    ) -> Result<String, RpcError> {
        let id = call.text(param).unwrap_or_default();
        if kind == IdKind::Session
            && let Some(client) = self.client_sessions.get(id)
            && let Some((_, session)) = client.at.get(&station)
        {
            return Ok(session.clone());
        }
        match self.names.split(id) {
            Some((_, Some(of), there)) if of == station => Ok(there.to_owned()),
            _ => Err(unknown(param)),
        }
    }

    /// Passes a request to a station: as a single request if it must overtake others or its client
    /// has no session, otherwise over the client's line.
    fn forward(&mut self, call: &Call, at: &ArmAt, purpose: Purpose) -> Handled {
        let is_single = self
            .sockets
            .get(&call.socket)
            .is_some_and(Socket::sends_single_requests);
        if is_single || (call.method.always && !call.method.session) {
            self.forward_single(call, at, purpose);
            return Ok(None);
        }
        let line = self.line_to(call.now, call.socket, at.station)?;
        self.forward_on_line(call, at, line, purpose)?;
        Ok(None)
    }

    /// Sends a single request, outside of all lines.
    pub(super) fn forward_single(
        &mut self,
        call: &Call,
        at: &ArmAt,
        purpose: Purpose,
    ) -> RequestId {
        let request = self.add_pending(call.pending(Some(&at.arm), Via::Call(at.station), purpose));
        let open = self.sockets.get(&call.socket);
        self.actions.push_back(HubAction::Call {
            request,
            socket: call.socket,
            at: at.clone(),
            token: open.and_then(|open| open.token.clone()),
            text: encode_request(Some(request), call.method.name, &call.params),
            ends: !call.method.always,
        });
        request
    }

    /// Sends a request over a line.
    fn forward_on_line(
        &mut self,
        call: &Call,
        at: &ArmAt,
        line: LineId,
        purpose: Purpose,
    ) -> Result<(), RpcError> {
        let text = |request| encode_request(request, call.method.name, &call.params);
        // Keep-alives of a jog are identical: one in the queue is enough, and more would only delay
        // a stop.
        if call.method.name == "jog.keep" && call.id.is_none() {
            let keep = (None, text(None));
            let open = self.lines.get(&line);
            if open.is_some_and(|open| !open.queue.contains(&keep)) {
                self.queue(line, None, keep.1, false);
            }
            return Ok(());
        }
        let text = text(Some(RequestId(self.ids + 1)));
        if text.len() > MAX_MESSAGE_SIZE {
            let why = "the message is larger than a station takes: 1 MiB";
            return Err(RpcError::arm(ErrorKind::InvalidInput, why));
        }
        let request = self.add_pending(call.pending(Some(&at.arm), Via::Line(line), purpose));
        self.queue(line, Some(request), text, call.method.always);
        Ok(())
    }

    /// Records a request that is passed on.
    fn add_pending(&mut self, pending: Pending) -> RequestId {
        let request = RequestId(self.next_id());
        if pending.purpose.is_client_request()
            && let Some(open) = self.sockets.get_mut(&pending.socket)
        {
            open.in_flight += 1;
        }
        self.pending.insert(request, pending);
        request
    }

    /// Fetches the program of a job from the hub's library. Stations have other libraries, so they
    /// get its bytes.
    fn fetch_program(&mut self, mut call: Call, arm: Option<&str>) -> Handled {
        let name = call.params.remove("program");
        let mut others = ["text", "data"].into_iter();
        if let Some(other) = others.find(|name| call.params.contains_key(*name)) {
            let why = format!("one of `program` and `{other}` has to be given");
            return Err(RpcError::param("program", why));
        }
        let socket = call.socket;
        let mut pending = call.pending(arm, Via::Home, Purpose::Nothing);
        pending.purpose = Purpose::Program(call);
        let request = self.add_pending(pending);
        let text = encode_request(Some(request), "program.get", &json!({"name": name}));
        self.actions.push_back(HubAction::Home(socket, text));
        Ok(None)
    }

    /// Continues a request once its program has been fetched, or fails it.
    pub(super) fn program_fetched(
        &mut self,
        now: HostInstant,
        mut call: Call,
        outcome: Result<Value, RpcError>,
    ) {
        self.request_finished(call.socket);
        let (socket, id) = (call.socket, call.id.clone());
        let outcome = outcome.map_err(|mut error| {
            if error.data.get("param") == Some(&json!("name")) {
                error = error.with("param", "program");
            } else if error.data.get("kind") == Some(&json!(ErrorKind::InvalidInput.name())) {
                error.message = "the program is too large to be sent to another station, which takes 700 KiB: keep it in the library of the arm's own station, and start it there".to_owned();
            }
            error
        });
        let outcome = outcome.and_then(|program| {
            call.now = now;
            call.params
                .insert("data".to_owned(), program["data"].clone());
            if !call.params.contains_key("format") && program["format"].is_string() {
                call.params
                    .insert("format".to_owned(), program["format"].clone());
            }
            if call.method.name == "class.send" {
                return self.call_by_arms(call);
            }
            let arm = call.text("arm").map(str::to_owned);
            self.handle_for_arm(call, arm.as_deref())
        });
        if let Err(error) = outcome {
            self.respond(socket, id.as_ref(), &Err(error));
        }
    }
}

fn unknown(param: &str) -> RpcError {
    RpcError::param(param, format!("there is no such {param}"))
}

/// Methods whose reply is merged from several stations.
const MERGED_METHODS: [&str; 3] = ["session.list", "server.info", "arm.list"];
/// Prefixes of methods that concern all stations.
const SITE_METHOD_PREFIXES: [&str; 4] = ["class.", "schedule.", "site.", "turn."];

/// Encodes a request. Without an id it is a notification.
pub(super) fn encode_request(
    request: Option<RequestId>,
    method: &str,
    params: &impl Serialize,
) -> String {
    let mut text = json!({"jsonrpc": "2.0", "method": method, "params": params});
    if let Some(RequestId(id)) = request {
        text["id"] = json!(id);
    }
    text.to_string()
}

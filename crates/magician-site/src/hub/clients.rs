//! Clients of the hub: they come with a hello, leave, and see who else is there.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, Role, RpcError};
use magician_station::{CloseCode, LIST_INTERVAL, RATE, SOCKETS};
use serde_json::{Value, json};

use super::requests::{Call, Handled};
use super::socket::{Pending, Socket, Wants};
use super::{Hub, HubAct, SESSIONS, SocketId, keys_where};
use crate::site::StationId;

/// Time that sessions at stations wait for a client that comes back; stations have 5 s.
pub(super) const RESUMES: Duration = Duration::from_secs(6);

/// A session of the hub, as stations know it.
#[derive(Debug, Default)]
pub(super) struct Person {
    pub(super) name: String,
    /// Where it has a session: the secret to come back with, and its id there.
    pub(super) at: BTreeMap<StationId, (String, String)>,
    pub(super) gone: Option<HostInstant>,
    /// The role of the socket that it left with.
    left_as: Option<Role>,
}

impl Hub {
    /// A client connects, with the token of its request if it has one.
    pub fn open(&mut self, bearer: Option<String>) -> SocketId {
        // Until home says what it is.
        self.opened(Socket::new(bearer, Role::Viewer, false))
    }

    /// A client connects for one request, which it may make by this role.
    pub fn open_once(&mut self, bearer: Option<String>, role: Role) -> SocketId {
        let token = bearer.or_else(|| self.token.clone());
        self.opened(Socket::new(token, role, true))
    }

    fn opened(&mut self, socket: Socket) -> SocketId {
        let id = SocketId(self.next_id());
        self.sockets.insert(id, socket);
        id
    }

    /// A client is gone, or was closed.
    pub fn close(&mut self, now: HostInstant, socket: SocketId) {
        self.drop_lines(socket);
        let Some(gone) = self.sockets.remove(&socket) else {
            return;
        };
        self.pending.retain(|_, pending| pending.socket != socket);
        self.gathers
            .retain(|_, gather| gather.call.socket != socket);
        let Some(session) = gone.session else {
            return;
        };
        // Another socket of the same session may have taken it over.
        let taken = |other: &Socket| other.session.as_ref() == Some(&session);
        if !self.sockets.values().any(taken)
            && let Some(person) = self.people.get_mut(&session)
        {
            (person.gone, person.left_as) = (Some(now), Some(gone.role));
            self.bound_gone();
        }
    }

    /// Bounds those who may come back, as a station does: the least role ends first, and of it who left first.
    fn bound_gone(&mut self) {
        let gone = self.people.iter().filter_map(|(id, person)| {
            let gone = person.gone?;
            Some((person.left_as, gone, id.clone()))
        });
        let gone: Vec<_> = gone.collect();
        if gone.len() > SOCKETS
            && let Some((_, _, first)) = gone.into_iter().min()
        {
            self.forget(&first);
        }
    }

    /// A session does not come back.
    pub(super) fn forget(&mut self, session: &str) {
        self.people.remove(session);
        self.names.forget(session);
    }

    /// The lines of a client end, whatever they wait for.
    pub(super) fn drop_lines(&mut self, socket: SocketId) {
        for line in keys_where(&self.lines, |line| line.socket == socket) {
            self.lines.remove(&line);
            self.acts.push_back(HubAct::Drop(line));
        }
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.ways.clear();
        }
    }

    /// The answer of a client to a ping, which its stations hear: a holder without a word for five seconds loses its lease.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        for line in keys_where(&self.lines, |line| line.socket == socket && line.up) {
            self.probe(now, line);
            if let Some(line) = self.lines.get_mut(&line) {
                line.alive = true;
            }
            self.acts.push_back(HubAct::Awake(line));
        }
    }

    /// The first message of a client.
    pub(super) fn greet(&mut self, call: &Call) -> Handled {
        if call.params.contains_key("pupil") {
            // After the answer, which says why; as at a station that does not know the pupil.
            if let Some(open) = self.sockets.get_mut(&call.socket) {
                open.outbox.close(CloseCode::TOKEN);
            }
            let (page, machines) = self.page_of(None);
            let error = RpcError::param("pupil", format!("pupils sign in {page}"));
            return Err(error.with("machines", machines));
        }
        let token = call.params.get("token").and_then(Value::as_str);
        let client = call.params.get("client");
        let name = client.and_then(|client| client["name"].as_str());
        let name = visible(name.unwrap_or_default().trim()).to_string();
        self.ask_home(call, Wants::Hello(name, token.map(str::to_owned)));
        Ok(None)
    }

    /// Home has answered the hello of a client.
    pub(super) fn greeted(
        &mut self,
        now: HostInstant,
        pending: &Pending,
        name: String,
        token: Option<String>,
        mut outcome: Result<Value, RpcError>,
    ) {
        let socket = pending.socket;
        let mut stations = Vec::new();
        if let Ok(hello) = &mut outcome {
            let names: Vec<_> = self.arms.keys().collect();
            hello["arms"] = json!(names);
            hello["limits"]["rate"] = json!(RATE + 2 * names.len());
            hello["hub"] = json!(true);
            let session = hello["session"].as_str().unwrap_or_default().to_owned();
            let person = self.people.entry(session.clone()).or_default();
            (person.name, person.gone) = (name, None);
            // Where it had sessions before it came back, its leases wait.
            stations.extend(person.at.keys().copied());
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.session = Some(session);
                let role = hello["role"].as_str().and_then(Role::named);
                open.role = role.unwrap_or(Role::Viewer);
                // A token that is given counts; clients of this machine have the hub's.
                open.token = token.or(open.token.take()).or(self.token.clone());
            }
        }
        self.finish(socket, pending.id.as_ref(), &outcome);
        for station in stations {
            let _ = self.line_to(now, socket, station);
        }
    }

    /// The sessions as they were told last.
    pub(super) fn known_sessions(&self, socket: SocketId) -> Value {
        let ids = Method::named("session.list").map_or(&[][..], Method::result_ids);
        let lines = self.lines.values();
        let lines = lines.filter(|line| line.socket == socket && line.up);
        self.merged_sessions(lines.map(|line| {
            let mut part = json!({"sessions": line.sessions});
            self.names.rename(line.slot, &mut part, ids);
            part["sessions"].take()
        }))
    }

    /// One list: a client of the hub is in it once, with its leases at all stations.
    pub(super) fn merged_sessions(&self, parts: impl Iterator<Item = Value>) -> Value {
        let mut all: Vec<Value> = Vec::new();
        let parts = std::iter::once(self.sessions.clone()).chain(parts);
        for session in parts.flat_map(|part| match part {
            Value::Array(sessions) => sessions,
            _ => Vec::new(),
        }) {
            let mut known = all.iter_mut();
            let known = known.find(|one| one["session"] == session["session"]);
            match known.map(|known| &mut known["leases"]) {
                Some(Value::Array(leases)) => {
                    leases.extend(session["leases"].as_array().into_iter().flatten().cloned());
                }
                Some(_) => {}
                None => all.push(session),
            }
        }
        json!({ "sessions": all })
    }

    /// The sessions have changed: a client hears of it once, however often they did, and five times a second at most.
    pub(super) fn sessions_changed(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.session.is_some()
        {
            open.list_waits = true;
            self.tell_sessions(now, socket);
        }
    }

    /// Tells a client of the sessions, if that is due.
    pub(super) fn tell_sessions(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.list_due().is_some_and(|due| due <= now)
        {
            (open.list_waits, open.listed) = (false, Some(now));
            if open.outbox.state_due(SESSIONS) {
                self.awake.insert(socket);
            }
        }
    }
}

impl Socket {
    /// When it is to be sent the list of sessions. `None` if it has the newest.
    pub(super) fn list_due(&self) -> Option<HostInstant> {
        let next = self.listed.map(|listed| listed + LIST_INTERVAL);
        self.list_waits.then(|| next.unwrap_or(HostInstant::ZERO))
    }
}

//! Clients of the hub: hello, keep-alive, disconnection, and the list of sessions.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::{HostInstant, visible};
use magician_station::api::{Method, Role, RpcError};
use magician_station::{CloseCode, LIST_INTERVAL, MAX_MESSAGES_PER_SECOND, MAX_SOCKETS};
use serde_json::{Value, json};

use super::requests::{Call, Handled};
use super::socket::{Pending, Purpose, Socket};
use super::{Hub, HubAction, SESSIONS_SUBSCRIPTION, SocketId, keys_where};
use crate::site::StationId;

/// Time for which the sessions of a disconnected client can be resumed. Stations keep them for 5 s;
/// the extra second makes sure that the hub does not forget a secret that a station still accepts.
pub(super) const RESUME_TIME: Duration = Duration::from_secs(6);

/// Session of a client of the hub, with its sessions at stations.
#[derive(Debug, Default)]
pub(super) struct ClientSession {
    pub(super) name: String,
    /// Session at each station: the secret to resume it, and its id.
    pub(super) at: BTreeMap<StationId, (String, String)>,
    pub(super) disconnected_at: Option<HostInstant>,
    /// Role of the last socket, for the order of eviction.
    last_role: Option<Role>,
}

impl Hub {
    /// Adds a client. `bearer` is the token of its HTTP request, if any.
    pub fn open(&mut self, bearer: Option<String>) -> SocketId {
        // The lowest role until home has answered the hello.
        self.opened(Socket::new(bearer, Role::Viewer, false))
    }

    /// Adds a client for a single request, made with this role.
    pub fn open_once(&mut self, bearer: Option<String>, role: Role) -> SocketId {
        let token = bearer.or_else(|| self.token.clone());
        self.opened(Socket::new(token, role, true))
    }

    fn opened(&mut self, socket: Socket) -> SocketId {
        let id = SocketId(self.next_id());
        self.sockets.insert(id, socket);
        id
    }

    /// Removes a client that disconnected or was closed.
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
        // A resumed session may already have a new socket.
        let taken = |other: &Socket| other.session.as_ref() == Some(&session);
        if !self.sockets.values().any(taken)
            && let Some(client) = self.client_sessions.get_mut(&session)
        {
            (client.disconnected_at, client.last_role) = (Some(now), Some(gone.role));
            self.evict_departed();
        }
    }

    /// Bounds the number of sessions that can be resumed, as a station does: evicts the lowest role
    /// first, and within a role the oldest.
    fn evict_departed(&mut self) {
        let gone = self.client_sessions.iter().filter_map(|(id, client)| {
            let gone = client.disconnected_at?;
            Some((client.last_role, gone, id.clone()))
        });
        let gone: Vec<_> = gone.collect();
        if gone.len() > MAX_SOCKETS
            && let Some((_, _, first)) = gone.into_iter().min()
        {
            self.forget(&first);
        }
    }

    /// Drops a session that can no longer be resumed.
    pub(super) fn forget(&mut self, session: &str) {
        self.client_sessions.remove(session);
        self.names.forget(session);
    }

    /// Closes all lines of a client. Pending requests are not answered.
    pub(super) fn drop_lines(&mut self, socket: SocketId) {
        for line in keys_where(&self.lines, |line| line.socket == socket) {
            self.lines.remove(&line);
            self.actions.push_back(HubAction::Drop(line));
        }
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.routes.clear();
        }
    }

    /// Handles a pong of a client and passes it on as a keep-alive: a holder that sends nothing for
    /// five seconds loses its lease.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        for line in keys_where(&self.lines, |line| line.socket == socket && line.up) {
            self.probe(now, line);
            if let Some(line) = self.lines.get_mut(&line) {
                line.keep_alive_due = true;
            }
            self.actions.push_back(HubAction::Awake(line));
        }
    }

    /// Handles `session.hello`, the first message of a client.
    pub(super) fn handle_hello(&mut self, call: &Call) -> Handled {
        if call.params.contains_key("pupil") {
            // Close after the reply, which gives the reason. A station does the same for an unknown
            // pupil.
            if let Some(open) = self.sockets.get_mut(&call.socket) {
                open.outbox.close(CloseCode::BAD_TOKEN);
            }
            let (page, machines) = self.describe_page(None);
            let error = RpcError::param("pupil", format!("pupils sign in {page}"));
            return Err(error.with("machines", machines));
        }
        let token = call.params.get("token").and_then(Value::as_str);
        let client = call.params.get("client");
        let name = client.and_then(|client| client["name"].as_str());
        let name = visible(name.unwrap_or_default().trim()).to_string();
        self.request_home(call, Purpose::Hello(name, token.map(str::to_owned)));
        Ok(None)
    }

    /// Handles the reply of home to a client's hello.
    pub(super) fn hello_answered(
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
            hello["limits"]["rate"] = json!(MAX_MESSAGES_PER_SECOND + 2 * names.len());
            hello["hub"] = json!(true);
            let session = hello["session"].as_str().unwrap_or_default().to_owned();
            let client = self.client_sessions.entry(session.clone()).or_default();
            (client.name, client.disconnected_at) = (name, None);
            // A resumed session may hold leases at these stations: reconnect before they expire.
            stations.extend(client.at.keys().copied());
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.session = Some(session);
                let role = hello["role"].as_str().and_then(Role::named);
                open.role = role.unwrap_or(Role::Viewer);
                // The token of the hello wins over that of the HTTP request; the hub's own is for
                // clients of this machine.
                open.token = token.or(open.token.take()).or(self.token.clone());
            }
        }
        self.finish(socket, pending.id.as_ref(), &outcome);
        for station in stations {
            let _ = self.line_to(now, socket, station);
        }
    }

    /// List of sessions from the last notifications of home and of the client's lines.
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

    /// Merges lists of sessions. A client of the hub appears once, with its leases at all stations.
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

    /// Marks the list of sessions as changed. Notifications are merged and limited to one per
    /// [`LIST_INTERVAL`].
    pub(super) fn sessions_changed(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.session.is_some()
        {
            open.sessions_changed = true;
            self.send_sessions(now, socket);
        }
    }

    /// Queues the list of sessions for a client, if it is due.
    pub(super) fn send_sessions(&mut self, now: HostInstant, socket: SocketId) {
        if let Some(open) = self.sockets.get_mut(&socket)
            && open.list_due().is_some_and(|due| due <= now)
        {
            (open.sessions_changed, open.sessions_sent_at) = (false, Some(now));
            if open.outbox.state_due(SESSIONS_SUBSCRIPTION) {
                self.awake.insert(socket);
            }
        }
    }
}

impl Socket {
    /// Time at which the list of sessions is due. `None` if the client has the newest.
    pub(super) fn list_due(&self) -> Option<HostInstant> {
        let next = self.sessions_sent_at.map(|sent_at| sent_at + LIST_INTERVAL);
        self.sessions_changed
            .then(|| next.unwrap_or(HostInstant::ZERO))
    }
}

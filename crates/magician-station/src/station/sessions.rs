//! Sessions: hello, resuming, roles, and the limits on their number.
//!
//! A session is a client with a name and a role. It survives its socket for a while, so that a
//! reloaded page finds its lease. Places are limited; viewers and clients without a hello are
//! evicted before anyone who may stop an arm.

use std::collections::BTreeSet;

use magician::admission::{AdmissionLimits, NoPlace, Origin};
use magician::message;
use magician_protocol::HostInstant;
use serde_json::{Map, Value, json};

use super::journal::JournalLine;
use super::newest::{LIST_INTERVAL, Newest};
use super::socket::{CloseCode, MAX_MESSAGES_PER_SECOND};
use super::{Grant, Peer, SocketId, Station};
use crate::api::{Notice, Params, Role, RpcError};
use crate::control::SessionId;
use crate::secret::same_secret;

/// Largest message, bytes.
pub const MAX_MESSAGE_SIZE: usize = 1024 * 1024;
/// Most sockets after their hello: sixty pupils whose pages are being reloaded, a teacher, a
/// projector.
pub const MAX_SOCKETS: usize = 128;
/// Most sockets of viewers. The rest is reserved for clients that may stop an arm.
pub const MAX_VIEWERS: usize = 80;
/// Limits on sockets of listeners. Sixteen without a hello suffice for a class that reconnects at
/// once, since each needs the time of one message. Loopback has separate places, before and after
/// hello, for a teacher's page and programs.
pub(super) const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: 4,
    strangers: 12,
    claims: MAX_SOCKETS,
    kept_for_loopback: 4,
    idle: None,
};
/// Most sockets without a hello.
#[cfg(feature = "http")]
pub(crate) const SILENT_SOCKETS: usize = LIMITS.loopback_strangers + LIMITS.strangers;
/// Most sessions without a socket that can be resumed, besides those with a lease: a whole class
/// whose access point fails.
const MAX_RESUMABLE: usize = 80;
/// Most bytes of a session's name, because the list of sessions is sent to all of them.
const MAX_NAME_BYTES: usize = 96;

/// Source of a session's role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RoleSource {
    /// A token, a pupil's code, or the listener's decision.
    Granted,
    /// An anonymous client of this machine.
    Place,
    /// The teacher's PIN of the class.
    #[cfg(feature = "class")]
    Pin,
}

/// Client with a name.
#[derive(Debug)]
pub(super) struct Session {
    pub(super) name: String,
    pub(super) grant: Grant,
    pub(super) role_source: RoleSource,
    /// Highest role that the session can get: the role it asked for, within what the station
    /// allows.
    #[cfg_attr(
        not(feature = "class"),
        expect(dead_code, reason = "only a class changes roles")
    )]
    pub(super) max_role: Role,
    /// Secret for resuming the session.
    secret: String,
    pub(super) since: HostInstant,
    pub(super) socket: Option<SocketId>,
    /// Instant at which its socket closed.
    left: Option<HostInstant>,
    pub(super) address: String,
    /// True for a session that lasts for one request. Such sessions are not listed.
    pub(super) one_shot: bool,
    /// Pupil who is signed in.
    #[cfg(feature = "class")]
    pub(super) pupil: Option<String>,
}

impl Station {
    /// Handles the first message of a socket.
    pub(super) fn hello(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        params: &Params,
    ) -> Result<Value, RpcError> {
        let client = params.object("client").cloned().unwrap_or_default();
        let name = client_name(&client)?;
        let Some(open) = self.sockets.get(&socket) else {
            return Err(RpcError::internal("the socket is gone"));
        };
        let peer = open.peer.clone();
        let token_grant = open.token_grant.clone();
        #[cfg(feature = "class")]
        let pupil = self.sign_in(now, params, &peer.place()).inspect_err(|_| {
            // Closed after the answer, which gives the reason.
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.outbox.close(CloseCode::BAD_TOKEN);
            }
        })?;
        #[cfg(not(feature = "class"))]
        let pupil: Option<String> = match params.get("pupil") {
            None => None,
            Some(_) => {
                return Err(RpcError::param(
                    "pupil",
                    message!("this station has no classes"),
                ));
            }
        };
        #[cfg(feature = "class")]
        let by_pin = self.teacher_signs_in(now, params, &peer).inspect_err(|_| {
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.outbox.close(CloseCode::BAD_TOKEN);
            }
        })?;
        #[cfg(not(feature = "class"))]
        if params.get("pin").is_some() {
            return Err(RpcError::param(
                "pin",
                message!("this station has no classes"),
            ));
        }
        let name = pupil.clone().unwrap_or(name);
        let of_role = |role| Some(Grant { role, token: None });
        let (role_source, grant) = match params.text("token") {
            #[cfg(feature = "class")]
            _ if by_pin => (RoleSource::Pin, of_role(Role::Teacher)),
            _ if pupil.is_some() => (RoleSource::Granted, of_role(Role::Student)),
            Some(_) => (RoleSource::Granted, token_grant),
            None => self.grant_of(&peer),
        };
        let Some(mut grant) = grant else {
            self.end_socket(socket, CloseCode::BAD_TOKEN);
            let why = match params.text("token") {
                Some(_) => message!("the token is not good"),
                None => message!("a token is needed from this address"),
            };
            return Err(RpcError::new(RpcError::FORBIDDEN, why));
        };
        let asked = params.text("role").and_then(Role::named);
        let most = self.highest_role().min(asked.unwrap_or(Role::Teacher));
        grant.role = grant.role.min(most);
        let back = params
            .text("resume")
            .and_then(|secret| self.resumed(secret, &grant, role_source));
        #[cfg(feature = "class")]
        // A secret alone must not let one pupil resume the session of another.
        let back = back.filter(|session| self.sessions[session].pupil == pupil);
        // Viewers have a limit below that of all sessions.
        let is_beyond = grant.role == Role::Viewer && self.viewers(back) >= MAX_VIEWERS;
        let full = if is_beyond {
            Some((message!("the station has all its viewers"), MAX_VIEWERS))
        } else {
            let full = self.claim_place(now, socket, grant.role).err();
            full.map(|NoPlace| (message!("the station has all its sessions"), MAX_SOCKETS))
        };
        if let Some((why, limit)) = full {
            self.end_socket(socket, CloseCode::FULL);
            return Err(RpcError::new(RpcError::TOO_MANY, why).with("limit", limit));
        }
        let (session, resumed) = match back {
            Some(session) => {
                self.control.rejoin(now, session);
                (session, true)
            }
            None => {
                let session = SessionId(self.next_id());
                self.control.join(now, session);
                (session, false)
            }
        };
        let since = self
            .sessions
            .get(&session)
            .map_or(now, |before| before.since);
        let before = self.sessions.insert(
            session,
            Session {
                name: name.clone(),
                grant: grant.clone(),
                role_source,
                max_role: most,
                secret: peer.secret.clone(),
                since,
                socket: Some(socket),
                left: None,
                address: peer.address,
                one_shot: false,
                #[cfg(feature = "class")]
                pupil,
            },
        );
        if let Some(other) = before.and_then(|before| before.socket) {
            // Jog and waits of the session belonged to the other socket, so they end with it.
            if let Some(open) = self.sockets.get_mut(&other) {
                open.session = None;
            }
            self.control.leave(now, session);
            self.control.rejoin(now, session);
            self.end_socket(other, CloseCode::TAKEN_OVER);
        }
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.session = Some(session);
        }
        #[cfg(feature = "class")]
        self.identify(now, session);
        self.notice_rates.changed(Newest::Sessions, LIST_INTERVAL);
        let arms: Vec<_> = self.arms.iter().map(|arm| arm.entry.name.clone()).collect();
        Ok(json!({
            "session": self.session_id(session),
            "resume": peer.secret,
            "resumed": resumed,
            "role": grant.role.name(),
            "api": 1,
            "version": self.config.version,
            "arms": arms,
            "limits": {"message": MAX_MESSAGE_SIZE, "rate": MAX_MESSAGES_PER_SECOND, "sockets": MAX_SOCKETS},
        }))
    }

    /// Returns the role of a client without a token, and its source. The grant is `None` if a token
    /// is needed.
    fn grant_of(&self, peer: &Peer) -> (RoleSource, Option<Grant>) {
        match &peer.grant {
            Some(grant) => (RoleSource::Granted, Some(grant.clone())),
            None if peer.origin == Origin::Loopback => {
                let (role, token) = (self.anonymous_role(), None);
                (RoleSource::Place, Some(Grant { role, token }))
            }
            None => (RoleSource::Granted, None),
        }
    }

    /// Returns the role of anonymous clients of this machine: teacher, or viewer while a class is
    /// set.
    #[must_use]
    pub fn anonymous_role(&self) -> Role {
        #[cfg(feature = "class")]
        if self.class.file.is_some() || self.class.elsewhere.is_some() {
            return Role::Viewer;
        }
        Role::Teacher
    }

    /// Returns the highest role at this station.
    fn highest_role(&self) -> Role {
        if self.config.read_only {
            Role::Viewer
        } else {
            Role::Teacher
        }
    }

    /// Claims a place for a session. If all are taken, a viewer is evicted for a higher role:
    /// viewers must not keep out a teacher or a pupil.
    fn claim_place(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        role: Role,
    ) -> Result<(), NoPlace> {
        while let Err(full) = self.admission.claim(now, socket) {
            let origin = { self.sockets.get(&socket) }.map(|open| open.peer.origin);
            let viewer = origin.and_then(|origin| self.viewer_to_evict(now, origin));
            let Some(viewer) = viewer.filter(|_| role > Role::Viewer) else {
                return Err(full);
            };
            // Freed at once: the socket itself closes after its farewell.
            self.admission.close(viewer);
            self.end_socket(viewer, CloseCode::FULL);
        }
        Ok(())
    }

    /// Returns the viewer to evict for a session from this origin: anonymous ones first, and among
    /// those the latest, so that a flood of pages cannot evict earlier viewers.
    pub(super) fn viewer_to_evict(&self, now: HostInstant, origin: Origin) -> Option<SocketId> {
        let makes_room = |socket: &SocketId| {
            // Tried on a copy, because the table alone knows which place frees which.
            let mut others = self.admission.clone();
            others.close(*socket);
            others.has_room(now, origin)
        };
        let viewers = { self.sessions.iter() }
            .filter(|(_, session)| session.grant.role == Role::Viewer)
            .filter_map(|(id, session)| {
                let is_nameless = session.grant.token.is_none();
                Some((is_nameless, session.since, *id, session.socket?))
            });
        let mut viewers: Vec<_> = viewers.collect();
        // Descending: anonymous before named, then latest first.
        viewers.sort_unstable_by(|one, other| other.cmp(one));
        let sockets = viewers.into_iter().map(|(.., socket)| socket);
        { sockets }.find(makes_room)
    }

    /// Returns the number of viewers with a socket, except the session that is being resumed, whose
    /// old socket is about to close.
    fn viewers(&self, back: Option<SessionId>) -> usize {
        let watches =
            |session: &Session| session.grant.role == Role::Viewer && session.socket.is_some();
        let others = self.sessions.iter().filter(|(id, _)| Some(**id) != back);
        others.filter(|(_, session)| watches(session)).count()
    }

    /// Creates a session for the single request of a socket without a hello, with the rights of its
    /// peer.
    pub(super) fn join_one_shot(
        &mut self,
        now: HostInstant,
        socket: SocketId,
    ) -> Result<(), RpcError> {
        let peer = { self.sockets.get(&socket) }.map(|open| open.peer.clone());
        let peer = peer.ok_or_else(|| RpcError::internal("the socket is gone"))?;
        let needs = || {
            RpcError::new(
                RpcError::FORBIDDEN,
                message!("a token is needed from this address"),
            )
        };
        let (role_source, grant) = self.grant_of(&peer);
        let mut grant = grant.ok_or_else(needs)?;
        let most = self.highest_role();
        grant.role = grant.role.min(most);
        let session = SessionId(self.next_id());
        self.control.join(now, session);
        let name = grant.token.clone().unwrap_or_else(|| "request".to_owned());
        self.sessions.insert(
            session,
            Session {
                name,
                grant,
                role_source,
                max_role: most,
                secret: String::new(),
                since: now,
                // Gets its answer and no notifications.
                socket: None,
                left: None,
                address: peer.address,
                one_shot: true,
                #[cfg(feature = "class")]
                pupil: None,
            },
        );
        #[cfg(feature = "class")]
        self.identify(now, session);
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.session = Some(session);
        }
        Ok(())
    }

    /// Ends a session of one request. If the caller left before the answer, what the request
    /// started is stopped.
    pub(super) fn end_one_shot(&mut self, now: HostInstant, session: SessionId, unanswered: bool) {
        if !unanswered {
            self.control.release_all(now, session);
        }
        self.control.expel(now, session);
    }

    /// Returns the session with this secret, if it has the same source of rights.
    fn resumed(&self, secret: &str, grant: &Grant, role_source: RoleSource) -> Option<SessionId> {
        let of = |session: &Session| {
            !secret.is_empty()
                && same_secret(&session.secret, secret)
                && session.grant.token == grant.token
                && session.role_source == role_source
        };
        let (id, _) = self.sessions.iter().find(|(_, session)| of(session))?;
        Some(*id)
    }

    /// Handles the end of a session's socket.
    pub(super) fn note_socket_closed(&mut self, now: HostInstant, session: SessionId) {
        if let Some(gone) = self.sessions.get_mut(&session) {
            gone.socket = None;
            gone.left = Some(now);
        }
        self.control.leave(now, session);
        self.limit_resumable(now);
        let mut line = self.line(now, Some(session), "session.end", Value::Null);
        "ok".clone_into(&mut line.result);
        self.lines.push_back(line);
    }

    /// Limits the sessions that can be resumed: a client that comes and goes in a loop must not
    /// displace others. The lowest role ends first, and within a role the session that left first.
    /// Sessions with a lease are exempt.
    fn limit_resumable(&mut self, now: HostInstant) {
        let kept = self.sessions.iter().filter_map(|(id, session)| {
            let left = session.left.filter(|_| session.socket.is_none())?;
            let holds = self.control.held_by(*id).next().is_some();
            (!holds).then_some((session.grant.role, left, *id))
        });
        let kept: Vec<_> = kept.collect();
        if kept.len() > MAX_RESUMABLE
            && let Some((_, _, first)) = kept.into_iter().min()
        {
            self.control.expel(now, first);
        }
    }

    /// Removes a session that is over.
    pub(super) fn remove_session(&mut self, session: SessionId) {
        let over = self.sessions.remove(&session);
        if over.is_some_and(|over| !over.one_shot) {
            self.notice_rates.changed(Newest::Sessions, LIST_INTERVAL);
        }
    }

    /// Revokes a token: its sessions and their leases end now.
    pub fn revoke(&mut self, now: HostInstant, token: &str) {
        let revoked: Vec<_> = { self.sessions.iter() }
            .filter(|(_, session)| session.grant.token.as_deref() == Some(token))
            .map(|(id, session)| (*id, session.socket))
            .collect();
        for (session, socket) in revoked {
            if let Some(socket) = socket {
                self.end_socket(socket, CloseCode::REVOKED);
            }
            self.control.expel(now, session);
        }
        self.carry_out_effects(now);
    }

    /// Returns the names of the tokens that sessions have used.
    #[must_use]
    pub fn tokens(&self) -> BTreeSet<String> {
        let tokens = self.sessions.values();
        tokens
            .filter_map(|session| session.grant.token.clone())
            .collect()
    }

    pub(super) fn list_sessions(&self) -> Value {
        let lasting = self
            .sessions
            .iter()
            .filter(|(_, session)| !session.one_shot);
        let list = lasting.map(|(id, session)| {
            let held = self
                .control
                .held_by(*id)
                .map(|arm| self.arm(arm).entry.name.clone());
            json!({
                "session": self.session_id(*id),
                "name": session.name,
                "role": session.grant.role.name(),
                "leases": held.collect::<Vec<_>>(),
                "since": self.unix(session.since),
            })
        });
        json!({"sessions": list.collect::<Vec<_>>()})
    }

    /// Returns the list of sessions as a notification.
    pub(super) fn session_list(&self) -> String {
        Notice::SessionChanged.message(&self.list_sessions())
    }

    /// Returns a session as JSON: `{session, name}`, or null.
    pub(super) fn name_of(&self, session: Option<SessionId>) -> Value {
        let known = session.and_then(|id| Some((id, self.sessions.get(&id)?)));
        known.map_or(
            Value::Null,
            |(id, session)| json!({"session": self.session_id(id), "name": session.name}),
        )
    }

    /// Creates a line of the journal, without its result.
    pub(super) fn line(
        &self,
        now: HostInstant,
        session: Option<SessionId>,
        method: &str,
        params: Value,
    ) -> JournalLine {
        let known = session.and_then(|id| self.sessions.get(&id));
        JournalLine {
            t: self.unix(now),
            session: session.map(|id| self.session_id(id)),
            name: known
                .map(|session| session.name.clone())
                .unwrap_or_default(),
            role: known.map(|session| session.grant.role.name()),
            peer: known
                .map(|session| session.address.clone())
                .unwrap_or_default(),
            arm: None,
            method: method.to_owned(),
            params,
            result: String::new(),
            ms: 0.0,
        }
    }
}

/// Returns the checked and shortened name of a client.
fn client_name(client: &Map<String, Value>) -> Result<String, RpcError> {
    let wrong = |why| Err(RpcError::param("client", why));
    for (key, value) in client {
        match (key.as_str(), value) {
            ("name" | "version", Value::String(text)) if text.chars().count() <= 80 => {}
            ("name" | "version", _) => {
                return wrong("`name` and `version` are text of at most 80 characters");
            }
            _ => return wrong("`client` has `name` and `version` alone"),
        }
    }
    match client.get("name").and_then(Value::as_str).map(str::trim) {
        Some(name) if !name.is_empty() => {
            let mut name = magician_protocol::visible(name).to_string();
            while name.len() > MAX_NAME_BYTES {
                // By characters, so that the text stays valid UTF-8.
                name.pop();
            }
            Ok(name)
        }
        _ => wrong("`client` needs a `name`"),
    }
}

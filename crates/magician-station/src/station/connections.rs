//! Connections of clients: admission, messages, keep-alives and the end of a socket.

use magician::admission::Origin;
use magician_protocol::HostInstant;

use super::socket::Socket;
use super::{CloseCode, Grant, Peer, SocketId, Station};
use crate::api::Message;

impl Station {
    /// Admits a client of a listener.
    ///
    /// A socket has no claim to its place until its hello: if there are too many of those, the
    /// oldest is evicted. `None` if all sessions are in use and no viewer can be evicted for a
    /// client with a higher role.
    pub fn admit(&mut self, now: HostInstant, peer: Peer) -> Option<SocketId> {
        let origin = peer.origin;
        if !self.may_have_room(now, origin) {
            return None;
        }
        let socket = self.open(now, peer);
        if let Some(silent) = self.admission.open(now, socket, origin) {
            self.end_socket(silent, CloseCode::HELLO_TIMEOUT);
        }
        Some(socket)
    }

    /// Returns the earliest instant at which a client can be [admitted](Self::admit) without
    /// evicting a socket that has not had its time for a hello.
    ///
    /// `None` if it can be admitted now, or if all sessions are in use.
    #[must_use]
    pub fn admits_at(&self, now: HostInstant, origin: Origin) -> Option<HostInstant> {
        if !self.may_have_room(now, origin) {
            return None;
        }
        self.admission.opens_at(now, origin, Socket::grace(origin))
    }

    /// True if a client from there may get a session by its hello.
    fn may_have_room(&self, now: HostInstant, origin: Origin) -> bool {
        self.admission.has_room(now, origin) || self.viewer_to_evict(now, origin).is_some()
    }

    /// Records that a message has arrived, before it is [received](Self::receive). The client no
    /// longer counts as silent.
    pub fn note_message(&mut self, now: HostInstant, socket: SocketId) {
        self.admission.heard(now, socket);
    }

    /// Connects a client of this process, or of a listener that limits its clients itself.
    pub fn open(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = SocketId(self.next_id());
        self.sockets.insert(id, Socket::new(now, peer));
        id
    }

    /// Returns the token of a `session.hello`. `None` for other messages.
    ///
    /// Tokens are stored in files, and reading one must not delay the station. So the listener
    /// looks the token up and passes its rights to [`set_token_grant`](Self::set_token_grant)
    /// before the message.
    #[must_use]
    pub fn token_of(text: &str) -> Option<String> {
        let message = Message::parse(text).ok()?;
        let token = message.params.get("token")?.as_str()?;
        (message.method == "session.hello").then(|| token.to_owned())
    }

    /// Sets the rights of the token in a client's hello. `None` for an invalid token.
    pub fn set_token_grant(&mut self, socket: SocketId, grant: Option<Grant>) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.token_grant = grant;
        }
    }

    /// Connects a program for DobotLink (feature `link`).
    #[cfg(feature = "link")]
    pub(crate) fn open_link(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = self.open(now, peer);
        if let Some(socket) = self.sockets.get_mut(&id) {
            socket.link = true;
        }
        id
    }

    /// Processes a message that the link translated from this call of its program. The journal
    /// names the call.
    #[cfg(feature = "link")]
    pub(crate) fn receive_for(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        text: &str,
        of: Option<String>,
    ) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.calls = of;
        }
        self.receive(now, socket, text);
    }

    /// Processes a text message of a client.
    pub fn receive(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        // Deadlines first: a message must not revive what is over.
        self.handle_timeout(now);
        self.handle_message(now, socket, text);
        self.carry_out_effects(now);
    }

    /// Processes the only message of a client without a hello. Its session ends with the socket;
    /// the lease that the request needs is acquired if it is free. Returns true if an answer
    /// follows.
    pub fn receive_once(&mut self, now: HostInstant, socket: SocketId, text: &str) -> bool {
        self.handle_timeout(now);
        let answered = self.handle_single_message(now, socket, text);
        self.carry_out_effects(now);
        answered
    }

    /// Records the reply to a ping, which keeps the lease alive as a message does.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        self.handle_timeout(now);
        if let Some(session) = self.session_of(socket) {
            self.control.keep_alive(now, session);
        }
    }

    /// Handles the end of a socket, by the client or by the station.
    pub fn close(&mut self, now: HostInstant, socket: SocketId) {
        let Some(gone) = self.sockets.remove(&socket) else {
            return;
        };
        self.admission.close(socket);
        // Looked at before requests without a line are dropped below.
        let unanswered = self
            .pending
            .values()
            .any(|pending| pending.socket == socket);
        // Requests with a journal line stay until they are over, so that the journal gets their
        // results.
        self.pending
            .retain(|_, pending| pending.socket != socket || pending.line.is_some());
        if let Some(session) = gone.session {
            match self.sessions.get(&session) {
                Some(known) if known.one_shot => self.end_one_shot(now, session, unanswered),
                _ => self.note_socket_closed(now, session),
            }
        }
        self.drop_closed_requests();
        // The subscriptions of the session are gone as well, so some arms can be read less often.
        self.update_read_rates();
        self.carry_out_effects(now);
    }
}

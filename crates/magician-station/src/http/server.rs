//! Interface between the listener and what it serves: a station, or a hub that looks like one.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::api::{Role, RpcError};
use crate::library::ProgramStore;
use crate::recording::RecordingStore;
use crate::running::{Client, RunningStation};
use crate::station::{Grant, Outgoing, Peer};

/// Server of the API.
pub trait ApiServer: Clone + Send + Sync + 'static {
    /// Client of this server.
    type Client: ApiClient;

    /// Connects a client with the token of its request. Waits until clients that connected just
    /// before have sent their hello or timed out. `None` if all sessions are in use.
    fn admit(
        &self,
        peer: Peer,
        token: Option<String>,
    ) -> impl Future<Output = Option<Self::Client>> + Send;

    /// Carries out one request in its own session. `None` for a notification, which has no answer.
    /// Dropping the future ends the session.
    fn call(
        &self,
        peer: Peer,
        token: Option<String>,
        text: &str,
    ) -> impl Future<Output = Option<String>> + Send;

    /// Returns the library of programs.
    fn programs(&self) -> Arc<dyn ProgramStore>;

    /// Returns the store of recordings.
    fn recordings(&self) -> Arc<dyn RecordingStore>;

    /// True if every session is limited to the role of a viewer.
    fn is_read_only(&self) -> bool;

    /// Returns the role of anonymous clients on this machine.
    fn anonymous_role(&self) -> Role;

    /// Checks the teacher's PIN of the class, for a request without a session.
    ///
    /// # Errors
    /// The PIN is wrong, there is no class, or there were too many wrong tries.
    fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError>;

    /// Returns the names of the tokens that sessions have used.
    fn tokens(&self) -> BTreeSet<String>;

    /// Revokes a token: its sessions end.
    fn revoke(&self, token: &str);
}

/// Client of an [`ApiServer`], whose messages the listener carries. Dropping it closes its socket.
pub trait ApiClient: Send + Sync + 'static {
    /// Records that a message has arrived, before it is processed.
    fn note_message(&self);

    /// Passes a message of the client.
    fn send(&self, text: &str);

    /// Sets the rights of the token in the client's hello, before the hello is sent.
    fn set_token_grant(&self, grant: Option<Grant>);

    /// Records the reply to a ping.
    fn pong(&self);

    /// Waits for the next message to the client. Cancel safe.
    fn receive(&self) -> impl Future<Output = Outgoing> + Send;
}

impl ApiServer for RunningStation {
    type Client = Client;

    async fn admit(&self, peer: Peer, _: Option<String>) -> Option<Client> {
        self.admit(peer).await
    }

    async fn call(&self, peer: Peer, _: Option<String>, text: &str) -> Option<String> {
        self.call(peer, text).await
    }

    fn programs(&self) -> Arc<dyn ProgramStore> {
        self.programs()
    }

    fn recordings(&self) -> Arc<dyn RecordingStore> {
        self.recordings()
    }

    fn is_read_only(&self) -> bool {
        self.is_read_only()
    }

    fn anonymous_role(&self) -> Role {
        self.anonymous_role()
    }

    #[cfg(feature = "class")]
    fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError> {
        self.try_pin(pin, peer)
    }

    #[cfg(not(feature = "class"))]
    fn try_pin(&self, _: &str, _: &Peer) -> Result<(), RpcError> {
        let why = "this station has no classes";
        Err(RpcError::new(RpcError::FORBIDDEN, why))
    }

    fn tokens(&self) -> BTreeSet<String> {
        self.tokens()
    }

    fn revoke(&self, token: &str) {
        self.revoke(token);
    }
}

impl ApiClient for Client {
    fn note_message(&self) {
        self.note_message();
    }

    fn send(&self, text: &str) {
        self.send(text);
    }

    fn set_token_grant(&self, grant: Option<Grant>) {
        self.set_token_grant(grant);
    }

    fn pong(&self) {
        self.pong();
    }

    async fn receive(&self) -> Outgoing {
        self.receive().await
    }
}

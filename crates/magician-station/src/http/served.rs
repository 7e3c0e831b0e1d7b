//! What a listener serves: a station, or whatever looks like one.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::api::{Role, RpcError};
use crate::library::ProgramStore;
use crate::recording::RecordingStore;
use crate::running::{Client, RunningStation};
use crate::station::{Grant, Outgoing, Peer};

/// Something that answers the API to clients on a network.
pub trait Served: Clone + Send + Sync + 'static {
    /// One of its clients.
    type Client: ServedClient;

    /// A client connects, with the token of its request, if it has one; `None` where there are as many as it takes. It waits
    /// until those that came just before have had the time to say hello.
    fn admit(
        &self,
        peer: Peer,
        token: Option<String>,
    ) -> impl Future<Output = Option<Self::Client>> + Send;

    /// Carries out one request, as a session of its own that lasts as long. `None` for a notification, which has no answer.
    /// Dropping the future ends the session.
    fn call(
        &self,
        peer: Peer,
        token: Option<String>,
        text: &str,
    ) -> impl Future<Output = Option<String>> + Send;

    /// Its library of programs.
    fn programs(&self) -> Arc<dyn ProgramStore>;

    /// Where its recordings are.
    fn recordings(&self) -> Arc<dyn RecordingStore>;

    /// Whether nobody is more than a viewer.
    fn is_read_only(&self) -> bool;

    /// The role of this machine's people without a name.
    fn place_role(&self) -> Role;

    /// Tries the teacher's PIN of a class, for a request without a session.
    ///
    /// # Errors
    /// Why it is not good.
    fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError>;

    /// The names of the tokens that sessions have come with.
    fn tokens(&self) -> BTreeSet<String>;

    /// A token is good no more: its sessions end.
    fn revoke(&self, token: &str);
}

/// A client of what is served, from whose socket the listener carries messages. Dropping it is the end of its socket.
pub trait ServedClient: Send + Sync + 'static {
    /// A message of the client has come, which is looked at before it is sent.
    fn heard(&self);

    /// A message of the client.
    fn send(&self, text: &str);

    /// What the token of its hello allows, before the hello is sent.
    fn vouch(&self, grant: Option<Grant>);

    /// The answer to a ping.
    fn pong(&self);

    /// What the client is to be sent next; waits for it. Dropping the future loses nothing.
    fn receive(&self) -> impl Future<Output = Outgoing> + Send;
}

impl Served for RunningStation {
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

    fn place_role(&self) -> Role {
        self.place_role()
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

impl ServedClient for Client {
    fn heard(&self) {
        self.heard();
    }

    fn send(&self, text: &str) {
        self.send(text);
    }

    fn vouch(&self, grant: Option<Grant>) {
        self.vouch(grant);
    }

    fn pong(&self) {
        self.pong();
    }

    async fn receive(&self) -> Outgoing {
        self.receive().await
    }
}

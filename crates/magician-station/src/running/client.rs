//! Client of a running station.

use std::fmt;
use std::sync::Arc;

use tokio::sync::Notify;

use super::Shared;
#[cfg(doc)]
use crate::station::Station;
use crate::station::{Grant, Outgoing, SocketId};

/// Client of a station in this process, or of a listener that carries its messages. Dropping it
/// closes its socket.
pub struct Client {
    pub(super) shared: Arc<Shared>,
    pub(super) socket: SocketId,
    pub(super) awake: Arc<Notify>,
}

impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client")
            .field("socket", &self.socket)
            .finish_non_exhaustive()
    }
}

impl Client {
    /// Records that a message of the client has arrived, before the message is processed. From then
    /// on the client does not count as silent and is not evicted for another one.
    pub fn note_message(&self) {
        self.shared
            .with(|inner, now| inner.station.note_message(now, self.socket));
    }

    /// Passes a message of the client to the station.
    pub fn send(&self, text: &str) {
        self.shared
            .with(|inner, now| inner.station.receive(now, self.socket, text));
    }

    /// Passes a message that the link translated from this call of its program.
    #[cfg(feature = "link")]
    pub(crate) fn send_for(&self, text: &str, of: Option<String>) {
        self.shared
            .with(|inner, now| inner.station.receive_for(now, self.socket, text, of));
    }

    /// Sets the rights of the token in the client's hello, before the hello is sent
    /// ([`Station::set_token_grant`]).
    pub fn set_token_grant(&self, grant: Option<Grant>) {
        self.shared
            .lock()
            .station
            .set_token_grant(self.socket, grant);
    }

    /// Records the reply to a ping, which keeps the lease alive. A holder that is silent for 5 s
    /// loses its lease.
    pub fn pong(&self) {
        self.shared
            .with(|inner, now| inner.station.pong(now, self.socket));
    }

    /// Waits for the next message to the client. After a close only the close is returned. Call it
    /// when the socket can send: until then newer states replace older ones in the queue. Cancel
    /// safe.
    pub async fn receive(&self) -> Outgoing {
        loop {
            if let Some(outgoing) = self.try_receive() {
                return outgoing;
            }
            self.awake.notified().await;
        }
    }

    /// Returns the next message to the client. `None` if none is waiting.
    pub fn try_receive(&self) -> Option<Outgoing> {
        self.shared.lock().station.poll_send(self.socket)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.shared.with(|inner, now| {
            inner.station.close(now, self.socket);
            inner.sockets.remove(&self.socket);
        });
    }
}

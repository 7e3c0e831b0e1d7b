//! A hub on a tokio runtime: the [`Hub`] state machine, its own station, and the tasks that drive
//! them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::{Arc, Mutex, Weak};

use magician::admission::Origin;
use magician_station::api::{Message, Method, RpcError};
use magician_station::class::is_pin;
use magician_station::http::{ApiClient, ApiServer};
use magician_station::{
    Client, Grant, JournalSink, NoRecordings, Outgoing, Peer, ProgramStore, RecordingStore, Role,
    RunningStation, StationConfig,
};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::AbortHandle;
use tokio::time::Instant;

use super::acting::{Home, Inner, Place, Shared};
use super::{Hub, SocketId};
use crate::Roster;
use crate::site::Site;

/// Configuration of a hub.
pub struct HubConfig {
    /// Configuration of home, which keeps the sessions and the library. Its arms are ignored.
    pub station: StationConfig,
    /// Token at stations for clients of this machine that bring none.
    pub token: Option<String>,
    /// Receives the journal of home. Stations keep their own journals.
    pub journal: JournalSink,
}

impl fmt::Debug for HubConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HubConfig")
            .field("station", &self.station)
            .finish_non_exhaustive()
    }
}

/// A [`Hub`] on a tokio runtime, for a [`Listener`](magician_station::http::Listener). Clones share
/// the same hub.
#[derive(Clone)]
pub struct RunningHub {
    shared: Arc<Shared>,
    _tasks: Arc<Tasks>,
}

impl fmt::Debug for RunningHub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RunningHub").finish_non_exhaustive()
    }
}

struct Tasks(Vec<AbortHandle>);

impl Drop for Tasks {
    fn drop(&mut self) {
        self.0.iter().for_each(AbortHandle::abort);
    }
}

impl RunningHub {
    /// Starts a hub on the current runtime.
    ///
    /// # Panics
    /// If called outside of a tokio runtime.
    #[must_use]
    pub fn start(config: HubConfig, site: Arc<dyn Site>) -> Self {
        let HubConfig {
            mut station,
            token,
            journal,
        } = config;
        station.arms.clear();
        let hub = Hub::new(token, station.unix_zero, station.random);
        let (library, read_only) = (Arc::clone(&station.programs), station.read_only);
        let home = RunningStation::start(station, Vec::new(), journal);
        let shared = Arc::new_cyclic(|this| Shared {
            inner: Mutex::new(Inner {
                hub,
                clients: BTreeMap::new(),
                lines: BTreeMap::new(),
            }),
            home,
            library,
            read_only,
            site,
            begun: Instant::now(),
            due: Notify::new(),
            this: Weak::clone(this),
            runtime: Handle::current(),
        });
        // Before any client can connect, so that the first request already sees the arms that are
        // present.
        let arms = shared.site.arms().into_keys().collect();
        shared.with(|hub, now| hub.on_site(now, arms));
        let watching = tokio::spawn(Shared::watch(Arc::downgrade(&shared)));
        let timing = tokio::spawn(Shared::keep_time(Arc::downgrade(&shared)));
        let looking = tokio::spawn(Shared::watch_class(Arc::downgrade(&shared)));
        let tasks = [watching, timing, looking].map(|task| task.abort_handle());
        let tasks = tasks.to_vec();
        Self {
            shared,
            _tasks: Arc::new(Tasks(tasks)),
        }
    }

    /// Checks whether a station has a class, which decides the role of users at this machine. A
    /// background task repeats the check every second.
    pub async fn look_at_class(&self) {
        self.shared.look_at_class().await;
    }

    /// Reads the rosters of all stations and adds their arms as expected.
    pub async fn read_roster(&self) -> Roster {
        let roster = self.shared.site.roster().await;
        self.shared.with(|hub, _| hub.expects(&roster));
        roster
    }

    /// Number of connected clients.
    #[must_use]
    pub fn clients(&self) -> usize {
        self.shared.lock().clients.len()
    }

    /// Connects a client. `token` is the token of its HTTP request, if any.
    #[must_use]
    pub fn connect(&self, peer: Peer, token: Option<String>) -> HubClient {
        self.join(self.shared.home.connect(peer), token)
    }

    /// Adds a client with a session at home.
    fn join(&self, client: Client, token: Option<String>) -> HubClient {
        let client = Arc::new(client);
        let pump = Arc::clone(&client);
        let made = self
            .shared
            .join(Home::Session(client), |hub| hub.open(token));
        let (shared, socket) = (Weak::clone(&self.shared.this), made.socket);
        let pumping = self.shared.runtime.spawn(async move {
            loop {
                let outgoing = pump.receive().await;
                let Some(shared) = shared.upgrade() else {
                    return;
                };
                match outgoing {
                    Outgoing::Text(text) => {
                        shared.with(|hub, now| hub.home_says(now, socket, &text))
                    }
                    Outgoing::Frame(_) => {}
                    Outgoing::Close(code) => {
                        return shared.with(|hub, _| hub.home_closes(socket, code));
                    }
                }
            }
        });
        if let Some(place) = self.shared.lock().clients.get_mut(&socket) {
            place.calls.push(pumping.abort_handle());
        }
        made
    }
}

impl ApiServer for RunningHub {
    type Client = HubClient;

    async fn admit(&self, peer: Peer, token: Option<String>) -> Option<HubClient> {
        // Home limits the number of connections and knows which of them have said hello.
        let client = self.shared.home.admit(peer).await?;
        Some(self.join(client, token))
    }

    async fn call(&self, peer: Peer, token: Option<String>, text: &str) -> Option<String> {
        let message = match Message::parse(text) {
            Ok(message) if !Hub::is_of_home(&message.method) => message,
            // Also malformed messages: home knows the errors for them.
            _ => return self.shared.home.call(peer, text).await,
        };
        let known = Method::named(&message.method);
        let of_place = (peer.origin == Origin::Loopback).then(|| self.anonymous_role());
        let role = peer.grant.as_ref().map(|grant| grant.role).or(of_place);
        let Some(role) = role.filter(|_| known.is_some_and(|method| !method.session)) else {
            // Home produces the error.
            return self.shared.home.call(peer, text).await;
        };
        // A PIN in place of a token concerns the hub alone. Stations get the hub's own token
        // instead.
        let token = token.filter(|token| !is_pin(token));
        let role = if self.shared.read_only {
            Role::Viewer
        } else {
            role
        };
        let client = self
            .shared
            .join(Home::Once(peer), |hub| hub.open_once(token, role));
        client.send(text);
        if message.id.is_none() && known.is_some_and(|method| method.always) {
            return None;
        }
        match client.receive().await {
            Outgoing::Text(text) => Some(text),
            Outgoing::Frame(_) | Outgoing::Close(_) => None,
        }
    }

    fn programs(&self) -> Arc<dyn ProgramStore> {
        Arc::clone(&self.shared.library)
    }

    fn recordings(&self) -> Arc<dyn RecordingStore> {
        Arc::new(NoRecordings)
    }

    fn is_read_only(&self) -> bool {
        self.shared.read_only
    }

    fn anonymous_role(&self) -> Role {
        self.shared.home.anonymous_role()
    }

    fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError> {
        self.shared.home.try_pin(pin, peer)
    }

    fn tokens(&self) -> BTreeSet<String> {
        self.shared.home.tokens()
    }

    fn revoke(&self, token: &str) {
        self.shared.home.revoke(token);
    }
}

impl Shared {
    fn join(self: &Arc<Self>, home: Home, open: impl FnOnce(&mut Hub) -> SocketId) -> HubClient {
        let awake = Arc::new(Notify::new());
        let mut inner = self.lock();
        let socket = open(&mut inner.hub);
        let place = Place {
            awake: Arc::clone(&awake),
            home,
            calls: Vec::new(),
        };
        inner.clients.insert(socket, place);
        HubClient {
            shared: Arc::clone(self),
            socket,
            awake,
        }
    }
}

/// Client of a hub. Dropping it closes its socket and its sessions at stations.
pub struct HubClient {
    shared: Arc<Shared>,
    socket: SocketId,
    awake: Arc<Notify>,
}

impl fmt::Debug for HubClient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HubClient")
            .field("socket", &self.socket)
            .finish_non_exhaustive()
    }
}

impl HubClient {
    fn home(&self) -> Option<Arc<Client>> {
        match self.shared.lock().clients.get(&self.socket)?.home.clone() {
            Home::Session(client) => Some(client),
            Home::Once(_) => None,
        }
    }

    /// Returns the next message for the client without waiting, or `None`.
    #[must_use]
    pub fn try_receive(&self) -> Option<Outgoing> {
        self.shared.lock().hub.poll_send(self.socket)
    }
}

impl ApiClient for HubClient {
    fn note_message(&self) {
        if let Some(home) = self.home() {
            home.note_message();
        }
    }

    fn send(&self, text: &str) {
        self.shared
            .with(|hub, now| hub.receive(now, self.socket, text));
    }

    fn set_token_grant(&self, grant: Option<Grant>) {
        if let Some(home) = self.home() {
            home.set_token_grant(grant);
        }
    }

    fn pong(&self) {
        if let Some(home) = self.home() {
            home.pong();
        }
        self.shared.with(|hub, now| hub.pong(now, self.socket));
    }

    async fn receive(&self) -> Outgoing {
        loop {
            if let Some(outgoing) = self.try_receive() {
                return outgoing;
            }
            self.awake.notified().await;
        }
    }
}

impl Drop for HubClient {
    fn drop(&mut self) {
        let place = self.shared.lock().clients.remove(&self.socket);
        self.shared.with(|hub, now| hub.close(now, self.socket));
        if let Some(place) = place {
            place.calls.iter().for_each(AbortHandle::abort);
        }
    }
}

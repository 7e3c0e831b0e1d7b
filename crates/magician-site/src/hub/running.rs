//! A hub at work: its own station, its lines, and the clients of a listener.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use magician::admission::Origin;
use serde_json::Value;

use magician_protocol::HostInstant;
use magician_station::api::{Message, RpcError, answer};
use magician_station::class::is_pin;
use magician_station::http::{Served, ServedClient};
use magician_station::{
    Client, Grant, JournalSink, NoRecordings, Outgoing, Peer, ProgramStore, RecordingStore, Role,
    RunningStation, StationConfig,
};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, sleep_until};

use super::{Hub, HubAct, LineId, LineMessage, SocketId};
use crate::Roster;
use crate::channel::{Closed, FromStation, ToStation};
use crate::site::{Caller, Site, SiteEvent, StationId};

/// Time from one look at the class of the stations to the next: a person waits so long for a change of role.
const CLASS: Duration = Duration::from_secs(1);
/// What stations are asked then.
const ASKED: &str = r#"{"jsonrpc":"2.0","id":1,"method":"class.get","params":{}}"#;

/// What a hub is made of.
pub struct HubConfig {
    /// Its own station, which keeps its sessions and its library; its arms are not served.
    pub station: StationConfig,
    /// The token that clients of this machine without one have at stations.
    pub token: Option<String>,
    /// Takes the lines of its journal; stations write their own.
    pub journal: JournalSink,
}

impl fmt::Debug for HubConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HubConfig")
            .field("station", &self.station)
            .finish_non_exhaustive()
    }
}

/// A [`Hub`] on a tokio runtime, for a [`Listener`](magician_station::http::Listener). Clones are of the same hub.
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

struct Shared {
    inner: Mutex<Inner>,
    home: RunningStation,
    library: Arc<dyn ProgramStore>,
    read_only: bool,
    site: Arc<dyn Site>,
    begun: Instant,
    due: Notify,
    this: Weak<Shared>,
    runtime: Handle,
}

struct Inner {
    hub: Hub,
    clients: BTreeMap<SocketId, Place>,
    lines: BTreeMap<LineId, (Arc<Notify>, AbortHandle)>,
}

/// What belongs to a client.
struct Place {
    awake: Arc<Notify>,
    home: Home,
    /// Requests that end with it.
    calls: Vec<AbortHandle>,
}

/// How a client reaches the hub's own station.
#[derive(Clone)]
enum Home {
    Session(Arc<Client>),
    /// By single requests.
    Once(Peer),
}

impl RunningHub {
    /// Sets it going on the present runtime.
    ///
    /// # Panics
    /// Outside of a tokio runtime.
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
        // What is there already is known to the first request.
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

    /// Looks whether a station has a class, for what this machine's people may do here. It goes on looking by itself.
    pub async fn look_at_class(&self) {
        self.shared.look_at_class().await;
    }

    /// Learns from the stations' rosters which arms are expected.
    pub async fn read_roster(&self) -> Roster {
        let roster = self.shared.site.roster().await;
        self.shared.with(|hub, _| hub.expects(&roster));
        roster
    }

    /// How many clients it has at present.
    #[must_use]
    pub fn clients(&self) -> usize {
        self.shared.lock().clients.len()
    }

    /// A client connects, with the token of its request if it has one.
    #[must_use]
    pub fn connect(&self, peer: Peer, token: Option<String>) -> HubClient {
        self.join(self.shared.home.connect(peer), token)
    }

    /// The client whose session at home this is.
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

impl Served for RunningHub {
    type Client = HubClient;

    async fn admit(&self, peer: Peer, token: Option<String>) -> Option<HubClient> {
        // Home counts, and knows who has said hello.
        let client = self.shared.home.admit(peer).await?;
        Some(self.join(client, token))
    }

    async fn call(&self, peer: Peer, token: Option<String>, text: &str) -> Option<String> {
        let message = match Message::parse(text) {
            Ok(message) if !Hub::is_of_home(&message.method) => message,
            _ => return self.shared.home.call(peer, text).await,
        };
        let known = magician_station::api::Method::named(&message.method);
        let of_place = (peer.origin == Origin::Loopback).then(|| self.place_role());
        let role = peer.grant.as_ref().map(|grant| grant.role).or(of_place);
        let Some(role) = role.filter(|_| known.is_some_and(|method| !method.session)) else {
            // Home has the words for it.
            return self.shared.home.call(peer, text).await;
        };
        // The PIN in the place of a token is the hub's to look at: stations know the hub's own token.
        let token = token.filter(|token| !is_pin(token));
        if message.id.is_none() && known.is_some_and(|method| !method.always) {
            let error = RpcError::request(format!("{} needs an `id`", message.method));
            return Some(answer(None, &Err(error)));
        }
        let role = if self.shared.read_only {
            Role::Viewer
        } else {
            role
        };
        let client = self
            .shared
            .join(Home::Once(peer), |hub| hub.open_once(token, role));
        client.send(text);
        message.id.as_ref()?;
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

    fn place_role(&self) -> Role {
        self.shared.home.place_role()
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
    fn lock(&self) -> MutexGuard<'_, Inner> {
        // A panic in the hub is a bug; what it holds is whole values all the same.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.begun.elapsed()
    }

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

    /// Does something with the hub, and what follows from it.
    fn with<T>(&self, act: impl FnOnce(&mut Hub, HostInstant) -> T) -> T {
        let mut inner = self.lock();
        let due = inner.hub.poll_timeout();
        let outcome = act(&mut inner.hub, self.now());
        while let Some(act) = inner.hub.poll_act() {
            self.carry_out(&mut inner, act);
        }
        while let Some(socket) = inner.hub.poll_awake() {
            if let Some(place) = inner.clients.get(&socket) {
                place.awake.notify_one();
            }
        }
        if inner.hub.poll_timeout() != due {
            self.due.notify_one();
        }
        outcome
    }

    fn carry_out(&self, inner: &mut Inner, act: HubAct) {
        match act {
            HubAct::Home(socket, text) => match inner.clients.get_mut(&socket) {
                None => {}
                Some(Place {
                    home: Home::Session(client),
                    ..
                }) => client.send(&text),
                Some(place) => {
                    let Home::Once(peer) = place.home.clone() else {
                        return;
                    };
                    let (this, home) = (Weak::clone(&self.this), self.home.clone());
                    let asking = self.runtime.spawn(async move {
                        let answer = home.call(peer, &text).await;
                        if let (Some(answer), Some(shared)) = (answer, this.upgrade()) {
                            shared.with(|hub, now| hub.home_says(now, socket, &answer));
                        }
                    });
                    place.calls.push(asking.abort_handle());
                }
            },
            HubAct::Open(line, station) => {
                let awake = Arc::new(Notify::new());
                let carrying =
                    Self::carry(Weak::clone(&self.this), line, station, Arc::clone(&awake));
                let carrying = self.runtime.spawn(carrying);
                inner.lines.insert(line, (awake, carrying.abort_handle()));
            }
            HubAct::Awake(line) => {
                if let Some((awake, _)) = inner.lines.get(&line) {
                    awake.notify_one();
                }
            }
            HubAct::Drop(line) => {
                if let Some((_, carrying)) = inner.lines.remove(&line) {
                    carrying.abort();
                }
            }
            HubAct::Call {
                request,
                socket,
                at,
                token,
                text,
                ends,
            } => {
                let (this, site) = (Weak::clone(&self.this), Arc::clone(&self.site));
                let calling = self.runtime.spawn(async move {
                    let client = "hub".to_owned();
                    let answer = site.call(&at, &Caller { token, client }, text).await;
                    if let Some(shared) = this.upgrade() {
                        shared.with(|hub, now| hub.called(now, request, answer));
                    }
                });
                if let Some(place) = inner.clients.get_mut(&socket).filter(|_| ends) {
                    place.calls.retain(|call| !call.is_finished());
                    place.calls.push(calling.abort_handle());
                }
            }
        }
    }

    /// A line, from its opening to its end. It is bounded both ways: what a station does not take waits in the hub, within the
    /// client's limits; what it sends is taken at once, and of states that wait for the client the newest is kept.
    async fn carry(this: Weak<Self>, line: LineId, station: StationId, awake: Arc<Notify>) {
        let Some(site) = this.upgrade().map(|shared| Arc::clone(&shared.site)) else {
            return;
        };
        let opened = site.open(station).await;
        let Some(shared) = this.upgrade() else {
            return;
        };
        let (to_station, mut from_station) = match opened {
            Ok(channel) => channel.split(),
            Err(error) => {
                return shared.with(|hub, now| hub.line_ended(now, line, &error.to_string(), None));
            }
        };
        shared.with(|hub, _| hub.line_opened(line));
        drop(shared);
        let writer = async {
            loop {
                let Ok(place) = to_station.reserve().await else {
                    // The reader hears why.
                    return std::future::pending::<Option<Closed>>().await;
                };
                // A message is taken out when it can go: until then a stop can overtake it.
                loop {
                    let message = this
                        .upgrade()
                        .map(|shared| shared.lock().hub.poll_line(line));
                    match message {
                        None => return None,
                        Some(Some(LineMessage::Text(text))) => {
                            place.send(ToStation::Text(text));
                            break;
                        }
                        Some(Some(LineMessage::Alive)) => {
                            place.send(ToStation::Alive);
                            break;
                        }
                        Some(None) => awake.notified().await,
                    }
                }
            }
        };
        let reader = async {
            loop {
                let message = from_station.recv().await;
                let shared = this.upgrade()?;
                match message {
                    Some(FromStation::Text(text)) => {
                        shared.with(|hub, now| hub.line_says(now, line, &text));
                    }
                    Some(FromStation::Frame(bytes)) => {
                        shared.with(|hub, _| hub.line_shows(line, &bytes))
                    }
                    Some(FromStation::Closed(closed)) => return Some(closed),
                    None => return Some(Closed::broken()),
                }
            }
        };
        let closed = tokio::select! {
            closed = writer => closed,
            closed = reader => closed,
        };
        if let (Some(closed), Some(shared)) = (closed, this.upgrade()) {
            shared.with(|hub, now| hub.line_ended(now, line, &closed.reason, Some(closed.code)));
        }
    }

    async fn watch(this: Weak<Self>) {
        let Some(mut events) = this.upgrade().map(|shared| shared.site.watch()) else {
            return;
        };
        loop {
            let event = events.next().await;
            let Some(shared) = this.upgrade() else {
                return;
            };
            match event {
                SiteEvent::Missed => {
                    let arms = shared.site.arms().into_keys().collect();
                    shared.with(|hub, now| hub.on_site(now, arms));
                }
                event => shared.with(|hub, now| hub.site(now, event)),
            }
        }
    }

    async fn watch_class(this: Weak<Self>) {
        loop {
            let Some(shared) = this.upgrade() else {
                return;
            };
            shared.look_at_class().await;
            drop(shared);
            sleep(CLASS).await;
        }
    }

    /// Asks the stations for their class by the hub's own token, of which any is enough. One that does not answer changes
    /// nothing.
    async fn look_at_class(&self) {
        let token = self.lock().hub.token();
        if token.is_none() {
            // Without it the hub's people move nothing anyway.
            return;
        }
        let caller = Caller {
            token,
            client: "hub".to_owned(),
        };
        let stations: BTreeMap<_, _> = { self.site.arms().into_keys() }
            .map(|at| (at.station, at))
            .collect();
        let mut pin = None;
        let mut silent = false;
        for at in stations.values() {
            let asked = self.site.call(at, &caller, ASKED.to_owned()).await;
            let answer: Option<Value> =
                { asked.ok().flatten() }.and_then(|text| serde_json::from_str(&text).ok());
            let class = answer.as_ref().and_then(|answer| answer.get("result"));
            match class {
                Some(class) if !class["class"].is_null() => {
                    let known = class["pin"].as_str().unwrap_or_default();
                    pin = Some(known.to_owned());
                    break;
                }
                Some(_) => {}
                None => silent = true,
            }
        }
        if pin.is_some() || !silent {
            self.home.set_class_elsewhere(pin);
        }
    }

    async fn keep_time(this: Weak<Self>) {
        loop {
            let Some(shared) = this.upgrade() else {
                return;
            };
            let due = shared.lock().hub.poll_timeout();
            let begun = shared.begun;
            let sleep = async {
                match due {
                    Some(due) => sleep_until(begun + (due - HostInstant::ZERO)).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                () = sleep => shared.with(|hub, now| hub.handle_timeout(now)),
                () = shared.due.notified() => {}
            }
        }
    }
}

/// A client of a hub. Dropping it is the end of its socket, and of its sessions at stations.
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

    /// What waits to be sent now, if anything does.
    #[must_use]
    pub fn try_receive(&self) -> Option<Outgoing> {
        self.shared.lock().hub.poll_send(self.socket)
    }
}

impl ServedClient for HubClient {
    fn heard(&self) {
        if let Some(home) = self.home() {
            home.heard();
        }
    }

    fn send(&self, text: &str) {
        self.shared
            .with(|hub, now| hub.receive(now, self.socket, text));
    }

    fn vouch(&self, grant: Option<Grant>) {
        if let Some(home) = self.home() {
            home.vouch(grant);
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

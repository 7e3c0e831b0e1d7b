//! Carries out the actions of a hub: messages to home, lines to stations, single requests, and
//! timers.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use magician_protocol::HostInstant;
use magician_station::{Client, Peer, ProgramStore, RunningStation};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep_until};

use super::{Hub, HubAction, LineId, LineMessage, SocketId};
use crate::channel::{Closed, FromStation, ToStation};
use crate::site::{Caller, Site, SiteEvent, StationId};

pub(super) struct Shared {
    pub(super) inner: Mutex<Inner>,
    pub(super) home: RunningStation,
    pub(super) library: Arc<dyn ProgramStore>,
    pub(super) read_only: bool,
    pub(super) site: Arc<dyn Site>,
    pub(super) started_at: Instant,
    pub(super) due: Notify,
    pub(super) this: Weak<Shared>,
    pub(super) runtime: Handle,
}

pub(super) struct Inner {
    pub(super) hub: Hub,
    pub(super) clients: BTreeMap<SocketId, ClientResources>,
    pub(super) lines: BTreeMap<LineId, (Arc<Notify>, AbortHandle)>,
}

/// Resources of a client.
pub(super) struct ClientResources {
    pub(super) awake: Arc<Notify>,
    pub(super) home: Home,
    /// Tasks that are aborted when the client disconnects.
    pub(super) calls: Vec<AbortHandle>,
}

/// Connection of a client to the hub's own station.
#[derive(Clone)]
pub(super) enum Home {
    Session(Arc<Client>),
    /// Single requests without a session.
    Once(Peer),
}

impl Shared {
    pub(super) fn lock(&self) -> MutexGuard<'_, Inner> {
        // A panic in the hub is a bug, but its fields are still whole values: go on instead of
        // blocking stops of all clients.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.started_at.elapsed()
    }

    /// Runs `act` on the hub, then carries out the resulting actions and wakes clients and the
    /// timer.
    pub(super) fn with<T>(&self, act: impl FnOnce(&mut Hub, HostInstant) -> T) -> T {
        let mut inner = self.lock();
        let due = inner.hub.poll_timeout();
        let outcome = act(&mut inner.hub, self.now());
        while let Some(act) = inner.hub.poll_action() {
            self.execute(&mut inner, act);
        }
        while let Some(socket) = inner.hub.poll_awake() {
            if let Some(entry) = inner.clients.get(&socket) {
                entry.awake.notify_one();
            }
        }
        if inner.hub.poll_timeout() != due {
            self.due.notify_one();
        }
        outcome
    }

    pub(super) fn execute(&self, inner: &mut Inner, act: HubAction) {
        match act {
            HubAction::Home(socket, text) => match inner.clients.get_mut(&socket) {
                None => {}
                Some(ClientResources {
                    home: Home::Session(client),
                    ..
                }) => client.send(&text),
                Some(entry) => {
                    let Home::Once(peer) = entry.home.clone() else {
                        return;
                    };
                    let (this, home) = (Weak::clone(&self.this), self.home.clone());
                    let asking = self.runtime.spawn(async move {
                        let answer = home.call(peer, &text).await;
                        if let (Some(answer), Some(shared)) = (answer, this.upgrade()) {
                            shared.with(|hub, now| hub.receive_from_home(now, socket, &answer));
                        }
                    });
                    entry.calls.push(asking.abort_handle());
                }
            },
            HubAction::Open(line, station) => {
                let awake = Arc::new(Notify::new());
                let carrying =
                    Self::run_line(Weak::clone(&self.this), line, station, Arc::clone(&awake));
                let carrying = self.runtime.spawn(carrying);
                inner.lines.insert(line, (awake, carrying.abort_handle()));
            }
            HubAction::Awake(line) => {
                if let Some((awake, _)) = inner.lines.get(&line) {
                    awake.notify_one();
                }
            }
            HubAction::Drop(line) => {
                if let Some((_, carrying)) = inner.lines.remove(&line) {
                    carrying.abort();
                }
            }
            HubAction::Call {
                request,
                socket,
                at,
                token,
                text,
                ends,
            } => {
                let (this, site) = (Weak::clone(&self.this), Arc::clone(&self.site));
                let calling = self.runtime.spawn(async move {
                    let answer = site.call(&at, &Caller { token }, text).await;
                    if let Some(shared) = this.upgrade() {
                        shared.with(|hub, now| hub.call_completed(now, request, answer));
                    }
                });
                if let Some(entry) = inner.clients.get_mut(&socket).filter(|_| ends) {
                    entry.calls.retain(|call| !call.is_finished());
                    entry.calls.push(calling.abort_handle());
                }
            }
        }
    }

    /// Runs a line from its opening to its end.
    ///
    /// Memory is bounded in both directions: messages that the station does not take wait in the
    /// hub, within the limits of the client; messages of the station are taken at once, and only
    /// the newest unread state is kept for the client.
    pub(super) async fn run_line(
        this: Weak<Self>,
        line: LineId,
        station: StationId,
        awake: Arc<Notify>,
    ) {
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
                let Ok(permit) = to_station.reserve().await else {
                    // The channel is closed: the reader receives the reason.
                    return std::future::pending::<Option<Closed>>().await;
                };
                // Take a message out only once it can be sent: until then a stop can overtake it.
                loop {
                    let message = this
                        .upgrade()
                        .map(|shared| shared.lock().hub.poll_line(line));
                    match message {
                        None => return None,
                        Some(Some(LineMessage::Text(text))) => {
                            permit.send(ToStation::Text(text));
                            break;
                        }
                        Some(Some(LineMessage::KeepAlive)) => {
                            permit.send(ToStation::KeepAlive);
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
                        shared.with(|hub, now| hub.receive_from_line(now, line, &text));
                    }
                    Some(FromStation::Frame(bytes)) => {
                        shared.with(|hub, _| hub.receive_frame(line, &bytes))
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

    pub(super) async fn watch(this: Weak<Self>) {
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
                    shared.with(|hub, now| hub.set_present_arms(now, arms));
                }
                event => shared.with(|hub, now| hub.site(now, event)),
            }
        }
    }

    pub(super) async fn run_timers(this: Weak<Self>) {
        loop {
            let Some(shared) = this.upgrade() else {
                return;
            };
            let due = shared.lock().hub.poll_timeout();
            let begun = shared.started_at;
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

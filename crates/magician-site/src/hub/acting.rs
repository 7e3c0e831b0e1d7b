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

use super::{Hub, HubAct, LineId, LineMessage, SocketId};
use crate::channel::{Closed, FromStation, ToStation};
use crate::site::{Caller, Site, SiteEvent, StationId};

pub(super) struct Shared {
    pub(super) inner: Mutex<Inner>,
    pub(super) home: RunningStation,
    pub(super) library: Arc<dyn ProgramStore>,
    pub(super) read_only: bool,
    pub(super) site: Arc<dyn Site>,
    pub(super) begun: Instant,
    pub(super) due: Notify,
    pub(super) this: Weak<Shared>,
    pub(super) runtime: Handle,
}

pub(super) struct Inner {
    pub(super) hub: Hub,
    pub(super) clients: BTreeMap<SocketId, Place>,
    pub(super) lines: BTreeMap<LineId, (Arc<Notify>, AbortHandle)>,
}

/// Resources of a client.
pub(super) struct Place {
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
        HostInstant::ZERO + self.begun.elapsed()
    }

    /// Runs `act` on the hub, then carries out the resulting actions and wakes clients and the
    /// timer.
    pub(super) fn with<T>(&self, act: impl FnOnce(&mut Hub, HostInstant) -> T) -> T {
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

    pub(super) fn carry_out(&self, inner: &mut Inner, act: HubAct) {
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
                    let answer = site.call(&at, &Caller { token }, text).await;
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

    /// Runs a line from its opening to its end.
    ///
    /// Memory is bounded in both directions: messages that the station does not take wait in the
    /// hub, within the limits of the client; messages of the station are taken at once, and only
    /// the newest unread state is kept for the client.
    pub(super) async fn carry(
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
                let Ok(place) = to_station.reserve().await else {
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
                    shared.with(|hub, now| hub.on_site(now, arms));
                }
                event => shared.with(|hub, now| hub.site(now, event)),
            }
        }
    }

    pub(super) async fn keep_time(this: Weak<Self>) {
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

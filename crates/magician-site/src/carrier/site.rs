//! A site seen from outside its stations, such as from a hub or an observer.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use futures_util::future::join_all;
use magician_station::api::{Message, Method};
use magician_station::client::StationDial;
use tokio::runtime::Handle;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_rustls::rustls::ClientConfig;
use zenoh::Session;
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::sample::{Sample, SampleKind};

use super::dial::{failed, session};
use super::revoked::{self, ListExchange};
use super::{CarrierError, Connection};
use crate::certificates::Identity;
use crate::keys::{Keys, SiteName};
use crate::message::StateMessage;
use crate::{
    ArmAt, ArmReport, BoxFuture, Caller, Channel, Roster, Site, SiteError, SiteEvents, SiteView,
    StationId,
};

/// Timeout of a query for one state. The state is published every second anyway.
const STATE_QUERY_TIMEOUT: Duration = Duration::from_secs(1);
/// Most state queries at the same time. A choice: joining a site with many arms must not flood it.
const MAX_STATE_QUERIES: usize = 32;
/// Time for stations to reply with their roster.
const ROSTER_TIMEOUT: Duration = Duration::from_millis(500);
/// Most addresses of a station that are kept. All are dialled at once, so this also bounds the
/// connections per request.
const MAX_STORED_ADDRESSES: usize = 16;

/// A site over Zenoh.
pub struct ZenohSite {
    shared: Arc<Shared>,
    connection: Connection,
    _declared: Declarations,
}

struct Shared {
    keys: Keys,
    view: SiteView,
    identity: Option<Identity>,
    /// Present stations, each with the machines that announce it. A station runs on one machine: if
    /// two announce the same id, one of them is an impostor.
    locations: Mutex<BTreeMap<StationId, BTreeMap<String, StationLocation>>>,
    /// Cached TLS configuration. Cleared when a newer list of revoked certificates arrives.
    config: Mutex<Option<Arc<ClientConfig>>>,
}

/// Location of a station according to one machine.
#[derive(Debug, Default)]
struct StationLocation {
    /// Arms that the machine announces.
    arms: BTreeSet<String>,
    /// Addresses to try. They are unproved: the peer has to show the certificate of the machine.
    at: Vec<SocketAddr>,
}

impl StationLocation {
    /// Puts new addresses in front and keeps older ones. Any host on the bus can announce wrong
    /// addresses, or none, and a stop must reach the station nevertheless.
    fn add_addresses(&mut self, at: &[SocketAddr]) {
        let older = std::mem::take(&mut self.at);
        self.at = at.to_vec();
        self.at
            .extend(older.iter().filter(|older| !at.contains(older)));
        self.at.truncate(MAX_STORED_ADDRESSES);
    }
}

impl fmt::Debug for ZenohSite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ZenohSite")
            .field("site", &self.shared.keys.site)
            .finish_non_exhaustive()
    }
}

impl ZenohSite {
    /// Joins a site with Zenoh's configuration file, or the defaults without one. Runs on any tokio
    /// runtime.
    ///
    /// Without a certificate the site shows what stations publish, unproved, and sends no requests.
    ///
    /// # Errors
    /// [`CarrierError`] if the configuration, network or certificate is unusable.
    pub async fn join(
        site: SiteName,
        config: Option<&Path>,
        identity: Option<Identity>,
    ) -> Result<Self, CarrierError> {
        let connection = Connection::open(config, identity.as_ref()).await?;
        let shared = Arc::new(Shared {
            keys: Keys { site },
            view: SiteView::default(),
            identity,
            locations: Mutex::default(),
            config: Mutex::default(),
        });
        let watched = Arc::clone(&shared);
        let ended = || CarrierError::Network("it ended".to_owned());
        let declared = connection
            .with_session(|session| async move { watch(&session, watched).await })
            .await
            .ok_or_else(ended)??;
        Ok(Self {
            shared,
            connection,
            _declared: declared,
        })
    }

    /// True if this machine has a certificate of the site. Then published states come from members,
    /// and requests can be sent.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        self.shared.identity.is_some()
    }

    /// Dials all stations. Returns the stations that prove their identity within this time, by the
    /// certificate of their machine. States of the others are unproved.
    pub async fn proved_stations(&self, within: Duration) -> BTreeSet<StationId> {
        let stations: BTreeSet<_> = self.arms().into_keys().map(|at| at.station).collect();
        let dials = stations.into_iter().filter_map(|station| {
            let dial = self.shared.dial(station).ok()?;
            Some(async move {
                let shown = timeout(within, dial.is_reachable()).await;
                shown.unwrap_or(false).then_some(station)
            })
        });
        join_all(dials).await.into_iter().flatten().collect()
    }
}

/// Declarations that keep the view up to date.
struct Declarations {
    _subscribers: [Subscriber<()>; 2],
    _lists: Option<ListExchange>,
}

/// Starts to fill the view from the bus.
async fn watch(session: &Session, shared: Arc<Shared>) -> zenoh::Result<Declarations> {
    let lists = match &shared.identity {
        None => None,
        Some(identity) => {
            let here = Arc::clone(&shared);
            let newer = move || *here.config() = None;
            Some(revoked::follow(session, &shared.keys, identity, newer).await?)
        }
    };
    let receiver = Arc::clone(&shared);
    let states = session.declare_subscriber(shared.keys.state("*", "*"));
    let states = states
        .callback(move |sample| receiver.handle_sample(&sample))
        .await?;
    let (asking, runtime) = (
        Arc::new(Semaphore::new(MAX_STATE_QUERIES)),
        Handle::current(),
    );
    let asked = session.clone();
    let key = shared.keys.all_alive("*");
    let presence = move |sample: Sample| {
        let Some((machine, at)) = shared.keys.parse_alive(sample.key_expr()) else {
            return;
        };
        if sample.kind() == SampleKind::Delete {
            shared.remove_token(machine, &at);
            return;
        }
        shared.add_token(machine, at.clone());
        let key = shared.keys.state(machine, &at.arm);
        let (session, shared) = (asked.clone(), Arc::clone(&shared));
        let asking = Arc::clone(&asking);
        runtime.spawn(async move {
            let _turn = asking.acquire().await;
            query_state(&session, &shared, key).await;
        });
    };
    let liveliness = session.liveliness();
    let alive = liveliness.declare_subscriber(key).history(true);
    let alive = alive.callback(presence).await?;
    Ok(Declarations {
        _subscribers: [states, alive],
        _lists: lists,
    })
}

/// Queries the state of an arm that has just appeared, so that clients need not wait for its next
/// publication.
async fn query_state(session: &Session, shared: &Shared, key: String) {
    let asked = session
        .get(key)
        .target(QueryTarget::All)
        .timeout(STATE_QUERY_TIMEOUT);
    let asked = asked.consolidation(ConsolidationMode::None);
    let Ok(replies) = asked.await else {
        return;
    };
    while let Ok(reply) = replies.recv_async().await {
        if let Ok(sample) = reply.result() {
            shared.handle_sample(sample);
        }
    }
}

impl Shared {
    fn locations(&self) -> MutexGuard<'_, BTreeMap<StationId, BTreeMap<String, StationLocation>>> {
        self.locations
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn config(&self) -> MutexGuard<'_, Option<Arc<ClientConfig>>> {
        self.config.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add_token(&self, machine: &str, at: ArmAt) {
        let mut places = self.locations();
        let machines = places.entry(at.station).or_default();
        let place = machines.entry(machine.to_owned()).or_default();
        place.arms.insert(at.arm.clone());
        // While the lock is held, as in `remove_token`, so that the view sees both in the same
        // order.
        self.view.arrived(at);
    }

    /// Removes one machine's token of an arm. The arm stays while any machine has a token of it, so
    /// that the end of a forged token hides no arm.
    fn remove_token(&self, machine: &str, at: &ArmAt) {
        let mut places = self.locations();
        if let Some(machines) = places.get_mut(&at.station) {
            if let Some(place) = machines.get_mut(machine) {
                place.arms.remove(&at.arm);
                if place.arms.is_empty() {
                    machines.remove(machine);
                }
            }
            if machines.values().any(|place| place.arms.contains(&at.arm)) {
                return;
            }
            if machines.is_empty() {
                places.remove(&at.station);
            }
        }
        self.view.left(at);
    }

    /// Handles a published state.
    fn handle_sample(&self, sample: &Sample) {
        let key = self.keys.parse_state(sample.key_expr());
        let message = StateMessage::parse(&sample.payload().to_bytes());
        let (Some((machine, arm)), Some(message)) = (key, message) else {
            return;
        };
        let station = message.station;
        let mut places = self.locations();
        let machines = places.get_mut(&station);
        let Some(place) = machines.and_then(|machines| machines.get_mut(machine)) else {
            // Ignore a state under the key of a machine that did not announce this station.
            return;
        };
        place.add_addresses(&message.at);
        drop(places);
        let arm = arm.to_owned();
        self.view
            .report(ArmAt { arm, station }, message.report(machine));
    }

    /// Prepares to dial a station. Fails unless exactly one machine announces it and this machine
    /// has a certificate.
    fn dial(&self, station: StationId) -> Result<StationDial, SiteError> {
        let places = self.locations();
        let machines = places.get(&station).ok_or(SiteError::Gone)?;
        let unproved = |why: String| SiteError::Unproved(why);
        let mut named = machines.iter();
        let (Some((machine, place)), None) = (named.next(), named.next()) else {
            let names: Vec<_> = machines.keys().map(String::as_str).collect();
            let names = names.join(", ");
            let why = format!(
                "several machines say that they are the station {station}, and one may be after its \
                 tokens: {names}. It is sent nothing"
            );
            return Err(unproved(why));
        };
        let Some(identity) = &self.identity else {
            let why = "this machine has no certificate of the site, so stations are shown and told nothing";
            return Err(unproved(why.to_owned()));
        };
        let mut config = self.config();
        let config = match &*config {
            Some(config) => Arc::clone(config),
            None => {
                let made = identity.client();
                let made = made.map_err(|error| unproved(error.to_string()))?;
                Arc::clone(config.insert(made))
            }
        };
        Ok(StationDial::new(machine, place.at.clone(), config))
    }

    /// Refuses requests to an arm whose name is ambiguous, except methods that are always allowed,
    /// such as a stop.
    fn check_request(&self, at: &ArmAt, request: &str) -> Result<(), SiteError> {
        let same = self.view.count_named(&at.arm);
        let message = Message::parse(request).ok();
        let method = message.and_then(|message| Method::named(&message.method));
        if same > 1 && !method.is_some_and(|method| method.always) {
            let why = format!(
                "{same} stations have an arm {}: only stops reach it",
                at.arm
            );
            return Err(SiteError::Refused(why));
        }
        Ok(())
    }
}

impl Site for ZenohSite {
    fn name(&self) -> &str {
        self.shared.keys.site.as_str()
    }

    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmReport>> {
        self.shared.view.arms()
    }

    fn watch(&self) -> SiteEvents {
        self.shared.view.watch()
    }

    fn call<'a>(
        &'a self,
        at: &'a ArmAt,
        caller: &'a Caller,
        request: String,
    ) -> BoxFuture<'a, Result<Option<String>, SiteError>> {
        Box::pin(async move {
            self.shared.check_request(at, &request)?;
            let dial = self.shared.dial(at.station)?;
            let answer = tokio::select! {
                answer = dial.post(caller.token.as_deref(), request) => answer.map_err(failed)?,
                // TCP alone takes minutes to notice a cut cable; the bus does so within seconds.
                () = self.shared.view.wait_gone(at.station) => return Err(SiteError::NoAnswer),
            };
            Ok(Some(answer).filter(|answer| !answer.is_empty()))
        })
    }

    fn roster(&self) -> BoxFuture<'_, Roster> {
        Box::pin(async move {
            let key = self.shared.keys.roster("*");
            let read = self.connection.with_session(|session| async move {
                let mut roster = Roster::default();
                let asked = session
                    .get(key)
                    .target(QueryTarget::All)
                    .timeout(ROSTER_TIMEOUT);
                let asked = asked.consolidation(ConsolidationMode::None).await;
                let Ok(replies) = asked else { return roster };
                while let Ok(reply) = replies.recv_async().await {
                    let said = reply.result().ok().map(Sample::payload);
                    let said = said.and_then(|bytes| bytes.try_to_string().ok());
                    if let Some(Ok(said)) = said.map(|text| Roster::parse(&text)) {
                        roster.add(&said);
                    }
                }
                roster
            });
            read.await.unwrap_or_default()
        })
    }

    fn open(&self, station: StationId) -> BoxFuture<'_, Result<Channel, SiteError>> {
        Box::pin(async move {
            let dial = self.shared.dial(station)?;
            let socket = dial.socket().await.map_err(failed)?;
            let shared = Arc::clone(&self.shared);
            let gone = async move { shared.view.wait_gone(station).await };
            Ok(session(socket, gone))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_addresses_are_kept_after_a_state_with_others() {
        let at = |port: u16| SocketAddr::from(([10, 0, 0, 1], port));
        let mut place = StationLocation::default();
        place.add_addresses(&[at(1), at(2)]);
        place.add_addresses(&[]);
        assert_eq!(place.at, [at(1), at(2)]);
        place.add_addresses(&[at(3), at(2)]);
        assert_eq!(place.at, [at(3), at(2), at(1)]);
        for port in 100..200 {
            place.add_addresses(&[at(port)]);
        }
        assert_eq!(place.at.len(), MAX_STORED_ADDRESSES);
    }
}

//! A station on its site: announces its arms, publishes their states, and accepts connections of
//! members.
//!
//! Names of arms are unique on a site. A station first searches for stations with the same names,
//! then declares its own tokens, waits, and searches again. If two stations with the same arm name
//! start at the same time, the station with the lower id stays and the other one leaves.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician_station::RunningStation;
use magician_station::http::TokenStore;
use serde_json::{Value, json};
use tokio::runtime::Handle;
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{sleep, timeout};
use zenoh::Session;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{Query, Queryable};

use super::api::SiteApi;
use super::publish::{ArmPublisher, MAX_ARMS_PER_CLIENT, OwnStation, publish_states};
use super::revoked::{self, ListExchange};
use super::{AbortOnDrop, CarrierError, Connection, LEAVE_TIMEOUT, reply};
use crate::certificates::Identity;
use crate::keys::{Keys, SiteName};
use crate::{ArmAt, StateThrottle, StationId};

/// Most queries that are answered at the same time. A choice: enough for all hubs and observers of
/// a site, and a bound on the work that a stranger can cause.
const MAX_CONCURRENT_ANSWERS: usize = 64;
/// Time to wait for the owner of a name to reply.
const NAME_QUERY_TIMEOUT: Duration = Duration::from_millis(500);
/// Time for the tokens of two stations that start at the same time to reach each other.
const TOKEN_PROPAGATION_TIME: Duration = Duration::from_millis(300);

/// An arm as announced on the site.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServedArm {
    /// Name of the arm, at its station and on the site.
    pub name: String,
    /// Port of the arm as configured at the station.
    pub port: String,
    /// True for a virtual arm.
    pub is_virtual: bool,
}

/// Options of joining a site as a station.
#[derive(Clone, Debug)]
pub struct NodeOptions {
    /// Name of the site.
    pub site: SiteName,
    /// Name of this machine. Ignored if [`identity`](Self::identity) is set: its certificate
    /// contains the name.
    pub machine: String,
    /// Arms of the station, in its order.
    pub arms: Vec<ServedArm>,
    /// Zenoh's configuration file. `None` for the defaults.
    pub config: Option<PathBuf>,
    /// Certificate of this machine. Without it the station publishes states but accepts no requests
    /// from the site.
    pub identity: Option<Identity>,
}

/// Presence of a station on a site. Dropping it leaves the site.
pub struct SiteNode {
    id: StationId,
    api: Option<Arc<SiteApi>>,
    /// Declared before the connection, so that it is dropped first: its declarations live on that.
    presence: Presence,
    connection: Connection,
}

/// Declarations of a station on the bus.
struct Presence {
    tokens: Vec<LivelinessToken>,
    _queryables: Vec<Queryable<()>>,
    _lists: Option<ListExchange>,
    _tasks: Vec<AbortOnDrop>,
}

impl fmt::Debug for SiteNode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SiteNode")
            .field("id", &self.id)
            .finish_non_exhaustive()
    }
}

impl SiteNode {
    /// Joins a site with all arms of a station. Needs a tokio runtime. Requests from the site need
    /// a token of `tokens`, like those of any other remote machine.
    ///
    /// # Errors
    /// [`CarrierError::Taken`] if another station has an arm of one of these names; any other
    /// [`CarrierError`].
    pub async fn join(
        options: NodeOptions,
        station: RunningStation,
        tokens: TokenStore,
    ) -> Result<Self, CarrierError> {
        let NodeOptions {
            site,
            machine,
            arms,
            config,
            identity,
        } = options;
        if identity.as_ref().is_some_and(Identity::is_revoked) {
            let why =
                "the certificate of this machine is revoked: it is let in nowhere on the site";
            return Err(CarrierError::Certificate(why.to_owned()));
        }
        let connection = Connection::open(config.as_deref(), identity.as_ref()).await?;
        let api = match &identity {
            Some(identity) => Some(SiteApi::open(identity, &station, &tokens).await?),
            None => None,
        };
        // A new id at each start, so that a restarted station is a different one.
        let mut random = [0; 8];
        getrandom::fill(&mut random).map_err(|error| CarrierError::Network(error.to_string()))?;
        let own = Arc::new(OwnStation {
            keys: Keys { site },
            id: StationId(u64::from_le_bytes(random)),
            machine: identity
                .as_ref()
                .map_or(machine, |own| own.machine().to_owned()),
            at: api.as_ref().map_or_else(Vec::new, |api| api.addresses()),
            station,
        });
        let id = own.id;
        let certified = identity.zip(api.clone());
        let ended = || CarrierError::Network("it ended".to_owned());
        let joined = connection
            .with_session(|session| async move { begin(&session, own, arms, certified).await })
            .await;
        match joined.unwrap_or_else(|| Err(ended())) {
            Ok(presence) => Ok(Self {
                id,
                api,
                presence,
                connection,
            }),
            Err(error) => {
                connection.close().await;
                Err(error)
            }
        }
    }

    /// Id of the station on the site.
    #[must_use]
    pub fn id(&self) -> StationId {
        self.id
    }

    /// Addresses of the listener for members of the site. Empty without a certificate.
    #[must_use]
    pub fn addresses(&self) -> Vec<SocketAddr> {
        self.api
            .as_ref()
            .map_or_else(Vec::new, |api| api.addresses())
    }

    /// Leaves the site. The presence is withdrawn first, so that no client dials a station that has
    /// stopped to answer.
    pub async fn leave(self) {
        let Presence {
            tokens,
            _queryables,
            _lists,
            _tasks,
        } = self.presence;
        self.connection
            .with_session(|_| async move {
                let all = async {
                    for token in tokens {
                        let _ = token.undeclare().await;
                    }
                };
                let _ = timeout(LEAVE_TIMEOUT, all).await;
            })
            .await;
        self.connection.close().await;
        if let Some(api) = &self.api {
            api.close().await;
        }
    }
}

async fn begin(
    session: &Session,
    own: Arc<OwnStation>,
    arms: Vec<ServedArm>,
    certified: Option<(Identity, Arc<SiteApi>)>,
) -> Result<Presence, CarrierError> {
    for arm in &arms {
        check_name_free(session, &own, arm, |_| true).await?;
    }
    let mut presence = Presence {
        tokens: Vec::new(),
        _queryables: Vec::new(),
        _lists: None,
        _tasks: Vec::new(),
    };
    if let Some((identity, api)) = certified {
        let newer = move || api.restart();
        presence._lists = Some(revoked::follow(session, &own.keys, &identity, newer).await?);
    }
    let responder = Arc::new(QueryResponder {
        own: Arc::clone(&own),
        permits: Arc::new(Semaphore::new(MAX_CONCURRENT_ANSWERS)),
        runtime: Handle::current(),
    });
    let (here, key) = (Arc::clone(&responder), own.keys.roster(&own.machine));
    let answer = move |query| here.reply_roster(query);
    presence
        ._queryables
        .push(session.declare_queryable(key).callback(answer).await?);
    for together in arms.chunks(MAX_ARMS_PER_CLIENT) {
        // Each publisher reports once whether it has subscribers, and then every change. The
        // channel has ample room: callbacks of the network must not wait, so they use `try_send`.
        let (listened, listening) = mpsc::channel(64 * MAX_ARMS_PER_CLIENT);
        let mut publishers = Vec::new();
        for (at, arm) in together.iter().enumerate() {
            let listened = listened.clone();
            let one = ArmPublisher::declare(session, &own, arm.clone(), at, listened).await?;
            let (here, throttle) = (Arc::clone(&responder), one.throttle());
            let state = own.keys.state(&own.machine, &arm.name);
            let of = arm.clone();
            let answer = move |query| here.reply_state(&of, &throttle, query);
            presence
                ._queryables
                .push(session.declare_queryable(state).callback(answer).await?);
            publishers.push(one);
        }
        let publishing = tokio::spawn(publish_states(Arc::clone(&own), publishers, listening));
        presence._tasks.push(AbortOnDrop(publishing.abort_handle()));
    }
    // Last of all: as soon as the tokens are visible, clients may send queries.
    for arm in &arms {
        let at = ArmAt {
            arm: arm.name.clone(),
            station: own.id,
        };
        let key = own.keys.alive(&own.machine, &at);
        let token = session.liveliness().declare_token(key).await?;
        presence.tokens.push(token);
    }
    sleep(TOKEN_PROPAGATION_TIME).await;
    for arm in &arms {
        // Both stations see each other now; the lower id stays.
        check_name_free(session, &own, arm, |other| other < own.id).await?;
    }
    Ok(presence)
}

/// Fails if another station has the name of this arm and `goes_before` is true for its id.
async fn check_name_free(
    session: &Session,
    own: &OwnStation,
    arm: &ServedArm,
    goes_before: impl Fn(StationId) -> bool,
) -> Result<(), CarrierError> {
    let key = own.keys.all_alive(&arm.name);
    let replies = session
        .liveliness()
        .get(key)
        .timeout(NAME_QUERY_TIMEOUT)
        .await?;
    let mut other = None;
    while let Ok(reply) = replies.recv_async().await {
        let Ok(sample) = reply.result() else { continue };
        let found = own.keys.parse_alive(sample.key_expr());
        let found = found.filter(|(_, at)| at.station != own.id && goes_before(at.station));
        other = other.or(found.map(|(machine, at)| (machine.to_owned(), at)));
    }
    let Some((machine, at)) = other else {
        return Ok(());
    };
    Err(CarrierError::Taken {
        site: own.keys.site.clone(),
        machine,
        arm: at.arm,
        station: at.station,
    })
}

/// Replies to queries for states and the roster. They are public, so no certificate is needed.
struct QueryResponder {
    own: Arc<OwnStation>,
    permits: Arc<Semaphore>,
    runtime: Handle,
}

impl QueryResponder {
    /// Replies with the roster. Called on a thread of the network.
    fn reply_roster(self: &Arc<Self>, query: Query) {
        self.reply_later(query, async |own| {
            let roster = own.request("site.roster", json!({})).await;
            roster.unwrap_or_default().to_string().into_bytes()
        });
    }

    /// Replies with the state of an arm: a fresh one if the station has it, otherwise the last
    /// known. Called on a thread of the network.
    fn reply_state(
        self: &Arc<Self>,
        arm: &ServedArm,
        throttle: &Arc<Mutex<StateThrottle>>,
        query: Query,
    ) {
        let (arm, throttle) = (arm.clone(), Arc::clone(throttle));
        self.reply_later(query, async move |own| {
            let fresh = own.request("arm.state", json!({"arm": arm.name})).await;
            let last = || {
                let throttle = throttle.lock().unwrap_or_else(PoisonError::into_inner);
                throttle.last()
            };
            own.state_message(&arm, fresh.unwrap_or_else(last))
        });
    }

    /// Replies from a separate task, because a thread of the network must not wait.
    fn reply_later<Reply>(
        self: &Arc<Self>,
        query: Query,
        answer: impl FnOnce(Arc<OwnStation>) -> Reply + Send + 'static,
    ) where
        Reply: Future<Output = Vec<u8>> + Send,
    {
        let Ok(place) = Arc::clone(&self.permits).try_acquire_owned() else {
            // Too many queries: drop this one. A subscriber gets the state within a second anyway.
            return;
        };
        let own = Arc::clone(&self.own);
        self.runtime.spawn(async move {
            let _place = place;
            reply(&query, answer(own).await);
        });
    }
}

impl OwnStation {
    /// Sends a request to the station as a viewer. Returns `None` on any error.
    async fn request(&self, method: &str, params: Value) -> Option<Value> {
        let peer = self.viewer().ok()?;
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let answer = self.station.call(peer, &request.to_string()).await?;
        let mut answer: Value = serde_json::from_str(&answer).ok()?;
        answer.get_mut("result").map(Value::take)
    }
}

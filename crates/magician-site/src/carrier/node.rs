//! A station on its site: it is there, tells, and can be dialled by those who have a certificate.

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
use super::publish::{Own, TOGETHER, Told, tell};
use super::revoked::{self, Lists};
use super::{Aborting, CarrierError, Connection, FAREWELL, reply};
use crate::certificates::Identity;
use crate::keys::{Keys, SiteName};
use crate::{ArmAt, StateTelling, StationId};

/// Questions that are answered at once, at most.
const ANSWERS: usize = 64;
/// Whoever has a name says so within this.
const NAMES: Duration = Duration::from_millis(500);
/// Two that began at once hear of each other within this.
const AT_ONCE: Duration = Duration::from_millis(300);

/// An arm as its site hears of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServedArm {
    /// Its name at its station and on the site.
    pub name: String,
    /// Where it is, as a person wrote it.
    pub port: String,
    /// Whether it is a virtual one.
    pub is_virtual: bool,
}

/// How a station joins a site.
#[derive(Clone, Debug)]
pub struct NodeOptions {
    /// The site.
    pub site: SiteName,
    /// The name of this machine, where it has no certificate with another one.
    pub machine: String,
    /// The arms of the station, in its order.
    pub arms: Vec<ServedArm>,
    /// A file of Zenoh's settings.
    pub config: Option<PathBuf>,
    /// The certificate of this machine. Without it the station tells states, and takes no requests
    /// from the site.
    pub identity: Option<Identity>,
}

/// A station on its site. Dropping it leaves the site.
pub struct SiteNode {
    id: StationId,
    api: Option<Arc<SiteApi>>,
    /// Before the connection: what it holds lives on that.
    presence: Presence,
    connection: Connection,
}

/// What a station has declared.
struct Presence {
    tokens: Vec<LivelinessToken>,
    _queryables: Vec<Queryable<()>>,
    _lists: Option<Lists>,
    _tasks: Vec<Aborting>,
}

impl fmt::Debug for SiteNode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SiteNode")
            .field("id", &self.id)
            .finish_non_exhaustive()
    }
}

impl SiteNode {
    /// Joins a site with all arms of a station, on a tokio runtime. Requests from the site need one of
    /// these tokens, as from any other machine.
    ///
    /// # Errors
    /// [`CarrierError::Taken`] where the site has an arm of one of these names, and the others.
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
        let mut random = [0; 8];
        getrandom::fill(&mut random).map_err(|error| CarrierError::Network(error.to_string()))?;
        let own = Arc::new(Own {
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
            .within(|session| async move { begin(&session, own, arms, certified).await })
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

    /// The station's id.
    #[must_use]
    pub fn id(&self) -> StationId {
        self.id
    }

    /// Addresses of its listener for the site; none without a certificate.
    #[must_use]
    pub fn addresses(&self) -> Vec<SocketAddr> {
        self.api
            .as_ref()
            .map_or_else(Vec::new, |api| api.addresses())
    }

    /// Leaves the site: first it is there no more, then it answers no more.
    pub async fn leave(self) {
        let Presence {
            tokens,
            _queryables,
            _lists,
            _tasks,
        } = self.presence;
        self.connection
            .within(|_| async move {
                let all = async {
                    for token in tokens {
                        let _ = token.undeclare().await;
                    }
                };
                let _ = timeout(FAREWELL, all).await;
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
    own: Arc<Own>,
    arms: Vec<ServedArm>,
    certified: Option<(Identity, Arc<SiteApi>)>,
) -> Result<Presence, CarrierError> {
    for arm in &arms {
        refuse_taken(session, &own, arm, |_| true).await?;
    }
    let mut presence = Presence {
        tokens: Vec::new(),
        _queryables: Vec::new(),
        _lists: None,
        _tasks: Vec::new(),
    };
    if let Some((identity, api)) = certified {
        let newer = move || api.renew();
        presence._lists = Some(revoked::follow(session, &own.keys, &identity, newer).await?);
    }
    let answering = Arc::new(Answering {
        own: Arc::clone(&own),
        places: Arc::new(Semaphore::new(ANSWERS)),
        runtime: Handle::current(),
    });
    let (here, key) = (Arc::clone(&answering), own.keys.roster(&own.machine));
    let answer = move |query| here.tell_roster(query);
    presence
        ._queryables
        .push(session.declare_queryable(key).callback(answer).await?);
    for together in arms.chunks(TOGETHER) {
        // Each tells once whether somebody listens, and then when that changes.
        let (listened, listening) = mpsc::channel(64 * TOGETHER);
        let mut told = Vec::new();
        for (at, arm) in together.iter().enumerate() {
            let listened = listened.clone();
            let one = Told::declare(session, &own, arm.clone(), at, listened).await?;
            let (here, telling) = (Arc::clone(&answering), one.telling());
            let state = own.keys.state(&own.machine, &arm.name);
            let of = arm.clone();
            let answer = move |query| here.tell_state(&of, &telling, query);
            presence
                ._queryables
                .push(session.declare_queryable(state).callback(answer).await?);
            told.push(one);
        }
        let telling = tokio::spawn(tell(Arc::clone(&own), told, listening));
        presence._tasks.push(Aborting(telling.abort_handle()));
    }
    // Who is there can be asked.
    for arm in &arms {
        let at = ArmAt {
            arm: arm.name.clone(),
            station: own.id,
        };
        let key = own.keys.alive(&own.machine, &at);
        let token = session.liveliness().declare_token(key).await?;
        presence.tokens.push(token);
    }
    sleep(AT_ONCE).await;
    for arm in &arms {
        // Of two that began at once one stays.
        refuse_taken(session, &own, arm, |other| other < own.id).await?;
    }
    Ok(presence)
}

/// Refuses a name that another station has.
async fn refuse_taken(
    session: &Session,
    own: &Own,
    arm: &ServedArm,
    goes_before: impl Fn(StationId) -> bool,
) -> Result<(), CarrierError> {
    let key = own.keys.all_alive(&arm.name);
    let replies = session.liveliness().get(key).timeout(NAMES).await?;
    let mut other = None;
    while let Ok(reply) = replies.recv_async().await {
        let Ok(sample) = reply.result() else { continue };
        let found = own.keys.read_alive(sample.key_expr());
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

/// Answers queries for states and the roster, for which nobody needs a certificate.
struct Answering {
    own: Arc<Own>,
    places: Arc<Semaphore>,
    runtime: Handle,
}

impl Answering {
    /// The roster, for who asks. Called by the network.
    fn tell_roster(self: &Arc<Self>, query: Query) {
        self.tell(query, async |own| {
            let roster = own.ask("site.roster", json!({})).await;
            roster.unwrap_or_default().to_string().into_bytes()
        });
    }

    /// The state of an arm for who asks: as fresh as `arm.state` is, or the last that is known. Called
    /// by the network.
    fn tell_state(
        self: &Arc<Self>,
        arm: &ServedArm,
        telling: &Arc<Mutex<StateTelling>>,
        query: Query,
    ) {
        let (arm, telling) = (arm.clone(), Arc::clone(telling));
        self.tell(query, async move |own| {
            let fresh = own.ask("arm.state", json!({"arm": arm.name})).await;
            let last = || {
                let telling = telling.lock().unwrap_or_else(PoisonError::into_inner);
                telling.last()
            };
            own.state_message(&arm, fresh.unwrap_or_else(last))
        });
    }

    /// Answers from a task of its own: the thread of the network that calls must not wait.
    fn tell<Telling>(
        self: &Arc<Self>,
        query: Query,
        answer: impl FnOnce(Arc<Own>) -> Telling + Send + 'static,
    ) where
        Telling: Future<Output = Vec<u8>> + Send,
    {
        let Ok(place) = Arc::clone(&self.places).try_acquire_owned() else {
            // Whoever listens hears it within a second.
            return;
        };
        let own = Arc::clone(&self.own);
        self.runtime.spawn(async move {
            let _place = place;
            reply(&query, answer(own).await);
        });
    }
}

impl Own {
    /// What the station answers to somebody who only looks.
    async fn ask(&self, method: &str, params: Value) -> Option<Value> {
        let peer = self.viewer().ok()?;
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let answer = self.station.call(peer, &request.to_string()).await?;
        let mut answer: Value = serde_json::from_str(&answer).ok()?;
        answer.get_mut("result").map(Value::take)
    }
}

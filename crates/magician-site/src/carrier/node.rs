//! A station on its site: it is there, tells, answers, and takes sessions.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician_station::api::{self, Message, RpcError};
use magician_station::http::{Served, TokenStore, UNCHECKED};
use magician_station::{MESSAGE, Peer, Role, RunningStation};
use serde_json::{Value, json};
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::time::{sleep, timeout};
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use zenoh::{Session, Wait};

use super::line::{Ends, Line};
use super::publish::{Own, TOGETHER, Told, tell};
use super::{Aborting, CarrierError, Connection, FAREWELL, patiently};
use crate::keys::{Keys, SiteName, Topic};
use crate::message::{Asked, ChannelId, EXPECT, Heard, StateMessage, hear};
use crate::{ArmAt, KeptRoster, Roster, StateTelling, StationId, carry, channel};

/// Requests under way, at most.
const CALLS: usize = 64;
/// Stops beside them: all that is left when there are too many others.
const STOPS: usize = 256;
/// A request that is longer is no stop.
const STOP: usize = 4096;
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
    /// The name of this machine.
    pub machine: String,
    /// The arms of the station, in its order.
    pub arms: Vec<ServedArm>,
    /// A file of Zenoh's settings.
    pub config: Option<PathBuf>,
    /// The file of the roster.
    pub roster: Option<PathBuf>,
}

/// A station on its site. Dropping it leaves the site.
pub struct SiteNode {
    id: StationId,
    /// Before the connection: what it holds lives on that.
    presence: Presence,
    connection: Connection,
}

/// What a station has declared.
struct Presence {
    tokens: Vec<LivelinessToken>,
    _queryables: Vec<Queryable<()>>,
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
    /// Joins a site with all arms of a station; the tokens of others are looked up in these. On any runtime.
    ///
    /// # Errors
    /// [`CarrierError::Taken`] where the site has an arm of one of these names, and the others.
    pub async fn join(
        options: NodeOptions,
        station: RunningStation,
        tokens: TokenStore,
    ) -> Result<Self, CarrierError> {
        let connection = Connection::open(options.config.as_deref()).await?;
        let mut random = [0; 8];
        getrandom::fill(&mut random).map_err(|error| CarrierError::Network(error.to_string()))?;
        let own = Arc::new(Own {
            keys: Keys { site: options.site },
            id: StationId(u64::from_le_bytes(random)),
            machine: options.machine,
            station,
        });
        let id = own.id;
        let ended = || CarrierError::Network("it ended".to_owned());
        let joined = connection
            .within(|session| async move {
                let roster = KeptRoster::open(options.roster);
                begin(&session, own, options.arms, tokens, roster).await
            })
            .await;
        match joined.unwrap_or_else(|| Err(ended())) {
            Ok(presence) => Ok(Self {
                id,
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

    /// Leaves the site: first it is there no more, then it answers no more.
    pub async fn leave(self) {
        let Presence {
            tokens,
            _queryables,
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
    }
}

async fn begin(
    session: &Session,
    own: Arc<Own>,
    arms: Vec<ServedArm>,
    tokens: TokenStore,
    roster: KeptRoster,
) -> Result<Presence, CarrierError> {
    for arm in &arms {
        refuse_taken(session, &own, arm, |_| true).await?;
    }
    let mut presence = Presence {
        tokens: Vec::new(),
        _queryables: Vec::new(),
        _tasks: Vec::new(),
    };
    let door = Arc::new(Door {
        own: Arc::clone(&own),
        session: session.clone(),
        tokens,
        calls: Arc::new(Semaphore::new(CALLS)),
        stops: Arc::new(Semaphore::new(STOPS)),
        channels: Mutex::default(),
        roster,
        runtime: Handle::current(),
    });
    let (door_here, key) = (Arc::clone(&door), own.keys.roster(own.id));
    let answer = move |query| door_here.tell_roster(query);
    presence
        ._queryables
        .push(session.declare_queryable(key).callback(answer).await?);
    for together in arms.chunks(TOGETHER) {
        // Each tells once whether somebody listens, and then when that changes.
        let (listened, listening) = mpsc::channel(64 * TOGETHER);
        let mut told = Vec::new();
        for (at, arm) in together.iter().enumerate() {
            let listened = listened.clone();
            let one = Told::declare(session, &own.keys, arm.clone(), at, listened).await?;
            let (door_here, telling) = (Arc::clone(&door), one.telling());
            let state = own.keys.topic(&arm.name, Topic::State);
            let of = arm.clone();
            let answer = move |query| door_here.tell_state(&of, &telling, query);
            presence
                ._queryables
                .push(session.declare_queryable(state).callback(answer).await?);
            let rpc = own.keys.topic(&arm.name, Topic::Rpc);
            let (door_here, of) = (Arc::clone(&door), arm.name.clone());
            let answer = move |query| door_here.take(&of, query);
            presence
                ._queryables
                .push(session.declare_queryable(rpc).callback(answer).await?);
            told.push(one);
        }
        let telling = tokio::spawn(tell(Arc::clone(&own), told, listening));
        presence._tasks.push(Aborting(telling.abort_handle()));
    }
    // Who is there can be asked.
    for arm in &arms {
        let key = own.keys.alive(&ArmAt {
            arm: arm.name.clone(),
            station: own.id,
        });
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
        let at = reply
            .result()
            .ok()
            .and_then(|sample| own.keys.read_alive(sample.key_expr()));
        let found = at.filter(|at| at.station != own.id && goes_before(at.station));
        other = other.or(found);
    }
    let Some(other) = other else { return Ok(()) };
    Err(CarrierError::Taken {
        site: own.keys.site.clone(),
        machine: machine_of(session, own, &other).await,
        arm: other.arm,
        station: other.station,
    })
}

/// The machine of another station.
async fn machine_of(session: &Session, own: &Own, other: &ArmAt) -> Option<String> {
    let key = own.keys.topic(&other.arm, Topic::State);
    let asked = session.get(key).target(QueryTarget::All).timeout(NAMES);
    let replies = asked.consolidation(ConsolidationMode::None).await.ok()?;
    while let Ok(reply) = replies.recv_async().await {
        let bytes = reply
            .result()
            .ok()
            .map(|sample| sample.payload().to_bytes());
        let message = bytes.and_then(|bytes| serde_json::from_slice::<StateMessage>(&bytes).ok());
        if let Some(message) = message.filter(|message| message.station == other.station) {
            return Some(message.machine);
        }
    }
    None
}

/// Where requests come in.
struct Door {
    own: Arc<Own>,
    session: Session,
    tokens: TokenStore,
    calls: Arc<Semaphore>,
    stops: Arc<Semaphore>,
    channels: Mutex<BTreeSet<u128>>,
    roster: KeptRoster,
    runtime: Handle,
}

impl Door {
    /// A request. Called by the network, which must not wait.
    fn take(self: &Arc<Self>, arm: &str, query: Query) {
        let length = query.payload().map_or(0, ZBytes::len);
        let any = Arc::clone(&self.calls).try_acquire_owned();
        let place = match any {
            Ok(place) => Some((place, false)),
            // Room is left for stops.
            Err(_) if length <= STOP => {
                let stop = Arc::clone(&self.stops).try_acquire_owned();
                stop.ok().map(|place| (place, true))
            }
            Err(_) => None,
        };
        let Some((place, only_stops)) = place else {
            self.refuse_soon(query, "the station has as many requests as it takes");
            return;
        };
        let (door, arm) = (Arc::clone(self), arm.to_owned());
        self.runtime.spawn(async move {
            door.answer(&arm, &query, place, only_stops).await;
        });
    }

    fn refuse_soon(&self, query: Query, why: &'static str) {
        // The network calls: an answer that waits for it here would wait for itself.
        self.runtime.spawn(async move { refuse(&query, why) });
    }

    async fn answer(
        self: Arc<Self>,
        arm: &str,
        query: &Query,
        place: OwnedSemaphorePermit,
        only_stops: bool,
    ) {
        let asked = query.attachment().map(ZBytes::to_bytes);
        let asked = asked.map_or_else(
            || Ok(Asked::default()),
            |bytes| serde_json::from_slice::<Asked>(&bytes),
        );
        let Ok(asked) = asked else {
            return refuse(query, "the attachment is not as it should be");
        };
        let text = query.payload().map(ZBytes::to_bytes).unwrap_or_default();
        if text.len() > MESSAGE {
            return refuse(query, "a request is 1 MiB at most");
        }
        let Ok(text) = std::str::from_utf8(&text) else {
            return refuse(query, "the request is no UTF-8");
        };
        match hear(self.own.id, &asked, text) {
            Heard::NotForUs => {}
            Heard::Refused(why) => refuse(query, why),
            Heard::Opens(_) | Heard::Calls { is_stop: false } if only_stops => {
                refuse(query, "the station has as many requests as it takes");
            }
            Heard::Opens(id) => {
                drop(place);
                self.open(arm, query, &asked, id).await;
            }
            Heard::Calls { .. } => self.call(query, &asked, text.to_owned()).await,
        }
    }

    async fn call(self: &Arc<Self>, query: &Query, asked: &Asked, text: String) {
        let Some(token) = asked.token.clone() else {
            return refuse(query, "a token is needed on a site");
        };
        let grant = match self.tokens.granted(token).await {
            Ok(Some(grant)) => grant,
            Ok(None) => return refuse(query, "the token is not good"),
            Err(_) => return refuse(query, UNCHECKED),
        };
        if let Ok(message) = Message::parse(&text)
            && message.method == EXPECT
        {
            let door = Arc::clone(self);
            // The disk is waited for.
            let done = tokio::task::spawn_blocking(move || door.expect(grant.role, &message));
            return reply(query, done.await.unwrap_or_default());
        }
        let peer = match Peer::elsewhere(Some(grant), address(asked)) {
            Ok(peer) => peer,
            Err(error) => return refuse(query, &error.to_string()),
        };
        let answer = self.own.station.call(peer, &text).await;
        reply(query, answer.unwrap_or_default());
    }

    /// Writes the roster, and answers with it.
    fn expect(&self, role: Role, message: &Message) -> String {
        let write = || {
            if role != Role::Teacher || self.own.station.is_read_only() {
                let why = "the roster of a site is a teacher's to write, at a station that is not read-only";
                return Err(RpcError::new(RpcError::FORBIDDEN, why));
            }
            let params = Value::Object(message.params.clone());
            let roster = Roster::parse(&params.to_string());
            let roster = roster.map_err(|why| RpcError::new(RpcError::PARAMS, why))?;
            let kept = self.roster.set(roster);
            kept.map_err(|error| RpcError::new(RpcError::INTERNAL, error.to_string()))?;
            Ok(params)
        };
        api::answer(message.id.as_ref(), &write())
    }

    /// The roster, for who asks. Called by the network.
    fn tell_roster(self: &Arc<Self>, query: Query) {
        let door = Arc::clone(self);
        self.runtime
            .spawn(async move { reply(&query, door.roster.roster().to_text()) });
    }

    /// Opens a session, and lets it go on by itself.
    async fn open(self: Arc<Self>, arm: &str, query: &Query, asked: &Asked, id: ChannelId) {
        if !self.channels().insert(id.0) {
            return refuse(query, "there is such a channel already");
        }
        let place = Place {
            door: Arc::clone(&self),
            id,
        };
        let client = Peer::elsewhere(None, address(asked))
            .ok()
            .and_then(|peer| self.own.station.try_connect(peer));
        let Some(client) = client else {
            return refuse(query, "the station has all the sockets that it takes");
        };
        let keys = self.own.keys.channel(arm, id.0);
        let ends = Ends {
            to: keys.down(),
            from: keys.up(),
            own: keys.station(),
            other: keys.hub(),
        };
        let line = match Line::open(&self.session, &ends).await {
            Ok(line) => line,
            Err(error) => return refuse(query, &error.to_string()),
        };
        let (here, end) = channel();
        let (to_station, from_station) = here.split();
        let tokens = self.tokens.clone();
        tokio::spawn(async move {
            let carrying = tokio::spawn(carry(client, tokens, end));
            line.carry(from_station, to_station).await;
            carrying.abort();
            drop(place);
        });
        reply(query, String::new());
    }

    fn channels(&self) -> std::sync::MutexGuard<'_, BTreeSet<u128>> {
        self.channels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state of an arm for who asks: as fresh as `arm.state` is, or the last that is known. Called by the network.
    fn tell_state(
        self: &Arc<Self>,
        arm: &ServedArm,
        telling: &Arc<Mutex<StateTelling>>,
        query: Query,
    ) {
        let Ok(place) = Arc::clone(&self.calls).try_acquire_owned() else {
            // Whoever listens hears it within a second.
            return;
        };
        let (door, arm, telling) = (Arc::clone(self), arm.clone(), Arc::clone(telling));
        self.runtime.spawn(async move {
            let _place = place;
            let fresh = door.state(&arm.name).await;
            let last = || {
                telling
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .last()
            };
            let state = fresh.unwrap_or_else(last);
            reply_bytes(&query, door.own.state_message(&arm, state));
        });
    }

    async fn state(&self, arm: &str) -> Option<Value> {
        let peer = self.own.viewer().ok()?;
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": "arm.state",
            "params": {"arm": arm}});
        let answer = self.own.station.call(peer, &request.to_string()).await?;
        let mut answer: Value = serde_json::from_str(&answer).ok()?;
        answer.get_mut("result").map(Value::take)
    }
}

/// An open channel of the door.
struct Place {
    door: Arc<Door>,
    id: ChannelId,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.door.channels().remove(&self.id.0);
    }
}

/// For the station's journal.
fn address(asked: &Asked) -> String {
    let client: String = asked.client.chars().take(80).collect();
    format!("site:{client}")
}

fn reply(query: &Query, text: String) {
    reply_bytes(query, text.into_bytes());
}

fn reply_bytes(query: &Query, bytes: Vec<u8>) {
    // One that has given up hears nothing.
    let _ = patiently(|| query.reply(query.key_expr().clone(), bytes).wait());
}

fn refuse(query: &Query, why: &str) {
    let why = json!({"refused": why}).to_string();
    let _ = patiently(|| query.reply_err(why).wait());
}

/// Why a station refuses, if this is its word.
pub(super) fn read_refusal(text: &str) -> Option<String> {
    let said: Value = serde_json::from_str(text).ok()?;
    said.get("refused")?.as_str().map(str::to_owned)
}

//! A site as a program sees it that is none of its stations.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::Semaphore;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Subscriber;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, QueryTarget};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use super::line::{Ends, Line};
use super::{CarrierError, Connection, patiently};
use crate::keys::{Keys, SiteName, Topic};
use crate::message::{Act, Asked, ChannelId, EventMessage, JobMessage, StateMessage, act};
use crate::{
    ArmAt, ArmNews, Caller, Channel, Later, Roster, Site, SiteError, SiteEvents, SiteView,
    StationId, channel,
};

/// A state that is asked for comes within this, or not.
const STATE: Duration = Duration::from_secs(1);
/// States that are asked for at once.
const STATES: usize = 32;
/// A session is open within this, or not.
const OPENING: Duration = Duration::from_secs(3);
/// A station that says which arms are expected has said so by then.
const ROSTER: Duration = Duration::from_millis(500);
/// A request may take as long as a motion does. When its station is gone it is over at once.
const CALL: Duration = Duration::from_secs(3600);

/// A site over Zenoh.
pub struct ZenohSite {
    shared: Arc<Shared>,
    connection: Connection,
    _subscribers: Vec<Subscriber<()>>,
}

struct Shared {
    keys: Keys,
    view: SiteView,
}

impl fmt::Debug for ZenohSite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ZenohSite")
            .field("site", &self.shared.keys.site)
            .finish_non_exhaustive()
    }
}

impl ZenohSite {
    /// Joins a site, by Zenoh's settings of a file or by the usual ones. On any runtime.
    ///
    /// # Errors
    /// [`CarrierError`].
    pub async fn join(site: SiteName, config: Option<&Path>) -> Result<Self, CarrierError> {
        let connection = Connection::open(config).await?;
        let shared = Arc::new(Shared {
            keys: Keys { site },
            view: SiteView::default(),
        });
        let watched = Arc::clone(&shared);
        let ended = || CarrierError::Network("it ended".to_owned());
        let subscribers = connection
            .within(|session| async move { watch(&session, watched).await })
            .await
            .ok_or_else(ended)??;
        Ok(Self {
            shared,
            connection,
            _subscribers: subscribers,
        })
    }

    /// Leaves the site.
    pub async fn leave(self) {
        self.connection.close().await;
    }
}

/// Has the view filled from here on.
async fn watch(session: &Session, shared: Arc<Shared>) -> zenoh::Result<Vec<Subscriber<()>>> {
    let mut subscribers = Vec::new();
    for topic in [Topic::State, Topic::Event, Topic::Job] {
        let key = shared.keys.topic("*", topic);
        let shared = Arc::clone(&shared);
        let take = move |sample: Sample| shared.take(topic, &sample);
        subscribers.push(session.declare_subscriber(key).callback(take).await?);
    }
    let (asking, runtime) = (Arc::new(Semaphore::new(STATES)), Handle::current());
    let asked = session.clone();
    let key = shared.keys.all_alive("*");
    let presence = move |sample: Sample| {
        let Some(at) = shared.keys.read_alive(sample.key_expr()) else {
            return;
        };
        if sample.kind() == SampleKind::Delete {
            shared.view.left(&at);
            return;
        }
        shared.view.arrived(at.clone());
        let (session, shared) = (asked.clone(), Arc::clone(&shared));
        let asking = Arc::clone(&asking);
        runtime.spawn(async move {
            let _turn = asking.acquire().await;
            ask_state(&session, &shared, &at).await;
        });
    };
    let liveliness = session.liveliness();
    let alive = liveliness.declare_subscriber(key).history(true);
    subscribers.push(alive.callback(presence).await?);
    Ok(subscribers)
}

/// Asks for the state of an arm that has come, so that nobody has to wait until it is told next.
async fn ask_state(session: &Session, shared: &Shared, at: &ArmAt) {
    let key = shared.keys.topic(&at.arm, Topic::State);
    let asked = session.get(key).target(QueryTarget::All).timeout(STATE);
    let asked = asked.consolidation(ConsolidationMode::None);
    let Ok(replies) = asked.await else {
        return;
    };
    while let Ok(reply) = replies.recv_async().await {
        if let Ok(sample) = reply.result() {
            shared.take(Topic::State, sample);
        }
    }
}

impl Shared {
    /// Something of an arm.
    fn take(&self, topic: Topic, sample: &Sample) {
        let Some((arm, _)) = self.keys.read_topic(sample.key_expr()) else {
            return;
        };
        let bytes = sample.payload().to_bytes();
        let at = |station| ArmAt {
            arm: arm.to_owned(),
            station,
        };
        match topic {
            Topic::State => {
                if let Ok(message) = serde_json::from_slice::<StateMessage>(&bytes) {
                    let (station, news) = message.split();
                    self.view.news(at(station), news);
                }
            }
            Topic::Event => {
                if let Ok(message) = serde_json::from_slice::<EventMessage>(&bytes) {
                    self.view.event(at(message.station), message.event);
                }
            }
            Topic::Job => {
                if let Ok(message) = serde_json::from_slice::<JobMessage>(&bytes) {
                    self.view.job(at(message.station), message.job);
                }
            }
            Topic::Rpc => {}
        }
    }

    /// Whether an arm may be asked for this: it is there, and its name is one arm, or it is stopped.
    fn may_ask(&self, at: &ArmAt, request: &str) -> Result<(), SiteError> {
        if !self.view.has(at) {
            return Err(SiteError::Gone);
        }
        let same = self.view.named(&at.arm);
        if same > 1 && act(request) != Act::Stops {
            let why = format!(
                "{same} stations have an arm {}: only stops reach it",
                at.arm
            );
            return Err(SiteError::Refused(why));
        }
        Ok(())
    }
}

/// One request to one station: sent once, answered once or not at all.
async fn ask(
    session: &Session,
    key: String,
    asked: &Asked,
    text: String,
    within: Duration,
) -> Result<Option<String>, SiteError> {
    let network = |error: zenoh::Error| SiteError::Network(error.to_string());
    let attachment =
        serde_json::to_vec(asked).map_err(|error| SiteError::Network(error.to_string()))?;
    let query = session
        .get(key)
        .payload(text)
        .attachment(attachment)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Block)
        .priority(Priority::InteractiveHigh)
        .express(true)
        .timeout(within);
    let replies = patiently(|| query.wait()).map_err(network)?;
    let text = |bytes: &ZBytes| bytes.try_to_string().ok().map(|text| text.into_owned());
    let Ok(reply) = replies.recv_async().await else {
        return Err(SiteError::NoAnswer);
    };
    match reply.result() {
        Ok(sample) => Ok(text(sample.payload()).filter(|text| !text.is_empty())),
        // Zenoh itself answers so when the time is up.
        Err(error) => Err(text(error.payload())
            .and_then(|text| super::node::read_refusal(&text))
            .map_or(SiteError::NoAnswer, SiteError::Refused)),
    }
}

impl Site for ZenohSite {
    fn name(&self) -> &str {
        self.shared.keys.site.as_str()
    }

    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmNews>> {
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
    ) -> Later<'a, Result<Option<String>, SiteError>> {
        Box::pin(async move {
            self.shared.may_ask(at, &request)?;
            let asked = Asked {
                token: caller.token.clone(),
                station: Some(at.station),
                client: caller.client.clone(),
                open: None,
            };
            let key = self.shared.keys.topic(&at.arm, Topic::Rpc);
            let answer = self
                .connection
                .within(|session| async move { ask(&session, key, &asked, request, CALL).await });
            let answer = answer.await;
            answer.unwrap_or(Err(SiteError::NoAnswer))
        })
    }

    fn roster(&self) -> Later<'_, Roster> {
        Box::pin(async move {
            let key = self.shared.keys.all_rosters();
            let read = self.connection.within(|session| async move {
                let mut roster = Roster::default();
                let asked = session.get(key).target(QueryTarget::All).timeout(ROSTER);
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

    fn open(&self, station: StationId) -> Later<'_, Result<Channel, SiteError>> {
        Box::pin(async move {
            let at = self.shared.view.arm_of(station).ok_or(SiteError::Gone)?;
            let shared = Arc::clone(&self.shared);
            let opened = self
                .connection
                .within(|session| async move { open(&session, &shared, &at).await })
                .await;
            opened.unwrap_or(Err(SiteError::NoAnswer))
        })
    }
}

async fn open(session: &Session, shared: &Shared, at: &ArmAt) -> Result<Channel, SiteError> {
    let mut random = [0; 16];
    getrandom::fill(&mut random).map_err(|error| SiteError::Network(error.to_string()))?;
    let id = ChannelId(u128::from_le_bytes(random));
    let keys = shared.keys.channel(&at.arm, id.0);
    let ends = Ends {
        to: keys.up(),
        from: keys.down(),
        own: keys.hub(),
        other: keys.station(),
    };
    let line = Line::open(session, &ends)
        .await
        .map_err(|error| SiteError::Network(error.to_string()))?;
    let asked = Asked {
        station: Some(at.station),
        open: Some(id),
        ..Asked::default()
    };
    let key = shared.keys.topic(&at.arm, Topic::Rpc);
    ask(session, key, &asked, String::new(), OPENING).await?;
    let (client, end) = channel();
    tokio::spawn(line.carry(end.from_client, end.to_client));
    Ok(client)
}

//! Publishes the states of a station's arms on the bus, but only while there are subscribers.
//!
//! One client of the station serves up to [`MAX_ARMS_PER_CLIENT`] arms. It subscribes to an arm at
//! the station when the first subscriber on the bus appears, and unsubscribes after the last one
//! leaves. [`StateThrottle`] limits the rate.

use std::future::pending;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician_station::http::TokenError;
use magician_station::{Client, Grant, Outgoing, Peer, Role, RunningStation};
use serde_json::{Value, json};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until};
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use super::node::ServedArm;
use crate::keys::Keys;
use crate::message::StateMessage;
use crate::{StateThrottle, StationId};

/// Most arms per client of the station: the most subscriptions that a socket may have.
pub(super) const MAX_ARMS_PER_CLIENT: usize = 16;
/// States a second that are requested from the station.
const STATE_RATE: u32 = 10;
/// Delay before reconnecting after the station has closed the client.
const RECONNECT_DELAY: Duration = Duration::from_secs(1);

/// Facts about this station, shared by the tasks that publish and answer queries for it.
pub(super) struct OwnStation {
    pub(super) keys: Keys,
    pub(super) id: StationId,
    pub(super) machine: String,
    /// Addresses of its listener.
    pub(super) at: Vec<SocketAddr>,
    pub(super) station: RunningStation,
}

impl OwnStation {
    /// Client identity of this program at the station: a viewer.
    pub(super) fn viewer(&self) -> Result<Peer, TokenError> {
        let grant = Grant {
            role: Role::Viewer,
            token: None,
        };
        Peer::elsewhere(Some(grant), format!("site {}", self.keys.site))
    }

    /// Encodes the state message of an arm.
    pub(super) fn state_message(&self, arm: &ServedArm, state: Value) -> Vec<u8> {
        let message = StateMessage {
            station: self.id,
            at: self.at.clone(),
            port: arm.port.clone(),
            is_virtual: arm.is_virtual,
            state,
        };
        // Cannot fail: the message consists of strings, numbers and maps with string keys.
        serde_json::to_vec(&message).unwrap_or_default()
    }
}

/// Publisher of one arm.
pub(super) struct ArmPublisher {
    pub(super) arm: ServedArm,
    throttle: Arc<Mutex<StateThrottle>>,
    state: Publisher<'static>,
    has_subscribers: bool,
    /// Subscription at the station. `None` without one, 0 while the reply is outstanding.
    subscription: Option<u64>,
}

/// Index of an arm, and true if its state has subscribers now.
pub(super) type ListenerChange = (usize, bool);

impl ArmPublisher {
    /// Declares the publisher of an arm. `at` is its index within its group.
    pub(super) async fn declare(
        session: &Session,
        own: &OwnStation,
        arm: ServedArm,
        at: usize,
        listened: mpsc::Sender<ListenerChange>,
    ) -> zenoh::Result<Self> {
        let state = session.declare_publisher(own.keys.state(&own.machine, &arm.name));
        // Drop instead of block: a slow link must not delay the states of other arms.
        let state = state.congestion_control(CongestionControl::Drop).await?;
        let tell = listened.clone();
        let listener = state.matching_listener().callback(move |status| {
            let _ = tell.try_send((at, status.matching()));
        });
        listener.background().await?;
        let _ = listened.try_send((at, state.matching_status().await?.matching()));
        Ok(Self {
            arm,
            throttle: Arc::default(),
            state,
            has_subscribers: false,
            subscription: None,
        })
    }

    /// Returns the throttle, which holds the merged state. Answers to queries use it too.
    pub(super) fn throttle(&self) -> Arc<Mutex<StateThrottle>> {
        Arc::clone(&self.throttle)
    }

    fn with<T>(&self, act: impl FnOnce(&mut StateThrottle) -> T) -> T {
        act(&mut self.throttle.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Subscribes or unsubscribes at the station, so that it matches `has_subscribers`.
    fn update_subscription(&mut self, at: usize, client: &Client) {
        match (self.has_subscribers, self.subscription) {
            (true, None) => {
                let params = json!({"arm": self.arm.name, "rate": STATE_RATE});
                client.send(&request(at as u64 + 1, "arm.subscribe", &params));
                self.subscription = Some(0);
            }
            (false, Some(id)) if id > 0 => {
                let params = json!({"subscription": id});
                client.send(&request(0, "arm.unsubscribe", &params));
                self.subscription = None;
                self.with(StateThrottle::reset_schedule);
            }
            // Either no change, or the reply to a subscription is outstanding and will call this
            // again.
            _ => {}
        }
    }
}

fn request(id: u64, method: &str, params: &Value) -> String {
    json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}).to_string()
}

/// Publishes the states of a group of arms until the station ends.
pub(super) async fn publish_states(
    own: Arc<OwnStation>,
    mut arms: Vec<ArmPublisher>,
    mut listened: mpsc::Receiver<ListenerChange>,
) {
    let begun = Instant::now();
    loop {
        let Ok(peer) = own.viewer() else { return };
        let client = own.station.connect(peer);
        let name = format!("site {}", own.keys.site);
        let hello = json!({"client": {"name": name}});
        client.send(&request(0, "session.hello", &hello));
        for (at, publisher) in arms.iter_mut().enumerate() {
            publisher.subscription = None;
            publisher.update_subscription(at, &client);
        }
        loop {
            let due = arms.iter().filter(|publisher| publisher.has_subscribers);
            let due = due.filter_map(|publisher| publisher.with(|throttle| throttle.due()));
            let due = due.min().map(|due| begun + due);
            tokio::select! {
                outgoing = client.receive() => match outgoing {
                    Outgoing::Text(text) => {
                        handle_message(&mut arms, &client, &text, begun.elapsed());
                    }
                    // Binary frames are not subscribed to.
                    Outgoing::Frame(_) => {}
                    Outgoing::Close(_) => break,
                },
                Some((at, has_subscribers)) = listened.recv() => {
                    if let Some(publisher) = arms.get_mut(at) {
                        publisher.has_subscribers = has_subscribers;
                        publisher.update_subscription(at, &client);
                    }
                }
                () = sleep_until_due(due) => {}
            }
            for publisher in arms.iter().filter(|publisher| publisher.has_subscribers) {
                if let Some(state) = publisher.with(|throttle| throttle.take_due(begun.elapsed())) {
                    // With `CongestionControl::Drop` a slow link drops it: a newer state follows
                    // soon.
                    let _ = publisher
                        .state
                        .put(own.state_message(&publisher.arm, state))
                        .wait();
                }
            }
        }
        sleep(RECONNECT_DELAY).await;
    }
}

async fn sleep_until_due(due: Option<Instant>) {
    match due {
        Some(due) => sleep_until(due).await,
        None => pending().await,
    }
}

/// Handles a message of the station.
fn handle_message(arms: &mut [ArmPublisher], client: &Client, text: &str, now: Duration) {
    let Ok(mut message) = serde_json::from_str::<Value>(text) else {
        return;
    };
    if let Some(at) = message["id"].as_u64().and_then(|id| id.checked_sub(1)) {
        let at = at as usize;
        if let Some(publisher) = arms.get_mut(at) {
            publisher.subscription = message["result"]["subscription"].as_u64();
            // The last subscriber may have left while the reply was outstanding.
            publisher.update_subscription(at, client);
        }
        return;
    }
    if message["method"] != "arm.state" {
        return;
    }
    let mut params = message["params"].take();
    let id = params["subscription"].as_u64();
    let publisher = { arms.iter() }.find(|publisher| id.is_some() && publisher.subscription == id);
    let change = serde_json::from_value(params["state"].take());
    if let (Some(publisher), Ok(change)) = (publisher, change) {
        publisher.with(|throttle| throttle.merge(now, change));
    }
}

//! Distribution of the list of revoked certificates to all machines of a site.
//!
//! The authority signs the list, so any machine may pass it on. A machine asks for lists when it
//! joins, receives new ones, and answers queries with its newest.

use std::path::Path;
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::time::sleep;
use zenoh::Session;
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use zenoh::sample::Sample;

use super::{CarrierError, Connection, reply};
use crate::certificates::{CertificateError, Identity};
use crate::keys::{Keys, SiteName};

/// Time for the links to the present machines to come up.
const LINK_SETUP_TIME: Duration = Duration::from_millis(1500);
/// Time for machines to reply with their list.
const LIST_QUERY_TIMEOUT: Duration = Duration::from_millis(500);

/// Declarations for the list on the bus. Dropping them ends the exchange.
pub(super) struct ListExchange {
    _subscriber: Subscriber<()>,
    _queryable: Queryable<()>,
}

/// Learns the current lists of all machines and every new one, and answers queries with the newest.
/// Calls `newer` whenever the list has become newer.
pub(super) async fn follow(
    session: &Session,
    keys: &Keys,
    identity: &Identity,
    newer: impl Fn() + Clone + Send + Sync + 'static,
) -> zenoh::Result<ListExchange> {
    let learn = {
        let identity = identity.clone();
        // On the authority's machine the list may be in the folder before it arrives on the bus.
        let last = Arc::new(Mutex::new(identity.revoked()));
        let warned = Arc::new(Once::new());
        move |sample: &Sample| {
            let tell = |error| tracing::warn!(%error, "a list of revoked certificates is not good");
            match identity.learn(&sample.payload().to_bytes()) {
                Ok(_) => {}
                // Warn only once: a host that keeps sending bad lists must not fill the disk with
                // warnings.
                Err(error @ CertificateError::List) => warned.call_once(|| tell(error)),
                Err(error) => tell(error),
            }
            let list = identity.revoked();
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            if *last != list {
                *last = list;
                newer();
            }
        }
    };
    let all = keys.revoked("*");
    let learn_published = learn.clone();
    let subscriber = session.declare_subscriber(&all);
    let subscriber = subscriber
        .callback(move |sample| learn_published(&sample))
        .await?;
    let (known, runtime) = (identity.clone(), Handle::current());
    let answer = move |query: Query| {
        let list = known.revoked();
        if !list.is_empty() {
            // This is a thread of the network: waiting for the reply here would deadlock.
            runtime.spawn(async move { reply(&query, list) });
        }
    };
    let queryable = session.declare_queryable(keys.revoked(identity.machine()));
    let queryable = queryable.callback(answer).await?;
    let asked = session
        .get(all)
        .target(QueryTarget::All)
        .timeout(LIST_QUERY_TIMEOUT);
    let replies = asked.consolidation(ConsolidationMode::None).await?;
    tokio::spawn(async move {
        while let Ok(reply) = replies.recv_async().await {
            if let Ok(sample) = reply.result() {
                learn(sample);
            }
        }
    });
    Ok(ListExchange {
        _subscriber: subscriber,
        _queryable: queryable,
    })
}

/// Sends the list of this machine to all machines that are on the site now. Others learn it from
/// them when they join.
///
/// # Errors
/// Any [`CarrierError`] of joining, or the network's on sending.
pub async fn distribute_revoked(
    site: SiteName,
    config: Option<&Path>,
    identity: &Identity,
) -> Result<(), CarrierError> {
    let connection = Connection::open(config, Some(identity)).await?;
    let key = Keys { site }.revoked(identity.machine());
    let list = identity.revoked();
    let distributing = connection.with_session(|session| async move {
        sleep(LINK_SETUP_TIME).await;
        session.put(key, list).await
    });
    let distributing = distributing.await;
    connection.close().await;
    match distributing {
        Some(distributing) => Ok(distributing?),
        None => Err(CarrierError::Network("it ended".to_owned())),
    }
}

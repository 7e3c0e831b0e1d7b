//! The list of revoked certificates on its way to all machines of a site. The authority has signed
//! it, so it does not matter who hands it on.

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

/// Links to the machines that are there come up within this.
const LINKS: Duration = Duration::from_millis(1500);
/// A machine that has a list has said so by then.
const LISTS: Duration = Duration::from_millis(500);

/// What is declared for the list. Dropping it ends that.
pub(super) struct Lists {
    _subscriber: Subscriber<()>,
    _queryable: Queryable<()>,
}

/// Learns lists, those that machines have now and each that comes, and answers with the newest.
/// `newer` is called after each that was newer than the one before.
pub(super) async fn follow(
    session: &Session,
    keys: &Keys,
    identity: &Identity,
    newer: impl Fn() + Clone + Send + Sync + 'static,
) -> zenoh::Result<Lists> {
    let learn = {
        let identity = identity.clone();
        // At the authority's machine the list may be in the folder before it is told.
        let last = Arc::new(Mutex::new(identity.revoked()));
        let warned = Arc::new(Once::new());
        move |sample: &Sample| {
            let tell = |error| tracing::warn!(%error, "a list of revoked certificates is not good");
            match identity.learn(&sample.payload().to_bytes()) {
                Ok(_) => {}
                // Once: whoever sends such lists fills no disk with warnings.
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
    let told = learn.clone();
    let subscriber = session.declare_subscriber(&all);
    let subscriber = subscriber.callback(move |sample| told(&sample)).await?;
    let (known, runtime) = (identity.clone(), Handle::current());
    let answer = move |query: Query| {
        let list = known.revoked();
        if !list.is_empty() {
            // The network calls: an answer that waits for it here would wait for itself.
            runtime.spawn(async move { reply(&query, list) });
        }
    };
    let queryable = session.declare_queryable(keys.revoked(identity.machine()));
    let queryable = queryable.callback(answer).await?;
    let asked = session.get(all).target(QueryTarget::All).timeout(LISTS);
    let replies = asked.consolidation(ConsolidationMode::None).await?;
    tokio::spawn(async move {
        while let Ok(reply) = replies.recv_async().await {
            if let Ok(sample) = reply.result() {
                learn(sample);
            }
        }
    });
    Ok(Lists {
        _subscriber: subscriber,
        _queryable: queryable,
    })
}

/// Tells the machines that are on the site now of the list of this machine. Others learn it from
/// them when they come.
///
/// # Errors
/// [`CarrierError`].
pub async fn tell_revoked(
    site: SiteName,
    config: Option<&Path>,
    identity: &Identity,
) -> Result<(), CarrierError> {
    let connection = Connection::open(config, Some(identity)).await?;
    let key = Keys { site }.revoked(identity.machine());
    let list = identity.revoked();
    let told = connection.within(|session| async move {
        sleep(LINKS).await;
        session.put(key, list).await
    });
    let told = told.await;
    connection.close().await;
    match told {
        Some(told) => Ok(told?),
        None => Err(CarrierError::Network("it ended".to_owned())),
    }
}

//! A site over Zenoh: [`SiteNode`] beside a station, [`ZenohSite`] for who looks at all of them.
//!
//! Zenoh needs a runtime of several threads, so each of the two has one of its own. What the library calls back does nothing but hand
//! on; what may wait for the network waits where nothing else has to.

mod api;
mod config;
mod dial;
mod node;
mod publish;
mod revoked;
mod site;

use std::fmt;
use std::future::Future;
use std::path::Path;
use std::time::Duration;

use tokio::runtime::{Builder, Runtime};
use tokio::task::{AbortHandle, block_in_place};
use tokio::time::timeout;
use zenoh::query::Query;
use zenoh::{Session, Wait};

pub use node::{NodeOptions, ServedArm, SiteNode};
pub use revoked::tell_revoked;
pub use site::ZenohSite;

use crate::StationId;
use crate::certificates::Identity;
use crate::keys::SiteName;

/// Flaw of this build, if it has it: `None` in builds from the repository.
///
/// Zenoh 1.10.2 closes a link with a linger that it reads when it is compiled. Meanwhile the close blocks one of two threads that
/// receive for all links (eclipse-zenoh/zenoh#1101), so stops of other stations wait for it.
pub const LINGER_FLAW: Option<&str> = if is_zero(option_env!("TCP_LINGER_TIMEOUT"))
    && is_zero(option_env!("TLS_LINGER_TIMEOUT"))
{
    None
} else {
    Some(
        "this build may hold up stops for 10 s and more when a cable is pulled: it was compiled without \
             TCP_LINGER_TIMEOUT=0 and TLS_LINGER_TIMEOUT=0",
    )
};

const fn is_zero(seconds: Option<&str>) -> bool {
    match seconds {
        Some(seconds) => matches!(seconds.as_bytes(), b"0"),
        None => false,
    }
}

/// How long the farewell may take.
const FAREWELL: Duration = Duration::from_secs(1);

/// Why a site cannot be joined.
#[derive(Debug)]
#[non_exhaustive]
pub enum CarrierError {
    /// The file of Zenoh's settings cannot be used.
    Config(String),
    /// The network cannot be used.
    Network(String),
    /// The certificate of this machine cannot be used.
    Certificate(String),
    /// An arm of this name is on the site already.
    Taken {
        /// The site.
        site: SiteName,
        /// The name.
        arm: String,
        /// The station that has it.
        station: StationId,
        /// The machine that this station runs on.
        machine: String,
    },
}

impl fmt::Display for CarrierError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(why) | Self::Certificate(why) => f.write_str(why),
            Self::Network(why) => write!(f, "the network of the site cannot be used: {why}"),
            Self::Taken {
                site,
                arm,
                station,
                machine,
            } => {
                write!(
                    f,
                    "the site {site} has an arm {arm} already: station {station} on {machine}"
                )
            }
        }
    }
}

impl std::error::Error for CarrierError {}

impl From<zenoh::Error> for CarrierError {
    fn from(error: zenoh::Error) -> Self {
        Self::Network(error.to_string())
    }
}

/// A Zenoh session with the runtime that it lives on.
struct Connection {
    /// Both until it is dropped.
    alive: Option<(Runtime, Session)>,
}

impl Connection {
    async fn open(file: Option<&Path>, identity: Option<&Identity>) -> Result<Self, CarrierError> {
        let config = config::read(file, identity)?;
        let threads = Builder::new_multi_thread()
            .worker_threads(2)
            .thread_name("site")
            .enable_all()
            .build();
        let runtime = threads.map_err(|error| CarrierError::Network(error.to_string()))?;
        let opening = runtime.spawn(async move { zenoh::open(config).await });
        let opened = match opening.await {
            Ok(opened) => opened.map_err(CarrierError::from),
            Err(error) => Err(CarrierError::Network(error.to_string())),
        };
        match opened {
            Ok(session) => Ok(Self {
                alive: Some((runtime, session)),
            }),
            Err(error) => {
                runtime.shutdown_background();
                Err(error)
            }
        }
    }

    /// Does something with the session, on its runtime; none when that has ended. It is given up with this future.
    async fn within<T: Send + 'static, Work>(&self, work: impl FnOnce(Session) -> Work) -> Option<T>
    where
        Work: Future<Output = T> + Send + 'static,
    {
        let (runtime, session) = self.alive.as_ref()?;
        let working = runtime.spawn(work(session.clone()));
        let _given_up = Aborting(working.abort_handle());
        working.await.ok()
    }

    /// Leaves the network.
    async fn close(&self) {
        self.within(|session| async move {
            let _ = timeout(FAREWELL, async { session.close().await }).await;
        })
        .await;
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        let Some((runtime, session)) = self.alive.take() else {
            return;
        };
        // The library waits for the end of a session, and would not on a runtime of one thread, where this may be.
        std::thread::spawn(move || {
            let _ = session.close().wait();
            drop(session);
            runtime.shutdown_background();
        });
    }
}

/// Ends a task with itself.
struct Aborting(AbortHandle);

impl Drop for Aborting {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Answers a query; one that has given up hears nothing.
fn reply(query: &Query, bytes: Vec<u8>) {
    let _ = patiently(|| query.reply(query.key_expr().clone(), bytes).wait());
}

/// Does what may wait for a slow network, where nothing else has to wait for it. On the runtime of a [`Connection`] alone.
fn patiently<T>(work: impl FnOnce() -> T) -> T {
    block_in_place(work)
}

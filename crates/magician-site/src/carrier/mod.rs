//! A site over Zenoh: [`SiteNode`] puts a station on the bus, [`ZenohSite`] lets a program see and
//! use all stations.
//!
//! The bus carries only what is public: liveliness tokens of arms, their states, rosters, and the
//! signed list of revoked certificates. Requests do not use the bus: the caller dials the station
//! by TLS at an address from its state message, and both sides check each other's certificate.
//!
//! Zenoh needs a multi-threaded runtime, so each of the two types creates one. Callbacks of the
//! library run on its receiving threads and must not wait: work that may block on the network runs
//! in separate tasks.

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
pub use revoked::distribute_revoked;
pub use site::ZenohSite;

use crate::StationId;
use crate::certificates::Identity;
use crate::keys::SiteName;

/// Warning about this build, or `None` for a correct one. Builds from the repository are correct.
///
/// Zenoh 1.10.2 closes a link with a linger timeout that is fixed at compile time. Until it
/// expires, the close blocks one of the two threads that receive for all links
/// (eclipse-zenoh/zenoh#1101), so that stops of other stations are delayed.
pub const LINGER_WARNING: Option<&str> = if is_zero(option_env!("TCP_LINGER_TIMEOUT"))
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

/// Longest time for an orderly departure. A choice: a program that ends should not hang on a dead
/// network; without the farewell its presence expires with the link's lease.
const LEAVE_TIMEOUT: Duration = Duration::from_secs(1);

/// Reason why a site cannot be joined.
#[derive(Debug)]
#[non_exhaustive]
pub enum CarrierError {
    /// Zenoh's configuration file is unusable.
    Config(String),
    /// The network is unusable.
    Network(String),
    /// The certificate of this machine is unusable.
    Certificate(String),
    /// The site already has an arm of this name.
    Taken {
        /// Name of the site.
        site: SiteName,
        /// Name of the arm.
        arm: String,
        /// Station that owns it.
        station: StationId,
        /// Machine of that station.
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

/// A Zenoh session and the runtime that it lives on.
struct Connection {
    /// `None` only while it is dropped.
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

    /// Runs `work` with the session on its runtime. Returns `None` if the runtime has ended.
    /// Dropping the future aborts the work.
    async fn with_session<T: Send + 'static, Work>(
        &self,
        work: impl FnOnce(Session) -> Work,
    ) -> Option<T>
    where
        Work: Future<Output = T> + Send + 'static,
    {
        let (runtime, session) = self.alive.as_ref()?;
        let working = runtime.spawn(work(session.clone()));
        let _given_up = AbortOnDrop(working.abort_handle());
        working.await.ok()
    }

    /// Closes the session.
    async fn close(&self) {
        self.with_session(|session| async move {
            let _ = timeout(LEAVE_TIMEOUT, async { session.close().await }).await;
        })
        .await;
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        let Some((runtime, session)) = self.alive.take() else {
            return;
        };
        // On a separate thread: closing blocks, which would deadlock on the single-threaded runtime
        // of the caller.
        std::thread::spawn(move || {
            let _ = session.close().wait();
            drop(session);
            runtime.shutdown_background();
        });
    }
}

/// Aborts a task when dropped.
struct AbortOnDrop(AbortHandle);

impl Drop for AbortOnDrop {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Replies to a query. A querier that has given up is ignored.
fn reply(query: &Query, bytes: Vec<u8>) {
    let _ = run_blocking(|| query.reply(query.key_expr().clone(), bytes).wait());
}

/// Runs blocking work outside of the async scheduler. Only for threads of a [`Connection`]'s
/// runtime, which has several.
fn run_blocking<T>(work: impl FnOnce() -> T) -> T {
    block_in_place(work)
}

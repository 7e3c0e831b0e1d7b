//! Options of the network interface, shared by all connections of a listener.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde_json::Value;
use tokio::time::Instant;

use super::pages::Pages;
use super::programs::Uploads;
use super::security::Admission;
use super::tokens::TokenStore;

/// Most pairing tries per minute, over all callers: a code of six digits lives two minutes, so at
/// most ten of a million codes can be tried.
const MAX_PAIRING_TRIES: usize = 5;

/// Options of the network interface.
#[derive(Clone, Debug)]
pub struct HttpOptions {
    /// Hosts and origins that are admitted.
    pub admission: Admission,
    /// Tokens. Needed by clients from elsewhere, and for a role above that of clients on this
    /// machine.
    pub tokens: TokenStore,
    /// Version of the program.
    pub version: String,
    /// Recent pairing tries.
    pub tries: PairingTries,
    /// Uploads in progress.
    pub uploads: Uploads,
    /// Calls of programs for DobotLink. `None` if none are served.
    pub link: Option<LinkCalls>,
    /// Page for browsers. Empty if none is served.
    pub pages: Pages,
    /// Source of keep-alives of a client.
    pub keep_alives: KeepAliveSource,
}

impl HttpOptions {
    /// Creates options without pages, for the station's own host names.
    #[must_use]
    pub fn new(tokens: TokenStore, version: impl Into<String>) -> Self {
        Self {
            admission: Admission::default(),
            tokens,
            version: version.into(),
            tries: PairingTries::default(),
            uploads: Uploads::default(),
            link: None,
            pages: Pages::default(),
            keep_alives: KeepAliveSource::default(),
        }
    }
}

/// Source of a client's keep-alives. A holder of a lease without one for 5 s loses it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeepAliveSource {
    /// Replies to the station's pings.
    #[default]
    Pings,
    /// The hub in between, which sends a pong for each keep-alive of the client behind it. The hub
    /// itself would answer pings even if that client were dead.
    Hub,
}

/// Function that returns the calls of programs for DobotLink.
#[derive(Clone)]
pub struct LinkCalls(pub Arc<dyn Fn() -> Value + Send + Sync>);

impl fmt::Debug for LinkCalls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("LinkCalls").finish()
    }
}

/// Pairing tries of the last minute.
#[derive(Clone, Debug, Default)]
pub struct PairingTries(Arc<Mutex<Vec<Instant>>>);

impl PairingTries {
    /// Counts a try. `Err` holds the time to wait if there were too many.
    pub(super) fn count(&self) -> Result<(), Duration> {
        let minute = Duration::from_secs(60);
        let mut tries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        tries.retain(|at| now - *at < minute);
        match tries.first() {
            Some(first) if tries.len() >= MAX_PAIRING_TRIES => Err(minute - (now - *first)),
            _ => {
                tries.push(now);
                Ok(())
            }
        }
    }
}

//! Network interface of a station: WebSocket and HTTP.
//!
//! [`Listener`] binds loopback addresses by default and serves a
//! [`RunningStation`](crate::RunningStation) or any other [`ApiServer`]. `security` alone decides
//! which requests are admitted. `places` limits the number of connections, and `pacing` gives them
//! turns. The other files are the routes, the stores on disk, and TLS.

mod descriptors;
mod folder;
mod jobs;
mod journal;
mod listen;
mod options;
mod pacing;
mod pages;
mod places;
mod programs;
mod recordings;
mod route_table;
mod routes;
mod security;
mod server;
mod socket;
mod tls;
mod tokens;

pub use folder::ProgramFolder;
pub use jobs::{JobFolder, JobStoreError};
pub use journal::JournalFile;
#[cfg(feature = "link")]
pub(crate) use listen::{ListenAddress, next, wait_for_end};
pub use listen::{ListenError, Listener};
pub use options::{HttpOptions, KeepAliveSource, LinkCalls, PairingTries};
#[cfg(feature = "link")]
pub(crate) use pacing::{Lane, Paced};
pub use pages::{PageFile, Pages};
#[cfg(feature = "link")]
pub(crate) use places::{Place, Places};
pub use programs::Uploads;
pub use recordings::RecordingFolder;
pub use route_table::{ROUTES, Route, RouteNeeds};
pub use security::{Admission, ConnectionEnds};
pub use server::{ApiClient, ApiServer};
pub use tls::{Tls, TlsError};
pub use tokens::{CODE_LIFETIME, TOKENS_UNAVAILABLE, TokenEntry, TokenError, TokenStore};

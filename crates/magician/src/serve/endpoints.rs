//! Endpoints in front of any service.

use std::fmt;
#[cfg(unix)]
use std::path::PathBuf;
use std::task::Context;

use super::spec::{self, EndpointSpec, Listeners};
use super::{Discovery, Endpoint, ServeError, Service};

/// Endpoints for a custom [`Service`]: a bridge, a proxy. They are the same as those of a
/// [`Server`](super::Server) for a virtual arm, with the same requirements on tokio.
#[derive(Default)]
pub struct Endpoints {
    pub(super) specs: Vec<EndpointSpec>,
}

impl Endpoints {
    /// Creates an empty list.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a pseudo-terminal behind a symlink at `path`, as [`Server::pty`](super::Server::pty).
    #[cfg(unix)]
    #[must_use]
    pub fn pty(mut self, path: impl Into<PathBuf>) -> Self {
        self.specs.push(EndpointSpec::Pty(path.into()));
        self
    }

    /// Adds a UDP socket at `HOST[:PORT]`, as [`Server::udp`](super::Server::udp), without
    /// discovery.
    #[must_use]
    pub fn udp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Udp(address.into()));
        self
    }

    /// Adds a TCP listener at `HOST:PORT`, as [`Server::tcp`](super::Server::tcp).
    #[must_use]
    pub fn tcp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Tcp(address.into()));
        self
    }

    /// Opens all endpoints in order, or none.
    ///
    /// # Errors
    /// [`ServeError`] if one cannot be opened. Predictable errors are found before anything is
    /// changed.
    pub fn open(&self, service: &mut dyn Service) -> Result<BoundEndpoints, ServeError> {
        let listeners = self.listen(&Discovery::Off, service)?;
        Ok(BoundEndpoints { listeners })
    }

    pub(super) fn listen(
        &self,
        discovery: &Discovery,
        service: &mut dyn Service,
    ) -> Result<Listeners, ServeError> {
        self.specs.iter().try_for_each(|spec| spec.check(None))?;
        spec::open_all(&self.specs, discovery, None, service)
    }
}

impl fmt::Debug for Endpoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Endpoints").finish_non_exhaustive()
    }
}

/// Open endpoints. Their symlinks and sockets are removed on drop.
pub struct BoundEndpoints {
    listeners: Listeners,
}

impl fmt::Debug for BoundEndpoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.endpoints()).finish()
    }
}

impl BoundEndpoints {
    /// Returns the public names of the endpoints, in order.
    #[must_use]
    pub fn endpoints(&self) -> Vec<Endpoint> {
        spec::endpoints(&self.listeners)
    }

    /// Reads available bytes, writes pending ones, and registers to be woken for more.
    ///
    /// The work per call is bounded here; the runtime's own budget ([`tokio::task::coop`]) would
    /// look like a full socket, so poll within [`tokio::task::unconstrained`].
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint fails.
    pub fn poll(
        &mut self,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
    ) -> Result<(), ServeError> {
        spec::poll_all(&mut self.listeners, cx, service)
    }
}

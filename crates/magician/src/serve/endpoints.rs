use std::fmt;
#[cfg(unix)]
use std::path::PathBuf;
use std::task::Context;

use super::spec::{self, EndpointSpec, Listeners};
use super::{Discovery, Endpoint, ServeError, Service};

/// Endpoints that lead to a [`Service`] of your own: a bridge, a proxy. They are what
/// [`Server`](super::Server) has for a virtual arm, and need the same of tokio.
#[derive(Default)]
pub struct Endpoints {
    pub(super) specs: Vec<EndpointSpec>,
}

impl Endpoints {
    /// No endpoint.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A pseudo-terminal behind a symlink at `path`, as [`Server::pty`](super::Server::pty).
    #[cfg(unix)]
    #[must_use]
    pub fn pty(mut self, path: impl Into<PathBuf>) -> Self {
        self.specs.push(EndpointSpec::Pty(path.into()));
        self
    }

    /// A UDP socket at `HOST[:PORT]`, as [`Server::udp`](super::Server::udp), without discovery.
    #[must_use]
    pub fn udp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Udp(address.into()));
        self
    }

    /// A TCP listener at `HOST:PORT`, as [`Server::tcp`](super::Server::tcp).
    #[must_use]
    pub fn tcp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Tcp(address.into()));
        self
    }

    /// Opens all of them, in their order, or none.
    ///
    /// # Errors
    /// [`ServeError`] when one cannot be opened; what is certain to fail does so before anything is
    /// touched.
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

/// Endpoints that accept. What they made (symlinks, sockets) is gone when this is dropped.
pub struct BoundEndpoints {
    listeners: Listeners,
}

impl fmt::Debug for BoundEndpoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.endpoints()).finish()
    }
}

impl BoundEndpoints {
    /// What they are called outside, in their order.
    #[must_use]
    pub fn endpoints(&self) -> Vec<Endpoint> {
        spec::endpoints(&self.listeners)
    }

    /// Reads what is there, writes what is due, and registers to be woken for more. Turns are
    /// bounded here: the runtime's own bound ([`tokio::task::coop`]) would look like a full
    /// socket, so poll within [`tokio::task::unconstrained`].
    ///
    /// # Errors
    /// [`ServeError`] when an endpoint breaks down.
    pub fn poll(
        &mut self,
        cx: &mut Context<'_>,
        service: &mut dyn Service,
    ) -> Result<(), ServeError> {
        spec::poll_all(&mut self.listeners, cx, service)
    }
}

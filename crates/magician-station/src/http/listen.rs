//! Listening addresses, and the loop that accepts and serves connections.
//!
//! An accepted connection gets an entry in the admission table ([`Places`]) at once, and is closed
//! when the table evicts it. Connections take turns at being read ([`Paced`]), so that a flood on
//! one of them does not delay the others.

use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::body::Incoming;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use magician::admission::AdmissionLimits;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tower::ServiceExt;

use super::descriptors::{self, within};
use super::options::HttpOptions;
use super::pacing::Paced;
use super::places::{Place, Places};
use super::routes::router;
use super::security::ConnectionEnds;
use super::server::ApiServer;
use super::tls::Tls;
use super::tokens::{TokenStore, run_blocking};

/// Default port of a station.
const DEFAULT_PORT: u16 = 8910;
/// Most connections at once.
///
/// Places for strangers from elsewhere suffice for the browsers of a class that load the page
/// together, with six connections each. Under a flood a stranger is evicted once `strangers` others
/// have arrived, and has to send the head of its request by then. All places and sockets together
/// need fewer than 1024 descriptors, the usual limit of a process; with a lower limit there are
/// fewer places.
pub(super) const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: 192,
    strangers: 384,
    claims: 128,
    kept_for_loopback: 16,
    idle: None,
};
/// Interval of checking the file of tokens for revoked ones.
const TOKEN_CHECK_INTERVAL: Duration = Duration::from_millis(500);
/// Time for the head of a request, and for a TLS handshake.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);

/// Reason why a station cannot listen.
#[derive(Debug)]
#[non_exhaustive]
pub enum ListenError {
    /// The text is not `HOST:PORT`.
    Address(String),
    /// The address is in use, or does not belong to this machine.
    Bind(SocketAddr, io::Error),
    /// The address can be reached by others, and the service has no login.
    Beyond(SocketAddr),
}

impl fmt::Display for ListenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address(text) => write!(f, "{text:?} is no address: expected HOST:PORT"),
            Self::Bind(address, error) => write!(f, "{address}: {error}"),
            Self::Beyond(address) => write!(f, "{address} is not of this machine alone"),
        }
    }
}

impl std::error::Error for ListenError {}

/// Address to listen at, as parsed from the user's text.
pub(crate) enum ListenAddress {
    Loopback(u16),
    At(SocketAddr),
}

impl ListenAddress {
    pub(crate) fn read(text: &str, default_port: u16) -> Result<Self, ListenError> {
        let wrong = || ListenError::Address(text.to_owned());
        if let Some((name, port)) = text.rsplit_once(':')
            && name.eq_ignore_ascii_case("localhost")
        {
            return port.parse().map(Self::Loopback).map_err(|_| wrong());
        }
        let address = text.parse().or_else(|_| {
            let host = text.parse::<IpAddr>();
            host.map(|host| SocketAddr::new(host, default_port))
        });
        address.map(Self::At).map_err(|_| wrong())
    }
}

/// Bound addresses of a station, before the first connection is accepted.
#[derive(Debug)]
pub struct Listener {
    pub(crate) listeners: Vec<TcpListener>,
    addresses: Vec<SocketAddr>,
    tls: Option<Tls>,
}

impl Listener {
    /// Binds `HOST:PORT`.
    ///
    /// Without an address, and for `localhost`, binds both loopback addresses at port 8910 or the
    /// given port. Port 0 takes a free port, the same on both. On a machine without IPv6 only
    /// `127.0.0.1` is bound.
    ///
    /// # Errors
    /// [`ListenError`] if the address is invalid or cannot be bound.
    pub async fn bind(address: Option<&str>) -> Result<Self, ListenError> {
        Self::bind_at(address, DEFAULT_PORT).await
    }

    /// Binds as [`bind`](Self::bind) does, with another default port.
    pub(crate) async fn bind_at(
        address: Option<&str>,
        default_port: u16,
    ) -> Result<Self, ListenError> {
        let wanted = match address {
            Some(address) => ListenAddress::read(address, default_port)?,
            None => ListenAddress::Loopback(default_port),
        };
        let address = match wanted {
            // `localhost` means both families, because browsers try either first.
            ListenAddress::Loopback(port) => return Self::loopback(port).await,
            ListenAddress::At(address) => address,
        };
        let bind = |error| ListenError::Bind(address, error);
        let listener = TcpListener::bind(address).await.map_err(bind)?;
        let addresses = vec![listener.local_addr().map_err(bind)?];
        Ok(Self {
            listeners: vec![listener],
            addresses,
            tls: None,
        })
    }

    /// Checks the form of an address.
    ///
    /// # Errors
    /// [`ListenError::Address`] if the text is not one.
    pub fn check(address: &str) -> Result<(), ListenError> {
        ListenAddress::read(address, DEFAULT_PORT).map(drop)
    }

    async fn loopback(port: u16) -> Result<Self, ListenError> {
        let four = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
        let bind = |error| ListenError::Bind(four, error);
        let listener = TcpListener::bind(four).await.map_err(bind)?;
        let four = listener.local_addr().map_err(bind)?;
        let six = SocketAddr::new(IpAddr::V6(Ipv6Addr::LOCALHOST), four.port());
        let (mut listeners, mut addresses) = (vec![listener], vec![four]);
        match TcpListener::bind(six).await {
            Ok(listener) => {
                listeners.push(listener);
                addresses.push(six);
            }
            // Another program at the same port of `::1` would get the browsers that prefer IPv6.
            Err(error) if error.kind() == io::ErrorKind::AddrInUse => {
                return Err(ListenError::Bind(six, error));
            }
            // This machine has no IPv6.
            Err(_) => {}
        }
        Ok(Self {
            listeners,
            addresses,
            tls: None,
        })
    }

    /// Encrypts all connections with TLS.
    #[must_use]
    pub fn encrypted(mut self, tls: Tls) -> Self {
        self.tls = Some(tls);
        self
    }

    /// True if connections are encrypted.
    #[must_use]
    pub fn is_encrypted(&self) -> bool {
        self.tls.is_some()
    }

    /// Returns the URL of the page, at the first address.
    #[must_use]
    pub fn url(&self) -> String {
        self.url_of("http")
    }

    /// Returns the URL of the WebSocket.
    #[must_use]
    pub fn api_url(&self) -> String {
        format!("{}api/v1/ws", self.url_of("ws"))
    }

    fn url_of(&self, scheme: &str) -> String {
        let secure = if self.tls.is_some() { "s" } else { "" };
        let address = self.addresses.first().map(|address| {
            // An unspecified address cannot be opened in a browser; loopback is always part of it.
            let host = match address.ip() {
                IpAddr::V4(Ipv4Addr::UNSPECIFIED) => Ipv4Addr::LOCALHOST.into(),
                IpAddr::V6(Ipv6Addr::UNSPECIFIED) => Ipv6Addr::LOCALHOST.into(),
                host => host,
            };
            SocketAddr::new(host, address.port()).to_string()
        });
        format!("{scheme}{secure}://{}/", address.unwrap_or_default())
    }

    /// Returns the bound addresses.
    #[must_use]
    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }

    /// True if only this machine can connect.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        self.addresses
            .iter()
            .all(|address| address.ip().is_loopback())
    }

    /// Serves a station, or another [`ApiServer`], until `over` becomes true. Sockets are then
    /// closed with 1001.
    pub async fn serve(
        self,
        station: impl ApiServer,
        options: HttpOptions,
        over: watch::Receiver<bool>,
    ) {
        let options = Arc::new(options);
        let places = Places::new(within(LIMITS, descriptors::limit()));
        let revocation_task = tokio::spawn(end_revoked_sessions(
            options.tokens.clone(),
            station.clone(),
        ));
        let mut accepting = JoinSet::new();
        for listener in self.listeners {
            let (station, options) = (station.clone(), Arc::clone(&options));
            let (places, over) = (places.clone(), over.clone());
            let listener_with_tls = (listener, self.tls.clone());
            accepting.spawn(accept(listener_with_tls, station, options, places, over));
        }
        accepting.join_all().await;
        revocation_task.abort();
    }
}

async fn accept(
    (listener, tls): (TcpListener, Option<Tls>),
    station: impl ApiServer,
    options: Arc<HttpOptions>,
    places: Places,
    mut over: watch::Receiver<bool>,
) {
    let mut connections = JoinSet::new();
    while let Some((stream, peer, place)) = next(&listener, &places, &mut over).await {
        // Finished tasks are reaped here, so that the set does not grow.
        while connections.try_join_next().is_some() {}
        let (station, options, over) = (station.clone(), Arc::clone(&options), over.clone());
        let tls = tls.clone();
        connections.spawn(async move {
            let Ok(local) = stream.local_addr() else {
                return;
            };
            // A stop is one small message and must not wait for Nagle's algorithm.
            let _ = stream.set_nodelay(true);
            let ends = ConnectionEnds {
                local,
                peer,
                tls: tls.is_some(),
            };
            let ends_here = (ends, over.clone(), place.clone());
            let service = |name| router(station, options, name, ends_here);
            let stream = Paced::new(stream, place.pacer().clone());
            let served = async {
                match tls {
                    None => serve_connection(stream, service(None), over).await,
                    // A client that does not complete the handshake is evicted like one that never
                    // sends the head of a request.
                    Some(tls) => {
                        let agreed = tokio::time::timeout(HEAD_TIMEOUT, tls.accept(stream)).await;
                        if let Ok(Ok(stream)) = agreed {
                            let name = tls.name_of(&stream);
                            serve_connection(stream, service(name), over).await;
                        }
                    }
                }
            };
            tokio::select! {
                () = served => {}
                () = place.evicted() => {}
            }
        });
    }
    // Sockets get time for their close frame; everything that is still open after that is cut.
    let farewell = async { while connections.join_next().await.is_some() {} };
    // Longer than the second that each connection has for its own shutdown.
    let _ = tokio::time::timeout(Duration::from_secs(2), farewell).await;
}

/// Accepts the next connection and gives it a place. `None` once the listener is to end.
pub(crate) async fn next(
    listener: &TcpListener,
    places: &Places,
    over: &mut watch::Receiver<bool>,
) -> Option<(TcpStream, SocketAddr, Place)> {
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = wait_for_end(over) => return None,
        };
        match accepted {
            Ok((stream, peer)) => {
                let place = places.enter(peer.ip());
                // One connection per round, so that new connections do not delay existing ones.
                tokio::task::yield_now().await;
                return Some((stream, peer, place));
            }
            Err(error) => recover(&error, places).await,
        }
    }
}

/// Recovers from a failed accept.
async fn recover(error: &io::Error, places: &Places) {
    match error.kind() {
        // The client was gone before the connection was accepted.
        io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset => {}
        // Out of descriptors: a stranger is evicted, and its socket closes at the next yield.
        _ if places.evict_stranger() => tokio::task::yield_now().await,
        // No stranger to evict: wait for a connection to end instead of spinning.
        _ => tokio::time::sleep(Duration::from_millis(100)).await,
    }
}

/// Serves one connection until it ends.
async fn serve_connection<S: AsyncRead + AsyncWrite + Send + Unpin + 'static>(
    stream: S,
    service: Router,
    mut over: watch::Receiver<bool>,
) {
    let service =
        service.map_request(|request: hyper::Request<Incoming>| request.map(axum::body::Body::new));
    let mut http = hyper::server::conn::http1::Builder::new();
    http.timer(TokioTimer::new())
        // A client that sends its head byte by byte would hold its place.
        .header_read_timeout(HEAD_TIMEOUT)
        // Limits the head of a request; hyper's own default is larger.
        .max_buf_size(64 * 1024);
    let connection = http
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(service))
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        // Errors of a client concern that client alone.
        _ = connection.as_mut() => {}
        () = wait_for_end(&mut over) => {
            // A response in progress gets a second, for instance the answer to the last stop.
            connection.as_mut().graceful_shutdown();
            let _ = tokio::time::timeout(Duration::from_secs(1), connection).await;
        }
    }
}

/// Ends the sessions of revoked tokens, whichever program revoked them.
async fn end_revoked_sessions(tokens: TokenStore, station: impl ApiServer) {
    let mut interval = tokio::time::interval(TOKEN_CHECK_INTERVAL);
    loop {
        interval.tick().await;
        // The used tokens are listed before the file is read. In the other order, a token created
        // in between would look revoked.
        let used = station.tokens();
        if used.is_empty() {
            continue;
        }
        // An unreadable file says nothing about tokens, so no session ends because of it.
        let Some(Ok(good)) = run_blocking(&tokens, |tokens| tokens.names()).await else {
            continue;
        };
        for revoked in used.iter().filter(|name| !good.contains(name)) {
            station.revoke(revoked);
        }
    }
}

/// Resolves when the station ends.
pub(crate) async fn wait_for_end(over: &mut watch::Receiver<bool>) {
    // An error means that the sender is gone, which is the end as well.
    drop(over.wait_for(|over| *over).await);
}

//! Addresses to listen at, and the connections that come.

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
use super::pacing::Paced;
use super::places::{Place, Places};
use super::routes::{HttpOptions, router};
use super::security::Ends;
use super::served::Served;
use super::tls::Tls;
use super::tokens::{TokenStore, beside};

/// The port of a station.
const PORT: u16 = 8910;
/// Connections at once. Strangers from elsewhere are as many as the browsers of a class open when all of them load the page,
/// six each. A connection that comes has to send its head before as many others come as there are places for strangers: under
/// a flood they are the time that it has. With the sockets all places stay below the 1024 descriptors that a process usually has;
/// with fewer descriptors there are fewer places.
pub(super) const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: 192,
    strangers: 384,
    claims: 128,
    kept_for_loopback: 16,
    idle: None,
};
/// The file of tokens is looked at so often.
const FOLLOWS: Duration = Duration::from_millis(500);
/// A request's head has to be there within this time.
const HEAD: Duration = Duration::from_secs(5);

/// Why a station cannot listen.
#[derive(Debug)]
#[non_exhaustive]
pub enum ListenError {
    /// It is no `HOST:PORT`.
    Address(String),
    /// The address is in use, or not this machine's.
    Bind(SocketAddr, io::Error),
    /// Others reach it, and what is served there has no login.
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

/// Where to listen, as a person writes it.
pub(crate) enum Wanted {
    Loopback(u16),
    At(SocketAddr),
}

impl Wanted {
    pub(crate) fn read(text: &str, usual: u16) -> Result<Self, ListenError> {
        let wrong = || ListenError::Address(text.to_owned());
        if let Some((name, port)) = text.rsplit_once(':')
            && name.eq_ignore_ascii_case("localhost")
        {
            return port.parse().map(Self::Loopback).map_err(|_| wrong());
        }
        let address = text.parse().or_else(|_| {
            let host = text.parse::<IpAddr>();
            host.map(|host| SocketAddr::new(host, usual))
        });
        address.map(Self::At).map_err(|_| wrong())
    }
}

/// The addresses of a station, before anything is accepted there.
#[derive(Debug)]
pub struct Listener {
    pub(crate) listeners: Vec<TcpListener>,
    addresses: Vec<SocketAddr>,
    tls: Option<Tls>,
}

impl Listener {
    /// Listens at `HOST:PORT`; without one, and for `localhost`, at port 8910, or the one that is named, of both loopback addresses.
    /// Port 0 takes a free one, the same on both. An IPv6 address that the machine does not have is left out beside `127.0.0.1`.
    ///
    /// # Errors
    /// [`ListenError`].
    pub async fn bind(address: Option<&str>) -> Result<Self, ListenError> {
        Self::bind_at(address, PORT).await
    }

    /// As [`bind`](Self::bind), at another port where none is named.
    pub(crate) async fn bind_at(address: Option<&str>, usual: u16) -> Result<Self, ListenError> {
        let wanted = match address {
            Some(address) => Wanted::read(address, usual)?,
            None => Wanted::Loopback(usual),
        };
        let address = match wanted {
            Wanted::Loopback(port) => return Self::loopback(port).await,
            Wanted::At(address) => address,
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

    /// Whether it can be listened at, by its form.
    ///
    /// # Errors
    /// [`ListenError::Address`].
    pub fn check(address: &str) -> Result<(), ListenError> {
        Wanted::read(address, PORT).map(drop)
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
            Err(error) if error.kind() == io::ErrorKind::AddrInUse => {
                return Err(ListenError::Bind(six, error));
            }
            // The machine has no IPv6.
            Err(_) => {}
        }
        Ok(Self {
            listeners,
            addresses,
            tls: None,
        })
    }

    /// With connections that are encrypted, all of them.
    #[must_use]
    pub fn encrypted(mut self, tls: Tls) -> Self {
        self.tls = Some(tls);
        self
    }

    /// Whether connections are encrypted.
    #[must_use]
    pub fn is_encrypted(&self) -> bool {
        self.tls.is_some()
    }

    /// Where pages find it: the first of its addresses.
    #[must_use]
    pub fn url(&self) -> String {
        self.url_of("http")
    }

    /// Where programs find its WebSocket.
    #[must_use]
    pub fn api_url(&self) -> String {
        format!("{}api/v1/ws", self.url_of("ws"))
    }

    fn url_of(&self, scheme: &str) -> String {
        let secure = if self.tls.is_some() { "s" } else { "" };
        let address = self.addresses.first().map(|address| {
            // Of all addresses of the machine the one that is always there.
            let host = match address.ip() {
                IpAddr::V4(Ipv4Addr::UNSPECIFIED) => Ipv4Addr::LOCALHOST.into(),
                IpAddr::V6(Ipv6Addr::UNSPECIFIED) => Ipv6Addr::LOCALHOST.into(),
                host => host,
            };
            SocketAddr::new(host, address.port()).to_string()
        });
        format!("{scheme}{secure}://{}/", address.unwrap_or_default())
    }

    /// Where it listens.
    #[must_use]
    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }

    /// Whether it can be reached from this machine alone.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        self.addresses
            .iter()
            .all(|address| address.ip().is_loopback())
    }

    /// Serves a station, or what looks like one, until `over` says so; sockets are closed with 1001 then.
    pub async fn serve(
        self,
        station: impl Served,
        options: HttpOptions,
        over: watch::Receiver<bool>,
    ) {
        let options = Arc::new(options);
        let places = Places::new(within(LIMITS, descriptors::limit()));
        let follows = tokio::spawn(follow(options.tokens.clone(), station.clone()));
        let mut accepting = JoinSet::new();
        for listener in self.listeners {
            let (station, options) = (station.clone(), Arc::clone(&options));
            let (places, over) = (places.clone(), over.clone());
            let door = (listener, self.tls.clone());
            accepting.spawn(accept(door, station, options, places, over));
        }
        accepting.join_all().await;
        follows.abort();
    }
}

async fn accept(
    (listener, tls): (TcpListener, Option<Tls>),
    station: impl Served,
    options: Arc<HttpOptions>,
    places: Places,
    mut over: watch::Receiver<bool>,
) {
    let mut connections = JoinSet::new();
    while let Some((stream, peer, place)) = next(&listener, &places, &mut over).await {
        while connections.try_join_next().is_some() {}
        let (station, options, over) = (station.clone(), Arc::clone(&options), over.clone());
        let tls = tls.clone();
        connections.spawn(async move {
            let Ok(local) = stream.local_addr() else {
                return;
            };
            // A stop is one small message.
            let _ = stream.set_nodelay(true);
            let ends = Ends {
                local,
                peer,
                tls: tls.is_some(),
            };
            let ends_here = (ends, over.clone(), place.clone());
            let service = |name| router(station, options, name, ends_here);
            let stream = Paced::new(stream, place.pacer().clone());
            let served = async {
                match tls {
                    None => carry(stream, service(None), over).await,
                    // A client that does not go on has a place as long as one that sends no head, and gives way alike.
                    Some(tls) => {
                        let agreed = tokio::time::timeout(HEAD, tls.accept(stream)).await;
                        if let Ok(Ok(stream)) = agreed {
                            let name = tls.name_of(&stream);
                            carry(stream, service(name), over).await;
                        }
                    }
                }
            };
            tokio::select! {
                () = served => {}
                () = place.gives_way() => {}
            }
        });
    }
    // Sockets say goodbye; what goes on after that is cut.
    let farewell = async { while connections.join_next().await.is_some() {} };
    let _ = tokio::time::timeout(Duration::from_secs(2), farewell).await;
}

/// Accepts the next connection, which gets a place at once; `None` when the listener is to end.
pub(crate) async fn next(
    listener: &TcpListener,
    places: &Places,
    over: &mut watch::Receiver<bool>,
) -> Option<(TcpStream, SocketAddr, Place)> {
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = ended(over) => return None,
        };
        match accepted {
            Ok((stream, peer)) => {
                let place = places.enter(peer.ip());
                // One connection a round, so that those that come do not hold up those that are there.
                tokio::task::yield_now().await;
                return Some((stream, peer, place));
            }
            Err(error) => recover(&error, places).await,
        }
    }
}

/// Makes room after a connection could not be accepted.
async fn recover(error: &io::Error, places: &Places) {
    match error.kind() {
        // It was gone before it was taken.
        io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset => {}
        // Out of descriptors: a stranger gives way, and its socket is closed by the next turn.
        _ if places.shed() => tokio::task::yield_now().await,
        // Without strangers a connection that ends makes room.
        _ => tokio::time::sleep(Duration::from_millis(100)).await,
    }
}

/// One connection to its end.
async fn carry<S: AsyncRead + AsyncWrite + Send + Unpin + 'static>(
    stream: S,
    service: Router,
    mut over: watch::Receiver<bool>,
) {
    let service =
        service.map_request(|request: hyper::Request<Incoming>| request.map(axum::body::Body::new));
    let mut http = hyper::server::conn::http1::Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(HEAD)
        .max_buf_size(64 * 1024);
    let connection = http
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(service))
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        // What a client does wrong is told to it alone.
        _ = connection.as_mut() => {}
        () = ended(&mut over) => {
            connection.as_mut().graceful_shutdown();
            let _ = tokio::time::timeout(Duration::from_secs(1), connection).await;
        }
    }
}

/// Ends the sessions of tokens that are revoked, whoever revokes them.
async fn follow(tokens: TokenStore, station: impl Served) {
    let mut looks = tokio::time::interval(FOLLOWS);
    loop {
        looks.tick().await;
        // First what is in use: a token that is made after the file was read has no session yet.
        let used = station.tokens();
        if used.is_empty() {
            continue;
        }
        // A file that cannot be read now says nothing of its tokens.
        let Some(Ok(good)) = beside(&tokens, |tokens| tokens.names()).await else {
            continue;
        };
        for revoked in used.iter().filter(|name| !good.contains(name)) {
            station.revoke(revoked);
        }
    }
}

/// Awaited for the station's end.
pub(crate) async fn ended(over: &mut watch::Receiver<bool>) {
    // Nobody is left who could say it: that is the end, too.
    drop(over.wait_for(|over| *over).await);
}

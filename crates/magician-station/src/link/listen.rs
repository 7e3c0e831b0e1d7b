//! Listener for programs written for DobotLink: accepts any URL path, on loopback addresses only.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::http::{Request, Response, StatusCode};
use futures_util::{SinkExt, StreamExt};
use magician::admission::AdmissionLimits;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{interval, timeout};
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::protocol::frame::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{WebSocketStream, accept_hdr_async_with_config};

use super::{LinkService, ProgramInput};
use crate::READ_BUFFER;
use crate::http::{
    Admission, ConnectionEnds, Lane, ListenAddress, ListenError, Listener, Paced, Place, Places,
    next,
};
use crate::station::{MAX_MESSAGE_SIZE, MAX_SOCKETS};

/// Port of DobotLink.
const DEFAULT_PORT: u16 = 9090;
/// Port at which DobotEDU expects a helper for its camera.
const IMAGE_PORT: u16 = 10001;
/// Most programs at once. A program is a stranger until its first message; if all places are taken,
/// a stranger is evicted.
const LIMITS: AdmissionLimits = AdmissionLimits {
    loopback_strangers: MAX_SOCKETS,
    // Not used: connections from elsewhere are refused.
    strangers: 1,
    claims: MAX_SOCKETS,
    kept_for_loopback: MAX_SOCKETS,
    idle: None,
};
/// Time for the head of a request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval of pings. A reply is a sign of life of the program.
const PING_INTERVAL: Duration = Duration::from_secs(2);
/// Longest time that one message may take to be written.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// Bound addresses of a link, before the first connection is accepted.
#[derive(Debug)]
pub struct LinkListener(Listener);

impl LinkListener {
    /// Binds both loopback addresses at port 9090, or `HOST:PORT`, which must be loopback because
    /// DobotLink's protocol has no login.
    ///
    /// # Errors
    /// [`ListenError`]; [`Beyond`](ListenError::Beyond) for an address that others can reach.
    pub async fn bind(address: Option<&str>) -> Result<Self, ListenError> {
        bind_loopback(address, DEFAULT_PORT).await.map(Self)
    }

    /// Returns the bound addresses.
    #[must_use]
    pub fn addresses(&self) -> &[SocketAddr] {
        self.0.addresses()
    }

    /// Serves programs until `over` becomes true. Programs in pages of other sites need an origin
    /// that `admission` allows.
    pub async fn serve(
        self,
        service: LinkService,
        admission: Admission,
        over: watch::Receiver<bool>,
    ) {
        serve(self.0, ConnectionService::Link(service), admission, over).await;
    }
}

/// Stub of the helper that DobotEDU waits for when it is imported: accepts a WebSocket at port
/// 10001 and stays silent.
#[derive(Debug)]
pub struct ImageStub(Listener);

impl ImageStub {
    /// Binds the port.
    ///
    /// # Errors
    /// [`ListenError`] if the port is in use.
    pub async fn bind() -> Result<Self, ListenError> {
        bind_loopback(None, IMAGE_PORT).await.map(Self)
    }

    /// Accepts connections until `over` becomes true.
    pub async fn serve(self, over: watch::Receiver<bool>) {
        serve(
            self.0,
            ConnectionService::Silent,
            Admission::default(),
            over,
        )
        .await;
    }
}

/// Service of a connection.
#[derive(Clone)]
enum ConnectionService {
    Link(LinkService),
    Silent,
}

impl ConnectionService {
    async fn with(
        self,
        mut socket: WebSocketStream<Paced<TcpStream>>,
        peer: SocketAddr,
        place: &Place,
        mut over: watch::Receiver<bool>,
    ) {
        match self {
            Self::Link(service) => talk(socket, &service, peer, place, over).await,
            Self::Silent => {
                let silence = async { while let Some(Ok(_)) = socket.next().await {} };
                tokio::select! {
                    () = silence => {}
                    () = crate::http::wait_for_end(&mut over) => {}
                }
            }
        }
    }
}

/// Binds an address, which must be loopback.
async fn bind_loopback(address: Option<&str>, usual: u16) -> Result<Listener, ListenError> {
    let wanted = address
        .map(|text| ListenAddress::read(text, usual))
        .transpose()?;
    match wanted {
        Some(ListenAddress::At(address)) if !address.ip().is_loopback() => {
            Err(ListenError::Beyond(address))
        }
        // `localhost`, a loopback address, or none given.
        _ => Listener::bind_at(address, usual).await,
    }
}

async fn serve(
    listeners: Listener,
    talk: ConnectionService,
    admission: Admission,
    over: watch::Receiver<bool>,
) {
    let admission = Arc::new(admission);
    let places = Places::new(LIMITS);
    let mut accepting = JoinSet::new();
    for listener in listeners.listeners {
        let (talk, admission) = (talk.clone(), admission.clone());
        accepting.spawn(accept(
            listener,
            talk,
            admission,
            places.clone(),
            over.clone(),
        ));
    }
    accepting.join_all().await;
}

async fn accept(
    listener: TcpListener,
    talk: ConnectionService,
    admission: Arc<Admission>,
    places: Places,
    mut over: watch::Receiver<bool>,
) {
    let mut programs = JoinSet::new();
    while let Some((stream, peer, place)) = next(&listener, &places, &mut over).await {
        while programs.try_join_next().is_some() {}
        let (talk, admission, over) = (talk.clone(), admission.clone(), over.clone());
        programs.spawn(async move {
            let served = async {
                if let Ok(Some(socket)) =
                    // The whole handshake has to fit into this time.
                    timeout(HEAD_TIMEOUT, open(stream, peer, &place, &admission)).await
                {
                    place.note_head();
                    talk.with(socket, peer, &place, over).await;
                }
            };
            tokio::select! {
                () = served => {}
                () = place.evicted() => {}
            }
        });
    }
    let farewell = async { while programs.join_next().await.is_some() {} };
    let _ = timeout(Duration::from_secs(2), farewell).await;
}

/// Opens the WebSocket of a program, if its request passes the checks that all listeners share.
#[allow(
    clippy::result_large_err,
    reason = "the type of a refusal is the library's"
)]
async fn open(
    stream: TcpStream,
    peer: SocketAddr,
    place: &Place,
    admission: &Admission,
) -> Option<WebSocketStream<Paced<TcpStream>>> {
    let local = stream.local_addr().ok()?;
    let _ = stream.set_nodelay(true);
    let ends = ConnectionEnds {
        local,
        peer,
        tls: false,
    };
    let admit = |request: &Request<()>, response: Response<()>| match admission
        .check_request(request, ends)
    {
        Ok(()) => Ok(response),
        Err((status, why)) => {
            let mut refused = Response::new(Some(why));
            *refused.status_mut() = status;
            Err(refused)
        }
    };
    let stream = Paced::new(stream, place.pacer().clone());
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE_SIZE))
        .read_buffer_size(READ_BUFFER);
    accept_hdr_async_with_config(stream, admit, Some(config))
        .await
        .ok()
}

/// Carries the messages of a program.
async fn talk(
    socket: WebSocketStream<Paced<TcpStream>>,
    service: &LinkService,
    peer: SocketAddr,
    place: &Place,
    mut over: watch::Receiver<bool>,
) {
    let (input, mut output) = service.connect("DobotLink", &peer.to_string()).split();
    let (mut sink, mut stream) = socket.split();
    let reader = async {
        let mut claimed = false;
        while let Some(message) = stream.next().await {
            place.pacer().turn(Lane::Ordinary).await;
            // The first message turns a stranger into a program with a claim to its place.
            if !claimed && matches!(message, Ok(Message::Text(_))) {
                claimed = true;
                if place.claim().is_err() {
                    return Some((CloseCode::Again, "the link has all its programs"));
                }
                place.pacer().begin_session();
            }
            let heard = match message {
                Ok(Message::Text(text)) => ProgramInput::Text(text.as_str().to_owned()),
                Ok(Message::Pong(_)) => ProgramInput::Pong,
                // The library answers pings.
                Ok(Message::Ping(_) | Message::Frame(_)) => continue,
                Ok(Message::Binary(_)) => {
                    return Some((CloseCode::Unsupported, "messages are text"));
                }
                Ok(Message::Close(_)) => return None,
                Err(Error::Capacity(_)) => {
                    return Some((CloseCode::Size, "a message is 1 MiB at most"));
                }
                Err(_) => return None,
            };
            if input.send(heard).await.is_err() {
                return None;
            }
        }
        None
    };
    let writer = async {
        let mut pings = interval(PING_INTERVAL);
        loop {
            let message = tokio::select! {
                // The end of the station first; then answers before pings.
                biased;
                () = crate::http::wait_for_end(&mut over) => {
                    return Some((CloseCode::Away, "the station ends"));
                }
                text = output.recv() => match text {
                    Some(text) => Message::text(text),
                    None => return None,
                },
                _ = pings.tick() => Message::Ping(Vec::new().into()),
            };
            match timeout(WRITE_TIMEOUT, sink.send(message)).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return None,
            }
        }
    };
    let last = tokio::select! {
        last = reader => last,
        last = writer => last,
    };
    // Dropped before the farewell: motion must end now.
    drop(input);
    if let Some((code, reason)) = last {
        let last = CloseFrame {
            code,
            reason: reason.into(),
        };
        let _ = timeout(HEAD_TIMEOUT, sink.send(Message::Close(Some(last)))).await;
    }
}

impl Admission {
    /// Checks a request. `Err` holds status and reason of the refusal.
    fn check_request(
        &self,
        request: &Request<()>,
        ends: ConnectionEnds,
    ) -> Result<(), (StatusCode, String)> {
        let (parts, ()) = request.clone().into_parts();
        let admitted =
            { self.admit(&parts, ends) }.map_err(|refused| (refused.status, refused.why))?;
        if admitted.loopback {
            return Ok(());
        }
        let why = "programs of this machine alone are let in";
        Err((StatusCode::FORBIDDEN, why.to_owned()))
    }
}

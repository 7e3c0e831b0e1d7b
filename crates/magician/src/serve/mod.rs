//! Servers: a virtual arm for other programs, over pseudo-terminals, UDP and TCP.
//!
//! A [`Server`] serves its own virtual arm. [`Endpoints`] are the same endpoints in front of other
//! services: a virtual arm that this process uses too ([`ServedArm`]), or an arm shared by several
//! programs ([`ProxyServer`]).
//!
//! A [`Server`] needs a tokio runtime with I/O (and, except on Linux, time) enabled. It is one
//! future on one thread, and so are several together ([`serve_all`]); a current-thread runtime has
//! the lowest latency. Signals are left to the caller: [`Server::serve_until`] ends when the future
//! passed to it does.
//!
//! Every client is a link with its own decoder: each successive client of a pseudo-terminal, each
//! UDP peer, each TCP connection. No client can block the arm or make it use more memory: unread
//! replies are dropped in whole frames, as a serial port drops them.

use std::fmt;
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::task::Context;

use magician_host::ErrorKind;
use magician_sim::{Controller, Event, LineTiming, Speed};

mod address;
mod arm;
#[cfg(feature = "record")]
mod behind;
mod cable;
mod discovery;
mod endpoints;
pub mod files;
mod flash_file;
mod handle;
mod outbox;
mod proxy;
#[cfg(unix)]
mod pty;
#[cfg(unix)]
mod reactor;
mod recording;
mod served_arm;
mod service;
mod several;
mod shared_arm;
mod spec;
mod tcp;
mod timer;
mod udp;
mod wake;

pub use discovery::Discovery;
pub use endpoints::{BoundEndpoints, Endpoints};
pub use handle::{Ended, Handle, PendingResult};
pub use proxy::{ProxyNotice, ProxyObserver, ProxyServer};
pub use served_arm::ServedArm;
pub use service::Service;
pub use several::{numbered, serve_all};

use files::FlashFileError;
use handle::Orders;
use spec::{EndpointSpec, Number};

/// Reads on one endpoint before the others get a turn. Choice.
const READS_PER_POLL: u32 = 16;

/// Server for one virtual arm. Defaults: real time, no pacing, no endpoint.
///
/// ```no_run
/// # async fn serve() -> Result<(), magician::serve::ServeError> {
/// use magician::serve::Server;
/// use magician_sim::{Controller, Profile};
///
/// Server::new(Controller::new(Profile::default()))
///     .udp("127.0.0.1")
///     .on_ready(|_| println!("ready"))
///     .serve_until(std::future::pending())
///     .await
/// # }
/// ```
pub struct Server {
    controller: Controller,
    speed: Speed,
    line: LineTiming,
    specs: Vec<EndpointSpec>,
    discovery: Discovery,
    number: Number,
    on_ready: OnReady,
    on_notice: OnNotice,
    orders: Orders,
    flash: Option<PathBuf>,
    #[cfg(feature = "trace")]
    trace: Option<Box<dyn io::Write + Send>>,
    #[cfg(feature = "record")]
    recording: Option<Box<dyn io::Write + Send>>,
}

type OnReady = Box<dyn FnOnce(&[Endpoint]) + Send>;
type OnNotice = Box<dyn FnMut(Notice) + Send>;

/// Open endpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Endpoint {
    /// A pseudo-terminal.
    #[cfg(unix)]
    Pty {
        /// Path of the symlink.
        path: PathBuf,
        /// Path of the terminal (`/dev/pts/3`).
        device: PathBuf,
    },
    /// UDP socket, with its actual port.
    Udp(SocketAddr),
    /// TCP listener, with its actual port.
    Tcp(SocketAddr),
    /// UDP socket that answers searching hosts, with its actual port.
    Discovery(SocketAddr),
}

impl Endpoint {
    /// True if other computers may be able to reach it, without a password.
    #[must_use]
    pub fn is_exposed(&self) -> bool {
        match self {
            Self::Udp(address) | Self::Tcp(address) => !address.ip().to_canonical().is_loopback(),
            // A pseudo-terminal belongs to its user; a discovery socket carries no commands.
            _ => false,
        }
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            #[cfg(unix)]
            Self::Pty { path, .. } => path.display().fmt(f),
            Self::Udp(address) => write!(f, "udp:{address}"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Discovery(address) => write!(f, "discovery:{address}"),
        }
    }
}

/// Event worth logging.
#[derive(Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Notice {
    /// Event of the controller.
    Arm(Event),
    /// A client sent its first bytes (UDP), connected (TCP), or opened the port (pseudo-terminal,
    /// on Linux).
    Connected(String),
    /// A client left, was replaced by a newer one (UDP), or was the last on a pseudo-terminal.
    Left(String),
    /// A connection was refused because the maximum is open, and all are in use.
    Refused(String),
    /// A connection that was idle, or had not sent a whole frame, was closed for a new one because
    /// the maximum was open.
    MadeRoom(String),
    /// The cable was pulled ([`Runner::unplug`](magician_sim::Runner::unplug)), and the endpoints
    /// are gone.
    Unplugged,
    /// The cable is plugged in, and the endpoints are back. A pseudo-terminal is another device
    /// now.
    Plugged(Vec<Endpoint>),
    /// Discovery is not available: it was not requested explicitly ([`Discovery::Auto`]), and its
    /// port is in use. Sent before the server is ready.
    Undiscoverable {
        /// Intended address.
        address: SocketAddr,
        /// Error of the system.
        error: io::Error,
    },
    /// The flash file could not be written and is unchanged; the write is repeated with the next
    /// change and at the end.
    FlashNotKept(FlashFileError),
    /// The trace could not be written and ends; the arm is still served.
    TraceEnded(io::Error),
    /// The recording could not be written and ends; the arm is still served, and
    /// [`ServeError::Record`] is returned at the end.
    RecordingEnded(io::Error),
}

/// Error of a server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The path for a pseudo-terminal is taken by something other than a symlink.
    #[cfg(unix)]
    #[error("{} exists and is not a symlink: give another path or remove it", path.display())]
    Occupied {
        /// Path in use.
        path: PathBuf,
    },
    /// The path for a pseudo-terminal belongs to another server that is running.
    #[cfg(unix)]
    #[error("{} is served already, by {}: end that one first, or give another path", path.display(), server(*process))]
    Served {
        /// Path in use.
        path: PathBuf,
        /// Process that serves it, if known.
        process: Option<u32>,
    },
    /// An address is invalid.
    #[error("{address}: {reason}")]
    Address {
        /// Address as given.
        address: String,
        /// Reason.
        reason: &'static str,
    },
    /// The system refused an endpoint.
    #[error("{endpoint}: cannot {action}: {source}")]
    Endpoint {
        /// Endpoint as given.
        endpoint: String,
        /// Operation that failed.
        action: &'static str,
        /// Error of the system.
        source: io::Error,
    },
    /// The trace could not be started.
    #[cfg(feature = "trace")]
    #[error("cannot write the trace: {0}")]
    Trace(#[source] io::Error),
    /// The recording could not be started, or its file is incomplete.
    #[cfg(feature = "record")]
    #[error("the recording is incomplete: {0}")]
    Record(#[source] io::Error),
    /// The system could not create a timer.
    #[error("cannot make a timer: {0}")]
    Timer(#[source] io::Error),
}

#[cfg(unix)]
fn server(process: Option<u32>) -> String {
    match process {
        Some(process) => format!("process {process}"),
        None => "another virtual arm or proxy".to_owned(),
    }
}

impl ServeError {
    /// Returns the kind of the error: [`ErrorKind::InvalidInput`] for an invalid address, else
    /// [`ErrorKind::Port`].
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Address { .. } => ErrorKind::InvalidInput,
            // All others come from the system, not from the input.
            _ => ErrorKind::Port,
        }
    }

    fn at(endpoint: impl fmt::Display, action: &'static str, source: impl Into<io::Error>) -> Self {
        Self::Endpoint {
            endpoint: endpoint.to_string(),
            action,
            source: source.into(),
        }
    }
}

impl Server {
    /// Creates a server for this arm.
    #[must_use]
    pub fn new(controller: Controller) -> Self {
        Self {
            controller,
            speed: Speed::default(),
            line: LineTiming::default(),
            specs: Vec::new(),
            discovery: Discovery::default(),
            number: None,
            // Empty closures instead of `Option`, so that callers need no case for them.
            on_ready: Box::new(|_| ()),
            on_notice: Box::new(|_| ()),
            orders: Orders::new(),
            flash: None,
            #[cfg(feature = "trace")]
            trace: None,
            #[cfg(feature = "record")]
            recording: None,
        }
    }

    /// Sets the speed of the arm's clock.
    #[must_use]
    pub fn speed(mut self, speed: Speed) -> Self {
        self.speed = speed;
        self
    }

    /// Sets baud rate and turnaround time, simulated for each client's line separately.
    #[must_use]
    pub fn line(mut self, line: LineTiming) -> Self {
        self.line = line;
        self
    }

    /// Adds a pseudo-terminal behind a symlink at `path`.
    ///
    /// It replaces an existing symlink, unless that belongs to a running server (detected on
    /// Linux). The terminal is raw from the start, survives clients that come, go or are killed,
    /// and belongs to the user who runs the server (mode 0620, group `tty`, as created by the
    /// system); for others, change the mode of the symlink's target.
    ///
    /// When the last client leaves, its unread replies are dropped, the bytes it wrote still take
    /// effect, and an exclusive flag is cleared. Linux reports when a client leaves. On other
    /// systems the flag is cleared once a second, and unread replies wait for the next client,
    /// which should discard its input on opening, as with any serial port.
    #[cfg(unix)]
    #[must_use]
    pub fn pty(mut self, path: impl Into<PathBuf>) -> Self {
        self.specs.push(EndpointSpec::Pty(path.into()));
        self
    }

    /// Adds a UDP socket at `HOST[:PORT]` (8899 by default, errata E45; 0: any free port).
    ///
    /// The datagrams of a sender form a byte stream, and each reply is a datagram to the address of
    /// its request. The 32 most recent senders are remembered. Port 8899 includes [`Discovery`].
    #[must_use]
    pub fn udp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Udp(address.into()));
        self
    }

    /// Adds endpoints after those added before.
    #[must_use]
    pub fn endpoints(mut self, endpoints: Endpoints) -> Self {
        // Behind those given before: the order is that of `on_ready`, and the first names the arm.
        self.specs.extend(endpoints.specs);
        self
    }

    /// Sets the address at which searching hosts are answered.
    #[must_use]
    pub fn discovery(mut self, discovery: Discovery) -> Self {
        self.discovery = discovery;
        self
    }

    /// Adds a TCP listener at `HOST:PORT` (0: any free port).
    ///
    /// It keeps up to 16 connections that have sent a whole frame, 12 of them from other machines.
    /// One more replaces a connection that has been silent for 10 s, or is refused. Connections
    /// that have not sent a frame give way to new ones immediately.
    #[must_use]
    pub fn tcp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Tcp(address.into()));
        self
    }

    /// Makes this arm number `number` of several, counted from 1, which distinguishes its
    /// endpoints.
    ///
    /// `.number` is appended to the paths of pseudo-terminals, and ports count up from the given
    /// ones (0 remains any free port). [`serve_all`] serves the arms together.
    #[must_use]
    pub fn number(mut self, number: u32) -> Self {
        self.number = Some(number);
        self
    }

    /// Keeps the arm's non-volatile memory in a file, written half a second after a change and at
    /// the end. The caller reads it before power-up ([`load_flash`](files::load_flash),
    /// [`Controller::with_flash`]).
    #[must_use]
    pub fn flash(mut self, path: impl Into<PathBuf>) -> Self {
        self.flash = Some(path.into());
        self
    }

    /// Writes all traffic to a trace file ([`trace`](magician_record::trace)).
    #[cfg(feature = "trace")]
    #[must_use]
    pub fn trace(mut self, writer: impl io::Write + Send + 'static) -> Self {
        self.trace = Some(Box::new(writer));
        self
    }

    /// Records the arm's motion ([`record`](magician_record::mcap)); the epoch is now.
    ///
    /// A thread writes to `writer`, so that a slow disk does not delay the arm, and may lag by 16
    /// MB. Then the recording ends; at [`Speed::Max`] the arm's clock waits instead.
    #[cfg(feature = "record")]
    #[must_use]
    pub fn record(mut self, writer: impl io::Write + Send + 'static) -> Self {
        self.recording = Some(Box::new(writer));
        self
    }

    /// Sets a function that is called once, when every endpoint accepts.
    #[must_use]
    pub fn on_ready(mut self, call: impl FnOnce(&[Endpoint]) + Send + 'static) -> Self {
        self.on_ready = Box::new(call);
        self
    }

    /// Sets a function that is called for every event worth logging. It should be quick, because
    /// the arm waits for it.
    #[must_use]
    pub fn on_notice(mut self, call: impl FnMut(Notice) + Send + 'static) -> Self {
        self.on_notice = Box::new(call);
        self
    }

    /// Returns a handle to observe and change the arm while it is served.
    #[must_use]
    pub fn handle(&self) -> Handle {
        self.orders.handle()
    }

    /// Opens all endpoints and serves until `end` is ready. Symlinks and sockets are removed when
    /// this returns or the future is dropped.
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint cannot be opened (none then stays open) or fails, and at the
    /// end if the recording is incomplete.
    pub async fn serve_until(self, end: impl Future<Output = ()>) -> Result<(), ServeError> {
        // A single arm is served like several, so there is one path for opening, polling and
        // ending.
        serve_all([self], end).await
    }

    /// Checks for predictable errors of its endpoints.
    fn check(&self) -> Result<(), ServeError> {
        let mut specs = self.specs.iter();
        // Before anything is opened, so that a typo in the last address leaves no symlink behind.
        specs.try_for_each(|spec| spec.check(self.number))?;
        spec::check(&self.discovery, self.number)
    }
}

/// Open endpoint.
trait Listener {
    /// Returns its public name.
    fn endpoint(&self) -> Endpoint;
    /// Reads available bytes, writes pending ones, and registers to be woken for more. While the
    /// arm is unplugged, received bytes are discarded.
    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()>;
    /// Disconnects all clients, because the cable was pulled, perhaps once more.
    fn unplug(&mut self, service: &mut dyn Service);
    /// Accepts clients again, because the cable is plugged in.
    fn plug(&mut self, _: &mut dyn Service) -> Result<(), ServeError> {
        // Sockets stay open while unplugged; only a pseudo-terminal has to be made anew.
        Ok(())
    }
}

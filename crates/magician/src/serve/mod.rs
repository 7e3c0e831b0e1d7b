//! The virtual arm for programs outside: pseudo-terminals, UDP and TCP, all to the same arm.
//!
//! [`Endpoints`] are the same endpoints in front of anything else: a virtual arm that this process uses too ([`ServedArm`]),
//! an arm that programs share ([`ProxyServer`]).
//!
//! A [`Server`] needs a tokio runtime with I/O (and, except on Linux, time) enabled. It is one
//! future on one thread, and so are several together ([`serve_all`]); a current-thread runtime
//! answers fastest. Signals are the caller's: [`Server::serve_until`] ends when the future given to
//! it does.
//!
//! Every client is a link of its own with its own decoder: each client of a pseudo-terminal in
//! turn, each UDP peer, each TCP connection. Nothing a client does, or leaves undone, blocks the
//! arm or grows: unread replies are dropped, whole frames at a time, as a serial port
//! drops them.

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
mod handle;
mod keep;
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

/// Reads on one endpoint before the others get their turn.
const READS_PER_POLL: u32 = 16;

/// Serves one virtual arm. What is not set is real time, no pacing, no endpoint.
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

/// An endpoint that accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Endpoint {
    /// A pseudo-terminal.
    #[cfg(unix)]
    Pty {
        /// The symlink to it.
        path: PathBuf,
        /// The terminal itself (`/dev/pts/3`).
        device: PathBuf,
    },
    /// A UDP socket, with the port it got.
    Udp(SocketAddr),
    /// A TCP listener, with the port it got.
    Tcp(SocketAddr),
    /// A UDP socket that answers hosts which look for an arm, with the port it got.
    Discovery(SocketAddr),
}

impl Endpoint {
    /// Whether other computers may reach it, none of which needs a password.
    #[must_use]
    pub fn is_exposed(&self) -> bool {
        match self {
            Self::Udp(address) | Self::Tcp(address) => !address.ip().to_canonical().is_loopback(),
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

/// Something worth a line in a log.
#[derive(Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Notice {
    /// The controller reports.
    Arm(Event),
    /// A client sent its first bytes (UDP), connected (TCP), or opened the port (pseudo-terminal,
    /// on Linux).
    Connected(String),
    /// A client left, was forgotten for a newer one (UDP) or, on a pseudo-terminal, was the last.
    Left(String),
    /// A connection was refused because as many as the server keeps are open, and all are in use.
    Refused(String),
    /// A connection that had been idle, or had sent no whole frame, was closed, because as many as the server keeps were open
    /// and a new one came.
    MadeRoom(String),
    /// The cable was pulled ([`Runner::unplug`](magician_sim::Runner::unplug)) and the endpoints are gone.
    Unplugged,
    /// The cable is back, and so are the endpoints: a pseudo-terminal is another device now.
    Plugged(Vec<Endpoint>),
    /// Hosts that look for an arm will not find this one: discovery was not requested explicitly
    /// ([`Discovery::Auto`]), and its port cannot be had. Comes before all is ready.
    Undiscoverable {
        /// Where it would have been.
        address: SocketAddr,
        /// What the system said.
        error: io::Error,
    },
    /// The file of the flash cannot be written and is as it was; it is tried again with the next change and at the end.
    FlashNotKept(FlashFileError),
    /// The trace cannot be written and ends here; the arm is served on.
    TraceEnded(io::Error),
    /// The recording cannot be written and ends here; the arm is served on, and
    /// [`ServeError::Record`] comes at the end.
    RecordingEnded(io::Error),
}

/// Why the arm is not, or no longer, served.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The path for a pseudo-terminal is taken by something that is not a symlink.
    #[cfg(unix)]
    #[error("{} exists and is not a symlink: give another path or remove it", path.display())]
    Occupied {
        /// The path.
        path: PathBuf,
    },
    /// The path for a pseudo-terminal is another server's, which still lives.
    #[cfg(unix)]
    #[error("{} is served already, by {}: end that one first, or give another path", path.display(), server(*process))]
    Served {
        /// The path.
        path: PathBuf,
        /// The process that serves it, if that is known.
        process: Option<u32>,
    },
    /// An address makes no sense.
    #[error("{address}: {reason}")]
    Address {
        /// As it was given.
        address: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The system refused an endpoint.
    #[error("{endpoint}: cannot {action}: {source}")]
    Endpoint {
        /// Which endpoint, as it was given.
        endpoint: String,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// The trace could not be begun.
    #[cfg(feature = "trace")]
    #[error("cannot write the trace: {0}")]
    Trace(#[source] io::Error),
    /// The recording could not be begun, or its file is not whole.
    #[cfg(feature = "record")]
    #[error("the recording is incomplete: {0}")]
    Record(#[source] io::Error),
    /// The system has no timer for us.
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
    /// Whose problem it is: [`ErrorKind::InvalidInput`] for an address that makes no sense, else [`ErrorKind::Port`].
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Address { .. } => ErrorKind::InvalidInput,
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
    /// A server for this arm.
    #[must_use]
    pub fn new(controller: Controller) -> Self {
        Self {
            controller,
            speed: Speed::default(),
            line: LineTiming::default(),
            specs: Vec::new(),
            discovery: Discovery::default(),
            number: None,
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

    /// How fast the arm's clock runs.
    #[must_use]
    pub fn speed(mut self, speed: Speed) -> Self {
        self.speed = speed;
        self
    }

    /// Baud rate and turnaround, for every client's line on its own.
    #[must_use]
    pub fn line(mut self, line: LineTiming) -> Self {
        self.line = line;
        self
    }

    /// A pseudo-terminal behind a symlink at `path`, which takes the place of a symlink that is
    /// there, but for that of a server which still lives (known on Linux). It is raw from the beginning, survives clients that come, go or are killed, and
    /// belongs to the user who runs the server (mode 0620, group `tty`, as the system makes
    /// pseudo-terminals); for others, change the mode of what the symlink points to.
    ///
    /// When the last client leaves, replies it did not read are dropped, what it wrote is still
    /// obeyed, and an exclusive flag it left is cleared. Linux tells when a client leaves; on other
    /// systems the flag is cleared once a second, and unread replies wait for the next client,
    /// which should discard its input on opening, as with any serial port.
    #[cfg(unix)]
    #[must_use]
    pub fn pty(mut self, path: impl Into<PathBuf>) -> Self {
        self.specs.push(EndpointSpec::Pty(path.into()));
        self
    }

    /// A UDP socket at `HOST[:PORT]` (8899 unless given, errata E45; 0: any free port). Each
    /// sender's datagrams are a stream of bytes; each reply is a datagram to the address its
    /// request came from. The 32 latest senders are remembered. On port 8899 it comes with
    /// [`Discovery`].
    #[must_use]
    pub fn udp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Udp(address.into()));
        self
    }

    /// All of these, after those that were asked for before.
    #[must_use]
    pub fn endpoints(mut self, endpoints: Endpoints) -> Self {
        self.specs.extend(endpoints.specs);
        self
    }

    /// Where hosts that look for an arm are answered.
    #[must_use]
    pub fn discovery(mut self, discovery: Discovery) -> Self {
        self.discovery = discovery;
        self
    }

    /// A TCP listener at `HOST:PORT` (0: any free port) for up to 16 connections at a time that have
    /// sent a whole frame, 12 of them from other machines; one more takes the place of one that has
    /// been silent for 10 s, or is refused. Connections that have not sent a frame give way to new
    /// ones at once.
    #[must_use]
    pub fn tcp(mut self, address: impl Into<String>) -> Self {
        self.specs.push(EndpointSpec::Tcp(address.into()));
        self
    }

    /// This is arm `number` of several, counted from 1, whose endpoints are told apart by it:
    /// `.number` is added to the paths of pseudo-terminals, and ports count up from the ones given
    /// (0 stays any free port). [`serve_all`] serves them together.
    #[must_use]
    pub fn number(mut self, number: u32) -> Self {
        self.number = Some(number);
        self
    }

    /// Keeps what the arm keeps without power in a file: it is written half a second after a change, and at the end.
    /// Reading it is the caller's, before the arm is switched on ([`load_flash`](files::load_flash),
    /// [`Controller::with_flash`]).
    #[must_use]
    pub fn flash(mut self, path: impl Into<PathBuf>) -> Self {
        self.flash = Some(path.into());
        self
    }

    /// Writes all that passes to a trace file ([`trace`](magician_record::trace)).
    #[cfg(feature = "trace")]
    #[must_use]
    pub fn trace(mut self, writer: impl io::Write + Send + 'static) -> Self {
        self.trace = Some(Box::new(writer));
        self
    }

    /// Records what the arm does ([`record`](magician_record::mcap)); the epoch is now. A thread of its own
    /// writes to `writer`, so that a slow disk does not hold the arm up: it may fall 16 MB behind.
    /// After that the recording ends, but at [`Speed::Max`] the arm's clock waits instead.
    #[cfg(feature = "record")]
    #[must_use]
    pub fn record(mut self, writer: impl io::Write + Send + 'static) -> Self {
        self.recording = Some(Box::new(writer));
        self
    }

    /// Called once, when every endpoint accepts.
    #[must_use]
    pub fn on_ready(mut self, call: impl FnOnce(&[Endpoint]) + Send + 'static) -> Self {
        self.on_ready = Box::new(call);
        self
    }

    /// Called for everything worth a line in a log. It should be quick: the arm waits for it.
    #[must_use]
    pub fn on_notice(mut self, call: impl FnMut(Notice) + Send + 'static) -> Self {
        self.on_notice = Box::new(call);
        self
    }

    /// A hand on the arm, to look at it and change it while it is served.
    #[must_use]
    pub fn handle(&self) -> Handle {
        self.orders.handle()
    }

    /// Opens every endpoint and serves until `end` is ready. What it made (symlinks, sockets) is
    /// gone when this returns or the future is dropped.
    ///
    /// # Errors
    /// [`ServeError`] when an endpoint cannot be opened (then none stays open) or breaks down, and
    /// at the end when the recording is not whole.
    pub async fn serve_until(self, end: impl Future<Output = ()>) -> Result<(), ServeError> {
        serve_all([self], end).await
    }

    /// Whether there is no hope of opening its endpoints.
    fn check(&self) -> Result<(), ServeError> {
        let mut specs = self.specs.iter();
        specs.try_for_each(|spec| spec.check(self.number))?;
        spec::check(&self.discovery, self.number)
    }
}

/// An open endpoint.
trait Listener {
    /// What it is called outside.
    fn endpoint(&self) -> Endpoint;
    /// Reads what is there, writes what is due, and registers to be woken for more. While the arm
    /// is unplugged, what is read goes nowhere.
    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()>;
    /// The arm's cable was pulled, perhaps once more: no client is a client any longer.
    fn unplug(&mut self, service: &mut dyn Service);
    /// The cable is back.
    fn plug(&mut self, _: &mut dyn Service) -> Result<(), ServeError> {
        Ok(())
    }
}

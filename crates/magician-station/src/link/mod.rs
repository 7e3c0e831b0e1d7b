//! Serves programs written for DobotLink: listens for them and runs the translation
//! [`magician_link::Link`] on tokio.
//!
//! Each program is a client of the station in this process. The translation is a state machine; one
//! task per program moves texts between the program, the translation and the station.

mod listen;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician::admission::Origin;
pub use magician_link::LinkOptions;
use magician_link::{Link, LinkReport};
use magician_protocol::HostInstant;
use serde_json::Value;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until};

pub use self::listen::{ImageStub, LinkListener};
use crate::RunningStation;
use crate::running::Client;
use crate::station::{Outgoing, Peer};

/// Interval of keep-alives sent to the station while the program's socket is open. DobotLink's
/// clients answer no pings while they compute, so an open socket alone has to keep the lease.
const KEEP_ALIVE_INTERVAL: Duration = Duration::from_secs(2);
/// Most unread answers. A program that reads nothing is disconnected.
const MAX_UNREAD_ANSWERS: usize = 4096;

/// Input of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ProgramInput {
    /// A message.
    Text(String),
    /// Reply to a ping.
    Pong,
}

/// Service for all programs of a station's link.
#[derive(Clone, Debug)]
pub struct LinkService {
    station: RunningStation,
    options: LinkOptions,
    report: Arc<Mutex<LinkReport>>,
}

impl LinkService {
    /// Creates the link of a station.
    #[must_use]
    pub fn new(station: RunningStation, options: LinkOptions) -> Self {
        Self {
            station,
            options,
            report: Arc::default(),
        }
    }

    /// Returns the calls by client up to now, as answered by `GET /api/v1/link`.
    #[must_use]
    pub fn report(&self) -> Value {
        let report = self.report.lock().unwrap_or_else(PoisonError::into_inner);
        report.to_value()
    }

    /// Connects a program of this machine. Dropping the returned value disconnects it.
    #[must_use]
    pub fn connect(&self, name: &str, address: &str) -> LinkProgram {
        // Bounded, so that a program that floods is slowed down by its own socket.
        let (input, inputs) = mpsc::channel(64);
        let (outputs, output) = mpsc::channel(MAX_UNREAD_ANSWERS);
        let service = self.clone();
        let (name, address) = (name.to_owned(), address.to_owned());
        tokio::spawn(async move { service.carry(name, address, inputs, outputs).await });
        LinkProgram { input, output }
    }

    async fn carry(
        self,
        name: String,
        address: String,
        mut inputs: mpsc::Receiver<ProgramInput>,
        outputs: mpsc::Sender<String>,
    ) {
        let begun = Instant::now();
        let now = || HostInstant::ZERO + begun.elapsed();
        let peer = Peer {
            // DobotLink has no login: while a class is set, its programs can only watch and stop.
            grant: None,
            origin: Origin::Loopback,
            address,
            // Programs do not resume sessions.
            secret: String::new(),
        };
        let client = self.station.connect_link(peer);
        let mut link = Link::new(now(), self.options.clone(), &name);
        let mut alive = interval(KEEP_ALIVE_INTERVAL);
        alive.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            exchange(&mut link, &client, now());
            while let Some(noted) = link.poll_answered() {
                let mut report = self.report.lock().unwrap_or_else(PoisonError::into_inner);
                report.count(&name, &noted);
            }
            while let Some(text) = link.poll_program() {
                if outputs.try_send(text).is_err() {
                    // The program reads nothing, or is gone.
                    return leave(&mut link, &client, now());
                }
            }
            let due = link.poll_timeout();
            let sleeps = async {
                match due {
                    Some(due) => sleep_until(begun + (due - HostInstant::ZERO)).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                // In this order: calls of the program first, so that a stop is not behind states.
                biased;
                heard = inputs.recv() => match heard {
                    Some(ProgramInput::Text(text)) => link.receive(now(), &text),
                    Some(ProgramInput::Pong) => link.pong(now()),
                    None => return leave(&mut link, &client, now()),
                },
                outgoing = client.receive() => match outgoing {
                    Outgoing::Text(text) => link.receive_from_station(now(), &text),
                    Outgoing::Frame(_) => {}
                    Outgoing::Close(_) => return,
                },
                () = sleeps => link.handle_timeout(now()),
                _ = alive.tick() => client.pong(),
            }
        }
    }
}

/// Exchanges messages until translation and station have no more.
fn exchange(link: &mut Link, client: &Client, now: HostInstant) {
    while let Some(call) = link.poll_station() {
        client.send_for(&call.text, call.origin);
        // Immediate answers are passed on at once, because the next call may depend on them.
        while let Some(Outgoing::Text(text)) = client.try_receive() {
            link.receive_from_station(now, &text);
        }
    }
}

/// Ends what the program started, because it is gone.
fn leave(link: &mut Link, client: &Client, now: HostInstant) {
    link.end();
    exchange(link, client, now);
}

/// Program's end of a connection.
#[derive(Debug)]
pub struct LinkProgram {
    input: mpsc::Sender<ProgramInput>,
    output: mpsc::Receiver<String>,
}

impl LinkProgram {
    /// Sends a message. Returns false if the link has disconnected the program.
    pub async fn send(&self, text: impl Into<String>) -> bool {
        self.input
            .send(ProgramInput::Text(text.into()))
            .await
            .is_ok()
    }

    /// Sends the reply to a ping. Returns false if the link has disconnected the program.
    pub async fn pong(&self) -> bool {
        self.input.send(ProgramInput::Pong).await.is_ok()
    }

    /// Waits for the next message to the program. `None` if it was disconnected.
    pub async fn receive(&mut self) -> Option<String> {
        self.output.recv().await
    }

    /// Splits into sender and receiver, to use both at the same time.
    pub(crate) fn split(self) -> (mpsc::Sender<ProgramInput>, mpsc::Receiver<String>) {
        (self.input, self.output)
    }
}

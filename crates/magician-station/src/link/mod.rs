//! Programs for DobotLink at a station: [`magician_link::Link`] on a tokio runtime, and its listener.

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

/// A program that has its socket open keeps its lease: DobotLink's clients answer no pings while they compute.
const ALIVE: Duration = Duration::from_secs(2);
/// Answers that a program has not read: one that reads nothing is cut off.
const UNREAD: usize = 4096;

/// What a program says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Heard {
    /// A message.
    Text(String),
    /// The answer to a ping.
    Pong,
}

/// What is common to all programs of a station's link.
#[derive(Clone, Debug)]
pub struct LinkService {
    station: RunningStation,
    options: LinkOptions,
    report: Arc<Mutex<LinkReport>>,
}

impl LinkService {
    /// The link of a station.
    #[must_use]
    pub fn new(station: RunningStation, options: LinkOptions) -> Self {
        Self {
            station,
            options,
            report: Arc::default(),
        }
    }

    /// The calls so far, by client: what `GET /api/v1/link` answers.
    #[must_use]
    pub fn report(&self) -> Value {
        let report = self.report.lock().unwrap_or_else(PoisonError::into_inner);
        report.to_value()
    }

    /// A program of this machine connects: what it says goes into the first end, what it is told comes out of the second. Its end
    /// is that of the first.
    #[must_use]
    pub fn connect(&self, name: &str, address: &str) -> LinkProgram {
        let (said, hears) = mpsc::channel(64);
        let (tells, told) = mpsc::channel(UNREAD);
        let service = self.clone();
        let (name, address) = (name.to_owned(), address.to_owned());
        tokio::spawn(async move { service.carry(name, address, hears, tells).await });
        LinkProgram { said, told }
    }

    async fn carry(
        self,
        name: String,
        address: String,
        mut hears: mpsc::Receiver<Heard>,
        tells: mpsc::Sender<String>,
    ) {
        let begun = Instant::now();
        let now = || HostInstant::ZERO + begun.elapsed();
        let peer = Peer {
            // DobotLink has no login: while a class is set its programs look on and stop.
            grant: None,
            origin: Origin::Loopback,
            address,
            // It does not come back to its session.
            secret: String::new(),
        };
        let client = self.station.connect_link(peer);
        let mut link = Link::new(now(), self.options.clone(), &name);
        let mut alive = interval(ALIVE);
        alive.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            exchange(&mut link, &client, now());
            while let Some(noted) = link.poll_noted() {
                let mut report = self.report.lock().unwrap_or_else(PoisonError::into_inner);
                report.count(&name, &noted);
            }
            while let Some(text) = link.poll_program() {
                if tells.try_send(text).is_err() {
                    // It reads nothing, or is gone.
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
                biased;
                heard = hears.recv() => match heard {
                    Some(Heard::Text(text)) => link.receive(now(), &text),
                    Some(Heard::Pong) => link.pong(now()),
                    None => return leave(&mut link, &client, now()),
                },
                outgoing = client.receive() => match outgoing {
                    Outgoing::Text(text) => link.hear(now(), &text),
                    Outgoing::Frame(_) => {}
                    Outgoing::Close(_) => return,
                },
                () = sleeps => link.handle_timeout(now()),
                _ = alive.tick() => client.pong(),
            }
        }
    }
}

/// Hands messages over until both sides have said all.
fn exchange(link: &mut Link, client: &Client, now: HostInstant) {
    while let Some(call) = link.poll_station() {
        client.send_for(&call.text, call.of);
        // What is answered at once is heard at once.
        while let Some(Outgoing::Text(text)) = client.try_receive() {
            link.hear(now, &text);
        }
    }
}

/// The program is gone.
fn leave(link: &mut Link, client: &Client, now: HostInstant) {
    link.end();
    exchange(link, client, now);
}

/// The ends of a program's connection.
#[derive(Debug)]
pub struct LinkProgram {
    said: mpsc::Sender<Heard>,
    told: mpsc::Receiver<String>,
}

impl LinkProgram {
    /// The program says something. Whether it is heard: the link may have cut it off.
    pub async fn say(&self, text: impl Into<String>) -> bool {
        self.said.send(Heard::Text(text.into())).await.is_ok()
    }

    /// The program answers a ping.
    pub async fn pong(&self) -> bool {
        self.said.send(Heard::Pong).await.is_ok()
    }

    /// What it is told next; `None` when it was cut off.
    pub async fn hear(&mut self) -> Option<String> {
        self.told.recv().await
    }

    /// Both ends, to be used at the same time.
    pub(crate) fn split(self) -> (mpsc::Sender<Heard>, mpsc::Receiver<String>) {
        (self.said, self.told)
    }
}

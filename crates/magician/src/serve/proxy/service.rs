//! Proxy on the wall clock, as a service behind endpoints.

use std::collections::BTreeMap;
use std::time::Instant;

use magician_protocol::{Direction, FrameBuf};
#[cfg(feature = "trace")]
use magician_record::trace::LINE_OF_ARM;
use magician_sim::LinkId;

use super::super::{Notice, Service};
#[cfg(feature = "trace")]
use super::trace::{ProxyTrace, wall_clock};
use super::{ProxyNotice, ProxyObserver};
use crate::proxy::{Chunk, Client, Event, Proxy, Settings};

/// Proxy on the wall clock, with its observer and trace.
pub(super) struct ProxyService {
    pub(super) proxy: Proxy,
    begun: Instant,
    names: BTreeMap<Client, String>,
    links: u32,
    observer: Box<dyn ProxyObserver>,
    #[cfg(feature = "trace")]
    trace: Option<ProxyTrace>,
    /// Name of the arm's line in the trace.
    #[cfg(feature = "trace")]
    arm: String,
}

impl ProxyService {
    pub(super) fn new(settings: Settings, arm: &str) -> Self {
        Self {
            proxy: Proxy::new(settings),
            begun: Instant::now(),
            names: BTreeMap::new(),
            links: 0,
            observer: Box::new(|_: ProxyNotice<'_>| ()),
            #[cfg(feature = "trace")]
            trace: None,
            #[cfg(feature = "trace")]
            arm: format!("{LINE_OF_ARM}{arm}"),
        }
    }

    pub(super) fn observe(&mut self, observer: Box<dyn ProxyObserver>) {
        self.observer = observer;
    }

    #[cfg(feature = "trace")]
    pub(super) fn trace(&mut self, trace: ProxyTrace) {
        self.trace = Some(trace);
    }

    pub(super) fn tell(&mut self, notice: ProxyNotice<'_>) {
        self.observer.notice(notice);
    }

    /// Returns the microseconds since the start.
    pub(super) fn now(&self) -> u64 {
        // 584,000 years of microseconds fit, so the bound is never reached.
        u64::try_from(self.begun.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    /// Lets time pass.
    pub(super) fn tick(&mut self) {
        let now = self.now();
        self.proxy.handle_timeout(now);
    }

    pub(super) fn receive_from_arm(&mut self, bytes: &[u8]) {
        self.record(None, Direction::Reply, bytes);
        let now = self.now();
        self.proxy.receive_from_arm(now, bytes);
    }

    pub(super) fn transmit_to_arm(&mut self) -> Option<Chunk> {
        let now = self.now();
        let chunk = self.proxy.poll_transmit_to_arm(now)?;
        self.record(None, Direction::Request, chunk.bytes());
        Some(chunk)
    }

    pub(super) fn lose_line(&mut self, why: &crate::Error) {
        self.proxy.lose_line();
        self.tell(ProxyNotice::LineLost(why));
    }

    pub(super) fn find_line(&mut self) {
        self.proxy.find_line();
        self.tell(ProxyNotice::LineFound);
    }

    /// Disconnects all clients.
    pub(super) fn close_all(&mut self) {
        let clients: Vec<Client> = self.names.keys().copied().collect();
        for client in clients {
            self.proxy.close(client);
        }
    }

    /// Passes new events to the observer.
    pub(super) fn show(&mut self) {
        while let Some(event) = self.proxy.poll_event() {
            let client = concerned(&event).and_then(|client| self.names.get(&client));
            self.observer.notice(ProxyNotice::Traffic {
                event: &event,
                client: client.map(String::as_str),
            });
        }
        self.observer.flush();
    }

    /// Records bytes. A trace that fails is ended; the proxy continues.
    #[cfg(feature = "trace")]
    fn record(&mut self, client: Option<Client>, direction: Direction, bytes: &[u8]) {
        let Some(trace) = &mut self.trace else {
            return;
        };
        let name = match client {
            Some(client) => self.names.get(&client),
            None => Some(&self.arm),
        };
        let Some(name) = name else {
            return;
        };
        let written = trace.record(name, wall_clock(), direction, bytes);
        self.traced(written);
    }

    #[cfg(not(feature = "trace"))]
    #[allow(clippy::unused_self)]
    fn record(&mut self, _: Option<Client>, _: Direction, _: &[u8]) {}

    #[cfg(feature = "trace")]
    fn traced(&mut self, written: std::io::Result<()>) {
        if let Err(error) = written {
            self.trace = None;
            self.tell(ProxyNotice::TraceEnded(&error));
        }
    }
}

fn client(link: LinkId) -> Client {
    Client(link.0)
}

/// Returns the client that an event concerns, if any.
fn concerned(event: &Event) -> Option<Client> {
    match event {
        Event::Request { client, .. }
        | Event::Reply { client, .. }
        | Event::Unanswered { client, .. }
        | Event::Dropped { client, .. } => Some(*client),
        Event::Foreign { from, .. } => *from,
        Event::Own { .. } | Event::Unclaimed { .. } => None,
        // Unreachable in a published build too: the crates depend on each other by exact version.
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

impl Service for ProxyService {
    fn open(&mut self, name: &str) -> LinkId {
        let link = LinkId(self.links);
        self.links = self.links.wrapping_add(1);
        self.proxy.open(client(link));
        self.names.insert(client(link), name.to_owned());
        link
    }

    fn close(&mut self, link: LinkId) {
        self.proxy.close(client(link));
        // While the client's name is still known.
        self.show();
        let name = self.names.remove(&client(link));
        #[cfg(feature = "trace")]
        if let (Some(trace), Some(name)) = (&mut self.trace, &name) {
            let written = trace.close(name);
            self.traced(written);
        }
        drop(name);
    }

    fn room(&self, link: LinkId) -> usize {
        self.proxy.room(client(link))
    }

    fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        self.record(Some(client(link)), Direction::Request, bytes);
        let now = self.now();
        self.proxy.receive(now, client(link), bytes);
    }

    fn reply(&mut self, link: LinkId) -> Option<FrameBuf> {
        let frame = self.proxy.poll_transmit(client(link))?;
        self.record(Some(client(link)), Direction::Reply, frame.bytes());
        Some(frame)
    }

    fn notice(&mut self, notice: Notice) {
        self.tell(ProxyNotice::Client(&notice));
    }
}

use std::collections::BTreeMap;
use std::time::Instant;

use magician::proxy::{Chunk, Client, Proxy, Settings};
use magician::serve::{Endpoint, Notice, Service};
use magician_protocol::{Direction, FrameBuf};
use magician_record::replay::LINE_OF_ARM;
use magician_sim::LinkId;

use super::log::Log;
use super::trace::{ProxyTrace, wall_clock};

/// What the endpoints lead to: the proxy on the wall clock, with its log and its trace.
pub(super) struct ProxyService {
    pub(super) proxy: Proxy,
    begun: Instant,
    names: BTreeMap<Client, String>,
    links: u32,
    log: Log,
    trace: Option<ProxyTrace>,
    /// What the arm's line is called in the trace.
    arm: String,
}

impl ProxyService {
    pub(super) fn new(settings: Settings, log: Log, arm: &str) -> Self {
        Self {
            proxy: Proxy::new(settings),
            begun: Instant::now(),
            names: BTreeMap::new(),
            links: 0,
            log,
            trace: None,
            arm: format!("{LINE_OF_ARM}{arm}"),
        }
    }

    pub(super) fn trace(&mut self, trace: ProxyTrace) {
        self.trace = Some(trace);
    }

    pub(super) fn say_serving(&self, arm: &str, endpoints: &[Endpoint]) {
        self.log.serving(arm, endpoints);
    }

    /// Says which computers may move the arm, if more than this one.
    pub(super) fn say_exposed(&self, arm: &str, endpoints: &[Endpoint]) {
        self.log.exposed(arm, endpoints);
    }

    /// Microseconds since this began.
    pub(super) fn now(&self) -> u64 {
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

    pub(super) fn lose_line(&mut self, why: &magician::Error) {
        self.proxy.lose_line();
        self.log.line_lost(why);
    }

    pub(super) fn find_line(&mut self) {
        self.proxy.find_line();
        self.log.line_found(&self.arm);
    }

    /// Everybody leaves.
    pub(super) fn close_all(&mut self) {
        let clients: Vec<Client> = self.names.keys().copied().collect();
        for client in clients {
            self.proxy.close(client);
        }
    }

    /// The arm did not confirm that it stands.
    pub(super) fn say_unconfirmed(&self) {
        self.log.unconfirmed();
    }

    /// Shows what has happened.
    pub(super) fn show(&mut self) {
        while let Some(event) = self.proxy.poll_event() {
            self.log.event(&event, &self.names);
        }
        self.log.flush();
    }

    /// A trace that cannot be written ends; the proxy does not.
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
        if let Err(error) = trace.record(name, wall_clock(), direction, bytes) {
            self.trace = None;
            self.log.trace_ended(&error);
        }
    }
}

fn client(link: LinkId) -> Client {
    Client(link.0)
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
        // While the name is known.
        self.show();
        let name = self.names.remove(&client(link));
        if let (Some(trace), Some(name)) = (&mut self.trace, name)
            && let Err(error) = trace.close(&name)
        {
            self.trace = None;
            self.log.trace_ended(&error);
        }
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
        self.log.notice(&notice);
    }
}

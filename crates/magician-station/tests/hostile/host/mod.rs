//! Host of the property tests: clients and arms that do anything, driven by a script, line by line.
//! The station's bounds are checked after each line; at the end every client with a socket must
//! have all its answers.

pub(crate) mod client;

use std::collections::HashMap;
use std::time::Duration;

use magician::admission::Origin;
use magician_job::JobState;
use magician_protocol::HostInstant;
use magician_station::api::{Message, MessageId};
use magician_station::control::{ArmId, JogEnd, RequestId};
use magician_station::{
    ArmEntry, ArmOrder, ArmRead, ArmReport, Grant, JobEnd, JobUpdate, Outcome, Outgoing, Peer,
    Role, SocketId, Station, StationConfig,
};
use serde_json::{Value, json};

use self::client::{Client, failed, reading};

const ARMS: u64 = 2;
/// Number of clients.
const CLIENTS: usize = 10;
/// Most requests of a socket in flight. Stops are not limited.
const MAX_REQUESTS_IN_FLIGHT: usize = 64;

/// Station with its surroundings.
pub(crate) struct Simulation {
    station: Station,
    now: HostInstant,
    clients: Vec<Client>,
    /// Number of closed sockets whose requests may still be in flight.
    opened: usize,
    /// Observer of leases.
    spy: SocketId,
    holders: Vec<Option<String>>,
    /// Number of jobs that may start without the lease, because they were queued.
    queued: u64,
    /// Number of written versions of the jobs.
    writes: u64,
    /// Orders without a report.
    orders: Vec<(ArmId, ArmOrder)>,
    /// Requests that the library has not answered.
    library: Vec<RequestId>,
    /// Counter that distinguishes readings.
    read: f32,
}

impl Default for Simulation {
    fn default() -> Self {
        let arm = |at: u64| ArmEntry {
            is_virtual: at == 0,
            ..ArmEntry::simulated(format!("arm{at}"))
        };
        let mut station = Station::new(StationConfig::new((0..ARMS).map(arm).collect(), "0"));
        let now = HostInstant::ZERO;
        let spy = station.open(now, peer(Some(Role::Viewer), 0));
        let hello = r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"spy"}}}"#;
        station.receive(now, spy, hello);
        Self {
            station,
            now,
            clients: Vec::new(),
            opened: 0,
            spy,
            holders: vec![None; ARMS as usize],
            queued: 0,
            writes: 0,
            orders: Vec::new(),
            library: Vec::new(),
            read: 0.0,
        }
    }
}

fn peer(role: Option<Role>, at: usize) -> Peer {
    Peer {
        grant: role.map(|role| Grant { role, token: None }),
        origin: Origin::Loopback,
        address: "127.0.0.1:1".to_owned(),
        secret: format!("secret-{at}"),
    }
}

impl Simulation {
    /// Runs a script.
    pub(crate) fn live(&mut self, script: &str) {
        for line in script.lines() {
            self.line(line);
            self.look();
        }
    }

    fn line(&mut self, line: &str) {
        let mut chars = line.chars();
        let Some(mark) = chars.next() else { return };
        let rest = chars.as_str();
        let number: u64 = rest.trim().parse().unwrap_or(0);
        let arm = ArmId(number % ARMS);
        match mark {
            '0'..='9' => self.message(mark as usize - '0' as usize, rest),
            '+' => self.open(number),
            '-' => self.close(number as usize),
            '>' => self.drain(number as usize),
            'p' => {
                if let Some(client) = self.clients.get(number as usize) {
                    self.station.pong(self.now, client.socket);
                }
            }
            't' => self.pass(Duration::from_millis(number % 10_000)),
            'r' | 'e' => self.report(number as usize, mark == 'r'),
            '?' => self.reading(arm),
            'l' | 'L' => self
                .station
                .report(self.now, arm, ArmReport::Link(mark == 'L')),
            'j' => {
                let jog = self.orders.iter().find_map(|(of, order)| match order {
                    ArmOrder::StartJog { jog, .. } if *of == arm => Some(*jog),
                    _ => None,
                });
                if let Some(jog) = jog {
                    let why = JogEnd::Limit;
                    let report = ArmReport::JogEnded { jog, why };
                    self.station.report(self.now, arm, report);
                }
            }
            'x' => self.station.revoke(self.now, "good"),
            _ => {}
        }
        self.take_orders(None);
    }

    fn open(&mut self, role: u64) {
        let roles = [
            None,
            Some(Role::Viewer),
            Some(Role::Student),
            Some(Role::Teacher),
        ];
        if self.clients.len() == CLIENTS {
            return;
        }
        self.opened += 1;
        let peer = peer(roles[role as usize % 4], self.opened);
        self.clients.push(Client {
            socket: self.station.open(self.now, peer),
            session: None,
            closed: false,
            asked: HashMap::new(),
            sent: 0,
            answers: 0,
        });
    }

    /// Closes a socket, by a broken line or by the client.
    fn close(&mut self, at: usize) {
        if at < self.clients.len() {
            let client = self.clients.remove(at);
            self.station.close(self.now, client.socket);
        }
    }

    fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while let Some(due) = self.station.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.station.handle_timeout(self.now);
            let next = self.station.poll_timeout();
            assert!(
                next.is_none_or(|next| next > self.now),
                "what is due is done"
            );
            self.take_orders(None);
        }
        self.now = until;
    }

    fn message(&mut self, at: usize, text: &str) {
        let Some(client) = self.clients.get_mut(at) else {
            return;
        };
        client.sent += 1;
        let id = match Message::parse(text) {
            Ok(message) => message.id,
            Err(bad) => bad.id,
        };
        if let Some(id) = id {
            let id = match id {
                MessageId::Text(text) => json!(text),
                MessageId::Number(number) => json!(number),
            };
            client.asked.entry(id.to_string()).or_default().0 += 1;
        }
        let socket = client.socket;
        // Timeouts first, so that their effects are not attributed to the message.
        self.station.handle_timeout(self.now);
        self.take_orders(None);
        if let Some(token) = Station::token_of(text) {
            let good = Grant {
                role: Role::Teacher,
                token: Some("good".to_owned()),
            };
            self.station
                .set_token_grant(socket, (token == "good").then_some(good));
        }
        if let Ok(message) = Message::parse(text) {
            self.queued += match message.method.as_str() {
                "class.send" => ARMS,
                "job.start" => u64::from(message.params.get("queue") == Some(&Value::Bool(true))),
                _ => 0,
            };
        }
        self.station.receive(self.now, socket, text);
        self.take_orders(Some(at));
    }

    /// Collects orders caused by a message of a client, or by no client.
    fn take_orders(&mut self, by: Option<usize>) {
        self.write_all();
        while let Some((arm, order)) = self.station.poll_order() {
            let moves = matches!(
                order,
                ArmOrder::Act { .. }
                    | ArmOrder::StartJog { .. }
                    | ArmOrder::KeepJog(_)
                    | ArmOrder::StartJob(_)
                    | ArmOrder::World { .. }
                    | ArmOrder::Guide {
                        request: Some(_),
                        ..
                    }
                    | ArmOrder::ResumeJob { .. }
            );
            let holder = self.holders[arm.0 as usize].as_ref();
            let by = by.map(|at| &self.clients[at]);
            let session = by.and_then(|client| client.session.as_ref());
            // A client that does not read does not know its own session.
            let known = session.is_none() || session == holder;
            let leased = holder.is_some() && by.is_some() && known;
            if moves && !leased {
                let queued = matches!(order, ArmOrder::StartJob(_)) && self.queued > 0;
                assert!(queued, "{order:?} by another than the holder, {holder:?}");
                self.queued -= 1;
            }
            match &order {
                ArmOrder::Stop { request: None }
                | ArmOrder::KeepJog(_)
                | ArmOrder::Guide { request: None, .. }
                | ArmOrder::EndJog(_)
                | ArmOrder::EndUnattended
                | ArmOrder::Watch { .. } => continue,
                _ => {}
            }
            self.orders.push((arm, order));
        }
        while let Some(order) = self.station.poll_library() {
            self.library.push(order.request);
        }
        while self.station.poll_journal().is_some() {}
        while self.station.poll_record().is_some() {}
        while self.station.poll_awake().is_some() {}
        self.spy();
    }

    /// Disk that fails for every seventh version of the jobs, and every seventh file.
    fn write_all(&mut self) {
        loop {
            while let Some(jobs) = self.station.poll_jobs() {
                let outcome = self.write();
                self.station
                    .jobs_written(self.now, jobs.arm(), jobs.revision(), outcome);
            }
            let files = self.station.poll_files();
            if files.is_empty() {
                return;
            }
            for (name, file) in files {
                let outcome = self.write();
                self.station
                    .file_written(self.now, name, file.revision, outcome);
            }
        }
    }

    fn write(&mut self) -> Result<(), String> {
        self.writes += 1;
        match self.writes % 7 {
            0 => Err("No space left on device".to_owned()),
            _ => Ok(()),
        }
    }

    /// Follows who holds which lease.
    fn spy(&mut self) {
        while let Some(outgoing) = self.station.poll_send(self.spy) {
            let Outgoing::Text(text) = outgoing else {
                panic!("the spy did nothing: {outgoing:?}");
            };
            let message: Value = serde_json::from_str(&text).expect("JSON");
            if message["method"] == json!("lease.changed") {
                let params = &message["params"];
                let arm = if params["arm"] == json!("arm0") { 0 } else { 1 };
                let holder = params["holder"]["session"].as_str();
                self.holders[arm] = holder.map(str::to_owned);
            }
        }
    }

    /// Answers for the library.
    fn look_up(&mut self, good: bool) {
        if let Some(request) = self.library.pop() {
            let outcome = if good { Ok(json!({})) } else { Err(failed()) };
            self.station.library_done(self.now, request, outcome);
        }
    }

    /// Reports the result of an order.
    fn report(&mut self, at: usize, good: bool) {
        self.look_up(good);
        if self.orders.is_empty() {
            return;
        }
        let (arm, order) = self.orders.remove(at % self.orders.len());
        let update = match &order {
            ArmOrder::StartJob(start) => Some((start.job, JobState::Running)),
            ArmOrder::ResumeJob { job, .. } => Some((*job, JobState::Running)),
            ArmOrder::PauseJob { job, reason, .. } => {
                let (reason, part) = (*reason, None);
                Some((*job, JobState::Paused { reason, part }))
            }
            ArmOrder::StopJob(job) => Some((*job, JobState::Stopping)),
            _ => None,
        };
        if let Some((job, state)) = update {
            let update = if good && state != JobState::Stopping {
                JobUpdate::State(state, None)
            } else {
                JobUpdate::Over(Box::new(JobEnd::new("stopped")))
            };
            let report = ArmReport::Job { job, update };
            return self.station.report(self.now, arm, report);
        }
        let request = match &order {
            ArmOrder::Read { request, .. }
            | ArmOrder::CheckJob { request, .. }
            | ArmOrder::Act { request, .. }
            | ArmOrder::Fence { request, .. }
            | ArmOrder::World { request, .. }
            | ArmOrder::Guide {
                request: Some(request),
                ..
            }
            | ArmOrder::StartJog { request, .. } => *request,
            ArmOrder::Stop { request } => request.expect("those without are not kept"),
            other => panic!("{other:?} is not kept"),
        };
        let state = matches!(
            &order,
            ArmOrder::Read {
                read: ArmRead::State,
                ..
            }
        );
        if state && good {
            self.reading(arm);
        }
        self.done(arm, request, state, good);
    }

    /// Reports a reading of the arm.
    fn reading(&mut self, arm: ArmId) {
        self.read += 1.0;
        let report = ArmReport::Reading(Box::new(reading(self.read)));
        self.station.report(self.now, arm, report);
    }

    fn done(&mut self, arm: ArmId, request: RequestId, state: bool, good: bool) {
        let outcome = match (good, state) {
            (true, true) => Ok(Outcome::State),
            (true, false) => Ok(Outcome::Value(json!({"stood": true}))),
            (false, _) => Err(failed()),
        };
        let report = ArmReport::Done { request, outcome };
        self.station.report(self.now, arm, report);
    }

    /// Reads all messages of a client.
    fn drain(&mut self, at: usize) {
        let Some(client) = self.clients.get_mut(at) else {
            return;
        };
        while let Some(outgoing) = self.station.poll_send(client.socket) {
            let end = matches!(outgoing, Outgoing::Close(_));
            assert!(
                end || !client.closed,
                "nothing comes after the end: {outgoing:?}"
            );
            match outgoing {
                Outgoing::Text(text) => client.hears(&text),
                Outgoing::Frame(frame) => assert_eq!(frame.len(), magician_station::FRAME_SIZE),
                Outgoing::Close(_) => {
                    client.closed = true;
                    break;
                }
            }
        }
    }

    /// Checks that nothing exceeds its bounds.
    fn look(&self) {
        let size = self.station.size();
        let sockets = self.clients.len() + 1;
        assert_eq!(size.sockets, sockets);
        assert!(size.subscriptions <= 16 * sockets, "{size:?}");
        assert!(size.jogs <= 256, "{size:?}");
        assert!(size.events <= 1000 * ARMS as usize, "{size:?}");
        assert!(size.sessions <= self.opened + 1, "{size:?}");
        let requests = MAX_REQUESTS_IN_FLIGHT * (self.opened + 1) + self.orders.len();
        assert!(size.pending <= requests, "{size:?}");
        let bytes = (8 * 1024 + 512) * 1024 * sockets;
        assert!(size.unsent <= bytes, "{size:?}");
    }

    /// Ends the test: arms report everything and all waits end. Then every client with a socket has
    /// its answers.
    pub(crate) fn end(&mut self) {
        while !(self.orders.is_empty() && self.library.is_empty()) {
            self.report(0, true);
            self.take_orders(None);
        }
        self.pass(Duration::from_secs(3700));
        while !(self.orders.is_empty() && self.library.is_empty()) {
            self.report(0, false);
            self.take_orders(None);
        }
        for at in 0..self.clients.len() {
            self.drain(at);
            let client = &self.clients[at];
            let open = client.asked.iter().find(|(_, (asked, came))| asked != came);
            assert!(client.closed || open.is_none(), "not answered: {open:?}");
        }
        for _ in 0..self.clients.len() {
            self.close(0);
        }
        self.pass(Duration::from_secs(10));
        self.take_orders(None);
        let size = self.station.size();
        let left = (
            size.sockets,
            size.sessions,
            size.pending,
            size.subscriptions,
        );
        assert_eq!(left, (1, 1, 0, 0), "nothing is left but the spy");
        assert!(
            self.holders.iter().all(Option::is_none),
            "nobody has a lease"
        );
    }
}

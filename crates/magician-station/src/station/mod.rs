//! The station: JSON-RPC text of clients in, text for clients and orders for arms out. No I/O, no
//! clock.
//!
//! [`Station`] joins the parts: sockets and sessions, [`Control`](crate::control::Control) for all
//! decisions about motion, records of jobs, subscriptions, recordings, and with the feature `class`
//! a class. Every public method that changes something ends in `carry_out_effects`, which carries
//! out the effects of control until none is left. The results are collected in queues and polled by
//! the shell: orders, journal lines, jobs and files to write, sockets with something to send.

mod calls;
#[cfg(feature = "class")]
mod class;
#[cfg(feature = "class")]
mod class_files;
mod config;
mod connections;
mod dispatch;
mod effects;
mod ending;
mod events;
mod fence;
mod held_work;
mod history;
mod job_updates;
mod jobs;
mod journal;
mod leases;
mod library;
mod long_requests;
mod motion;
mod newest;
mod outbox;
#[cfg(feature = "class")]
mod queue;
mod recordings;
mod records;
mod reports;
#[cfg(feature = "class")]
mod results;
mod rights;
#[cfg(feature = "class")]
mod schedule;
mod sessions;
#[cfg(feature = "class")]
mod sign_in;
mod size;
mod socket;
mod state;
mod store;
mod teach;
mod throttle;
mod tools;
#[cfg(feature = "class")]
mod turns;
mod watch;
mod world;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

use magician::admission::AdmissionTable;
use magician_protocol::HostInstant;
use serde_json::Value;

pub use self::config::{ArmEntry, Grant, StationConfig};
use self::ending::Ending;
pub use self::ending::{EndReport, ForcedStop};
use self::events::EventLog;
use self::held_work::HeldWork;
use self::jobs::AwaitedJobState;
pub use self::journal::JournalLine;
use self::long_requests::LongRequests;
pub use self::newest::LIST_INTERVAL;
use self::newest::{Newest, NoticeRates};
pub use self::outbox::{Next, Outbox};
use self::recordings::{ArmRecordings, Recorded};
#[cfg(feature = "http")]
pub(crate) use self::sessions::SILENT_SOCKETS;
use self::sessions::{LIMITS, Session};
pub use self::sessions::{MAX_MESSAGE_SIZE, MAX_SOCKETS, MAX_VIEWERS};
pub use self::size::StationSize;
use self::socket::Socket;
pub use self::socket::{
    CloseCode, MAX_MESSAGES_PER_SECOND, MAX_REQUESTS_IN_FLIGHT, Outgoing, Peer,
};
use self::state::SharedState;
use self::store::Records;
pub use self::store::{FileSnapshot, JobsSnapshot, check_jobs, damaged_jobs};
pub use self::teach::TeachAct;
pub use self::throttle::{RateVerdict, Throttle};
use crate::api::{MessageId, Notice, Params, RpcError};
use crate::control::{ArmId, Control, JobId, JogId, LeaseId, RequestId, SessionId};
use crate::library::LibraryOrder;
use crate::order::{ArmOrder, ArmReport};
use crate::reading::{ArmReading, StateContext};
use crate::recording::RecordOrder;

/// Id of a client's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SocketId(pub u64);

/// Event for which a request waits.
#[derive(Debug)]
enum Awaited {
    /// Result of an order.
    Arm(ArmId),
    /// The change is on the disk.
    Saved,
    /// Result of the library.
    Library,
    /// Check that a job's program and preset exist. Then the job starts with these parameters.
    Program(ArmId, Box<Params>),
    /// The lease.
    Lease { asked: bool },
    /// Start of a jog.
    Jog(ArmId, JogId),
    /// State of a job.
    Job(ArmId, JobId, AwaitedJobState),
    /// Result of the recorder.
    Record(Recorded),
    /// Stop of several arms.
    Stops {
        left: BTreeSet<ArmId>,
        arms: Vec<Value>,
        failed: Option<RpcError>,
    },
}

/// Request without an answer so far.
#[derive(Debug)]
struct Pending {
    socket: SocketId,
    id: Option<MessageId>,
    awaits: Awaited,
    line: Option<JournalLine>,
    began: HostInstant,
}

/// State of an arm within the station.
#[derive(Debug)]
struct ArmState {
    entry: ArmEntry,
    reading: Option<ArmReading>,
    recordings: ArmRecordings,
    /// Forms of that reading for subscribers.
    state: Option<SharedState>,
    /// Instant of that reading.
    read_at: HostInstant,
    link: bool,
    /// Instant at which the line broke or was found. Earlier readings are outdated.
    link_changed_at: HostInstant,
    events: EventLog,
    /// Current rate of reading, and pins.
    watched: (Option<u32>, Vec<magician::Pin>),
}

/// Station: one or more arms, shared by many clients.
///
/// A listener passes in what clients send ([`open`](Self::open), [`receive`](Self::receive),
/// [`close`](Self::close)) and sends what [`poll_send`](Self::poll_send) returns for each socket.
/// Arms get the orders of [`poll_order`](Self::poll_order), and their reports go to
/// [`report`](Self::report). Time comes from the calls; [`poll_timeout`](Self::poll_timeout)
/// returns when [`handle_timeout`](Self::handle_timeout) is due.
///
/// ```
/// use magician::admission::Origin;
/// use magician_protocol::HostInstant;
/// use magician_station::{ArmEntry, Grant, Outgoing, Peer, Role, Station, StationConfig};
///
/// let arms = vec![ArmEntry::simulated("arm")];
/// let mut station = Station::new(StationConfig::new(arms, "1"));
/// let grant = Some(Grant { role: Role::Teacher, token: None });
/// let origin = Origin::Loopback;
/// let peer = Peer { grant, origin, address: "127.0.0.1".into(), secret: "0123456789abcdef".into() };
/// let now = HostInstant::ZERO;
/// let socket = station.open(now, peer);
/// station.receive(now, socket, r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"doc"}}}"#);
/// let Some(Outgoing::Text(answer)) = station.poll_send(socket) else { panic!() };
/// assert!(answer.contains("\"role\":\"teacher\""));
/// ```
pub struct Station {
    config: StationConfig,
    control: Control,
    arms: Vec<ArmState>,
    sockets: BTreeMap<SocketId, Socket>,
    sessions: BTreeMap<SessionId, Session>,
    /// Sockets of listeners. Decides which one is evicted.
    admission: AdmissionTable<SocketId>,
    notice_rates: NoticeRates,
    pending: BTreeMap<RequestId, Pending>,
    orders: VecDeque<(ArmId, ArmOrder)>,
    record_orders: VecDeque<(ArmId, RecordOrder)>,
    library: VecDeque<LibraryOrder>,
    long_requests: LongRequests,
    #[cfg(feature = "class")]
    class: class::StationClass,
    /// Arms of jogs, including jogs that have ended.
    jogs: BTreeMap<JogId, ArmId>,
    records: Records,
    held_work: HeldWork,
    lines: VecDeque<JournalLine>,
    awake: BTreeSet<SocketId>,
    /// State of the end of the station, once it has begun.
    ending: Option<Ending>,
    ids: u64,
}

impl fmt::Debug for Station {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Station")
            .field("config", &self.config)
            .field("sockets", &self.sockets.len())
            .field("pending", &self.pending.len())
            .finish_non_exhaustive()
    }
}

impl Station {
    /// Creates a station whose arms are connected and which has no clients.
    #[must_use]
    pub fn new(config: StationConfig) -> Self {
        let place = |entry: &ArmEntry| ArmState {
            entry: entry.clone(),
            reading: None,
            recordings: ArmRecordings::default(),
            state: None,
            read_at: HostInstant::ZERO,
            link: true,
            link_changed_at: HostInstant::ZERO,
            events: EventLog::default(),
            watched: (None, Vec::new()),
        };
        let names: Vec<_> = config.arms.iter().map(|arm| arm.name.as_str()).collect();
        let mut station = Self {
            records: Records::load(&*config.jobs, &names, config.unix_zero),
            held_work: HeldWork::default(),
            control: Control::new(config.arms.len()),
            arms: config.arms.iter().map(place).collect(),
            #[cfg(feature = "class")]
            class: class::StationClass::load(&config),
            config,
            sockets: BTreeMap::new(),
            sessions: BTreeMap::new(),
            admission: AdmissionTable::new(LIMITS),
            notice_rates: NoticeRates::default(),
            pending: BTreeMap::new(),
            orders: VecDeque::new(),
            record_orders: VecDeque::new(),
            library: VecDeque::new(),
            long_requests: LongRequests::default(),
            jogs: BTreeMap::new(),
            lines: VecDeque::new(),
            awake: BTreeSet::new(),
            ending: None,
            ids: 0,
        };
        // Before the first client, who may list or resume them.
        station.load_jobs();
        // Reading for the history starts now, before the first client.
        station.update_read_rates();
        station
    }

    /// Returns the arms, by id.
    #[must_use]
    pub fn arms(&self) -> &[ArmEntry] {
        &self.config.arms
    }

    /// Processes a report of an arm.
    pub fn report(&mut self, now: HostInstant, arm: ArmId, report: ArmReport) {
        self.take_report(now, arm, report);
        self.carry_out_effects(now);
    }

    /// Handles everything that is due.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        #[cfg(feature = "class")]
        self.class_timeout(now);
        self.control.handle_timeout(now);
        self.save_for_alarms(now);
        self.records.retry_writes(now, false);
        self.answer_stands(now);
        let late = |socket: &Socket| socket.session.is_none() && now >= socket.hello_due();
        let late: Vec<_> = { self.sockets.iter() }
            .filter(|(_, socket)| late(socket) && !socket.outbox.is_closing())
            .map(|(id, _)| *id)
            .collect();
        for socket in late {
            self.end_socket(socket, CloseCode::HELLO_TIMEOUT);
        }
        self.carry_out_effects(now);
    }

    /// Returns the instant at which [`handle_timeout`](Self::handle_timeout) is due. `None` if
    /// nothing is pending.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let hellos = self.sockets.values().filter_map(|socket| {
            let waits = socket.session.is_none() && !socket.outbox.is_closing();
            waits.then(|| socket.hello_due())
        });
        let saves = self.arms.iter().filter_map(|place| place.recordings.due());
        let due = (hellos.chain(self.control.poll_timeout()))
            .chain(saves)
            .chain(self.notice_rates.due())
            .chain(self.end_due())
            .chain(self.held_due())
            .min();
        #[cfg(feature = "class")]
        let due = due.into_iter().chain(self.class.next()).min();
        due
    }

    /// Returns the next order for an arm.
    pub fn poll_order(&mut self) -> Option<(ArmId, ArmOrder)> {
        self.orders.pop_front()
    }

    /// Returns the next operation on the library.
    pub fn poll_library(&mut self) -> Option<LibraryOrder> {
        self.library.pop_front()
    }

    /// Takes the result of an operation on the library.
    pub fn library_done(
        &mut self,
        now: HostInstant,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        self.finish_long_request(request);
        match outcome {
            Ok(_) if self.waits_for_program(request) => self.continue_start(now, request),
            outcome => self.finish(now, request, outcome),
        }
        self.carry_out_effects(now);
    }

    /// Returns the next line for the journal.
    pub fn poll_journal(&mut self) -> Option<JournalLine> {
        self.lines.pop_front()
    }

    /// Returns the jobs of an arm that have changed and must be written.
    /// [`jobs_written`](Self::jobs_written) takes the result.
    pub fn poll_jobs(&mut self) -> Option<JobsSnapshot> {
        self.records.take_changed()
    }

    /// Returns a socket that has something new to send.
    pub fn poll_awake(&mut self) -> Option<SocketId> {
        self.awake.pop_first()
    }

    /// Returns the next message to a client. Call it when the client can take the message: states
    /// are then made from the newest reading.
    pub fn poll_send(&mut self, socket: SocketId) -> Option<Outgoing> {
        loop {
            match self.sockets.get_mut(&socket)?.outbox.pop()? {
                Next::Text(text) => return Some(Outgoing::Text(text)),
                Next::Close(code) => return Some(Outgoing::Close(code)),
                // Turns are sent as they change, with the time left, and so never wait here.
                #[cfg(feature = "class")]
                Next::State(Newest::Turns) => {}
                Next::State(Newest::Sessions) => return Some(Outgoing::Text(self.session_list())),
                Next::State(Newest::Job(job)) => {
                    // A job may have been deleted since. Then the next message follows.
                    if let Some(text) = self.job_notice(job) {
                        return Some(Outgoing::Text(text));
                    }
                }
                Next::State(Newest::State(subscription)) => {
                    if let Some(state) = self.state_for(socket, subscription) {
                        return Some(state);
                    }
                }
            }
        }
    }

    /// Carries out all consequences of what happened.
    fn carry_out_effects(&mut self, now: HostInstant) {
        // First, because it produces effects.
        self.evict_overdue(now);
        while let Some(effect) = self.control.poll_effect() {
            self.carry_out(now, effect);
        }
        #[cfg(feature = "class")]
        {
            self.order_fences();
            // Starting a job has further effects, so control is settled again.
            if self.begin_queued(now) {
                return self.carry_out_effects(now);
            }
            self.notify_turns(now);
        }
        // Last, so that it reports the state after all effects.
        self.queue_due(now);
    }

    fn next_id(&mut self) -> u64 {
        self.ids += 1;
        self.ids
    }

    fn session_of(&self, socket: SocketId) -> Option<SessionId> {
        self.sockets.get(&socket)?.session
    }

    fn arm_ids(&self) -> impl Iterator<Item = ArmId> + use<> {
        (0..self.arms.len() as u64).map(ArmId)
    }

    fn arm(&self, arm: ArmId) -> &ArmState {
        &self.arms[arm.0 as usize]
    }

    fn arm_mut(&mut self, arm: ArmId) -> &mut ArmState {
        &mut self.arms[arm.0 as usize]
    }

    fn order(&mut self, arm: ArmId, order: ArmOrder) {
        let moves = matches!(
            order,
            ArmOrder::Act { .. }
                | ArmOrder::StartJog { .. }
                | ArmOrder::StartJob(_)
                | ArmOrder::ResumeJob { .. }
        );
        // The history is read faster before the arm moves, or its start would be missing.
        if moves && self.arm_mut(arm).recordings.expect_motion() {
            self.update_read_rates();
        }
        if let Some(order) = self.hold_behind_start(arm, order) {
            self.orders.push_back((arm, order));
        }
    }

    /// Converts an instant to Unix seconds.
    fn unix(&self, now: HostInstant) -> f64 {
        let micros = (self.config.unix_zero + now.as_micros() as f64 / 1e6) * 1e6;
        // Rounded to microseconds, or the sum shows digits that were never measured.
        micros.round() / 1e6
    }

    fn text_id(&self, mark: char, id: u64) -> String {
        format!("{mark}{}-{id}", self.config.epoch)
    }

    fn session_id(&self, id: SessionId) -> String {
        self.text_id('s', id.0)
    }

    fn jog_id(&self, id: JogId) -> String {
        self.text_id('g', id.0)
    }

    fn lease_id(&self, id: LeaseId) -> String {
        self.text_id('l', id.0)
    }

    /// Parses an id of this kind. `None` if it is not an id of this station.
    fn number(&self, mark: char, text: &str) -> Option<u64> {
        let rest = text.strip_prefix(mark)?;
        let (epoch, number) = rest.rsplit_once('-')?;
        let number: u64 = number.parse().ok()?;
        // Only the exact form is valid, because clients compare ids as text.
        (epoch == self.config.epoch && self.text_id(mark, number) == text).then_some(number)
    }

    /// Returns the part of an arm's state that its reading lacks.
    fn state_context(&self, arm: ArmId) -> StateContext {
        let job = self.job_at(arm);
        StateContext {
            t: self.unix(self.arm(arm).read_at),
            arm: self.arm(arm).entry.name.clone(),
            job: job.map(|(job, _)| job.id.clone()),
            job_runs: job.is_some_and(|(_, runs)| runs),
            jog: self.control.jog(arm).map(|(jog, _)| self.jog_id(jog)),
            holder: self.holder(arm),
        }
    }

    /// Returns the holder of an arm's lease as JSON.
    fn holder(&self, arm: ArmId) -> Value {
        self.name_of(self.control.holder(arm))
    }

    fn end_socket(&mut self, socket: SocketId, code: CloseCode) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.close(code);
            self.awake.insert(socket);
        }
    }

    /// Sends a notification to a session, if it has a socket.
    fn notify(&mut self, session: SessionId, notice: Notice, params: &Value) {
        let socket = self
            .sessions
            .get(&session)
            .and_then(|session| session.socket);
        if let Some(socket) = socket {
            self.notify_socket(socket, notice.message(params));
        }
    }

    fn notify_socket(&mut self, socket: SocketId, text: String) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.notice(text);
            self.awake.insert(socket);
        }
    }

    /// Sends a notification to all sessions.
    fn notify_all(&mut self, notice: Notice, params: &Value) {
        let text = notice.message(params);
        let sockets: Vec<_> = { self.sessions.values() }
            .filter_map(|session| session.socket)
            .collect();
        for socket in sockets {
            self.notify_socket(socket, text.clone());
        }
    }
}

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
mod dispatch;
mod effects;
mod ending;
mod events;
mod fence;
mod history;
mod jobs;
mod journal;
mod held_work;
mod leases;
mod long_requests;
mod library;
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
use std::sync::Arc;

use magician::admission::{AdmissionTable, Origin};
use magician_job::presets::Presets;
use magician_protocol::HostInstant;
use serde_json::Value;

use self::ending::Ending;
pub use self::ending::{ForcedStop, EndReport};
use self::events::EventLog;
use self::jobs::AwaitedJobState;
pub use self::journal::JournalLine;
use self::held_work::HeldWork;
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
pub use self::socket::{CloseCode, Outgoing, Peer, MAX_MESSAGES_PER_SECOND, MAX_REQUESTS_IN_FLIGHT};
use self::state::SharedState;
use self::store::Records;
pub use self::store::{FileSnapshot, JobsSnapshot, check_jobs, damaged_jobs};
pub use self::teach::TeachAct;
pub use self::throttle::{RateVerdict, Throttle};
use crate::api::{Message, MessageId, Notice, Params, Role, RpcError};
use crate::control::{ArmId, Control, JobId, JogId, LeaseId, RequestId, SessionId};
use crate::frames::FrameRing;
use crate::job::{FormatReader, JobStore, NoJobStore, Reader};
use crate::library::{LibraryOrder, NoPrograms, ProgramStore};
use crate::order::{ArmOrder, ArmReport};
use crate::reading::{ArmReading, StateContext};
use crate::recording::{NoRecordings, RecordOrder, RecordingStore};
use crate::surface::{MemorySurfaces, SurfaceStore};

/// Id of a client's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SocketId(pub u64);

/// Rights of a client, and their source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// Role.
    pub role: Role,
    /// Name of the token. `None` for a client that needs no token.
    pub token: Option<String>,
}

/// Arm of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmEntry {
    /// Name: `[a-z0-9][a-z0-9_-]{0,31}`.
    pub name: String,
    /// Port, as given by the user.
    pub port: String,
    /// True for a virtual arm of this process. It burns nothing.
    pub is_virtual: bool,
    /// True if a laser may be mounted at the arm's pins.
    pub laser_pins: bool,
    /// Fence. [`RunningStation`](crate::RunningStation) sets it from the arm.
    pub fence: Option<magician::Fence>,
}

/// Configuration of a station.
pub struct StationConfig {
    /// Arms.
    pub arms: Vec<ArmEntry>,
    /// Prefix of all ids. Must differ for each start of a station, so that no id is used twice.
    pub epoch: String,
    /// Unix time at [`HostInstant::ZERO`], s.
    pub unix_zero: f64,
    /// Version of the program.
    pub version: String,
    /// True to limit every session to the role of a viewer.
    pub read_only: bool,
    /// True to let students burn with the laser of a real arm.
    pub student_laser: bool,
    /// Reader of programs.
    pub reader: Arc<dyn Reader>,
    /// Store of jobs.
    pub jobs: Arc<dyn JobStore>,
    /// Store of measured work surfaces.
    pub surfaces: Arc<dyn SurfaceStore>,
    /// Store of recordings.
    pub recordings: Arc<dyn RecordingStore>,
    /// Most readings per second for the history of the last ten minutes. With 0 only readings made
    /// for other purposes are kept.
    pub ring: u32,
    /// True to save the history to a file when an alarm is raised.
    pub save_on_alarm: bool,
    /// Traffic of the arms' lines, by index. Empty if no line is tapped.
    pub lines: Vec<Arc<FrameRing>>,
    /// Library of programs.
    pub programs: Arc<dyn ProgramStore>,
    /// Presets of drawing and engraving.
    pub presets: Presets,
    /// Text of the class file. `None` uses the stored one.
    #[cfg(feature = "class")]
    pub class: Option<String>,
    /// Text of the schedule file. `None` uses the stored one.
    #[cfg(feature = "class")]
    pub schedule: Option<String>,
    /// Source of unpredictable numbers, for codes.
    #[cfg(feature = "class")]
    pub random: fn() -> u64,
}

impl ArmEntry {
    /// Creates the entry of a virtual arm of this process.
    #[must_use]
    pub fn simulated(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            port: "sim".to_owned(),
            is_virtual: true,
            laser_pins: true,
            fence: None,
        }
    }
}

impl StationConfig {
    /// Creates a configuration with these arms and defaults: no tokens, built-in formats, nothing
    /// stored beyond the station's lifetime, a clock that starts in 1970.
    #[must_use]
    pub fn new(arms: Vec<ArmEntry>, epoch: impl Into<String>) -> Self {
        Self::reading_by(arms, epoch, Arc::new(FormatReader::default()))
    }

    /// Creates the same configuration with this reader of programs.
    #[must_use]
    pub fn reading_by(
        arms: Vec<ArmEntry>,
        epoch: impl Into<String>,
        reader: Arc<dyn Reader>,
    ) -> Self {
        Self {
            arms,
            epoch: epoch.into(),
            unix_zero: 0.0,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            read_only: false,
            student_laser: false,
            reader,
            jobs: Arc::new(NoJobStore),
            surfaces: Arc::new(MemorySurfaces::default()),
            recordings: Arc::new(NoRecordings),
            ring: 0,
            save_on_alarm: true,
            lines: Vec::new(),
            programs: Arc::new(NoPrograms),
            presets: Presets::default(),
            #[cfg(feature = "class")]
            class: None,
            #[cfg(feature = "class")]
            schedule: None,
            #[cfg(feature = "class")]
            random: crate::class::random,
        }
    }
}

impl fmt::Debug for StationConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StationConfig")
            .field("arms", &self.arms)
            .field("epoch", &self.epoch)
            .finish_non_exhaustive()
    }
}

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

    /// Admits a client of a listener.
    ///
    /// A socket has no claim to its place until its hello: if there are too many of those, the
    /// oldest is evicted. `None` if all sessions are in use and no viewer can be evicted for a
    /// client with a higher role.
    pub fn admit(&mut self, now: HostInstant, peer: Peer) -> Option<SocketId> {
        let origin = peer.origin;
        if !self.may_have_room(now, origin) {
            return None;
        }
        let socket = self.open(now, peer);
        if let Some(silent) = self.admission.open(now, socket, origin) {
            self.end_socket(silent, CloseCode::HELLO_TIMEOUT);
        }
        Some(socket)
    }

    /// Returns the earliest instant at which a client can be [admitted](Self::admit) without
    /// evicting a socket that has not had its time for a hello.
    ///
    /// `None` if it can be admitted now, or if all sessions are in use.
    #[must_use]
    pub fn admits_at(&self, now: HostInstant, origin: Origin) -> Option<HostInstant> {
        if !self.may_have_room(now, origin) {
            return None;
        }
        self.admission.opens_at(now, origin, Socket::grace(origin))
    }

    /// True if a client from there may get a session by its hello.
    fn may_have_room(&self, now: HostInstant, origin: Origin) -> bool {
        self.admission.has_room(now, origin) || self.viewer_to_evict(now, origin).is_some()
    }

    /// Records that a message has arrived, before it is [received](Self::receive). The client no
    /// longer counts as silent.
    pub fn note_message(&mut self, now: HostInstant, socket: SocketId) {
        self.admission.heard(now, socket);
    }

    /// Connects a client of this process, or of a listener that limits its clients itself.
    pub fn open(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = SocketId(self.next_id());
        self.sockets.insert(id, Socket::new(now, peer));
        id
    }

    /// Returns the token of a `session.hello`. `None` for other messages.
    ///
    /// Tokens are stored in files, and reading one must not delay the station. So the listener
    /// looks the token up and passes its rights to [`set_token_grant`](Self::set_token_grant)
    /// before the message.
    #[must_use]
    pub fn token_of(text: &str) -> Option<String> {
        let message = Message::parse(text).ok()?;
        let token = message.params.get("token")?.as_str()?;
        (message.method == "session.hello").then(|| token.to_owned())
    }

    /// Sets the rights of the token in a client's hello. `None` for an invalid token.
    pub fn set_token_grant(&mut self, socket: SocketId, grant: Option<Grant>) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.token_grant = grant;
        }
    }

    /// Connects a program for DobotLink (feature `link`).
    #[cfg(feature = "link")]
    pub(crate) fn open_link(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = self.open(now, peer);
        if let Some(socket) = self.sockets.get_mut(&id) {
            socket.link = true;
        }
        id
    }

    /// Processes a message that the link translated from this call of its program. The journal
    /// names the call.
    #[cfg(feature = "link")]
    pub(crate) fn receive_for(
        &mut self,
        now: HostInstant,
        socket: SocketId,
        text: &str,
        of: Option<String>,
    ) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.calls = of;
        }
        self.receive(now, socket, text);
    }

    /// Processes a text message of a client.
    pub fn receive(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        // Deadlines first: a message must not revive what is over.
        self.handle_timeout(now);
        self.handle_message(now, socket, text);
        self.carry_out_effects(now);
    }

    /// Processes the only message of a client without a hello. Its session ends with the socket;
    /// the lease that the request needs is acquired if it is free. Returns true if an answer
    /// follows.
    pub fn receive_once(&mut self, now: HostInstant, socket: SocketId, text: &str) -> bool {
        self.handle_timeout(now);
        let answered = self.handle_single_message(now, socket, text);
        self.carry_out_effects(now);
        answered
    }

    /// Records the reply to a ping, which keeps the lease alive as a message does.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        self.handle_timeout(now);
        if let Some(session) = self.session_of(socket) {
            self.control.keep_alive(now, session);
        }
    }

    /// Handles the end of a socket, by the client or by the station.
    pub fn close(&mut self, now: HostInstant, socket: SocketId) {
        let Some(gone) = self.sockets.remove(&socket) else {
            return;
        };
        self.admission.close(socket);
        // Looked at before requests without a line are dropped below.
        let unanswered = self
            .pending
            .values()
            .any(|pending| pending.socket == socket);
        // Requests with a journal line stay until they are over, so that the journal gets their
        // results.
        self.pending
            .retain(|_, pending| pending.socket != socket || pending.line.is_some());
        if let Some(session) = gone.session {
            match self.sessions.get(&session) {
                Some(known) if known.one_shot => self.end_one_shot(now, session, unanswered),
                _ => self.note_socket_closed(now, session),
            }
        }
        self.drop_closed_requests();
        // The subscriptions of the session are gone as well, so some arms can be read less often.
        self.update_read_rates();
        self.carry_out_effects(now);
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

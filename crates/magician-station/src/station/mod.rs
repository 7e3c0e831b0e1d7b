//! The station: text of clients in, text and orders to arms out. Without I/O and clock.

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
mod keeping;
mod leases;
mod lengthy;
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
pub use self::ending::{CutOff, RunsEnd};
use self::events::EventLog;
use self::jobs::Wants;
pub use self::journal::JournalLine;
use self::keeping::Keeping;
use self::lengthy::LengthyWork;
pub use self::newest::LIST_INTERVAL;
use self::newest::{Newest, Telling};
pub use self::outbox::{Next, Outbox};
use self::recordings::{ArmRecordings, Recorded};
#[cfg(feature = "http")]
pub(crate) use self::sessions::SILENT_SOCKETS;
use self::sessions::{LIMITS, Session};
pub use self::sessions::{MESSAGE, SOCKETS, VIEWERS};
pub use self::size::StationSize;
use self::socket::Socket;
pub use self::socket::{CloseCode, Outgoing, Peer, RATE, UNDER_WAY};
use self::state::SharedState;
use self::store::Records;
pub use self::store::{FileToKeep, JobsToKeep, check_jobs, damaged_jobs};
pub use self::throttle::{Pace, Throttle};
use crate::api::{Message, MessageId, Notice, Params, Role, RpcError};
use crate::control::{ArmId, Control, JobId, JogId, LeaseId, RequestId, SessionId};
use crate::frames::FrameRing;
use crate::job::{FormatReader, JobStore, NoStore, Reader};
use crate::library::{LibraryOrder, NoPrograms, ProgramStore};
use crate::order::{ArmOrder, ArmReport};
use crate::reading::{ArmReading, StateContext};
use crate::recording::{NoRecordings, RecordOrder, RecordingStore};
use crate::surface::{MemorySurfaces, SurfaceStore};

/// A connection of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SocketId(pub u64);

/// What somebody may do, and by which right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// Its role.
    pub role: Role,
    /// The name of the token; none for who needs no token.
    pub token: Option<String>,
}

/// An arm of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmEntry {
    /// Its name: `[a-z0-9][a-z0-9_-]{0,31}`.
    pub name: String,
    /// Where it is, as a person wrote it.
    pub port: String,
    /// Whether it is a virtual arm of this process: nothing of it burns.
    pub is_virtual: bool,
    /// Whether a laser may be mounted at its pins.
    pub laser_pins: bool,
    /// Its fence. [`RunningStation`](crate::RunningStation) takes that of the arm itself.
    pub fence: Option<magician::Fence>,
}

/// What a station is made of.
pub struct StationConfig {
    /// Its arms.
    pub arms: Vec<ArmEntry>,
    /// What ids begin with: another text for each start of a station, so that none is used twice.
    pub epoch: String,
    /// Unix seconds at [`HostInstant::ZERO`].
    pub unix_zero: f64,
    /// Version of the program.
    pub version: String,
    /// Whether nobody is more than a viewer.
    pub read_only: bool,
    /// Whether students may have the laser of a real arm burn.
    pub student_laser: bool,
    /// Reads programs.
    pub reader: Arc<dyn Reader>,
    /// Keeps jobs.
    pub jobs: Arc<dyn JobStore>,
    /// Keeps the heights of work surfaces that were touched.
    pub surfaces: Arc<dyn SurfaceStore>,
    /// Keeps recordings.
    pub recordings: Arc<dyn RecordingStore>,
    /// How often an arm is read for the last ten minutes, at most, 1/s; 0 for what others have read alone.
    pub ring: u32,
    /// Whether an alarm has the last minutes written into a file, where the arm is read for them.
    pub save_on_alarm: bool,
    /// What passes on the lines of the arms, in their order; none where nobody listens.
    pub lines: Vec<Arc<FrameRing>>,
    /// Keeps programs.
    pub programs: Arc<dyn ProgramStore>,
    /// Presets of drawing and engraving.
    pub presets: Presets,
    /// The file of the class; without it the one that was kept.
    #[cfg(feature = "class")]
    pub class: Option<String>,
    /// The file of the schedule; without it the one that was kept.
    #[cfg(feature = "class")]
    pub schedule: Option<String>,
    /// Gives numbers that nobody can guess, for codes.
    #[cfg(feature = "class")]
    pub random: fn() -> u64,
}

impl ArmEntry {
    /// A virtual arm of this process.
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
    /// These arms for anybody who is let in: without tokens, with jobs of the formats that are built in, which are not kept
    /// beyond its end, and a clock that counts from 1970 on.
    #[must_use]
    pub fn new(arms: Vec<ArmEntry>, epoch: impl Into<String>) -> Self {
        Self::reading_by(arms, epoch, Arc::new(FormatReader::default()))
    }

    /// The same, with this reader of programs.
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
            jobs: Arc::new(NoStore),
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

/// What a request waits for.
#[derive(Debug)]
enum Awaited {
    /// The outcome of an order.
    Arm(ArmId),
    /// That what it promises is on the disk.
    Kept,
    /// What the library has done.
    Library,
    /// Whether there are the program and the preset of a job, which begins then with these parameters.
    Program(ArmId, Box<Params>),
    /// The lease.
    Lease { asked: bool },
    /// A jog that begins.
    Jog(ArmId, JogId),
    /// What a job does.
    Job(ArmId, JobId, Wants),
    /// What a file comes to.
    Record(Recorded),
    /// Arms that come to a stand.
    Stops {
        left: BTreeSet<ArmId>,
        arms: Vec<Value>,
        failed: Option<RpcError>,
    },
}

/// A request that is not answered yet.
#[derive(Debug)]
struct Pending {
    socket: SocketId,
    id: Option<MessageId>,
    waits: Awaited,
    line: Option<JournalLine>,
    began: HostInstant,
}

/// An arm as the station knows it.
#[derive(Debug)]
struct ArmPlace {
    entry: ArmEntry,
    reading: Option<ArmReading>,
    recordings: ArmRecordings,
    /// What was made of that reading for subscribers.
    state: Option<SharedState>,
    /// When that reading came.
    read_at: HostInstant,
    link: bool,
    /// When the line broke or was found last: what was read before is not the state any more.
    found_at: HostInstant,
    events: EventLog,
    /// How often it is read at present.
    watched: (Option<u32>, Vec<magician::Pin>),
}

/// One or more arms for many clients.
///
/// A listener gives it what clients send ([`open`](Self::open), [`receive`](Self::receive), [`close`](Self::close)) and sends what
/// [`poll_send`](Self::poll_send) has for each; arms get the orders of [`poll_order`](Self::poll_order) and
/// [`report`](Self::report) what comes of them. Time is what the calls say; [`poll_timeout`](Self::poll_timeout) tells when
/// [`handle_timeout`](Self::handle_timeout) is due.
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
    arms: Vec<ArmPlace>,
    sockets: BTreeMap<SocketId, Socket>,
    sessions: BTreeMap<SessionId, Session>,
    /// Sockets of listeners, and which of them gives way.
    admission: AdmissionTable<SocketId>,
    telling: Telling,
    pending: BTreeMap<RequestId, Pending>,
    orders: VecDeque<(ArmId, ArmOrder)>,
    record_orders: VecDeque<(ArmId, RecordOrder)>,
    library: VecDeque<LibraryOrder>,
    lengthy: LengthyWork,
    #[cfg(feature = "class")]
    class: class::Class,
    /// The arms of jogs, also of those that have ended.
    jogs: BTreeMap<JogId, ArmId>,
    records: Records,
    keeping: Keeping,
    lines: VecDeque<JournalLine>,
    awake: BTreeSet<SocketId>,
    /// Its end, once that has begun.
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
    /// A station whose arms are connected, and nobody else.
    #[must_use]
    pub fn new(config: StationConfig) -> Self {
        let place = |entry: &ArmEntry| ArmPlace {
            entry: entry.clone(),
            reading: None,
            recordings: ArmRecordings::default(),
            state: None,
            read_at: HostInstant::ZERO,
            link: true,
            found_at: HostInstant::ZERO,
            events: EventLog::default(),
            watched: (None, Vec::new()),
        };
        let names: Vec<_> = config.arms.iter().map(|arm| arm.name.as_str()).collect();
        let mut station = Self {
            records: Records::load(&*config.jobs, &names, config.unix_zero),
            keeping: Keeping::default(),
            control: Control::new(config.arms.len()),
            arms: config.arms.iter().map(place).collect(),
            #[cfg(feature = "class")]
            class: class::Class::load(&config),
            config,
            sockets: BTreeMap::new(),
            sessions: BTreeMap::new(),
            admission: AdmissionTable::new(LIMITS),
            telling: Telling::default(),
            pending: BTreeMap::new(),
            orders: VecDeque::new(),
            record_orders: VecDeque::new(),
            library: VecDeque::new(),
            lengthy: LengthyWork::default(),
            jogs: BTreeMap::new(),
            lines: VecDeque::new(),
            awake: BTreeSet::new(),
            ending: None,
            ids: 0,
        };
        station.take_up_jobs();
        // Arms are read for the last minutes from the beginning on.
        station.watch_anew();
        station
    }

    /// The arms, in the order of their ids.
    #[must_use]
    pub fn arms(&self) -> &[ArmEntry] {
        &self.config.arms
    }

    /// A client connects to a listener. Until it says hello it has no claim to a place: of those that are silent the oldest
    /// gives way to a new one. `None` if there are as many sessions as the station takes, and none of them is a viewer's, which
    /// gives way to a higher role.
    pub fn admit(&mut self, now: HostInstant, peer: Peer) -> Option<SocketId> {
        let origin = peer.origin;
        if !self.may_have_room(now, origin) {
            return None;
        }
        let socket = self.open(now, peer);
        if let Some(silent) = self.admission.open(now, socket, origin) {
            self.end_socket(silent, CloseCode::LATE);
        }
        Some(socket)
    }

    /// When a client from there may be [admitted](Self::admit) so that one that gives way to it has had its time to say hello.
    /// `None` if that is now, or if there are as many sessions as the station takes.
    #[must_use]
    pub fn admits_at(&self, now: HostInstant, origin: Origin) -> Option<HostInstant> {
        if !self.may_have_room(now, origin) {
            return None;
        }
        self.admission.opens_at(now, origin, Socket::grace(origin))
    }

    /// True if a client from there may get a place by its hello.
    fn may_have_room(&self, now: HostInstant, origin: Origin) -> bool {
        self.admission.has_room(now, origin) || self.yielding_viewer(now, origin).is_some()
    }

    /// A message of a client has come, which is looked at before it is [received](Self::receive): the client is silent no more.
    pub fn heard(&mut self, now: HostInstant, socket: SocketId) {
        self.admission.heard(now, socket);
    }

    /// A client of this process connects, or of a listener that bounds its clients itself.
    pub fn open(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = SocketId(self.next_id());
        self.sockets.insert(id, Socket::new(now, peer));
        id
    }

    /// The token of a `session.hello`. Tokens lie in files, and others wait for the station: whoever carries messages finds out
    /// what it allows, and says so by [`vouch`](Self::vouch) before the message.
    #[must_use]
    pub fn token_of(text: &str) -> Option<String> {
        let message = Message::parse(text).ok()?;
        let token = message.params.get("token")?.as_str()?;
        (message.method == "session.hello").then(|| token.to_owned())
    }

    /// What the token of a client's hello allows; none for one that is not good.
    pub fn vouch(&mut self, socket: SocketId, grant: Option<Grant>) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.vouched = grant;
        }
    }

    /// A program of DobotLink connects (feature `link`).
    #[cfg(feature = "link")]
    pub(crate) fn open_link(&mut self, now: HostInstant, peer: Peer) -> SocketId {
        let id = self.open(now, peer);
        if let Some(socket) = self.sockets.get_mut(&id) {
            socket.link = true;
        }
        id
    }

    /// A message of a link, made for this call of its program: the journal tells of that.
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

    /// A text message of a client.
    pub fn receive(&mut self, now: HostInstant, socket: SocketId, text: &str) {
        // What is over by now is over for this message too.
        self.handle_timeout(now);
        self.take(now, socket, text);
        self.settle(now);
    }

    /// The only message of a client that says no hello: one request, by a session that ends with the socket. The lease that it
    /// needs is taken when it is free. Whether an answer comes.
    pub fn receive_once(&mut self, now: HostInstant, socket: SocketId, text: &str) -> bool {
        self.handle_timeout(now);
        let answered = self.take_once(now, socket, text);
        self.settle(now);
        answered
    }

    /// The answer to a ping: a word, as a message is one.
    pub fn pong(&mut self, now: HostInstant, socket: SocketId) {
        self.handle_timeout(now);
        if let Some(session) = self.session_of(socket) {
            self.control.keep_alive(now, session);
        }
    }

    /// A client is gone, or was closed.
    pub fn close(&mut self, now: HostInstant, socket: SocketId) {
        let Some(gone) = self.sockets.remove(&socket) else {
            return;
        };
        self.admission.close(socket);
        let unanswered = self
            .pending
            .values()
            .any(|pending| pending.socket == socket);
        self.pending
            .retain(|_, pending| pending.socket != socket || pending.line.is_some());
        if let Some(session) = gone.session {
            match self.sessions.get(&session) {
                Some(known) if known.one_shot => self.left_one_shot(now, session, unanswered),
                _ => self.left(now, session),
            }
        }
        self.forget_turns();
        self.watch_anew();
        self.settle(now);
    }

    /// An arm reports.
    pub fn report(&mut self, now: HostInstant, arm: ArmId, report: ArmReport) {
        self.take_report(now, arm, report);
        self.settle(now);
    }

    /// Something that is due by now.
    pub fn handle_timeout(&mut self, now: HostInstant) {
        #[cfg(feature = "class")]
        self.class_timeout(now);
        self.control.handle_timeout(now);
        self.save_for_alarms(now);
        self.records.try_again(now, false);
        self.tell_stands(now);
        let late = |socket: &Socket| socket.session.is_none() && now >= socket.hello_due();
        let late: Vec<_> = { self.sockets.iter() }
            .filter(|(_, socket)| late(socket) && !socket.outbox.is_closing())
            .map(|(id, _)| *id)
            .collect();
        for socket in late {
            self.end_socket(socket, CloseCode::LATE);
        }
        self.settle(now);
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<HostInstant> {
        let hellos = self.sockets.values().filter_map(|socket| {
            let waits = socket.session.is_none() && !socket.outbox.is_closing();
            waits.then(|| socket.hello_due())
        });
        let saves = self.arms.iter().filter_map(|place| place.recordings.due());
        let due = (hellos.chain(self.control.poll_timeout()))
            .chain(saves)
            .chain(self.telling.due())
            .chain(self.end_due())
            .chain(self.keeping_due())
            .min();
        #[cfg(feature = "class")]
        let due = due.into_iter().chain(self.class.next()).min();
        due
    }

    /// An order for an arm.
    pub fn poll_order(&mut self) -> Option<(ArmId, ArmOrder)> {
        self.orders.pop_front()
    }

    /// Something to do with the library of programs.
    pub fn poll_library(&mut self) -> Option<LibraryOrder> {
        self.library.pop_front()
    }

    /// What came of it.
    pub fn library_done(
        &mut self,
        now: HostInstant,
        request: RequestId,
        outcome: Result<Value, RpcError>,
    ) {
        self.turn_is_over(request);
        match outcome {
            Ok(_) if self.waits_for_program(request) => self.start_found(now, request),
            outcome => self.finish(now, request, outcome),
        }
        self.settle(now);
    }

    /// A line for the journal.
    pub fn poll_journal(&mut self) -> Option<JournalLine> {
        self.lines.pop_front()
    }

    /// What is to be kept of the jobs of an arm, where that has changed. [`jobs_kept`](Self::jobs_kept) takes what comes of it.
    pub fn poll_jobs(&mut self) -> Option<JobsToKeep> {
        self.records.take_changed()
    }

    /// A socket that has something to send since it was asked last.
    pub fn poll_awake(&mut self) -> Option<SocketId> {
        self.awake.pop_first()
    }

    /// What a client is to be sent next. Ask when it can take it: a state is the newest one then.
    pub fn poll_send(&mut self, socket: SocketId) -> Option<Outgoing> {
        loop {
            match self.sockets.get_mut(&socket)?.outbox.pop()? {
                Next::Text(text) => return Some(Outgoing::Text(text)),
                Next::Close(code) => return Some(Outgoing::Close(code)),
                // They are told with the time that is left of them, and so never wait.
                #[cfg(feature = "class")]
                Next::State(Newest::Turns) => {}
                Next::State(Newest::Sessions) => return Some(Outgoing::Text(self.session_list())),
                Next::State(Newest::Job(job)) => {
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

    /// Carries out what follows from what happened.
    fn settle(&mut self, now: HostInstant) {
        self.evict_overdue(now);
        while let Some(effect) = self.control.poll_effect() {
            self.carry_out(now, effect);
        }
        #[cfg(feature = "class")]
        {
            self.put_fences();
            if self.begin_queued(now) {
                return self.settle(now);
            }
            self.tell_turns(now);
        }
        self.tell_newest(now);
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

    fn arm(&self, arm: ArmId) -> &ArmPlace {
        &self.arms[arm.0 as usize]
    }

    fn arm_mut(&mut self, arm: ArmId) -> &mut ArmPlace {
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
        if moves && self.arm_mut(arm).recordings.expect_motion() {
            self.watch_anew();
        }
        if let Some(order) = self.behind_start(arm, order) {
            self.orders.push_back((arm, order));
        }
    }

    /// Unix seconds.
    fn unix(&self, now: HostInstant) -> f64 {
        let micros = (self.config.unix_zero + now.as_micros() as f64 / 1e6) * 1e6;
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

    /// The number of an id of this kind.
    fn number(&self, mark: char, text: &str) -> Option<u64> {
        let rest = text.strip_prefix(mark)?;
        let (epoch, number) = rest.rsplit_once('-')?;
        let number: u64 = number.parse().ok()?;
        // In one form only: an id is compared as text by clients.
        (epoch == self.config.epoch && self.text_id(mark, number) == text).then_some(number)
    }

    /// What every state of an arm says beside its reading.
    fn beside(&self, arm: ArmId) -> StateContext {
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

    /// The holder of an arm's lease as JSON has it.
    fn holder(&self, arm: ArmId) -> Value {
        self.name_of(self.control.holder(arm))
    }

    fn end_socket(&mut self, socket: SocketId, code: CloseCode) {
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.outbox.close(code);
            self.awake.insert(socket);
        }
    }

    /// Tells a session something.
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

    /// Tells all sessions something.
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

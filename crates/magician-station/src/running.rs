//! A station with its arms on a tokio runtime: what listeners, pages in the process and tests talk to.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use magician::Arm;
use magician::admission::Origin;
use magician_job::presets::Presets;
use magician_protocol::HostInstant;
use tokio::runtime::Handle;
use tokio::sync::{Notify, oneshot};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep_until, timeout};

use crate::api::Role;
#[cfg(feature = "class")]
use crate::api::RpcError;
use crate::control::ArmId;
use crate::engine::ArmEngine;
use crate::fair::FairLine;
use crate::job::Reader;
use crate::keeper::{Keeper, Kept, Written};
use crate::library::{LibraryOrder, ProgramStore};
use crate::order::ArmReport;
use crate::recording::{Recorder, RecordingStore};
use crate::station::{
    Grant, JournalLine, Outgoing, Peer, RunsEnd, SocketId, Station, StationConfig, StationSize,
};
use crate::surface::ArmSurface;

/// Longest time for the runs of a station that ends: the 5 s of holders ([`Station::end`]), with room
/// for the station's own job.
const RUNS: Duration = Duration::from_secs(6);
/// The same after a second call, which moves nothing more.
const AT_ONCE: Duration = Duration::from_secs(1);
/// Longest time for the last stop of an arm, which answers within a tenth of it.
const LAST_STOP: Duration = Duration::from_secs(2);

/// Longest time for the reports of jobs whose arms have stopped.
const JOBS_OVER: Duration = Duration::from_millis(500);

/// Clients that wait for room, by their address.
type WaitingClients = FairLine<String, (Peer, oneshot::Sender<Option<Client>>)>;

/// Takes the lines of a journal.
pub type JournalSink = Box<dyn Fn(JournalLine) + Send + Sync>;

/// A station whose arms are at work. Clones are of the same station; when the last one and the last [`Client`] are gone, jogs
/// end and what the arms do is stopped, by the rules of the driver.
///
/// ```
/// use magician::Arm;
/// use magician::admission::Origin;
/// use magician_station::{ArmEntry, Grant, Outgoing, Peer, Role, RunningStation, StationConfig};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let arm = Arm::connect("sim").await?;
/// let config = StationConfig::new(vec![ArmEntry::simulated("arm")], "1");
/// let station = RunningStation::start(config, vec![arm], Box::new(|_| {}));
/// let grant = Some(Grant { role: Role::Teacher, token: None });
/// let origin = Origin::Loopback;
/// let peer = Peer { grant, origin, address: "here".into(), secret: "0123456789abcdef".into() };
/// let client = station.connect(peer);
/// client.send(r#"{"jsonrpc":"2.0","id":1,"method":"session.hello","params":{"client":{"name":"doc"}}}"#);
/// client.send(r#"{"jsonrpc":"2.0","id":2,"method":"arm.state"}"#);
/// while let Outgoing::Text(text) = client.receive().await {
///     if text.contains("left_space") {
///         break;
///     }
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct RunningStation {
    shared: Arc<Shared>,
    _timer: Arc<Timer>,
}

impl fmt::Debug for RunningStation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RunningStation").finish_non_exhaustive()
    }
}

struct Timer(AbortHandle);

impl Drop for Timer {
    fn drop(&mut self) {
        self.0.abort();
    }
}

struct Shared {
    inner: Mutex<Inner>,
    begun: Instant,
    /// Something is due earlier than before.
    due: Notify,
    /// The station ends, and nobody holds an arm any more.
    let_go: Notify,
    /// Something has happened, after which there may be room.
    changed: Notify,
    /// Clients of this machine that wait for room, and those from elsewhere.
    waiting: [WaitingClients; 2],
    keeper: Arc<Keeper>,
    recordings: Arc<dyn RecordingStore>,
    library: Arc<dyn ProgramStore>,
    presets: Presets,
    reader: Arc<dyn Reader>,
    visits: AtomicU64,
    #[cfg(feature = "http")]
    read_only: bool,
    this: Weak<Shared>,
    runtime: Handle,
}

struct Inner {
    station: Station,
    engines: Vec<ArmEngine>,
    recorder: Recorder,
    sockets: BTreeMap<SocketId, Arc<Notify>>,
}

impl Inner {
    fn take_kept(&mut self, now: HostInstant, kept: Written) {
        let Written {
            what,
            revision,
            outcome,
        } = kept;
        match what {
            Kept::Jobs(arm) => self.station.jobs_kept(now, arm, revision, outcome),
            #[cfg(feature = "class")]
            Kept::File(name) => self.station.file_kept(now, name, revision, outcome),
            #[cfg(not(feature = "class"))]
            Kept::File(_) => {}
        }
    }
}

impl RunningStation {
    /// Sets it going on the present runtime, with an arm for each entry of the config, in its order.
    ///
    /// # Panics
    /// Outside of a tokio runtime.
    #[must_use]
    pub fn start(mut config: StationConfig, arms: Vec<Arm>, journal: JournalSink) -> Self {
        let begun = Instant::now();
        for (entry, arm) in config.arms.iter_mut().zip(&arms) {
            entry.fence = arm.fence();
        }
        let (lines, zero) = (config.lines.clone(), config.unix_zero);
        let shared = Arc::new_cyclic(|shared: &Weak<Shared>| {
            let reader = Arc::clone(&config.reader);
            let store = Arc::clone(&config.jobs);
            let (entries, surfaces) = (config.arms.clone(), Arc::clone(&config.surfaces));
            let engine = |(at, arm): (usize, &Arm)| {
                let (shared, id) = (Weak::clone(shared), ArmId(at as u64));
                let surface = ArmSurface::new(entries[at].clone(), Arc::clone(&surfaces));
                let store = Arc::clone(&store);
                let journal = move || store.journal();
                ArmEngine::start(arm, Arc::clone(&reader), surface, journal, move |report| {
                    if let Some(shared) = shared.upgrade() {
                        shared.report(id, report);
                    }
                })
            };
            let recorder = {
                let (shared, store) = (Weak::clone(shared), Arc::clone(&config.recordings));
                Recorder::start(store, config.lines.clone(), move |arm, report| {
                    if let Some(shared) = shared.upgrade() {
                        shared.with(|inner, now| inner.station.recorded(now, arm, report));
                    }
                })
            };
            Shared {
                recordings: Arc::clone(&config.recordings),
                library: Arc::clone(&config.programs),
                presets: config.presets.clone(),
                visits: AtomicU64::new(0),
                #[cfg(feature = "http")]
                read_only: config.read_only,
                this: Weak::clone(shared),
                runtime: Handle::current(),
                inner: Mutex::new(Inner {
                    recorder,
                    station: Station::new(config),
                    engines: arms.iter().enumerate().map(engine).collect(),
                    sockets: BTreeMap::new(),
                }),
                begun,
                due: Notify::new(),
                let_go: Notify::new(),
                changed: Notify::new(),
                waiting: Default::default(),
                keeper: {
                    let shared = Weak::clone(shared);
                    Keeper::new(journal, store, move |kept| {
                        if let Some(shared) = shared.upgrade() {
                            shared.with(|inner, now| inner.take_kept(now, kept));
                        }
                    })
                },
                reader: Arc::clone(&reader),
            }
        });
        for line in &lines {
            line.set_clock(shared.begun, zero);
        }
        // Arms are read for the last minutes before anybody comes.
        shared.with(|_, _| ());
        let timer = tokio::spawn(Shared::keep_time(Arc::downgrade(&shared)));
        Self {
            shared,
            _timer: Arc::new(Timer(timer.abort_handle())),
        }
    }

    /// A client connects.
    #[must_use]
    pub fn connect(&self, peer: Peer) -> Client {
        self.shared.with(|inner, now| {
            let socket = inner.station.open(now, peer);
            self.client(inner, socket)
        })
    }

    /// The client of a socket that was opened just now.
    fn client(&self, inner: &mut Inner, socket: SocketId) -> Client {
        let awake = Arc::new(Notify::new());
        inner.sockets.insert(socket, Arc::clone(&awake));
        Client {
            shared: Arc::clone(&self.shared),
            socket,
            awake,
        }
    }

    /// A program of DobotLink connects.
    #[cfg(feature = "link")]
    pub(crate) fn connect_link(&self, peer: Peer) -> Client {
        self.shared.with(|inner, now| {
            let socket = inner.station.open_link(now, peer);
            self.client(inner, socket)
        })
    }

    /// As [`connect`](Self::connect), for a client of a listener; `None` if there are as many sessions as the station takes
    /// ([`Station::admit`]).
    #[must_use]
    pub fn try_connect(&self, peer: Peer) -> Option<Client> {
        let client = self.shared.with(|inner, now| {
            let socket = inner.station.admit(now, peer)?;
            Some(self.client(inner, socket))
        });
        if client.is_some() {
            self.shared.visits.fetch_add(1, Ordering::SeqCst);
        }
        client
    }

    /// As [`try_connect`](Self::try_connect), but nobody gives way who came just now: a client waits until there is room, or the
    /// one that gives way has had its time to say hello ([`Station::admits_at`]). Addresses take turns.
    pub async fn admit(&self, peer: Peer) -> Option<Client> {
        let host = peer.address.rsplit_once(':');
        let host = host.map_or(peer.address.as_str(), |(host, _)| host);
        let (host, origin) = (host.to_owned(), peer.origin);
        let (to, client) = oneshot::channel();
        if self.waiting(origin).push(host, (peer, to)) {
            tokio::spawn(self.clone().admit_waiting(origin));
        }
        client.await.ok().flatten()
    }

    fn waiting(&self, origin: Origin) -> &WaitingClients {
        let [loopback, elsewhere] = &self.shared.waiting;
        match origin {
            Origin::Loopback => loopback,
            Origin::Elsewhere => elsewhere,
        }
    }

    /// Lets those in that wait, one after the other.
    async fn admit_waiting(self, origin: Origin) {
        while let Some((peer, to)) = self.waiting(origin).pop() {
            while !to.is_closed() {
                let mut changed = pin!(self.shared.changed.notified());
                changed.as_mut().enable();
                let now = self.shared.now();
                let at = self.shared.lock().station.admits_at(now, origin);
                let Some(at) = at else {
                    break;
                };
                tokio::select! {
                    () = sleep_until(self.shared.begun + (at - HostInstant::ZERO)) => {}
                    () = changed => {}
                }
            }
            if !to.is_closed() {
                // One that is gone meanwhile is dropped, which closes its socket.
                let _ = to.send(self.try_connect(peer));
            }
        }
    }

    /// Carries out one request, as a session of its own that lasts as long: the lease that it needs is taken when it is free.
    /// `None` for a notification, which has no answer. Dropping the future ends the session, and what it does is stopped.
    pub async fn call(&self, peer: Peer, text: &str) -> Option<String> {
        let client = self.connect(peer);
        let answered = self
            .shared
            .with(|inner, now| inner.station.receive_once(now, client.socket, text));
        if !answered {
            return None;
        }
        loop {
            match client.receive().await {
                Outgoing::Text(text) => return Some(text),
                Outgoing::Frame(_) => {}
                Outgoing::Close(_) => return None,
            }
        }
    }

    /// Its library of programs.
    #[cfg(feature = "http")]
    pub(crate) fn programs(&self) -> Arc<dyn ProgramStore> {
        Arc::clone(&self.shared.library)
    }

    /// The role of this machine's people without a name: a viewer's while a class is set.
    #[must_use]
    pub fn place_role(&self) -> Role {
        self.shared.lock().station.place_role()
    }

    /// Tries the teacher's PIN of the class ([`Station::try_pin`]).
    ///
    /// # Errors
    /// As there.
    #[cfg(feature = "class")]
    pub fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError> {
        self.shared
            .with(|inner, now| inner.station.try_pin(now, pin, peer))
    }

    /// Says which PIN the class of the stations behind a hub has ([`Station::set_class_elsewhere`]).
    #[cfg(feature = "class")]
    pub fn set_class_elsewhere(&self, pin: Option<String>) {
        self.shared
            .with(|inner, now| inner.station.set_class_elsewhere(now, pin));
    }

    /// The teacher's PIN of the class, if there is a class.
    #[cfg(feature = "class")]
    #[must_use]
    pub fn pin(&self) -> Option<String> {
        self.shared.with(|inner, now| {
            // The first look at the clock makes it.
            inner.station.handle_timeout(now);
            inner.station.pin().map(str::to_owned)
        })
    }

    /// Whether nobody is more than a viewer.
    #[cfg(feature = "http")]
    pub(crate) fn is_read_only(&self) -> bool {
        self.shared.read_only
    }

    /// How many sockets are open.
    #[must_use]
    pub fn sockets(&self) -> usize {
        self.shared.lock().station.size().sockets
    }

    /// How many sockets have been [taken](Self::try_connect) up to now, of which some may be closed.
    #[must_use]
    pub fn visits(&self) -> u64 {
        self.shared.visits.load(Ordering::SeqCst)
    }

    /// What it holds at present, and how many orders its arms have not carried out.
    #[doc(hidden)]
    #[must_use]
    pub fn size(&self) -> (StationSize, usize) {
        let inner = self.shared.lock();
        let orders = inner.engines.iter().map(ArmEngine::load).sum();
        (inner.station.size(), orders)
    }

    /// Waits until journal and jobs are written as they are now. They are written beside everything else, a moment later.
    pub async fn flush(&self) {
        self.shared.keeper.flush().await;
    }

    /// The names of the tokens that sessions have come with.
    #[must_use]
    pub fn tokens(&self) -> BTreeSet<String> {
        self.shared.lock().station.tokens()
    }

    /// Ends what runs, for the end of the program: jobs are stopped as a person would stop them
    /// (pens go up, settings are restored), clients are told and get a few seconds to end in the
    /// same way what they run over an arm ([`Station::end`]), and nothing else begins. Then the
    /// station itself stops every arm: after it returns the queues are empty, lasers and motors off,
    /// and no command of a client is accepted any more. Called once more, it ends everything at once.
    /// It takes 9 s at most.
    pub async fn end_runs(&self) -> RunsEnd {
        let (again, jobs) = self.shared.with(|inner, now| {
            #[cfg(feature = "class")]
            inner.station.close_queue();
            let again = inner.station.is_ending();
            inner.station.end(now);
            let jobs: Vec<_> = inner.engines.iter().map(ArmEngine::end_job).collect();
            (again, jobs)
        });
        let runs = async {
            for job in jobs {
                job.await;
            }
            self.let_go().await;
        };
        // An arm that does not answer holds up a job.
        let _ = timeout(if again { AT_ONCE } else { RUNS }, runs).await;
        let stops: Vec<_> = self.shared.with(|inner, now| {
            inner.station.end(now);
            let is_reader = inner.station.is_read_only();
            let stops = inner.engines.iter().map(|engine| engine.end(is_reader));
            stops.map(|stop| timeout(LAST_STOP, stop)).collect()
        });
        let mut unconfirmed = Vec::new();
        let names = self.shared.lock().station.arm_names();
        for (arm, stop) in names.into_iter().zip(stops) {
            match stop.await {
                Ok(Ok(())) => {}
                Ok(Err(error)) => unconfirmed.push((arm, error.to_string())),
                Err(_) => unconfirmed.push((arm, "it took too long".to_owned())),
            }
        }
        // Their end is told before anything else ends, and kept.
        let _ = timeout(JOBS_OVER, self.jobs_over()).await;
        self.shared.with(|inner, now| {
            let lost: Vec<_> = unconfirmed.iter().map(|(arm, _)| arm.clone()).collect();
            inner.station.end_jobs(now, &lost);
        });
        let cut_off = self.shared.lock().station.cut_off().to_vec();
        RunsEnd {
            cut_off,
            unconfirmed,
        }
    }

    /// Waits until no job is under way.
    async fn jobs_over(&self) {
        loop {
            let changed = self.shared.changed.notified();
            tokio::pin!(changed);
            changed.as_mut().enable();
            if !self.shared.lock().station.has_jobs_under_way() {
                return;
            }
            changed.await;
        }
    }

    /// Waits until no session holds an arm of a station that ends.
    async fn let_go(&self) {
        loop {
            let let_go = self.shared.let_go.notified();
            tokio::pin!(let_go);
            let_go.as_mut().enable();
            if self.shared.lock().station.has_let_go() {
                return;
            }
            let_go.await;
        }
    }

    /// Completes the files of recordings under way: for the end of the program.
    pub async fn close_recordings(&self) {
        let closed = self.shared.lock().recorder.close();
        let _ = closed.await;
    }

    /// Where its recordings are.
    #[must_use]
    pub fn recordings(&self) -> Arc<dyn RecordingStore> {
        Arc::clone(&self.shared.recordings)
    }

    /// A token is good no more: its sessions end.
    pub fn revoke(&self, token: &str) {
        self.shared
            .with(|inner, now| inner.station.revoke(now, token));
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        // A panic in the station is a bug; what it holds is whole values all the same.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.begun.elapsed()
    }

    /// Does something with the station, and what follows from it.
    fn with<T>(&self, act: impl FnOnce(&mut Inner, HostInstant) -> T) -> T {
        let mut inner = self.lock();
        let due = inner.station.poll_timeout();
        let outcome = act(&mut inner, self.now());
        // What was written at once has its own effects.
        while let Some(written) = self.carry_out(&mut inner) {
            for kept in written {
                inner.take_kept(self.now(), kept);
            }
        }
        if inner.station.poll_timeout() != due {
            self.due.notify_one();
        }
        if inner.station.has_let_go() {
            self.let_go.notify_waiters();
        }
        self.changed.notify_waiters();
        outcome
    }

    /// Hands out what the station has for others. `None` if it is at rest, else what was written at once.
    fn carry_out(&self, inner: &mut Inner) -> Option<Vec<Written>> {
        while let Some((arm, order)) = inner.station.poll_order() {
            if let Some(engine) = inner.engines.get(arm.0 as usize) {
                engine.order(order);
            }
        }
        while let Some((arm, order)) = inner.station.poll_record() {
            inner.recorder.order(arm, order);
        }
        while let Some(socket) = inner.station.poll_awake() {
            if let Some(awake) = inner.sockets.get(&socket) {
                awake.notify_one();
            }
        }
        while let Some(order) = inner.station.poll_library() {
            self.look_into(order);
        }
        let mut lines = Vec::new();
        while let Some(line) = inner.station.poll_journal() {
            lines.push(line);
        }
        // In the order in which it happened: nobody comes between.
        #[cfg(feature = "class")]
        let files = inner.station.poll_kept();
        #[cfg(not(feature = "class"))]
        let files = BTreeMap::new();
        let mut jobs = Vec::new();
        while let Some(changed) = inner.station.poll_jobs() {
            jobs.push(changed);
        }
        let written = self.keeper.keep_all(lines, jobs, files);
        (!written.is_empty()).then_some(written)
    }

    /// Does something with the library, beside the station.
    fn look_into(&self, order: LibraryOrder) {
        let (shared, library) = (Weak::clone(&self.this), Arc::clone(&self.library));
        let (presets, reader) = (self.presets.clone(), Arc::clone(&self.reader));
        let LibraryOrder { request, by, act } = order;
        // A client may be dropped outside of the runtime.
        self.runtime.spawn(async move {
            let outcome = act.carry_out(by, library, presets, reader).await;
            if let Some(shared) = shared.upgrade() {
                shared.with(|inner, now| inner.station.library_done(now, request, outcome));
            }
        });
    }

    fn report(&self, arm: ArmId, report: ArmReport) {
        self.with(|inner, now| inner.station.report(now, arm, report));
    }

    async fn keep_time(shared: Weak<Self>) {
        loop {
            let Some(strong) = shared.upgrade() else {
                return;
            };
            let due = strong.lock().station.poll_timeout();
            let begun = strong.begun;
            let sleep = async {
                match due {
                    Some(due) => sleep_until(begun + (due - HostInstant::ZERO)).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                () = sleep => strong.with(|inner, now| inner.station.handle_timeout(now)),
                () = strong.due.notified() => {}
            }
        }
    }
}

/// A client of a station in this process, or of a listener that carries its messages. Dropping it is the end of its socket.
pub struct Client {
    shared: Arc<Shared>,
    socket: SocketId,
    awake: Arc<Notify>,
}

impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client")
            .field("socket", &self.socket)
            .finish_non_exhaustive()
    }
}

impl Client {
    /// A message of the client has come, which is looked at before it is sent: it gives way to no silent one any more.
    pub fn heard(&self) {
        self.shared
            .with(|inner, now| inner.station.heard(now, self.socket));
    }

    /// A message of the client.
    pub fn send(&self, text: &str) {
        self.shared
            .with(|inner, now| inner.station.receive(now, self.socket, text));
    }

    /// A message of a link, made for this call of its program.
    #[cfg(feature = "link")]
    pub(crate) fn send_for(&self, text: &str, of: Option<String>) {
        self.shared
            .with(|inner, now| inner.station.receive_for(now, self.socket, text, of));
    }

    /// What the token of its hello allows, before the hello is sent: [`Station::vouch`].
    pub fn vouch(&self, grant: Option<Grant>) {
        self.shared.lock().station.vouch(self.socket, grant);
    }

    /// A sign of life: the answer to a ping. A holder without a word for five seconds loses its lease.
    pub fn pong(&self) {
        self.shared
            .with(|inner, now| inner.station.pong(now, self.socket));
    }

    /// What the client is to be sent next; waits for it. After a close comes nothing but the close. Ask when it can be sent:
    /// what waits here stays new. Dropping the future loses nothing.
    pub async fn receive(&self) -> Outgoing {
        loop {
            if let Some(outgoing) = self.try_receive() {
                return outgoing;
            }
            self.awake.notified().await;
        }
    }

    /// What waits to be sent now, if anything does.
    pub fn try_receive(&self) -> Option<Outgoing> {
        self.shared.lock().station.poll_send(self.socket)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.shared.with(|inner, now| {
            inner.station.close(now, self.socket);
            inner.sockets.remove(&self.socket);
        });
    }
}

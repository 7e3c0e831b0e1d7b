//! A station at work: the sans-io [`Station`] with its arms, a clock and a tokio runtime.
//!
//! [`RunningStation`] is what listeners, in-process clients and tests use. It holds the station
//! behind one mutex. Each call takes the lock, lets the station decide, and then hands out
//! everything the station produced (orders, records, journal lines, files, wake-ups) before the
//! lock is released. So effects leave in the order of the decisions. A timer task calls
//! [`Station::handle_timeout`] when the earliest deadline is due.

mod client;
mod ending;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::pin::pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use magician::Arm;
use magician::admission::Origin;
use magician_job::presets::Presets;
use magician_protocol::HostInstant;
use tokio::runtime::Handle;
use tokio::sync::{Notify, oneshot};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep_until};

pub use self::client::Client;
use crate::api::Role;
#[cfg(feature = "class")]
use crate::api::RpcError;
use crate::control::ArmId;
use crate::disk_writer::{DiskWriter, StoredFile, Written};
use crate::engine::ArmEngine;
use crate::fair::FairLine;
use crate::job::Reader;
use crate::library::{LibraryOrder, ProgramStore};
use crate::order::ArmReport;
use crate::recording::{Recorder, RecordingStore};
use crate::station::{JournalLine, Outgoing, Peer, SocketId, Station, StationConfig, StationSize};
use crate::surface::ArmSurface;

/// Queue of clients that wait for a free session, by address.
type WaitingClients = FairLine<String, (Peer, oneshot::Sender<Option<Client>>)>;

/// Callback for the lines of the journal.
pub type JournalSink = Box<dyn Fn(JournalLine) + Send + Sync>;

/// Handle to a running station. Clones refer to the same station. When the last handle and the last
/// [`Client`] are dropped, jogs end and motion is stopped by the rules of the driver.
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
    started: Instant,
    /// Wakes the timer: a deadline is earlier than before.
    due: Notify,
    /// Notified when the station ends and no session holds an arm.
    released: Notify,
    /// Notified after each change, because a session may have become free.
    changed: Notify,
    /// Clients that wait for a session: those of this machine, and those from elsewhere. Two
    /// queues, so that the network cannot delay this machine.
    waiting: [WaitingClients; 2],
    disk_writer: Arc<DiskWriter>,
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
    fn note_written(&mut self, now: HostInstant, kept: Written) {
        let Written {
            what,
            revision,
            outcome,
        } = kept;
        match what {
            StoredFile::Jobs(arm) => self.station.jobs_written(now, arm, revision, outcome),
            #[cfg(feature = "class")]
            StoredFile::File(name) => self.station.file_written(now, name, revision, outcome),
            #[cfg(not(feature = "class"))]
            StoredFile::File(_) => {}
        }
    }
}

impl RunningStation {
    /// Starts the station on the current runtime, with one arm for each entry of the configuration,
    /// in its order.
    ///
    /// # Panics
    /// If called outside of a tokio runtime.
    #[must_use]
    pub fn start(mut config: StationConfig, arms: Vec<Arm>, journal: JournalSink) -> Self {
        let started = Instant::now();
        for (entry, arm) in config.arms.iter_mut().zip(&arms) {
            // The driver may have a fence from its options.
            entry.fence = arm.fence();
        }
        let (lines, zero) = (config.lines.clone(), config.unix_zero);
        let shared = Arc::new_cyclic(|shared: &Weak<Shared>| {
            let reader = Arc::clone(&config.reader);
            let store = Arc::clone(&config.jobs);
            let (entries, surfaces) = (config.arms.clone(), Arc::clone(&config.surfaces));
            let engine = |(at, arm): (usize, &Arm)| {
                // Weak: engine, recorder and keeper are owned by the station, and a strong
                // reference would keep all of them alive for ever.
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
                started,
                due: Notify::new(),
                released: Notify::new(),
                changed: Notify::new(),
                waiting: Default::default(),
                disk_writer: {
                    let shared = Weak::clone(shared);
                    DiskWriter::new(journal, store, move |kept| {
                        if let Some(shared) = shared.upgrade() {
                            shared.with(|inner, now| inner.note_written(now, kept));
                        }
                    })
                },
                reader: Arc::clone(&reader),
            }
        });
        for line in &lines {
            line.set_clock(shared.started, zero);
        }
        // Reading starts now, so that the history covers the time before the first client.
        shared.with(|_, _| ());
        let timer = tokio::spawn(Shared::run_timer(Arc::downgrade(&shared)));
        Self {
            shared,
            _timer: Arc::new(Timer(timer.abort_handle())),
        }
    }

    /// Connects a client.
    #[must_use]
    pub fn connect(&self, peer: Peer) -> Client {
        self.shared.with(|inner, now| {
            let socket = inner.station.open(now, peer);
            self.client(inner, socket)
        })
    }

    /// Creates the client of a socket that was just opened.
    fn client(&self, inner: &mut Inner, socket: SocketId) -> Client {
        let awake = Arc::new(Notify::new());
        inner.sockets.insert(socket, Arc::clone(&awake));
        Client {
            shared: Arc::clone(&self.shared),
            socket,
            awake,
        }
    }

    /// Connects a program for DobotLink.
    #[cfg(feature = "link")]
    pub(crate) fn connect_link(&self, peer: Peer) -> Client {
        self.shared.with(|inner, now| {
            let socket = inner.station.open_link(now, peer);
            self.client(inner, socket)
        })
    }

    /// Connects a client of a listener. `None` if all sessions are in use ([`Station::admit`]).
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

    /// Connects a client as [`try_connect`](Self::try_connect) does, but evicts no client that has
    /// just connected.
    ///
    /// If all sessions are in use, it waits until one is free or the client to be evicted has had
    /// its time to say hello ([`Station::admits_at`]). Waiting clients are admitted by address in
    /// turns. `None` if the station refuses the client.
    pub async fn admit(&self, peer: Peer) -> Option<Client> {
        // By host, because each connection has another port.
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

    /// Admits waiting clients one after the other.
    async fn admit_waiting(self, origin: Origin) {
        while let Some((peer, to)) = self.waiting(origin).pop() {
            while !to.is_closed() {
                // Registered before the check: a change in between would otherwise be missed.
                let mut changed = pin!(self.shared.changed.notified());
                changed.as_mut().enable();
                let now = self.shared.now();
                // Asked again after each change: the answer depends on all other sockets.
                let at = self.shared.lock().station.admits_at(now, origin);
                let Some(at) = at else {
                    break;
                };
                tokio::select! {
                    () = sleep_until(self.shared.started + (at - HostInstant::ZERO)) => {}
                    () = changed => {}
                }
            }
            if !to.is_closed() {
                // If the caller is gone meanwhile, the client is dropped here, which closes its
                // socket.
                let _ = to.send(self.try_connect(peer));
            }
        }
    }

    /// Carries out one request in its own session.
    ///
    /// The session acquires the lease if the request needs it and it is free. `None` for a
    /// notification, which has no answer. Dropping the future ends the session and stops what it
    /// started.
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
                // Not expected from a single request, and not its answer.
                Outgoing::Frame(_) => {}
                Outgoing::Close(_) => return None,
            }
        }
    }

    /// Returns the library of programs.
    #[cfg(feature = "http")]
    pub(crate) fn programs(&self) -> Arc<dyn ProgramStore> {
        Arc::clone(&self.shared.library)
    }

    /// Returns the role of anonymous clients on this machine: viewer while a class is set.
    #[must_use]
    pub fn anonymous_role(&self) -> Role {
        self.shared.lock().station.anonymous_role()
    }

    /// Checks the teacher's PIN of the class ([`Station::try_pin`]).
    ///
    /// # Errors
    /// The same as [`Station::try_pin`].
    #[cfg(feature = "class")]
    pub fn try_pin(&self, pin: &str, peer: &Peer) -> Result<(), RpcError> {
        self.shared
            .with(|inner, now| inner.station.try_pin(now, pin, peer))
    }

    /// Sets the PIN of the class held by the stations behind a hub
    /// ([`Station::set_class_elsewhere`]).
    #[cfg(feature = "class")]
    pub fn set_class_elsewhere(&self, pin: Option<String>) {
        self.shared
            .with(|inner, now| inner.station.set_class_elsewhere(now, pin));
    }

    /// Returns the teacher's PIN. `None` without a class.
    #[cfg(feature = "class")]
    #[must_use]
    pub fn pin(&self) -> Option<String> {
        self.shared.with(|inner, now| {
            // The PIN is created by the first call with a time, because the station has no clock.
            inner.station.handle_timeout(now);
            inner.station.pin().map(str::to_owned)
        })
    }

    /// True if every session is limited to the role of a viewer.
    #[cfg(feature = "http")]
    pub(crate) fn is_read_only(&self) -> bool {
        self.shared.read_only
    }

    /// Returns the number of open sockets.
    #[must_use]
    pub fn sockets(&self) -> usize {
        self.shared.lock().station.size().sockets
    }

    /// Returns the number of sockets [admitted](Self::try_connect) so far, including closed ones.
    #[must_use]
    pub fn visits(&self) -> u64 {
        self.shared.visits.load(Ordering::SeqCst)
    }

    /// Returns the sizes of the station's state, and the number of orders that the arms have not
    /// carried out. For tests of bounded memory.
    #[doc(hidden)]
    #[must_use]
    pub fn size(&self) -> (StationSize, usize) {
        let inner = self.shared.lock();
        let orders = inner.engines.iter().map(ArmEngine::load).sum();
        (inner.station.size(), orders)
    }

    /// Waits until journal and jobs are on disk in their current state. They are written in the
    /// background, a moment after the change.
    pub async fn flush(&self) {
        self.shared.disk_writer.flush().await;
    }

    /// Returns the names of the tokens that sessions have used.
    #[must_use]
    pub fn tokens(&self) -> BTreeSet<String> {
        self.shared.lock().station.tokens()
    }

    /// Completes the files of all recordings, for the end of the program.
    pub async fn close_recordings(&self) {
        let closed = self.shared.lock().recorder.close();
        let _ = closed.await;
    }

    /// Returns the store of recordings.
    #[must_use]
    pub fn recordings(&self) -> Arc<dyn RecordingStore> {
        Arc::clone(&self.shared.recordings)
    }

    /// Revokes a token: sessions that used it end.
    pub fn revoke(&self, token: &str) {
        self.shared
            .with(|inner, now| inner.station.revoke(now, token));
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        // A panic in the station is a bug, but its state consists of whole values and stays usable:
        // stops must still work.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.started.elapsed()
    }

    /// Changes the station and carries out everything that follows.
    fn with<T>(&self, act: impl FnOnce(&mut Inner, HostInstant) -> T) -> T {
        let mut inner = self.lock();
        // Compared after the change: the timer is woken only if its deadline moved.
        let due = inner.station.poll_timeout();
        let outcome = act(&mut inner, self.now());
        // Files that were written inline are reported back, which may produce further effects.
        while let Some(written) = self.carry_out(&mut inner) {
            for kept in written {
                inner.note_written(self.now(), kept);
            }
        }
        if inner.station.poll_timeout() != due {
            self.due.notify_one();
        }
        if inner.station.is_released() {
            self.released.notify_waiters();
        }
        self.changed.notify_waiters();
        outcome
    }

    /// Distributes what the station produced. `None` if nothing was written inline, else the
    /// results of writing.
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
            self.carry_out_library(order);
        }
        let mut lines = Vec::new();
        while let Some(line) = inner.station.poll_journal() {
            lines.push(line);
        }
        // Still under the lock: lines and files are queued in the order of the events.
        #[cfg(feature = "class")]
        let files = inner.station.poll_files();
        #[cfg(not(feature = "class"))]
        let files = BTreeMap::new();
        let mut jobs = Vec::new();
        while let Some(changed) = inner.station.poll_jobs() {
            jobs.push(changed);
        }
        let written = self.disk_writer.queue_all(lines, jobs, files);
        (!written.is_empty()).then_some(written)
    }

    /// Carries out an operation on the library off the station's thread.
    fn carry_out_library(&self, order: LibraryOrder) {
        let (shared, library) = (Weak::clone(&self.this), Arc::clone(&self.library));
        let (presets, reader) = (self.presets.clone(), Arc::clone(&self.reader));
        let LibraryOrder { request, by, act } = order;
        // Spawned by handle, because a client may be dropped outside of the runtime.
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

    async fn run_timer(shared: Weak<Self>) {
        loop {
            let Some(strong) = shared.upgrade() else {
                return;
            };
            let due = strong.lock().station.poll_timeout();
            let started = strong.started;
            let sleep = async {
                match due {
                    Some(due) => sleep_until(started + (due - HostInstant::ZERO)).await,
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

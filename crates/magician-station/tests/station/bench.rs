//! Station with virtual arms, and clients that speak JSON to it.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::admission::Origin;
use magician::sim::{Controller, Profile};
use magician::{Arm, Options, SimSpeed, Tracer, VirtualArm};
use magician_job::presets::Presets;
use magician_job::{Journal, JournalError, JournalKey};
use magician_program::resume::Checkpoint;
use magician_station::{
    ArmEntry, Client, CloseCode, FormatReader, FrameRing, Grant, JobStore, JournalLine,
    NoRecordings, Outgoing, Peer, RecordingStore, Role, RunningStation, StationConfig, StoredRun,
};
use serde_json::{Value, json};
use tokio::time::{Instant, timeout};

use crate::memory_library::{Gate, Gated, MemoryLibrary, MemoryPresets};
use crate::schema_check;

/// Longest time for an answer, in virtual time.
const MESSAGE_TIMEOUT: Duration = Duration::from_secs(120);

pub(crate) struct LocalStation {
    pub(crate) station: RunningStation,
    pub(crate) arms: Vec<VirtualArm>,
    /// Drivers of the station's connections to the arms.
    pub(crate) drivers: Vec<Arm>,
    pub(crate) kept: Storage,
    pub(crate) library: Arc<MemoryLibrary>,
    pub(crate) gate: Gate,
    pub(crate) lines: Arc<Mutex<Vec<JournalLine>>>,
    sockets: std::cell::Cell<u32>,
}

impl LocalStation {
    /// Creates a station with this many arms, named `arm`, or `arm1`, `arm2`, .. Time is the test's
    /// virtual time.
    pub(crate) async fn new(arms: usize) -> Self {
        Self::with(arms, true, Storage::default(), Arc::new(NoRecordings)).await
    }

    /// Creates a station whose arms count as real as far as the laser is concerned.
    pub(crate) async fn real(arms: usize) -> Self {
        Self::with(arms, false, Storage::default(), Arc::new(NoRecordings)).await
    }

    /// Creates a station with one arm that finds the jobs of an earlier one.
    pub(crate) async fn after(kept: Storage) -> Self {
        Self::with(1, true, kept, Arc::new(NoRecordings)).await
    }

    /// Creates a station with one arm that keeps recordings.
    pub(crate) async fn recording(recordings: impl RecordingStore + 'static) -> Self {
        Self::with(1, true, Storage::default(), Arc::new(recordings)).await
    }

    /// Creates the same with a history and a tapped line.
    pub(crate) async fn ringing(
        recordings: impl RecordingStore + 'static,
        line: Arc<FrameRing>,
        trace: Tracer,
    ) -> Self {
        let kept = Storage::default();
        Self::made(1, true, kept, Arc::new(recordings), Some((line, trace))).await
    }

    /// Creates a station with one real arm at which students may burn.
    pub(crate) async fn student_laser() -> Self {
        let (kept, recordings) = (Storage::default(), Arc::new(NoRecordings));
        Self::of(1, false, kept, recordings, None, true).await
    }

    async fn with(
        count: usize,
        is_virtual: bool,
        store: Storage,
        recordings: Arc<dyn RecordingStore>,
    ) -> Self {
        Self::made(count, is_virtual, store, recordings, None).await
    }

    async fn made(
        count: usize,
        is_virtual: bool,
        store: Storage,
        recordings: Arc<dyn RecordingStore>,
        ring: Option<(Arc<FrameRing>, Tracer)>,
    ) -> Self {
        Self::of(count, is_virtual, store, recordings, ring, false).await
    }

    async fn of(
        count: usize,
        is_virtual: bool,
        store: Storage,
        recordings: Arc<dyn RecordingStore>,
        ring: Option<(Arc<FrameRing>, Tracer)>,
        student_laser: bool,
    ) -> Self {
        let kept = store.clone();
        let mut arms = Vec::new();
        let mut virtual_arms = Vec::new();
        let mut entries = Vec::new();
        for at in 0..count {
            let controller = Controller::new(Profile::default());
            let virtual_arm =
                VirtualArm::new(controller, SimSpeed::Times(1.0)).with_breaking_lines();
            let mut options = Options::default().laser_pins(true);
            options.trace = ring.as_ref().map(|(_, trace)| trace.clone());
            arms.push(Arm::simulated(virtual_arm.clone(), options).await.unwrap());
            virtual_arms.push(virtual_arm);
            let name = if count == 1 {
                "arm".to_owned()
            } else {
                format!("arm{}", at + 1)
            };
            entries.push(ArmEntry {
                is_virtual,
                ..ArmEntry::simulated(name)
            });
        }
        let lines = Arc::new(Mutex::new(Vec::new()));
        // Ids must differ at each start.
        let starts = kept.jobs.lock().unwrap()["jobs"]
            .as_array()
            .map_or(0, Vec::len);
        let epoch = starts.to_string();
        let library = Arc::new(MemoryLibrary::default());
        let presets = Presets::with_store(Arc::new(MemoryPresets::default()));
        let reader = FormatReader::default()
            .with_library(Arc::clone(&library) as _)
            .with_presets(presets.clone());
        let gate = Gate::default();
        let config = StationConfig {
            unix_zero: 1_000_000.0,
            student_laser,
            jobs: Arc::new(store),
            recordings,
            ring: if ring.is_some() { 50 } else { 0 },
            lines: ring.into_iter().map(|(line, _)| line).collect(),
            reader: Arc::new(Gated(reader, gate.clone())),
            programs: Arc::clone(&library) as _,
            presets,
            ..StationConfig::new(entries, epoch)
        };
        let journal = Arc::clone(&lines);
        let drivers = arms.clone();
        let station = RunningStation::start(
            config,
            arms,
            Box::new(move |line| journal.lock().unwrap().push(line)),
        );
        Self {
            station,
            arms: virtual_arms,
            drivers,
            kept,
            library,
            gate,
            lines,
            sockets: std::cell::Cell::new(0),
        }
    }

    /// Opens a socket without a session.
    pub(crate) fn socket(&self, role: Option<Role>) -> Tester {
        let grant = role.map(|role| Grant { role, token: None });
        self.socket_of(grant, "127.0.0.1:1")
    }

    /// Opens a socket from this address.
    pub(crate) fn socket_of(&self, grant: Option<Grant>, address: &str) -> Tester {
        self.sockets.set(self.sockets.get() + 1);
        let secret = format!("secret-{:032}", self.sockets.get());
        // Without a grant it comes from elsewhere, because on this machine every client has a role.
        let origin = match grant {
            Some(_) => Origin::Loopback,
            None => Origin::Elsewhere,
        };
        self.socket_at(grant, origin, address, secret)
    }

    /// Opens a socket of an anonymous client of this machine.
    pub(crate) fn stranger(&self) -> Tester {
        self.sockets.set(self.sockets.get() + 1);
        let secret = format!("secret-{:032}", self.sockets.get());
        self.socket_at(None, Origin::Loopback, "127.0.0.1:1", secret)
    }

    fn socket_at(
        &self,
        grant: Option<Grant>,
        origin: Origin,
        address: &str,
        secret: String,
    ) -> Tester {
        let peer = Peer {
            grant,
            origin,
            address: address.to_owned(),
            secret,
        };
        Tester {
            client: self.station.connect(peer),
            next: 0,
            notices: Vec::new(),
            frames: Vec::new(),
            closed: None,
            requests: BTreeMap::new(),
        }
    }

    /// Sends a single request from this machine.
    pub(crate) async fn once(&self, method: &str, params: Value) -> Value {
        let grant = Grant {
            role: Role::Teacher,
            token: None,
        };
        self.once_as(Some(grant), method, params).await
    }

    /// Sends a single request from this machine, with this token or none.
    pub(crate) async fn once_as(&self, grant: Option<Grant>, method: &str, params: Value) -> Value {
        let peer = Peer {
            grant,
            origin: Origin::Loopback,
            address: "127.0.0.1:1".to_owned(),
            secret: String::new(),
        };
        let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let answer = self.station.call(peer, &message.to_string()).await;
        serde_json::from_str(&answer.expect("an answer")).unwrap()
    }

    /// Opens a session with this name and role.
    pub(crate) async fn join_as(&self, name: &str, role: Role) -> Tester {
        let mut tester = self.socket(Some(role));
        tester
            .call("session.hello", json!({"client": {"name": name}}))
            .await
            .unwrap();
        tester
    }

    pub(crate) async fn join(&self, name: &str) -> Tester {
        self.join_as(name, Role::Student).await
    }
}

/// Jobs and journals in memory, which a station leaves to the next one.
#[derive(Clone, Default)]
pub(crate) struct Storage {
    /// Jobs of the first arm.
    pub(crate) jobs: Arc<Mutex<Value>>,
    /// True if the disk is full.
    pub(crate) full: Arc<AtomicBool>,
    pub(crate) runs: Vec<StoredRun>,
    /// Files of the class by name.
    pub(crate) files: Arc<Mutex<BTreeMap<String, String>>>,
    journals: Arc<Mutex<BTreeMap<String, Checkpoint>>>,
}

impl Storage {
    /// Returns a copy, independent of what the station does later.
    pub(crate) fn copy(&self) -> Self {
        Self {
            jobs: Arc::new(Mutex::new(self.jobs.lock().unwrap().clone())),
            full: Arc::default(),
            runs: self.runs.clone(),
            files: Arc::new(Mutex::new(self.files.lock().unwrap().clone())),
            journals: Arc::new(Mutex::new(self.journals.lock().unwrap().clone())),
        }
    }
}

impl JobStore for Storage {
    fn load(&self, arm: usize) -> Value {
        match arm {
            0 => self.jobs.lock().unwrap().clone(),
            _ => Value::Null,
        }
    }

    fn save(&self, arm: usize, jobs: &Value) -> io::Result<()> {
        if self.full.load(Ordering::SeqCst) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        if arm == 0 {
            *self.jobs.lock().unwrap() = jobs.clone();
        }
        Ok(())
    }

    fn load_text(&self, name: &str) -> io::Result<Option<String>> {
        Ok(self.files.lock().unwrap().get(name).cloned())
    }

    fn save_text(&self, name: &str, text: &str) -> io::Result<()> {
        if self.full.load(Ordering::SeqCst) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let mut files = self.files.lock().unwrap();
        files.insert(name.to_owned(), text.to_owned());
        Ok(())
    }

    fn runs(&self, arm: usize) -> Vec<StoredRun> {
        match arm {
            0 => self.runs.clone(),
            _ => Vec::new(),
        }
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(StoredJournal {
            kept: self.clone(),
            key: String::new(),
        })
    }
}

struct StoredJournal {
    kept: Storage,
    key: String,
}

impl Journal for StoredJournal {
    fn open(&mut self, key: &JournalKey) {
        self.key = format!("{}-{}", key.program, key.arm);
    }

    fn load(&self) -> Result<Checkpoint, JournalError> {
        let journals = self.kept.journals.lock().unwrap();
        journals
            .get(&self.key)
            .cloned()
            .ok_or(JournalError::NotFound)
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        let mut journals = self.kept.journals.lock().unwrap();
        journals.insert(self.key.clone(), checkpoint.clone());
        Ok(())
    }

    fn remove(&mut self) {
        self.kept.journals.lock().unwrap().remove(&self.key);
    }
}

/// Client.
pub(crate) struct Tester {
    pub(crate) client: Client,
    next: i64,
    /// Received notifications in order: method and parameters.
    pub(crate) notices: Vec<(String, Value)>,
    pub(crate) frames: Vec<Vec<u8>>,
    pub(crate) closed: Option<CloseCode>,
    /// Requests without an answer by id: method and parameters.
    requests: BTreeMap<i64, (String, Value)>,
}

impl Tester {
    /// Sends a request and returns its id.
    pub(crate) fn send(&mut self, method: &str, params: Value) -> i64 {
        self.next += 1;
        let message =
            json!({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params});
        self.client.send(&message.to_string());
        let params = message["params"].clone();
        self.requests.insert(self.next, (method.to_owned(), params));
        self.next
    }

    pub(crate) fn notify(&mut self, method: &str, params: Value) {
        let message = json!({"jsonrpc": "2.0", "method": method, "params": params});
        self.client.send(&message.to_string());
    }

    /// Calls a method. Returns its result or its error.
    pub(crate) async fn call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        let id = self.send(method, params);
        self.answer(id).await
    }

    /// Calls a method that must succeed.
    pub(crate) async fn ok(&mut self, method: &str, params: Value) -> Value {
        let outcome = self.call(method, params).await;
        outcome.unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// Calls a method that must fail. Returns the error code.
    pub(crate) async fn code(&mut self, method: &str, params: Value) -> i64 {
        let outcome = self.call(method, params).await;
        let error = outcome.expect_err(method);
        error["code"].as_i64().unwrap()
    }

    /// Waits for the answer to a request.
    pub(crate) async fn answer(&mut self, id: i64) -> Result<Value, Value> {
        loop {
            let message = self.message().await.expect("an answer before the end");
            if message["id"] == json!(id) {
                return match message.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(message["result"].clone()),
                };
            }
        }
    }

    /// Waits for the next answer and stores notifications. `None` if the socket was closed.
    pub(crate) async fn message(&mut self) -> Option<Value> {
        loop {
            let outgoing = timeout(MESSAGE_TIMEOUT, self.client.receive())
                .await
                .expect("in time");
            match outgoing {
                Outgoing::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if message.get("method").is_none() {
                        self.check(&message);
                        return Some(message);
                    }
                    self.keep(&message);
                }
                Outgoing::Frame(frame) => self.frames.push(frame),
                Outgoing::Close(code) => {
                    self.closed = Some(code);
                    return None;
                }
            }
        }
    }

    /// Reads everything that arrives within this time.
    pub(crate) async fn listen(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while let Ok(outgoing) = tokio::time::timeout_at(until, self.client.receive()).await {
            match outgoing {
                Outgoing::Text(text) => self.keep(&serde_json::from_str(&text).unwrap()),
                Outgoing::Frame(frame) => self.frames.push(frame),
                Outgoing::Close(code) => {
                    self.closed = Some(code);
                    return;
                }
            }
        }
    }

    /// Checks an answer against its schema.
    fn check(&mut self, message: &Value) {
        let asked = message["id"]
            .as_i64()
            .and_then(|id| self.requests.remove(&id));
        match (asked, message.get("error")) {
            (Some((method, _)), Some(error)) => schema_check::check_error(&method, error),
            (Some((method, params)), None) => {
                schema_check::check_call(&method, &params, &message["result"]);
            }
            (None, _) => {}
        }
    }

    fn keep(&mut self, message: &Value) {
        if message.get("method").is_some() {
            schema_check::check_notification(message);
        } else {
            self.check(message);
        }
        let method = message["method"].as_str().unwrap_or("answer").to_owned();
        self.notices.push((method, message["params"].clone()));
    }

    /// Returns the notifications of a method so far.
    pub(crate) fn noticed(&self, method: &str) -> Vec<&Value> {
        let of = self.notices.iter().filter(|(name, _)| name == method);
        of.map(|(_, params)| params).collect()
    }

    pub(crate) async fn lease(&mut self) -> Value {
        self.ok("lease.acquire", json!({})).await["lease"].clone()
    }

    /// Starts a job with twenty moves and returns its id.
    pub(crate) async fn begin_job(&mut self) -> Value {
        let steps: Vec<_> = (0..20)
            .map(|at| json!({"move": [220, at, 20, 0]}))
            .collect();
        let plan = json!({"format": "magician-plan", "version": 1, "steps": steps});
        self.ok("job.start", json!({"text": plan.to_string()}))
            .await["job"]
            .clone()
    }
}

//! A test site of stations in this process, a hub over it, and its clients, in virtual time.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::sim::Scenario;
use magician::{Arm, Options, SimSpeed, VirtualArm};
use magician_site::hub::{HubClient, HubConfig, RunningHub};
use magician_site::{
    ArmAt, ArmReport, BoxFuture, Caller, Channel, Roster, Site, SiteError, SiteEvent,
    SiteEventSender, SiteEvents, StationEnd, StationId, carry, channel, event_channel,
};
use magician_station::http::{ApiClient, ProgramFolder, TokenStore};
use magician_station::{
    ArmEntry, CloseCode, Grant, Outgoing, Peer, Role, RunningStation, StationConfig,
};
use serde_json::{Value, json};
use tokio::task::AbortHandle;
use tokio::time::{Instant, timeout_at};

/// Timeout of every reply, in virtual time.
const REPLY_TIMEOUT: Duration = Duration::from_secs(60);

/// A station. All stations give ids of the same form.
pub(crate) struct TestStation {
    pub(crate) running: RunningStation,
    pub(crate) arms: Vec<String>,
    /// Virtual arms, in the order of their names.
    pub(crate) cells: Vec<VirtualArm>,
}

/// Treatment of lines to a faulty station.
pub(crate) type Fault = Arc<dyn Fn(StationEnd) + Send + Sync>;

#[derive(Default)]
struct State {
    stations: BTreeMap<StationId, Arc<TestStation>>,
    there: BTreeSet<StationId>,
    faults: BTreeMap<StationId, Fault>,
    silent: BTreeSet<StationId>,
    watchers: Vec<SiteEventSender>,
    carried: BTreeMap<StationId, Vec<AbortHandle>>,
}

#[derive(Default)]
pub(crate) struct TestSite {
    state: Mutex<State>,
    opened: AtomicUsize,
    /// File with the tokens of its stations.
    tokens: Mutex<PathBuf>,
    /// Union of its stations' rosters.
    pub(crate) roster: Mutex<Roster>,
    /// Methods of single requests.
    pub(crate) calls: Mutex<Vec<String>>,
}

impl TestStation {
    /// The arm's y coordinate, as its station reports it.
    pub(crate) async fn y(&self, arm: &str) -> f64 {
        let request =
            json!({"jsonrpc": "2.0", "id": 1, "method": "arm.state", "params": {"arm": arm}});
        let answer = self
            .running
            .call(peer(), &request.to_string())
            .await
            .unwrap();
        let answer: Value = serde_json::from_str(&answer).unwrap();
        answer["result"]["y"].as_f64().unwrap()
    }
}

pub(crate) fn peer() -> Peer {
    let grant = Some(Grant {
        role: Role::Teacher,
        token: None,
    });
    Peer::elsewhere(grant, "site".to_owned()).unwrap()
}

impl TestSite {
    pub(crate) async fn of(stations: usize, arms: usize) -> Arc<Self> {
        let site = Arc::new(Self::default());
        for at in 0..stations {
            let names: Vec<_> = (0..arms)
                .map(|arm| format!("arm{}", at * arms + arm))
                .collect();
            site.start(StationId(at as u64 + 1), &names).await;
        }
        site
    }

    /// Starts a station with virtual arms of these names.
    pub(crate) async fn start(&self, id: StationId, names: &[String]) {
        self.start_in(id, names, &Scenario::default(), |_| {}).await;
    }

    /// Starts a station with virtual arms in a given world, and changes its configuration.
    pub(crate) async fn start_in(
        &self,
        id: StationId,
        names: &[String],
        world: &Scenario,
        more: impl FnOnce(&mut StationConfig),
    ) {
        let (mut arms, mut cells) = (Vec::new(), Vec::new());
        for _ in names {
            let cell =
                VirtualArm::in_scenario_at(world, SimSpeed::Times(1.0)).with_breaking_lines();
            let arm = Arm::simulated(cell.clone(), Options::default());
            arms.push(arm.await.unwrap());
            cells.push(cell);
        }
        let entries = names.iter().map(ArmEntry::simulated).collect();
        let mut config = StationConfig::new(entries, "same");
        more(&mut config);
        let running = RunningStation::start(config, arms, Box::new(|_| {}));
        let station = TestStation {
            running,
            arms: names.to_vec(),
            cells,
        };
        self.state
            .lock()
            .unwrap()
            .stations
            .insert(id, Arc::new(station));
        self.restore_station(id);
    }

    pub(crate) fn station(&self, id: u64) -> Arc<TestStation> {
        Arc::clone(&self.state.lock().unwrap().stations[&StationId(id)])
    }

    /// Makes the station unreachable.
    pub(crate) fn cut(&self, id: u64) {
        let id = StationId(id);
        self.end_lines(id);
        self.state.lock().unwrap().there.remove(&id);
        for at in self.arms_of(id) {
            self.tell(&SiteEvent::Left(at));
        }
    }

    /// Ends the lines of a station that stays present.
    pub(crate) fn end_lines(&self, id: StationId) {
        let carried = self.state.lock().unwrap().carried.remove(&id);
        carried.into_iter().flatten().for_each(|one| one.abort());
    }

    pub(crate) fn restore_station(&self, id: StationId) {
        self.state.lock().unwrap().there.insert(id);
        for at in self.arms_of(id) {
            self.tell(&SiteEvent::Arrived(at));
        }
    }

    /// Sets the treatment of lines to a station from now on. `None` is the normal one.
    pub(crate) fn fault(&self, id: u64, fault: Option<Fault>) {
        let mut state = self.state.lock().unwrap();
        match fault {
            Some(fault) => state.faults.insert(StationId(id), fault),
            None => state.faults.remove(&StationId(id)),
        };
    }

    /// Keeps the station present but silent.
    pub(crate) fn silence(&self, id: u64) {
        self.fault(id, Some(Arc::new(std::mem::forget)));
        self.state.lock().unwrap().silent.insert(StationId(id));
    }

    pub(crate) fn tell(&self, event: &SiteEvent) {
        let mut state = self.state.lock().unwrap();
        state.watchers.retain(|sender| sender.send(event.clone()));
    }

    /// Publishes the state of an arm, as its station does on a real site.
    pub(crate) async fn report(&self, station: u64, arm: &str) {
        let request =
            json!({"jsonrpc": "2.0", "id": 1, "method": "arm.state", "params": {"arm": arm}});
        let running = self.station(station).running.clone();
        let answer = running.call(peer(), &request.to_string()).await.unwrap();
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let report = ArmReport {
            machine: "test".to_owned(),
            port: "sim".to_owned(),
            is_virtual: true,
            state: answer["result"].clone(),
        };
        self.tell(&SiteEvent::Report(at(station, arm), report));
    }

    pub(crate) fn opened(&self) -> usize {
        self.opened.load(Ordering::SeqCst)
    }

    fn arms_of(&self, id: StationId) -> Vec<ArmAt> {
        let state = self.state.lock().unwrap();
        let arms = state.stations[&id].arms.iter();
        arms.map(|arm| ArmAt {
            arm: arm.clone(),
            station: id,
        })
        .collect()
    }
}

pub(crate) fn at(station: u64, arm: &str) -> ArmAt {
    ArmAt {
        arm: arm.to_owned(),
        station: StationId(station),
    }
}

impl Site for TestSite {
    fn name(&self) -> &str {
        "test"
    }

    fn arms(&self) -> BTreeMap<ArmAt, Option<ArmReport>> {
        let there = self.state.lock().unwrap().there.clone();
        there
            .into_iter()
            .flat_map(|id| self.arms_of(id))
            .map(|at| (at, None))
            .collect()
    }

    fn watch(&self) -> SiteEvents {
        let (sender, events) = event_channel();
        for at in self.arms().into_keys() {
            sender.send(SiteEvent::Arrived(at));
        }
        self.state.lock().unwrap().watchers.push(sender);
        events
    }

    fn call<'a>(
        &'a self,
        at: &'a ArmAt,
        _: &'a Caller,
        request: String,
    ) -> BoxFuture<'a, Result<Option<String>, SiteError>> {
        Box::pin(async move {
            let message: Value = serde_json::from_str(&request).unwrap();
            let method = message["method"].as_str().unwrap().to_owned();
            self.calls.lock().unwrap().push(method);
            let (station, silent) = {
                let state = self.state.lock().unwrap();
                if !state.there.contains(&at.station) {
                    return Err(SiteError::Gone);
                }
                let station = Arc::clone(&state.stations[&at.station]);
                (station, state.silent.contains(&at.station))
            };
            if silent {
                std::future::pending::<()>().await;
            }
            Ok(station.running.call(peer(), &request).await)
        })
    }

    fn roster(&self) -> BoxFuture<'_, Roster> {
        let roster = self.roster.lock().unwrap().clone();
        Box::pin(async move { roster })
    }

    fn open(&self, station: StationId) -> BoxFuture<'_, Result<Channel, SiteError>> {
        Box::pin(async move {
            self.opened.fetch_add(1, Ordering::SeqCst);
            let mut state = self.state.lock().unwrap();
            if !state.there.contains(&station) {
                return Err(SiteError::Gone);
            }
            let (client, end) = channel();
            if let Some(fault) = state.faults.get(&station) {
                fault(end);
                return Ok(client);
            }
            let running = state.stations[&station].running.clone();
            let tokens = TokenStore::at(self.tokens.lock().unwrap().clone());
            let carried = tokio::spawn(carry(running.connect(peer()), tokens, end));
            state
                .carried
                .entry(station)
                .or_default()
                .push(carried.abort_handle());
            Ok(client)
        })
    }
}

/// A hub over a test site.
pub(crate) struct TestHub {
    pub(crate) site: Arc<TestSite>,
    pub(crate) hub: RunningHub,
    _programs: tempfile::TempDir,
}

impl TestHub {
    pub(crate) async fn new(stations: usize, arms: usize) -> Self {
        Self::over(TestSite::of(stations, arms).await, false).await
    }

    /// Starts a hub that has a teacher's token for the stations.
    pub(crate) async fn with_token(stations: usize, arms: usize) -> Self {
        Self::start(TestSite::of(stations, arms).await, false, true)
    }

    pub(crate) async fn over(site: Arc<TestSite>, read_only: bool) -> Self {
        Self::start(site, read_only, false)
    }

    fn start(site: Arc<TestSite>, read_only: bool, has_token: bool) -> Self {
        let mut station = StationConfig::new(Vec::new(), "hub");
        station.read_only = read_only;
        let programs = tempfile::tempdir().unwrap();
        station.programs = Arc::new(ProgramFolder::at(programs.path()));
        let tokens = programs.path().join("tokens.toml");
        let token = has_token.then(|| {
            let store = TokenStore::at(&tokens);
            store.create(None, Role::Teacher).unwrap().1
        });
        *site.tokens.lock().unwrap() = tokens;
        let config = HubConfig {
            station,
            token,
            journal: Box::new(|_| {}),
        };
        let hub = RunningHub::start(config, Arc::clone(&site) as _);
        Self {
            site,
            hub,
            _programs: programs,
        }
    }

    /// Replies of these stations to a teacher who asks them directly.
    pub(crate) async fn ask_all(&self, of: &[u64], method: &str) -> Vec<Value> {
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": method}).to_string();
        let mut answers = Vec::new();
        for id in of {
            let running = self.site.station(*id).running.clone();
            let answer = running.call(peer(), &request).await.unwrap();
            let mut answer: Value = serde_json::from_str(&answer).unwrap();
            answers.push(answer["result"].take());
        }
        answers
    }

    pub(crate) fn socket(&self) -> Tester {
        self.socket_of(peer())
    }

    pub(crate) fn socket_of(&self, peer: Peer) -> Tester {
        Tester {
            client: self.hub.connect(peer, None),
            next: 0,
            notices: Vec::new(),
            frames: Vec::new(),
            answers: Vec::new(),
            closed: None,
        }
    }

    pub(crate) async fn join(&self, name: &str) -> Tester {
        let mut tester = self.socket();
        tester
            .ok("session.hello", json!({"client": {"name": name}}))
            .await;
        tester
    }
}

/// Client of the hub. It checks that no message contains an id that the hub should have renamed.
pub(crate) struct Tester {
    pub(crate) client: HubClient,
    next: i64,
    pub(crate) notices: Vec<(String, Value)>,
    pub(crate) frames: Vec<Vec<u8>>,
    answers: Vec<Value>,
    pub(crate) closed: Option<CloseCode>,
}

/// Checks that no id of a station appears unchanged.
fn check_ids(value: &Value) {
    match value {
        Value::String(text) => {
            let bare = text.starts_with(['s', 'l', 'g', 'j']) && text[1..].starts_with("same-");
            assert!(!bare, "the id {text} of a station");
        }
        Value::Array(items) => items.iter().for_each(check_ids),
        Value::Object(members) => members.values().for_each(check_ids),
        _ => {}
    }
}

impl Tester {
    pub(crate) fn send(&mut self, method: &str, params: Value) -> i64 {
        self.next += 1;
        let message =
            json!({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params});
        self.client.send(&message.to_string());
        self.next
    }

    pub(crate) fn notify(&mut self, method: &str, params: Value) {
        let message = json!({"jsonrpc": "2.0", "method": method, "params": params});
        self.client.send(&message.to_string());
    }

    pub(crate) async fn call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        let id = self.send(method, params);
        self.answer(id).await
    }

    pub(crate) async fn ok(&mut self, method: &str, params: Value) -> Value {
        let outcome = self.call(method, params).await;
        outcome.unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    pub(crate) async fn fails(&mut self, method: &str, params: Value) -> Value {
        self.call(method, params).await.expect_err(method)
    }

    pub(crate) async fn answer(&mut self, id: i64) -> Result<Value, Value> {
        let until = Instant::now() + REPLY_TIMEOUT;
        loop {
            let known = self
                .answers
                .iter()
                .position(|message| message["id"] == json!(id));
            if let Some(at) = known {
                let message = self.answers.remove(at);
                return match message.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(message["result"].clone()),
                };
            }
            let outgoing = timeout_at(until, self.client.receive())
                .await
                .expect("in time");
            if !self.take(outgoing) {
                panic!("closed with {:?}", self.closed);
            }
        }
    }

    /// Stores a message. Returns false for the end.
    fn take(&mut self, outgoing: Outgoing) -> bool {
        match outgoing {
            Outgoing::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                check_ids(&message);
                match message["method"].as_str() {
                    Some(method) => self
                        .notices
                        .push((method.to_owned(), message["params"].clone())),
                    None => self.answers.push(message),
                }
            }
            Outgoing::Frame(frame) => self.frames.push(frame),
            Outgoing::Close(code) => {
                self.closed = Some(code);
                return false;
            }
        }
        true
    }

    /// Reads messages for this time, and answers pings.
    pub(crate) async fn run_for(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            let pause = (Instant::now() + Duration::from_secs(1)).min(until);
            while let Ok(outgoing) = timeout_at(pause, self.client.receive()).await {
                if !self.take(outgoing) {
                    return;
                }
            }
            self.client.pong();
        }
    }

    pub(crate) fn noticed(&self, method: &str) -> Vec<&Value> {
        let of = self.notices.iter().filter(|(name, _)| name == method);
        of.map(|(_, params)| params).collect()
    }

    pub(crate) async fn take_arm(&mut self, arm: &str) -> Value {
        self.ok("lease.take", json!({"arm": arm})).await["lease"].clone()
    }

    /// Row of an arm in the list of arms.
    pub(crate) async fn row(&mut self, arm: &str) -> Value {
        let list = self.ok("arm.list", json!({})).await;
        let mut rows = list["arms"].as_array().unwrap().iter();
        rows.find(|row| row["name"] == arm).expect(arm).clone()
    }
}

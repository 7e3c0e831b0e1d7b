//! Property tests of durability: a disk that fails at any write, or dies with the program. Nothing
//! answered is lost, nothing is done twice. Without arms, files and clock.

use std::io;
use std::sync::{Arc, Mutex};

use magician::admission::Origin;
use magician_job::{Journal, NoJournal};
use magician_protocol::HostInstant;
use magician_station::control::{ArmId, JobId};
use magician_station::{
    ArmEntry, ArmOrder, ArmReport, Grant, JobEnd, JobStore, JobUpdate, Outgoing, Peer, Role,
    SocketId, Station, StationConfig,
};
use serde_json::{Value, json};

/// Fate of one write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// The disk refuses and reports it.
    Full,
    /// The disk reports a failure but has written.
    LostWord,
    /// The program is killed before the write.
    KilledBefore,
    /// The program is killed after the write, before it learns of it.
    KilledBehind,
}

const FAULTS: [Fault; 4] = [
    Fault::Full,
    Fault::LostWord,
    Fault::KilledBefore,
    Fault::KilledBehind,
];

/// Content of the disk.
#[derive(Clone, Default)]
struct Disk(Arc<Mutex<Value>>);

impl JobStore for Disk {
    fn load(&self, _: usize) -> Value {
        self.0.lock().unwrap().clone()
    }

    fn save(&self, _: usize, jobs: &Value) -> io::Result<()> {
        *self.0.lock().unwrap() = jobs.clone();
        Ok(())
    }

    fn journal(&self) -> Box<dyn Journal> {
        Box::new(NoJournal)
    }
}

/// Promise given by an answer.
#[derive(Clone, Debug, PartialEq)]
enum Promise {
    /// The job with this key exists.
    Started(String, String),
    /// The job has left the queue.
    Stopped(String),
    /// The job has resumed after its stop.
    GoesOn(String),
    /// The job has left the list.
    Deleted(String),
    /// Requested, but the program was killed before the answer: both states are right.
    MayBeDeleted(String),
}

/// Process: a station with one arm that does what the test says.
struct Simulation {
    station: Station,
    socket: SocketId,
    disk: Disk,
    requests: u64,
    /// Number of the failing write, from 0, and its fate.
    fault: Option<(u32, Fault)>,
    writes: u32,
    killed: bool,
    /// Jobs that the arm was ordered to start, in order.
    started: Vec<JobId>,
    promises: Vec<Promise>,
}

impl Simulation {
    fn new(disk: Disk, epoch: &str, fault: Option<(u32, Fault)>) -> Self {
        let mut config = StationConfig::new(vec![ArmEntry::simulated("arm")], epoch);
        config.jobs = Arc::new(disk.clone());
        let mut station = Station::new(config);
        let grant = Some(Grant {
            role: Role::Teacher,
            token: None,
        });
        let peer = Peer {
            grant,
            origin: Origin::Loopback,
            address: "here".to_owned(),
            secret: "0123456789abcdef".to_owned(),
        };
        let socket = station.open(HostInstant::ZERO, peer);
        let mut life = Self {
            station,
            socket,
            disk,
            requests: 0,
            fault,
            writes: 0,
            killed: false,
            started: Vec::new(),
            promises: Vec::new(),
        };
        life.call("session.hello", json!({"client": {"name": "store"}}));
        life.call("lease.acquire", json!({}));
        life
    }

    /// Carries out writes and orders until none are left.
    fn turn(&mut self) {
        while !self.killed {
            if let Some(jobs) = self.station.poll_jobs() {
                let fault = self.fault.filter(|(at, _)| *at == self.writes);
                let fault = fault.map(|(_, fault)| fault);
                self.writes += 1;
                if !matches!(fault, Some(Fault::Full | Fault::KilledBefore)) {
                    self.disk.save(0, &jobs.to_value()).unwrap();
                }
                if matches!(fault, Some(Fault::KilledBefore | Fault::KilledBehind)) {
                    self.killed = true;
                    return;
                }
                let outcome = match fault {
                    Some(_) => Err("No space left on device".to_owned()),
                    None => Ok(()),
                };
                let (arm, revision) = (jobs.arm(), jobs.revision());
                self.station
                    .jobs_written(HostInstant::ZERO, arm, revision, outcome);
            } else if let Some((_, order)) = self.station.poll_order() {
                match order {
                    ArmOrder::StartJob(start) => self.started.push(start.job),
                    ArmOrder::StopJob(job) => self.over(job, "stopped"),
                    _ => {}
                }
            } else {
                return;
            }
        }
    }

    fn update(&mut self, job: JobId, update: JobUpdate) {
        if self.killed {
            return;
        }
        let report = ArmReport::Job { job, update };
        self.station.report(HostInstant::ZERO, ArmId(0), report);
        self.turn();
    }

    fn over(&mut self, job: JobId, state: &'static str) {
        self.update(job, JobUpdate::Over(Box::new(JobEnd::new(state))));
    }

    /// Brings the last started job into this state.
    fn goes_on(&mut self, state: &str) {
        let Some(job) = self.started.last().copied() else {
            return;
        };
        if state == "done" {
            return self.over(job, "done");
        }
        let running = JobUpdate::State(magician_job::JobState::Running, None);
        self.update(job, running);
    }

    /// Calls a method. `None` if there is no answer, because the program was killed or the answer
    /// comes later.
    fn call(&mut self, method: &str, params: Value) -> Option<Result<Value, Value>> {
        self.requests += 1;
        let id = self.requests;
        if self.killed {
            return None;
        }
        let message = json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params});
        let text = message.to_string();
        self.station.receive(HostInstant::ZERO, self.socket, &text);
        self.turn();
        self.answer(id)
    }

    fn answer(&mut self, id: u64) -> Option<Result<Value, Value>> {
        // Messages sent before the kill are received.
        let mut answer = None;
        while let Some(Outgoing::Text(text)) = self.station.poll_send(self.socket) {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == json!(id) {
                answer = Some(match message.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(message["result"].clone()),
                });
            }
        }
        answer
    }

    /// Starts a job with this key, queued if another one runs.
    fn start(&mut self, key: &str) {
        let text = json!({"format": "magician-plan", "version": 1, "title": key, "steps": []});
        let params =
            json!({"text": text.to_string(), "key": key, "queue": true, "after_check": false});
        if let Some(Ok(answer)) = self.call("job.start", params) {
            let job = answer["job"].as_str().unwrap().to_owned();
            self.promises.push(Promise::Started(key.to_owned(), job));
        }
    }

    fn job(&self, key: &str) -> Option<String> {
        self.promises.iter().find_map(|promise| match promise {
            Promise::Started(of, job) if of == key => Some(job.clone()),
            _ => None,
        })
    }

    fn stop(&mut self, key: &str) {
        let Some(job) = self.job(key) else { return };
        if let Some(Ok(_)) = self.call("job.stop", json!({"job": job})) {
            self.promises.push(Promise::Stopped(job));
        }
    }

    /// Resumes a stopped job, up to its first step.
    fn resume(&mut self, key: &str) {
        let Some(job) = self.job(key) else { return };
        let at_once = self.call("job.resume", json!({"job": job}));
        assert!(
            !matches!(at_once, Some(Ok(_))),
            "nothing runs yet: {at_once:?}"
        );
        let request = self.requests;
        self.goes_on("running");
        if let Some(Ok(answer)) = self.answer(request) {
            assert_eq!(answer["state"], json!("running"));
            self.promises.push(Promise::GoesOn(job));
        }
    }

    fn delete(&mut self, key: &str) {
        let Some(job) = self.job(key) else { return };
        match self.call("job.delete", json!({"job": job})) {
            Some(Ok(_)) => self.promises.push(Promise::Deleted(job)),
            None => self.promises.push(Promise::MayBeDeleted(job)),
            Some(Err(_)) => {}
        }
    }

    fn reorder(&mut self, key: &str, place: u64) {
        let Some(job) = self.job(key) else { return };
        self.call("job.reorder", json!({"job": job, "position": place}));
    }

    fn list(&mut self) -> Vec<Value> {
        let answer = self.call("job.list", json!({})).unwrap().unwrap();
        answer["jobs"].as_array().unwrap().clone()
    }
}

/// Step of the day.
type Step = (&'static str, fn(&mut Simulation));

/// Day that leads through all states.
const DAY: [Step; 14] = [
    ("a begins", |life| life.start("a")),
    ("a runs", |life| life.goes_on("running")),
    ("b waits", |life| life.start("b")),
    ("c waits", |life| life.start("c")),
    ("d waits", |life| life.start("d")),
    ("d goes before b", |life| life.reorder("d", 1)),
    ("c is stopped", |life| life.stop("c")),
    ("a is done", |life| life.goes_on("done")),
    // d has started by now.
    ("d runs", |life| life.goes_on("running")),
    ("a is deleted", |life| life.delete("a")),
    ("d is done", |life| life.goes_on("done")),
    ("b runs", |life| life.goes_on("running")),
    ("b is stopped", |life| life.stop("b")),
    ("b goes on", |life| life.resume("b")),
];

/// Runs the first steps of the day with this fault, and then a second process.
fn live(steps: usize, fault: Option<(u32, Fault)>) -> u32 {
    let disk = Disk::default();
    let mut first = Simulation::new(disk.clone(), "1", fault);
    for (_, step) in &DAY[..steps] {
        step(&mut first);
    }
    let at = || format!("after {:?} with {fault:?}", DAY[..steps].last());
    // Jobs that the arm was ordered to start, by their public ids.
    let begun: Vec<_> = first
        .started
        .iter()
        .map(|job| format!("j1-{}", job.0))
        .collect();
    assert!(
        begun
            .iter()
            .all(|job| begun.iter().filter(|other| *other == job).count() == 1),
        "{begun:?} {}",
        at()
    );
    let promises = first.promises.clone();
    let stopped = |job: &str| promises.contains(&Promise::Stopped(job.to_owned()));
    let deleted = |job: &str| promises.contains(&Promise::Deleted(job.to_owned()));
    let writes = first.writes;
    drop(first);

    let mut second = Simulation::new(disk, "2", None);
    second.turn();
    let jobs = second.list();
    let found = |id: &str| -> Vec<Value> {
        let of = jobs.iter().filter(|job| job["job"] == json!(id));
        of.cloned().collect()
    };
    let mut keys = Vec::new();
    for promise in &promises {
        match promise {
            Promise::Started(key, job) => {
                let count = found(job).len();
                let undecided = promises.contains(&Promise::MayBeDeleted(job.clone()));
                if !undecided {
                    assert_eq!(count, usize::from(!deleted(job)), "{key} {}", at());
                }
                if count > 0 {
                    keys.push((key.clone(), job.clone()));
                }
            }
            Promise::Stopped(job) => {
                let state = found(job).first().map(|job| job["state"].clone());
                assert_ne!(state, Some(json!("queued")), "{}", at());
            }
            Promise::GoesOn(job) => {
                let state = found(job).first().map(|job| job["state"].clone());
                assert_eq!(state, Some(json!("interrupted")), "{}", at());
            }
            Promise::MayBeDeleted(_) => {}
            Promise::Deleted(job) => assert_eq!(found(job).len(), 0, "{}", at()),
        }
    }
    for job in &jobs {
        let id = job["job"].as_str().unwrap();
        assert_eq!(found(id).len(), 1, "{id} {}", at());
        let waits = job["state"] == "queued";
        assert!(
            !waits || !begun.contains(&id.to_owned()),
            "{id} moved {}",
            at()
        );
        let over = ["queued", "interrupted", "done", "stopped", "failed"];
        assert!(
            over.iter().any(|state| job["state"] == *state),
            "{job} {}",
            at()
        );
        if waits {
            assert_eq!(job["reason"], json!("restart"), "{}", at());
        }
    }
    // No job starts by itself.
    assert_eq!(second.started, [], "{}", at());
    for (key, job) in &keys {
        if deleted(job) || stopped(job) {
            continue;
        }
        second.start(key);
        assert_eq!(second.job(key).as_ref(), Some(job), "{key} {}", at());
    }
    assert_eq!(second.started, [], "a known key begins nothing {}", at());
    writes
}

#[test]
fn failed_writes_lose_no_answer_and_repeat_no_action() {
    let mut lives = 0;
    for steps in 1..=DAY.len() {
        let writes = live(steps, None);
        for at in 0..writes {
            for fault in FAULTS {
                live(steps, Some((at, fault)));
                lives += 1;
            }
        }
    }
    assert!(lives > 300, "{lives}");
}

/// Checks that the day without faults does what its steps say. Otherwise the property proves
/// nothing.
#[test]
fn script_covers_every_job_state() {
    let mut life = Simulation::new(Disk::default(), "1", None);
    let mut seen = std::collections::BTreeSet::new();
    for (_, step) in DAY {
        step(&mut life);
        for job in life.list() {
            seen.insert(job["state"].as_str().unwrap().to_owned());
        }
    }
    let seen: Vec<_> = seen.iter().map(String::as_str).collect();
    assert_eq!(seen, ["checking", "done", "queued", "running", "stopped"]);
    assert_eq!(life.started.len(), 4, "b began twice");
    assert!(
        life.promises
            .iter()
            .any(|promise| matches!(promise, Promise::GoesOn(_)))
    );
    let titles: Vec<_> = life.list().iter().map(|job| job["state"].clone()).collect();
    assert_eq!(
        titles,
        ["running", "stopped", "done"],
        "b, c, d; a is deleted"
    );
}

#[test]
fn unsaved_start_is_refused_and_moves_nothing() {
    for method in ["begins", "waits"] {
        let mut life = Simulation::new(Disk::default(), "1", None);
        if method == "waits" {
            life.start("a");
            life.goes_on("running");
        }
        let begun = life.started.len();
        life.fault = Some((life.writes, Fault::Full));
        let text = json!({"format": "magician-plan", "version": 1, "steps": []}).to_string();
        let params = json!({"text": text, "queue": true, "key": "x"});
        let refused = life.call("job.start", params).unwrap().unwrap_err();
        assert_eq!(refused["data"]["kind"], json!("closed"), "{refused}");
        let message = refused["message"].as_str().unwrap();
        assert!(message.contains("No space left"), "{message}");
        assert_eq!(life.started.len(), begun, "{method}");
        let last = life.list().pop().unwrap();
        assert_eq!(last["state"], json!("failed"), "{last}");
        // There is room again.
        life.start("x");
        assert!(life.job("x").is_some());
    }
}

#[test]
fn reused_key_with_another_program_is_refused() {
    let mut life = Simulation::new(Disk::default(), "1", None);
    life.start("a");
    let plan = json!({"format": "magician-plan", "version": 1, "steps": [{"wait": 5}]}).to_string();
    let params = json!({"text": plan, "key": "a", "queue": true});
    let refused = life.call("job.start", params).unwrap().unwrap_err();
    assert_eq!(refused["code"], json!(-32602));
    assert_eq!(refused["data"]["param"], json!("key"));
    assert_eq!(refused["data"]["job"], json!(life.job("a").unwrap()));
    assert_eq!(life.started.len(), 1);
    let empty = life.call("job.start", json!({"text": "{}", "key": ""}));
    assert_eq!(empty.unwrap().unwrap_err()["data"]["param"], json!("key"));
}

#[test]
fn failed_write_is_retried_until_it_succeeds() {
    let mut life = Simulation::new(Disk::default(), "1", None);
    life.start("a");
    life.goes_on("running");
    life.fault = Some((life.writes, Fault::Full));
    life.goes_on("done");
    let kept = |life: &Simulation| life.disk.load(0)["jobs"][0]["state"].clone();
    assert_eq!(kept(&life), json!("running"));
    let due = life.station.poll_timeout().unwrap();
    life.station.handle_timeout(due);
    life.turn();
    assert_eq!(kept(&life), json!("done"));
}

#[test]
fn removed_queued_job_does_not_affect_the_running_one() {
    let mut life = Simulation::new(Disk::default(), "1", None);
    life.start("a");
    life.goes_on("running");
    life.start("b");
    life.start("c");
    life.stop("b");
    assert_eq!(life.started.len(), 1, "c waits for a");
    let busy = life.call("arm.home", json!({})).unwrap().unwrap_err();
    assert_eq!(busy["code"], json!(-32003), "{busy}");
    assert_eq!(busy["data"]["job"], json!(life.job("a").unwrap()));
}

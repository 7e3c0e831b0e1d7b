//! Property tests: what viewers and strangers send costs no other client a socket, a jog or a
//! lease.

use std::time::Duration;

use magician::admission::Origin;
use magician_job::JobState;
use magician_protocol::HostInstant;
use magician_station::control::ArmId;
use magician_station::{
    ArmEntry, ArmOrder, ArmReport, CloseCode, Grant, JobUpdate, MAX_SOCKETS, MAX_VIEWERS, Outcome,
    Outgoing, Peer, Role, SocketId, Station, StationConfig,
};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::RngSeed;
use serde_json::{Value, json};

use crate::host::client::reading;

/// Interval at which the student keeps the jog alive.
const KEEP_INTERVAL: Duration = Duration::from_millis(60);
/// Bytes that the student's connection carries in that interval: 4 Mbit/s.
const BYTES_PER_INTERVAL: usize = 30_000;

/// Action of a viewer or a stranger.
#[derive(Clone, Debug)]
enum Action {
    /// Connects, with or without a token.
    Open(bool),
    /// Says hello, with a name of this length.
    Hello(usize, usize),
    /// Connects, says hello and disconnects, this many times.
    Loop(u8),
    /// Sends a request, this many times.
    Call(usize, &'static str, u8),
    /// Sends text other than a request.
    Garbage(usize),
    Close(usize),
    /// Reads all messages.
    Read(usize),
    /// Waits, ms.
    Wait(u64),
}

const CALLS: &[&str] = &[
    r#""session.list""#,
    r#""server.info""#,
    r#""arm.list""#,
    r#""arm.state","params":{"arm":"arm0"}"#,
    r#""arm.subscribe","params":{"arm":"arm0","rate":50}"#,
    r#""arm.subscribe","params":{"arm":"arm1","rate":50,"binary":true}"#,
    r#""arm.unsubscribe","params":{"subscription":1}"#,
    r#""events.since","params":{"arm":"arm1"}"#,
    r#""job.list""#,
    r#""lease.acquire","params":{"arm":"arm0"}"#,
    r#""lease.take","params":{"arm":"arm1"}"#,
    r#""arm.move","params":{"arm":"arm1","to":[200,0,50,0]}"#,
    r#""jog.start","params":{"arm":"arm1","axis":"x+"}"#,
    r#""arm.get","params":{"arm":"arm0","command":"Pose"}"#,
    r#""arm.stop","params":{"arm":"arm2"}"#,
    r#""jog.stop","params":{"arm":"arm2"}"#,
];

fn action() -> impl Strategy<Value = Action> {
    let at = 0..24_usize;
    prop_oneof![
        4 => any::<bool>().prop_map(Action::Open),
        4 => (at.clone(), 1..100_usize).prop_map(|(at, name)| Action::Hello(at, name)),
        6 => (1..40_u8).prop_map(Action::Loop),
        6 => (at.clone(), select(CALLS), 1..100_u8)
            .prop_map(|(at, call, times)| Action::Call(at, call, times)),
        1 => at.clone().prop_map(Action::Garbage),
        2 => at.clone().prop_map(Action::Close),
        2 => at.prop_map(Action::Read),
        6 => (0..150_u64).prop_map(Action::Wait),
    ]
}

/// Station with a working student and other clients.
struct Scene {
    station: Station,
    now: HostInstant,
    student: SocketId,
    jog: String,
    /// Next instant at which the student reads and keeps the jog alive.
    next: HostInstant,
    others: Vec<SocketId>,
    opened: usize,
    /// Times of the lists of sessions that the student received, and bytes in total.
    lists: Vec<HostInstant>,
    bytes: usize,
    read: f32,
}

fn hello(name: &str, token: bool) -> String {
    let mut params = json!({"client": {"name": name}});
    if token {
        params["token"] = json!("viewer");
    }
    json!({"jsonrpc": "2.0", "id": 1, "method": "session.hello", "params": params}).to_string()
}

impl Scene {
    fn new() -> Self {
        // The third arm belongs to no one: any client may stop it.
        let arms = ["arm0", "arm1", "arm2"].map(ArmEntry::simulated).to_vec();
        let mut scene = Self {
            station: Station::new(StationConfig::new(arms, "0")),
            now: HostInstant::ZERO,
            student: SocketId(0),
            jog: String::new(),
            next: HostInstant::ZERO,
            others: Vec::new(),
            opened: 0,
            lists: Vec::new(),
            bytes: 0,
            read: 0.0,
        };
        scene.student = scene.open(Some(Role::Student)).expect("room");
        scene.send(&hello("Anna", false));
        for arm in ["arm0", "arm1"] {
            let acquire = json!({"jsonrpc": "2.0", "id": 2, "method": "lease.acquire", "params": {"arm": arm}});
            scene.send(&acquire.to_string());
        }
        let plan =
            json!({"format": "magician-plan", "version": 1, "steps": [{"move": [220, 0, 20, 0]}]});
        let job = json!({"arm": "arm0", "text": plan.to_string()});
        let start = json!({"jsonrpc": "2.0", "id": 3, "method": "job.start", "params": job});
        scene.send(&start.to_string());
        let subscribe = json!({"jsonrpc": "2.0", "id": 5, "method": "arm.subscribe", "params": {"arm": "arm2"}});
        scene.send(&subscribe.to_string());
        let jog = json!({"arm": "arm1", "axis": "y+", "keep_ms": 250});
        let start = json!({"jsonrpc": "2.0", "id": 4, "method": "jog.start", "params": jog});
        scene.send(&start.to_string());
        let jog = scene.answer(4)["result"]["jog"].clone();
        scene.jog = jog.as_str().expect("a jog").to_owned();
        scene
    }

    fn open(&mut self, role: Option<Role>) -> Option<SocketId> {
        self.opened += 1;
        let peer = Peer {
            grant: role.map(|role| Grant { role, token: None }),
            origin: Origin::Elsewhere,
            address: "192.0.2.7:1".to_owned(),
            secret: format!("secret-{}", self.opened),
        };
        self.station.admit(self.now, peer)
    }

    fn send(&mut self, text: &str) {
        self.station.receive(self.now, self.student, text);
        self.orders();
    }

    fn answer(&mut self, id: u64) -> Value {
        while let Some(outgoing) = self.station.poll_send(self.student) {
            let Outgoing::Text(text) = outgoing else {
                continue;
            };
            let message: Value = serde_json::from_str(&text).expect("JSON");
            if message["id"] == json!(id) {
                return message;
            }
        }
        panic!("no answer to {id}");
    }

    /// Reports the orders of arms as done at once. The student's arm must not be ordered to stop.
    fn orders(&mut self) {
        while let Some(jobs) = self.station.poll_jobs() {
            let (arm, revision) = (jobs.arm(), jobs.revision());
            self.station.jobs_written(self.now, arm, revision, Ok(()));
        }
        while let Some((arm, order)) = self.station.poll_order() {
            let done = |request, outcome| ArmReport::Done { request, outcome };
            let report = match order {
                ArmOrder::Stop {
                    request: Some(request),
                } if arm == ArmId(2) => done(request, Ok(Outcome::Value(json!({"stood": true})))),
                ArmOrder::EndJog(_) | ArmOrder::StopJob(_) | ArmOrder::Stop { .. } => {
                    panic!("{order:?} at {:?}", self.now)
                }
                ArmOrder::StartJob(start) => ArmReport::Job {
                    job: start.job,
                    update: JobUpdate::State(JobState::Running, None),
                },
                ArmOrder::StartJog { request, .. } => done(request, Ok(Outcome::Value(json!({})))),
                ArmOrder::Read { request, .. } => {
                    self.reading(arm);
                    done(request, Ok(Outcome::State))
                }
                _ => continue,
            };
            self.station.report(self.now, arm, report);
        }
        while self.station.poll_library().is_some() {}
        while self.station.poll_journal().is_some() {}
        while self.station.poll_record().is_some() {}
        while self.station.poll_awake().is_some() {}
    }

    fn reading(&mut self, arm: ArmId) {
        self.read += 1.0;
        let report = ArmReport::Reading(Box::new(reading(self.read)));
        self.station.report(self.now, arm, report);
    }

    /// Lets time pass: arms are read, and the student reads as much as the connection carries and
    /// keeps the jog alive.
    fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while self.next <= until {
            self.sleep(self.next);
            self.next += KEEP_INTERVAL;
            self.reading(ArmId(0));
            self.reading(ArmId(1));
            self.student_reads();
            let keep = json!({"jsonrpc": "2.0", "method": "jog.keep", "params": {"jog": self.jog}});
            self.send(&keep.to_string());
        }
        self.sleep(until);
    }

    fn sleep(&mut self, until: HostInstant) {
        while let Some(due) = self.station.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.station.handle_timeout(self.now);
            self.orders();
        }
        self.now = self.now.max(until);
        self.orders();
    }

    fn student_reads(&mut self) {
        let mut taken = 0;
        while taken < BYTES_PER_INTERVAL
            && let Some(outgoing) = self.station.poll_send(self.student)
        {
            match outgoing {
                Outgoing::Text(text) => {
                    taken += text.len();
                    for lost in ["jog.ended", "lease.changed"] {
                        assert!(!text.contains(lost), "{text}");
                    }
                    if text.contains("session.changed") {
                        self.lists.push(self.now);
                    }
                }
                Outgoing::Frame(frame) => taken += frame.len(),
                Outgoing::Close(code) => panic!("closed with {code:?}"),
            }
        }
        self.bytes += taken;
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Open(token) => self.come(token),
            Action::Hello(at, name) => {
                self.tell(at, &hello(&"\u{202e}".repeat(name.min(80)), true))
            }
            Action::Loop(times) => {
                for _ in 0..times {
                    if let Some(socket) = self.open(Some(Role::Viewer)) {
                        let name = "\u{202e}".repeat(80);
                        self.station.receive(self.now, socket, &hello(&name, false));
                        self.station.close(self.now, socket);
                        self.orders();
                    }
                }
            }
            Action::Call(at, call, times) => {
                for id in 0..times {
                    self.tell(
                        at,
                        &format!(r#"{{"jsonrpc":"2.0","id":{id},"method":{call}}}"#),
                    );
                }
            }
            Action::Garbage(at) => self.tell(at, "{"),
            Action::Close(at) => {
                if at < self.others.len() {
                    let socket = self.others.swap_remove(at);
                    self.station.close(self.now, socket);
                    self.orders();
                }
            }
            Action::Read(at) => {
                if let Some(socket) = self.others.get(at) {
                    while let Some(outgoing) = self.station.poll_send(*socket) {
                        if matches!(outgoing, Outgoing::Close(_)) {
                            break;
                        }
                    }
                }
            }
            Action::Wait(ms) => self.pass(Duration::from_millis(ms)),
        }
    }

    fn come(&mut self, token: bool) {
        let role = token.then_some(Role::Viewer);
        if let Some(socket) = self.open(role) {
            self.others.push(socket);
        }
    }

    fn tell(&mut self, at: usize, text: &str) {
        let Some(socket) = self.others.get(at).copied() else {
            return;
        };
        if Station::token_of(text).is_some() {
            let viewer = Grant {
                role: Role::Viewer,
                token: Some("viewer".to_owned()),
            };
            self.station.set_token_grant(socket, Some(viewer));
        }
        self.station.receive(self.now, socket, text);
        self.orders();
    }

    /// Checks that the student is still working and was sent no more than people can read.
    fn end(mut self) {
        self.pass(Duration::from_millis(300));
        let info = json!({"jsonrpc": "2.0", "id": 9, "method": "session.list"});
        self.send(&info.to_string());
        let list = self.answer(9);
        let anna = {
            list["result"]["sessions"]
                .as_array()
                .expect("a list")
                .iter()
        }
        .find(|session| session["name"] == json!("Anna"));
        let leases = anna.map(|anna| anna["leases"].clone());
        assert_eq!(leases, Some(json!(["arm0", "arm1"])));
        for second in self.lists.windows(6) {
            let [first, .., last] = second else { continue };
            assert!(*last - *first >= Duration::from_millis(940), "{second:?}");
        }
        let size = self.station.size();
        assert!(size.sessions <= MAX_SOCKETS + 80, "{size:?}");
        let longest = list.to_string().len();
        assert!(longest < 80 * 1024, "{longest} bytes of sessions");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 60,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn viewers_and_strangers_do_not_disturb_a_student(
        deeds in vec(action(), 1..150),
    ) {
        let mut scene = Scene::new();
        for action in deeds {
            scene.act(action);
        }
        scene.end();
    }
}

#[test]
fn hello_loops_send_a_listener_less_than_two_megabytes() {
    let mut scene = Scene::new();
    for _ in 0..500 {
        scene.act(Action::Loop(3));
        scene.act(Action::Wait(20));
    }
    println!("{} bytes in {} lists", scene.bytes, scene.lists.len());
    assert!(scene.lists.len() <= 51, "{}", scene.lists.len());
    assert!(scene.bytes < 2_000_000, "{} bytes", scene.bytes);
    scene.end();
}

#[test]
fn loop_of_stops_is_obeyed_and_closes_no_listener() {
    let mut scene = Scene::new();
    scene.come(true);
    scene.tell(0, &hello("v", true));
    for _ in 0..300 {
        scene.act(Action::Call(
            0,
            r#""arm.stop","params":{"arm":"arm2"}"#,
            250,
        ));
        scene.act(Action::Read(0));
        scene.act(Action::Wait(3));
    }
    scene.end();
}

#[test]
fn student_resumes_during_a_loop_of_viewers() {
    let mut scene = Scene::new();
    let secret = "secret-1";
    let socket = scene.student;
    // The jog ends with the socket; the lease is kept.
    scene.station.close(scene.now, socket);
    while scene.station.poll_order().is_some() {}
    for _ in 0..100 {
        scene.act(Action::Loop(40));
    }
    let back = scene.open(Some(Role::Student)).expect("room");
    let hello = json!({"client": {"name": "Anna"}, "resume": secret});
    let hello = json!({"jsonrpc": "2.0", "id": 1, "method": "session.hello", "params": hello});
    scene.station.receive(scene.now, back, &hello.to_string());
    scene.student = back;
    assert_eq!(scene.answer(1)["result"]["resumed"], json!(true));
}

/// Returns the error that a client received before its socket was closed.
fn refusal(scene: &mut Scene, socket: SocketId) -> Value {
    let Some(Outgoing::Text(text)) = scene.station.poll_send(socket) else {
        panic!("an answer");
    };
    let end = Some(Outgoing::Close(CloseCode::FULL));
    assert_eq!(scene.station.poll_send(socket), end);
    serde_json::from_str::<Value>(&text).expect("JSON")["error"].clone()
}

#[test]
fn excess_viewers_are_refused_and_students_admitted() {
    let mut scene = Scene::new();
    for at in 0..MAX_VIEWERS {
        scene.come(true);
        scene.tell(at, &hello("v", true));
        let answer = scene.station.poll_send(scene.others[at]);
        assert!(
            matches!(answer, Some(Outgoing::Text(text)) if text.contains("result")),
            "{at}"
        );
    }
    scene.come(true);
    scene.tell(MAX_VIEWERS, &hello("late", true));
    let late = scene.others[MAX_VIEWERS];
    let error = refusal(&mut scene, late);
    assert_eq!(
        (&error["code"], &error["data"]["limit"]),
        (&json!(-32006), &json!(MAX_VIEWERS))
    );
    scene.student = scene.open(Some(Role::Student)).expect("room");
    scene.send(&hello("Ben", false));
    assert_eq!(scene.answer(1)["result"]["role"], json!("student"));
}

#[test]
fn hello_without_a_free_place_is_refused_except_from_loopback() {
    let mut scene = Scene::new();
    let late = scene.open(Some(Role::Student)).expect("room");
    // All places but four are open to clients from elsewhere, and the student has one of them.
    for _ in 1..MAX_SOCKETS - 4 {
        let socket = scene.open(Some(Role::Student)).expect("room");
        scene.station.receive(scene.now, socket, &hello("s", false));
    }
    assert_eq!(
        scene.open(None),
        None,
        "nobody else comes in from elsewhere"
    );
    let local = Peer {
        grant: None,
        origin: Origin::Loopback,
        address: "127.0.0.1:1".to_owned(),
        secret: "local".to_owned(),
    };
    assert!(scene.station.admit(scene.now, local).is_some());
    scene
        .station
        .receive(scene.now, late, &hello("late", false));
    assert_eq!(refusal(&mut scene, late)["code"], json!(-32006));
}

#[test]
fn viewers_are_evicted_for_pin_code_and_token() {
    const CLASS: &str = "[class]\npin = \"482913\"\n[[pupil]]\nname = \"Ada\"\ncode = \"7K3M\"\n";
    let mut config = StationConfig::new(vec![ArmEntry::simulated("arm")], "0");
    config.class = Some(CLASS.to_owned());
    let mut station = Station::new(config);
    let now = HostInstant::ZERO;
    let mut opened = 0;
    let mut come = |station: &mut Station, grant: Option<Role>, more: Value| {
        opened += 1;
        let peer = Peer {
            grant: grant.map(|role| Grant { role, token: None }),
            origin: Origin::Loopback,
            address: "127.0.0.1:1".to_owned(),
            secret: format!("secret-{opened}"),
        };
        let socket = station.admit(now, peer)?;
        let mut params = json!({"client": {"name": "page"}});
        params
            .as_object_mut()
            .expect("an object")
            .extend(more.as_object().expect("an object").clone());
        let hello = json!({"jsonrpc": "2.0", "id": 1, "method": "session.hello", "params": params});
        station.receive(now, socket, &hello.to_string());
        Some(socket)
    };
    // True if the hello was answered with a session and the socket is still open.
    let is_in = |station: &mut Station, socket: SocketId| {
        let mut is_in = None;
        while let Some(outgoing) = station.poll_send(socket) {
            match outgoing {
                Outgoing::Text(text) if text.contains("\"resume\"") => is_in = Some(true),
                Outgoing::Close(code) => {
                    assert_eq!(code, CloseCode::FULL);
                    station.close(now, socket);
                    return Some(false);
                }
                Outgoing::Text(_) | Outgoing::Frame(_) => {}
            }
        }
        is_in
    };
    let viewers: Vec<_> = (0..MAX_VIEWERS)
        .map(|_| come(&mut station, None, json!({})).expect("room"))
        .collect();
    for viewer in &viewers {
        assert_eq!(is_in(&mut station, *viewer), Some(true));
    }
    for _ in MAX_VIEWERS..MAX_SOCKETS {
        let socket = come(&mut station, Some(Role::Student), json!({})).expect("room");
        assert_eq!(is_in(&mut station, socket), Some(true));
    }
    let late = come(&mut station, None, json!({})).expect("it may have a PIN");
    assert_eq!(
        is_in(&mut station, late),
        Some(false),
        "a viewer drives out nobody"
    );
    let ways = [
        (None, json!({"pin": "482913"})),
        (None, json!({"pupil": {"name": "Ada", "code": "7K3M"}})),
        (Some(Role::Teacher), json!({})),
    ];
    for (at, (grant, more)) in ways.into_iter().enumerate() {
        let socket = come(&mut station, grant, more.clone()).expect("room");
        assert_eq!(is_in(&mut station, socket), Some(true), "{more}");
        let last = viewers[MAX_VIEWERS - 1 - at];
        assert_eq!(is_in(&mut station, last), Some(false), "{more}");
    }
    assert_eq!(is_in(&mut station, viewers[0]), None, "the first looks on");
    // In the end only clients that may move an arm are left.
    for _ in 3..MAX_VIEWERS {
        let socket = come(&mut station, Some(Role::Student), json!({})).expect("room");
        assert_eq!(is_in(&mut station, socket), Some(true));
    }
    assert!(come(&mut station, None, json!({"pin": "482913"})).is_none());
}

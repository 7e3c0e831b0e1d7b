//! What is known of an arm behind a line that broke: nothing that was read before.

use std::time::Duration;

use magician::commands::Pose;
use magician_protocol::HostInstant;
use magician_station::control::ArmId;
use magician_station::{
    ArmEntry, ArmOrder, ArmReading, ArmReport, Grant, Outcome, Outgoing, Peer, Role, SocketId,
    Station, StationConfig, ToolReading,
};
use serde_json::{Value, json};

const ARM: ArmId = ArmId(0);

/// A station whose arm is the test.
struct TestStation {
    station: Station,
    socket: SocketId,
    now: HostInstant,
    frames: usize,
}

impl TestStation {
    fn new() -> Self {
        let mut station = Station::new(StationConfig::new(vec![ArmEntry::simulated("arm")], "0"));
        let now = HostInstant::from_micros(1_000_000);
        let role = Role::Teacher;
        let socket = station.open(
            now,
            Peer {
                grant: Some(Grant { role, token: None }),
                address: String::new(),
                secret: "secret".to_owned(),
            },
        );
        let mut station = Self {
            station,
            socket,
            now,
            frames: 0,
        };
        station.send("session.hello", &json!({"client": {"name": "Anna"}}));
        station.heard();
        station
    }

    fn send(&mut self, method: &str, params: &Value) {
        let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        self.station
            .receive(self.now, self.socket, &message.to_string());
    }

    fn report(&mut self, report: ArmReport) {
        self.station.report(self.now, ARM, report);
    }

    /// A reading with this `x`, so old.
    fn read(&mut self, x: f32, age: Duration) {
        let pose = Pose {
            x,
            y: 0.0,
            z: 0.0,
            r: 0.0,
            joint_angle: [0.0; 4],
        };
        self.report(ArmReport::Reading(Box::new(ArmReading {
            age,
            pose,
            current_index: 0,
            left_space: 32,
            alarms: Vec::new(),
            alarm_holds: false,
            link: true,
            moving: false,
            homed: None,
            rail: None,
            tool: ToolReading::default(),
            speed: None,
            pins: Vec::new(),
        })));
    }

    /// The messages that wait.
    fn heard(&mut self) -> Vec<Value> {
        let mut heard = Vec::new();
        while let Some(outgoing) = self.station.poll_send(self.socket) {
            match outgoing {
                Outgoing::Text(text) => heard.push(serde_json::from_str(&text).unwrap()),
                Outgoing::Frame(_) => self.frames += 1,
                Outgoing::Close(code) => panic!("{code:?}"),
            }
        }
        heard
    }

    /// The states among them.
    fn states(&mut self) -> Vec<Value> {
        let heard = self.heard().into_iter();
        let states = heard.filter(|message| message["method"] == json!("arm.state"));
        states
            .map(|message| message["params"]["state"].clone())
            .collect()
    }

    fn subscribe(&mut self, frame: &str) {
        self.send("arm.subscribe", &json!({"rate": 50, "frame": frame}));
    }

    fn line(&mut self, up: bool) {
        self.report(ArmReport::Link(up));
    }
}

#[test]
fn no_state_from_before_a_lost_line_is_sent_or_answered_after_it() {
    let mut station = TestStation::new();
    station.subscribe("json");
    station.read(1.0, Duration::ZERO);
    assert_eq!(station.states()[0]["x"], json!(1.0));
    station.line(false);
    station.now += Duration::from_millis(10);
    station.line(true);
    assert_eq!(station.states(), [json!({"link": "lost", "t": 1.0})]);
    // A change beside the reading has it sent, if there is one.
    station.send("lease.acquire", &json!({}));
    // What was on its way when the line broke.
    station.now += Duration::from_millis(5);
    station.read(1.0, Duration::from_millis(6));
    station.read(1.0, Duration::from_millis(60));
    assert_eq!(station.states(), [] as [Value; 0]);
    // Not longer ago than 100 ms, but before.
    while station.station.poll_order().is_some() {}
    station.send("arm.state", &json!({}));
    let order = station.station.poll_order();
    assert!(
        matches!(order, Some((_, ArmOrder::Read { .. }))),
        "{order:?}"
    );
    station.now += Duration::from_millis(20);
    station.read(2.0, Duration::from_millis(20));
    let states = station.states();
    assert_eq!(
        (&states[0]["x"], &states[0]["link"]),
        (&json!(2.0), &json!("up"))
    );
}

#[test]
fn a_state_that_waits_to_be_sent_when_the_line_breaks_is_not() {
    for frame in ["json", "binary"] {
        let mut station = TestStation::new();
        station.subscribe(frame);
        station.read(1.0, Duration::ZERO);
        station.states();
        station.frames = 0;
        station.now += Duration::from_millis(100);
        station.read(2.0, Duration::ZERO);
        station.line(false);
        station.line(true);
        station.now += Duration::from_millis(100);
        station.read(3.0, Duration::ZERO);
        // Nothing was sent in between: first that it was lost, then what was found, and that it is up.
        let states = station.states();
        assert_eq!(states[0]["link"], json!("lost"), "{frame}");
        let x = states[1].get("x");
        assert!(frame == "binary" || x == Some(&json!(3.0)), "{states:?}");
        assert_eq!(station.frames, usize::from(frame == "binary"));
        assert!(frame == "binary" || states[1]["link"] == json!("up"));
    }
}

#[test]
fn a_request_whose_reading_is_from_before_a_lost_line_fails() {
    let mut station = TestStation::new();
    station.send("arm.state", &json!({}));
    let Some((_, ArmOrder::Read { request, .. })) = station.station.poll_order() else {
        panic!("it is read");
    };
    station.read(1.0, Duration::ZERO);
    station.line(false);
    station.line(true);
    let outcome = Ok(Outcome::State);
    station.report(ArmReport::Done { request, outcome });
    let answer = station.heard().pop().unwrap();
    assert_eq!(answer["error"]["data"]["kind"], json!("port"));
}

#[test]
fn the_first_state_of_a_subscription_comes_behind_its_answer() {
    let mut station = TestStation::new();
    station.read(1.0, Duration::ZERO);
    station.subscribe("json");
    let heard = station.heard();
    assert!(heard[0].get("result").is_some(), "{heard:?}");
    assert_eq!(heard[1]["params"]["state"]["x"], json!(1.0));
}

//! Station without an engine: the test is arm and clock.

use std::time::Duration;

use magician::admission::Origin;
use magician::commands::Pose;
use magician_protocol::HostInstant;
use magician_station::control::ArmId;
use magician_station::{
    ArmEntry, ArmReading, ArmReport, Grant, Outgoing, Peer, Role, SocketId, Station, StationConfig,
    ToolReading,
};
use serde_json::{Value, json};

pub(crate) const ARM: ArmId = ArmId(0);

/// Station with a connected teacher.
pub(crate) struct BareStation {
    pub(crate) station: Station,
    pub(crate) socket: SocketId,
    pub(crate) now: HostInstant,
    pub(crate) frames: usize,
}

impl BareStation {
    pub(crate) fn new() -> Self {
        Self::with(StationConfig::new(vec![ArmEntry::simulated("arm")], "0"))
    }

    pub(crate) fn with(config: StationConfig) -> Self {
        let now = HostInstant::from_micros(1_000_000);
        let mut station = Self {
            station: Station::new(config),
            socket: SocketId(0),
            now,
            frames: 0,
        };
        station.socket = station.join("Anna");
        station.received();
        station
    }

    /// Connects another teacher.
    pub(crate) fn join(&mut self, name: &str) -> SocketId {
        let role = Role::Teacher;
        let token = Some(format!("token of {name}"));
        let peer = Peer {
            grant: Some(Grant { role, token }),
            origin: Origin::Loopback,
            address: String::new(),
            secret: format!("secret of {name}"),
        };
        let socket = self.station.open(self.now, peer);
        self.ask(socket, "session.hello", &json!({"client": {"name": name}}));
        socket
    }

    pub(crate) fn ask(&mut self, socket: SocketId, method: &str, params: &Value) {
        let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        self.station.receive(self.now, socket, &message.to_string());
    }

    pub(crate) fn send(&mut self, method: &str, params: &Value) {
        self.ask(self.socket, method, params);
    }

    pub(crate) fn report(&mut self, report: ArmReport) {
        self.station.report(self.now, ARM, report);
    }

    /// Reports a reading with this `x` and age.
    pub(crate) fn read(&mut self, x: f32, age: Duration) {
        self.reading(x, |reading| reading.age = age);
    }

    /// Reports a reading with this `x`, changed by `say`.
    pub(crate) fn reading(&mut self, x: f32, change: impl FnOnce(&mut ArmReading)) {
        let pose = Pose {
            x,
            y: 0.0,
            z: 0.0,
            r: 0.0,
            joint_angle: [0.0; 4],
        };
        let mut reading = ArmReading {
            age: Duration::ZERO,
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
        };
        change(&mut reading);
        self.report(ArmReport::Reading(Box::new(reading)));
    }

    /// Returns the waiting messages.
    pub(crate) fn received(&mut self) -> Vec<Value> {
        let mut received = Vec::new();
        while let Some(outgoing) = self.station.poll_send(self.socket) {
            match outgoing {
                Outgoing::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if message.get("method").is_some() {
                        crate::schema_check::check_notification(&message);
                    }
                    received.push(message);
                }
                Outgoing::Frame(_) => self.frames += 1,
                Outgoing::Close(code) => panic!("{code:?}"),
            }
        }
        received
    }

    /// Returns the states among the waiting messages.
    pub(crate) fn states(&mut self) -> Vec<Value> {
        let received = self.received().into_iter();
        let states = received.filter(|message| message["method"] == json!("arm.state"));
        states
            .map(|message| message["params"]["state"].clone())
            .collect()
    }

    pub(crate) fn subscribe(&mut self, frame: &str) {
        self.send("arm.subscribe", &json!({"rate": 50, "frame": frame}));
    }

    pub(crate) fn line(&mut self, up: bool) {
        self.report(ArmReport::Link(up));
    }
}

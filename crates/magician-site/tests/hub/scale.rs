//! Five hundred arms on one page.

use std::time::Duration;

use magician_protocol::HostInstant;
use magician_site::hub::{Hub, HubAction, LineId, LineMessage, SocketId};
use magician_site::{SiteEvent, StationId};
use magician_station::Outgoing;
use serde_json::{Value, json};

use crate::bench::at;

const STATIONS: u64 = 50;
const ARMS: u64 = 10;

/// A hub whose only client has subscribed to all arms of all stations.
struct BusyClient {
    hub: Hub,
    socket: SocketId,
    lines: Vec<(LineId, StationId)>,
    now: HostInstant,
}

impl BusyClient {
    fn new() -> Self {
        let mut hub = Hub::new(None, 0.0, || 0);
        let now = HostInstant::ZERO;
        for station in 1..=STATIONS {
            for arm in 0..ARMS {
                hub.site(
                    now,
                    SiteEvent::Arrived(at(station, &format!("arm{station}-{arm}"))),
                );
            }
        }
        let socket = hub.open(None);
        let mut client = Self {
            hub,
            socket,
            lines: Vec::new(),
            now,
        };
        client.send(0, "session.hello", json!({"client": {"name": "page"}}));
        for station in 1..=STATIONS {
            for arm in 0..ARMS {
                client.send(
                    1,
                    "arm.subscribe",
                    json!({"arm": format!("arm{station}-{arm}"), "rate": 10}),
                );
                // Stay below the rate limit of a client.
                client.now += Duration::from_millis(2);
            }
        }
        while client.hub.poll_send(socket).is_some() {}
        client
    }

    fn send(&mut self, id: u64, method: &str, params: Value) {
        let text =
            json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}).to_string();
        self.hub.receive(self.now, self.socket, &text);
        self.settle();
    }

    /// Lets home and stations answer all pending requests.
    fn settle(&mut self) {
        while let Some(act) = self.hub.poll_action() {
            match act {
                HubAction::Home(socket, text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    let result =
                        json!({"session": "s", "resume": "r", "role": "teacher", "limits": {}});
                    let answer = json!({"jsonrpc": "2.0", "id": message["id"], "result": result});
                    self.hub
                        .receive_from_home(self.now, socket, &answer.to_string());
                }
                HubAction::Open(line, station) => {
                    self.lines.push((line, station));
                    self.hub.line_opened(line);
                }
                HubAction::Awake(line) => {
                    while let Some(LineMessage::Text(text)) = self.hub.poll_line(line) {
                        let message: Value = serde_json::from_str(&text).unwrap();
                        let arm = message["params"]["arm"].as_str().unwrap_or("-0");
                        let number: u64 = arm.rsplit_once('-').unwrap().1.parse().unwrap();
                        let result =
                            json!({"subscription": number + 1, "session": "s", "resume": "r"});
                        let answer =
                            json!({"jsonrpc": "2.0", "id": message["id"], "result": result});
                        self.hub
                            .receive_from_line(self.now, line, &answer.to_string());
                    }
                }
                HubAction::Drop(_) | HubAction::Call { .. } => {}
            }
        }
    }

    /// Reports a state of every arm.
    fn report_all(&mut self, x: f64) {
        for at in 0..self.lines.len() {
            let line = self.lines[at].0;
            for arm in 1..=ARMS {
                let state = json!({
                    "t": x, "x": x, "y": 1.25, "z": 20.5, "r": 0.125, "j1": 1.5, "j2": 45.5, "j3": 45.25, "j4": 0.5,
                    "current_index": 17, "left_space": 30,
                });
                let params = json!({"subscription": arm, "state": state});
                let text =
                    json!({"jsonrpc": "2.0", "method": "arm.state", "params": params}).to_string();
                self.hub.receive_from_line(self.now, line, &text);
            }
        }
    }

    fn read(&mut self) -> Vec<Value> {
        let mut states = Vec::new();
        while let Some(Outgoing::Text(text)) = self.hub.poll_send(self.socket) {
            states.push(serde_json::from_str(&text).unwrap());
        }
        states
    }
}

#[test]
fn slow_client_of_500_arms_gets_only_the_newest_states() {
    let mut client = BusyClient::new();
    assert_eq!(client.lines.len() as u64, STATIONS);
    for round in 0..100 {
        client.now += Duration::from_millis(100);
        client.report_all(f64::from(round));
    }
    let states = client.read();
    assert_eq!(states.len() as u64, STATIONS * ARMS);
    assert!(
        states
            .iter()
            .all(|state| state["params"]["state"]["x"] == 99.0)
    );
    let mut ids: Vec<_> = states
        .iter()
        .map(|state| state["params"]["subscription"].as_u64().unwrap())
        .collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len() as u64, STATIONS * ARMS);
}

#[test]
#[ignore = "a measurement: cargo test -p magician-site --release --test hub -- --ignored --nocapture"]
fn cost_of_500_arms_at_10_hz() {
    let mut client = BusyClient::new();
    let rounds = 200;
    let begun = std::time::Instant::now();
    let mut bytes = 0;
    for round in 0..rounds {
        client.now += Duration::from_millis(100);
        client.report_all(f64::from(round));
        while let Some(Outgoing::Text(text)) = client.hub.poll_send(client.socket) {
            bytes += text.len();
        }
    }
    let took = begun.elapsed();
    let states = rounds as u64 * STATIONS * ARMS;
    println!(
        "{:.1} us a state, {:.1} % of a core at 10 Hz, {:.2} MB/s to the page",
        took.as_secs_f64() * 1e6 / states as f64,
        took.as_secs_f64() / (f64::from(rounds) * 0.1) * 100.0,
        bytes as f64 / 1e6 / (f64::from(rounds) * 0.1),
    );
}

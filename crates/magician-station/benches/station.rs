//! Costs of a station: `cargo bench -p magician-station --features http`.
//!
//! Prints, over TCP on this machine: the time from sending a stop to the driver's write of it to
//! the line, alone and beside 20 viewers at 20 Hz; a reading through the station compared with one
//! by the driver; and the processor time and memory of an idle station.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use magician::commands::{CpCmd, Pose};
use magician::sim::Controller;
use magician::{Arm, Options, SimSpeed, Tracer, VirtualArm};
use magician_protocol::CpMode;
use magician_station::http::{Admission, HttpOptions, Listener, TokenStore};
use magician_station::link::{LinkListener, LinkOptions, LinkService};
use magician_station::{ArmEntry, RunningStation, StationConfig};
use serde_json::{Value, json};
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};

const STOPS: usize = 200;
const READS: usize = 2000;
const MAX_VIEWERS: usize = 20;

/// Writer that notes when the driver writes a stop.
#[derive(Clone, Default)]
struct Tap(Arc<Mutex<Option<Instant>>>);

impl Write for Tap {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // ForceStopExec, id 242, as a set command.
        if bytes
            .windows(5)
            .any(|window| window == [0xAA, 0xAA, 2, 242, 1])
        {
            self.0
                .lock()
                .expect("no panic")
                .get_or_insert_with(Instant::now);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Client(WebSocketStream<MaybeTlsStream<TcpStream>>);

impl Client {
    async fn join(url: &str) -> Self {
        let (socket, _) = tokio_tungstenite::connect_async(url)
            .await
            .expect("it listens");
        let mut client = Self(socket);
        client
            .call("session.hello", json!({"client": {"name": "bench"}}))
            .await;
        client
    }

    async fn send(&mut self, method: &str, params: Value) {
        let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        self.0
            .send(Message::text(message.to_string()))
            .await
            .expect("it reads");
    }

    async fn call(&mut self, method: &str, params: Value) -> Value {
        self.send(method, params).await;
        loop {
            if let Some(Ok(Message::Text(text))) = self.0.next().await {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                if message.get("method").is_none() {
                    return message;
                }
            }
        }
    }
}

/// Formats median, 99th percentile and maximum, ms.
fn spread(mut times: Vec<Duration>) -> String {
    times.sort();
    let at = |part: f64| {
        let index = ((times.len() - 1) as f64 * part).round() as usize;
        times[index].as_secs_f64() * 1e3
    };
    format!(
        "p50 {:.3} ms, p99 {:.3} ms, most {:.3} ms",
        at(0.5),
        at(0.99),
        at(1.0)
    )
}

async fn stops(client: &mut Client, tap: &Tap) -> Vec<Duration> {
    let mut times = Vec::with_capacity(STOPS);
    for _ in 0..STOPS {
        tap.0.lock().expect("no panic").take();
        let sent = Instant::now();
        client.call("arm.stop", json!({})).await;
        let written = tap.0.lock().expect("no panic").expect("a stop was written");
        times.push(written - sent);
    }
    times
}

/// Returns processor time of this process, s, and its memory, MB.
fn taken() -> (f64, f64) {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> = { stat.rsplit(") ").next().unwrap_or_default().split(' ') }
        .map(|field| field.parse().unwrap_or(0.0))
        .collect();
    let seconds = |at: usize| fields.get(at).copied().unwrap_or(0.0) / 100.0;
    (
        seconds(11) + seconds(12),
        fields.get(21).copied().unwrap_or(0.0) * 4096.0 / 1e6,
    )
}

#[tokio::main(flavor = "current_thread")]
async fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load {}", load.trim());
    let tap = Tap::default();
    let tracer = Tracer::new(tap.clone()).expect("a trace");
    let virtual_arm = VirtualArm::new(Controller::default(), SimSpeed::Times(1.0));
    let arm = Arm::simulated(virtual_arm, Options::default().trace(tracer))
        .await
        .expect("an arm");
    let config = StationConfig::new(vec![ArmEntry::simulated("arm")], "0");
    let station = RunningStation::start(config, vec![arm.clone()], Box::new(|_| {}));
    let listener = Listener::bind(Some("127.0.0.1:0")).await.expect("a port");
    let url = format!("ws://{}/api/v1/ws", listener.addresses()[0]);
    let (_over, ends) = watch::channel(false);
    let options = HttpOptions::new(TokenStore::at("/nonexistent/tokens.toml"), "0");
    let mut programs = Programs::at(station.clone(), ends.clone()).await;
    tokio::spawn(listener.serve(station, options, ends));

    let mut viewer = Client::join(&url).await;
    viewer.call("arm.subscribe", json!({"rate": 20})).await;
    tokio::spawn(async move { while viewer.0.next().await.is_some() {} });
    let (busy, _) = taken();
    let begun = Instant::now();
    tokio::time::sleep(Duration::from_secs(5)).await;
    let (after, memory) = taken();
    let share = (after - busy) / begun.elapsed().as_secs_f64() * 100.0;
    println!(
        "idle, one arm at 20 Hz, one viewer: {share:.2} % of a core, {memory:.1} MB (with the virtual arm and the viewer)"
    );

    let mut times = Vec::with_capacity(READS);
    for _ in 0..READS {
        let begun = Instant::now();
        arm.get::<Pose>().await.expect("a pose");
        times.push(begun.elapsed());
    }
    println!("a pose by the driver:      {}", spread(times));
    let mut client = Client::join(&url).await;
    let mut times = Vec::with_capacity(READS);
    for at in 0..READS {
        if at % 150 == 149 {
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
        let begun = Instant::now();
        let answer = client.call("arm.get", json!({"command": "Pose"})).await;
        times.push(begun.elapsed());
        assert!(answer.get("result").is_some(), "{answer}");
    }
    println!("a pose by the station:     {}", spread(times));

    println!(
        "a stop, one viewer:        {}",
        spread(stops(&mut client, &tap).await)
    );
    for _ in 0..MAX_VIEWERS {
        let mut viewer = Client::join(&url).await;
        viewer.call("arm.subscribe", json!({"rate": 20})).await;
        tokio::spawn(async move { while viewer.0.next().await.is_some() {} });
    }
    println!(
        "a stop, 21 viewers:        {}",
        spread(stops(&mut client, &tap).await)
    );
    let mut times = Vec::with_capacity(READS);
    for _ in 0..READS {
        let begun = Instant::now();
        programs.call("GetPose", json!({})).await;
        times.push(begun.elapsed());
    }
    println!("a pose by the link:        {}", spread(times));
    segments().await;
}

/// Program for DobotLink.
struct Programs(WebSocketStream<MaybeTlsStream<TcpStream>>);

impl Programs {
    async fn at(station: RunningStation, ends: watch::Receiver<bool>) -> Self {
        let listener = LinkListener::bind(Some("127.0.0.1:0"))
            .await
            .expect("a port");
        let url = format!("ws://{}/", listener.addresses()[0]);
        let service = LinkService::new(station, LinkOptions::default());
        tokio::spawn(listener.serve(service, Admission::default(), ends));
        let (socket, _) = tokio_tungstenite::connect_async(url)
            .await
            .expect("it listens");
        let mut program = Self(socket);
        program.call("ConnectDobot", json!({})).await;
        program
    }

    async fn send(&mut self, api: &str, mut params: Value) {
        params["portName"] = json!("arm");
        let method = format!("dobotlink.Magician.{api}");
        let message = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        self.0
            .send(Message::text(message.to_string()))
            .await
            .expect("it reads");
    }

    async fn hear(&mut self) -> Value {
        loop {
            if let Some(Ok(Message::Text(text))) = self.0.next().await {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                if message.get("id").is_some() {
                    assert!(message.get("error").is_none(), "{message}");
                    return message;
                }
            }
        }
    }

    async fn call(&mut self, api: &str, params: Value) -> Value {
        self.send(api, params).await;
        self.hear().await
    }
}

/// Path segments to an arm whose time runs 50 times as fast, as quickly as it takes them: by the
/// driver, and through the link with 8 calls in flight.
async fn segments() {
    const SEGMENTS: usize = 3000;
    let place = |at: usize| 0.2 * (at as f32);
    let x = |at: usize| 200.0 + place(at % 400).min(80.0 - place(at % 400));
    let new_arm = || async {
        let arm = VirtualArm::new(Controller::default(), SimSpeed::Times(50.0));
        let arm = Arm::simulated(arm, Options::default())
            .await
            .expect("an arm");
        arm.queue().start().await.expect("started");
        arm
    };
    let arm = new_arm().await;
    let begun = Instant::now();
    for at in 0..SEGMENTS {
        let segment = CpCmd {
            cp_mode: CpMode::Absolute,
            x: x(at),
            y: 0.0,
            z: 30.0,
            velocity_or_power: 100.0,
        };
        while let Err(error) = arm.enqueue(&segment).await {
            assert_eq!(error.kind(), magician::ErrorKind::QueueFull, "{error}");
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }
    let by_driver = SEGMENTS as f64 / begun.elapsed().as_secs_f64();
    let arm = new_arm().await;
    let config = StationConfig::new(vec![ArmEntry::simulated("arm")], "1");
    let station = RunningStation::start(config, vec![arm], Box::new(|_| {}));
    let (_over, ends) = watch::channel(false);
    let mut program = Programs::at(station, ends).await;
    let begun = Instant::now();
    for at in 0..SEGMENTS {
        let segment = json!({
            "cpMode": 1, "x": x(at), "y": 0, "z": 30, "power": 100, "isWaitForFinish": false, "timeout": 60_000,
        });
        program.send("SetCPCmd", segment).await;
        if at >= 8 {
            program.hear().await;
        }
    }
    for _ in 0..8 {
        program.hear().await;
    }
    let by_link = SEGMENTS as f64 / begun.elapsed().as_secs_f64();
    println!("segments a second: {by_driver:.0} by the driver, {by_link:.0} by the link");
}
